//! `libclearway`: the client for C, in `include/clearway.h`, and on top of it C++, in
//! `include/clearway.hpp`.
//!
//! Functions check what can be checked of their arguments; what they demand beyond that is in their
//! documentation, which is that of the header.
#![expect(unsafe_code, reason = "pointers come from C")]
#![expect(clippy::missing_safety_doc, reason = "the header says what pointers must be")]

mod client;
mod error;
mod reply;
mod values;

pub use client::*;
pub use error::*;
pub use reply::*;
pub use values::*;
