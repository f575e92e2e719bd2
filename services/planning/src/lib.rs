//! Rule-based path planning through channels and junctions, after the paper "Rule-Based Path
//! Finding Algorithm for Part Assembly and Its Extension to Mobile Robot Path Planning"
//! (`docs/errata.md` lists what is corrected here).
//!
//! | module | what it does | in the paper |
//! |---|---|---|
//! | [`budget`] | limits steps and memory, and stops | |
//! | [`geometry`] | vectors, boxes, polygons, distances, exact predicates | |
//! | [`motion`] | lines, arcs and turns; legs of a path | |
//! | [`free_space`] | walls, channels, junctions; channels from solids | section 2 |
//! | [`clearance`] | the exact least distance between a moving body and walls | |
//! | [`disassembly`] | Table 1: a part out of its cavity | section 3, example in section 4 |
//! | [`driving`] | Table 2 ([`driving::rules::TABLE_2`]): a robot through corridors | section 5 |
//! | [`route`] | the order in which to travel channels | |
//! | [`any_angle`] | a robot among walls at any angle | |
//! | [`translation`] | a part of any shape among solids of any shape | |
//! | [`trajectory`] | speeds, and states sampled over time | |
//!
//! Each module knows only those above it.
//!
//! A pure library: no clock, no input or output, no threads, no logging. The same arguments
//! give the same bits on every machine; transcendental functions come from [`libm`] for that
//! reason.
//!
//! Units are metres, radians and seconds. Frames are right-handed. Assembly in two dimensions
//! takes place in (x, z), driving in (x, y), and everything in three dimensions in (x, y, z);
//! coordinates are in that order.

#[cfg(all(feature = "altered-rules", debug_assertions))]
pub mod altered;
pub mod any_angle;
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
pub mod translation;
