//! Driving: worked numbers, orientations, refusals, and random corridors.

mod general;
mod properties;
mod refusals;
mod safest;
mod scene;
mod worked;
