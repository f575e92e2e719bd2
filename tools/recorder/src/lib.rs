//! The recorder: takes a planner's traffic from the tap and writes it to MCAP files.
//!
//! Taking and writing are two threads, so that neither compressing nor a slow disk keeps the tap
//! waiting: `take` and `store`, with a queue between.

pub mod command_line;
mod describe;
mod progress;
mod settings;
pub mod size;
mod store;
mod take;

pub use settings::{Settings, Snapshot, Topic, Topics};
pub use take::{EndReason, Ended, Failure, run};
