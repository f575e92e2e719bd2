//! Recorded exchanges, planned again and compared.
//!
//! [`exchanges`] puts requests and replies of a recording together, [`compare`] compares two
//! replies answer by answer, [`check`] plans a recording's requests again, and [`diff`] compares
//! two recordings, whose requests [`pair`] puts side by side. How a request is planned is an
//! argument: this crate knows neither the planner nor the bus.

pub mod check;
pub mod compare;
pub mod describe;
pub mod diff;
pub mod exchanges;
pub mod motion;
pub mod named;
pub mod pair;
pub mod report;
pub mod tolerance;
