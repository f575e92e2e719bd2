//! The programs as people run them: real processes over real shared memory, each test in a
//! domain of its own.

mod bad_input;
mod client;
mod command_line;
mod demo;
mod domains;
mod end_to_end;
mod golden;
mod hostile;
mod independent;
mod kills;
mod meshes;
mod operation;
mod plan;
mod planner;
mod play;
mod read;
mod recorder;
mod recordings;
mod service;
mod viewing;
