//! Replies for people: pictures (SVG) and tables.

pub mod picture;
pub mod table;
