//! What the `plan` command prints and draws; the demo shows the same.

pub mod map;
pub mod output;
pub mod picture;
