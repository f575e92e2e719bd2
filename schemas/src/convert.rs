//! From memory to messages and back: the border where a peer's memory is checked.
//!
//! Codes are looked up, counts are checked against the memory present, text must be
//! UTF-8. Whether the numbers make sense as a scene is for the planner to decide. Reading
//! reuses the memory of the message it fills: the second request of a kind allocates
//! nothing.

mod cells;
pub(crate) mod codes;
mod dimension;
mod manner;
mod reply;
mod request;
mod scene;

pub use cells::{CellWriter, Malformed};
pub use dimension::dimension;
pub use reply::{
    Certificate, PartSink, Samples, TrajectoryWriter, read_part, read_part_in_place, write_refusal,
};
pub use request::{check_version, header_of, read_request, unreadable};
pub use scene::{read_scene, write_scene};
