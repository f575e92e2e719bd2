//! Where a body can move: channels as the request gives them, or made from its solids; and the
//! walls around.

mod explain;
mod made;
mod source;
mod space;
mod take;

pub(crate) use explain::{Explain, closed_to_union};
pub(crate) use source::{Buffers, Source, floor_walls, given_channels};
pub(crate) use space::{FreeSpace, Outlines};
