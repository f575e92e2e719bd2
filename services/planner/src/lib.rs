//! The planner: one pure function from a scene request to a reply, and the service
//! loop around it.
//!
//! [`Workspace::answer`] is all that happens to a request. What it keeps between requests changes
//! no reply, and it reads no clock and no files, so a recorded request answered anew under the same
//! [`Caps`] gives the same bytes: [`reply_to`].

mod answer;
mod caps;
pub mod config;
pub mod service;

pub use answer::{CacheStats, Workspace, reply_to};
pub use caps::Caps;
