//! Plans again what was recorded, and compares.
//!
//! How a request is planned is an argument throughout: the program passes the planner's
//! one pure function, tests pass their own.

pub mod check;
pub mod cli;
pub mod compare;
pub mod diff;
pub mod exchanges;
pub mod info;
pub mod report;
