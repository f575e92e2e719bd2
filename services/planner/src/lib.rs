//! The planner process: a service loop on the bus around [`answer::Workspace`].
//!
//! Whatever happens to a request happens in `answer`; this crate takes requests from the bus,
//! has them planned by several threads, writes their replies to it, keeps a defect from ending the
//! service, and logs. It does not know
//! geometry, recordings or JSON.

mod at_once;
pub mod command_line;
mod desk;
mod manager;
pub mod metrics;
pub mod options;
mod queue;
mod resume;
pub mod service;
mod shown;
mod statistics;
pub mod supervisor;
mod turns;
mod workers;
