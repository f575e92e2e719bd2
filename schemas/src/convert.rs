//! From memory to messages and back: the border where what a peer wrote is checked.
//!
//! Codes are looked up, counts are checked against the memory that is there, text
//! must be UTF-8. Whether the numbers make a scene is the planner's to say. Reading
//! reuses the memory of the message that it fills: the second request of a kind
//! allocates nothing.

mod cells;
mod codes;
mod reply;
mod request;
mod scene;

pub use cells::{CellWriter, Malformed};
pub use reply::{PartSink, Samples, TrajectoryWriter, read_part, write_refusal};
pub use request::{check_version, header_of, read_request, unreadable};
pub use scene::{dimension, read_scene, write_scene};
