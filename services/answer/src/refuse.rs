//! Why there is no answer, in the words and numbers of a reply.

mod anywhere;
mod assembly;
mod blocked;
mod cost;
mod driving;
mod refused;
mod route;
mod scene;
mod translation;
mod words;

pub(crate) use anywhere::{gap_per_junction, in_solid, no_motion, out_of_bounds};
pub(crate) use assembly::{chain, disassembly, short_of_the_mouth, wall_in_the_way};
pub(crate) use blocked::blocked;
pub(crate) use cost::{answers, cells, too_many_samples};
pub(crate) use driving::{driving, less_gap};
pub(crate) use refused::Refused;
pub(crate) use route::{no_mouth, route};
pub(crate) use scene::{axis_box, limit, sampling};
pub(crate) use translation::{no_junctions, no_way};
pub(crate) use words::{Axes, FLOOR, PLANE, SPACE};
