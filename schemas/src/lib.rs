//! The messages between clients, planner and recorder, and nothing else.
//!
//! A scene request and its reply exist in three forms: as JSON ([`json`]), which
//! people write and read; as owned Rust values ([`message`]), which are planned
//! from and recorded (in the form of [`codec`]); and as plain memory ([`wire`]),
//! which lies in shared memory. [`convert`] leads from one to the other and is the one
//! place where what a peer wrote is checked.
//!
//! Units are metres, radians and seconds; time stamps are nanoseconds with the
//! suffix `_ns`, counted from the Unix epoch.

pub mod codec;
pub mod convert;
pub mod json;
pub mod message;
pub mod status;
pub mod topic;
pub mod wire;
