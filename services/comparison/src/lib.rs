//! Recorded exchanges, planned again and compared.
//!
//! [`exchanges`] puts requests and replies of a recording together, [`compare`] finds the
//! first difference of two replies, [`check`] plans a recording's requests again, and
//! [`diff`] compares two recordings. How a request is planned is an argument: this crate
//! knows neither the planner nor the bus.

pub mod check;
pub mod compare;
pub mod diff;
pub mod exchanges;
