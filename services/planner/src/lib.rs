//! The planner: one pure function from a scene request to a reply, and the service
//! loop around it.
//!
//! [`Workspace::answer`] is all that happens to a request. It keeps nothing between requests but
//! memory, reads no clock and no files, so a recorded request answered anew gives
//! the same bytes: [`reply_to`].

mod answer;
pub mod config;
pub mod service;

pub use answer::{MOST_SAMPLES, Workspace, reply_to};
