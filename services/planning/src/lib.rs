//! Rule-based path finding through channels and junctions, after the paper
//! "Rule-Based Path Finding Algorithm for Part Assembly and Its Extension to
//! Mobile Robot Path Planning" (`docs/errata.md` lists what was corrected).
//!
//! A pure library: no clock, no input or output, no threads, no logging. The
//! same arguments give the same bits on every machine; transcendental functions
//! come from [`libm`] for that reason.
//!
//! Units are metres, radians and seconds. Frames are right-handed. Scenes of
//! assembly tasks in two dimensions live in (x, z), driving scenes in (x, y),
//! scenes in three dimensions in (x, y, z); coordinates are held in that order.

pub mod budget;
pub mod clearance;
pub mod disassembly;
pub mod driving;
pub mod free_space;
pub mod geometry;
pub mod motion;
pub mod route;
#[cfg(test)]
pub(crate) mod section_4;
pub mod trajectory;
