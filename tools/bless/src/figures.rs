//! The figures of `docs/method.md`: a module for each, which returns the SVG's text.
//!
//! What they show is planned, not drawn by hand: scenes go through the planner, and its paths,
//! junctions, corners and numbers come out.

pub(crate) mod channels;
mod drawing;
pub(crate) mod guiding_circle;
mod motion;
pub(crate) mod profile;
pub(crate) mod route;
pub(crate) mod safest_gap;
pub(crate) mod smooth_corners;
pub(crate) mod solids;
pub(crate) mod table_1;
pub(crate) mod tangents;
