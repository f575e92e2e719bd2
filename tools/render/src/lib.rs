//! Replies for people: pictures (SVG), tables and rows of samples (CSV).

pub mod chart;
pub mod csv;
pub mod picture;
pub mod table;
