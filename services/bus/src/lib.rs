//! Typed ports over iceoryx2 shared memory.
//!
//! A [`Server`] (the planner) takes scene requests and streams replies to them, part by
//! part; a [`Client`] asks; a [`TapReader`] (the recorder) sees all of it. This crate is
//! the only caller of iceoryx2's builders: `ports.rs` holds every setting of the services,
//! and every cure for what can go wrong on the bus is here:
//!
//! - a reply can reach the wrong client: [`Client`] checks the request key;
//! - a wake-up can be lost: [`wait`] drains the bell until it is silent;
//! - a slow or dead client can't hold the server up: sending never waits, see [`Incoming`];
//! - a request can change while it is read, or be shorter than it says: [`Incoming::copy`];
//! - a slow recorder can't either: it loses messages, and [`TapReader`] counts them.
//!
//! # Versions
//!
//! A planner serves the current version of the messages and the one before it
//! ([`schemas::wire::previous`]) side by side, each as a service with its own name, so
//! clients can be upgraded one by one after the planner. Both share the planner's places
//! (`max_clients`) and its bells, and are served in turn. The tap carries the current
//! version only: upgrade recorders together with the planner. A client needs a planner at
//! least as new as itself ([`ConnectError::OlderPlanner`]).

mod cause;
pub mod client;
mod clock;
mod connect;
pub mod domain;
mod error;
mod fork;
mod headers;
mod janitor;
mod ledger;
mod list;
mod log;
mod member;
mod memory;
mod options;
mod ports;
mod presence;
mod previous;
mod process;
mod root;
pub mod server;
mod site;
pub mod status;
pub mod tap;
#[cfg(test)]
mod test_domain;
pub mod wait;

pub use cause::Cause;
pub use client::{Client, Loan, Pending};
pub use clock::now_ns;
pub use domain::{Domain, DomainError};
pub use error::{CallError, ConnectError, OpenError, ReceiveError, ReplyError};
pub use fork::Origin;
pub use list::{DomainStatus, PlannerStatus, domains};
pub use log::forward_to_tracing;
pub use memory::free_memory;
pub use options::{ReplyOptions, ServerOptions};
pub use ports::most_memory;
pub use presence::SUPERVISOR_VARIABLE;
pub use root::{ROOT_VARIABLE, RootError, RootProblem};
pub use server::{ClientWatch, Incoming, ReplySink, Server, Waker};
pub use status::StatusReader;
pub use tap::{TapEvent, TapMessage, TapReader};
pub use wait::{Wait, Woken, leave_signals_alone, terminated, termination_signal};
