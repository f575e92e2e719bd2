//! Typed ports over iceoryx2 shared memory.
//!
//! A [`Server`] (the planner) takes scene requests and streams replies to them, part
//! by part; a [`Client`] asks; a [`TapReader`] (the recorder) sees all of it. This
//! crate is the only caller of iceoryx2's builders, so every setting of the services
//! stands in `ports.rs`, and every cure for what can go wrong on the bus stands here:
//!
//! - a reply can reach the wrong client: [`Client`] checks the request key;
//! - a wake-up can be lost: [`wait`] drains the bell until it is silent;
//! - a slow or dead client can't hold the server up: see [`ReplyOptions`];
//! - a slow recorder can't either: it loses messages and [`TapReader`] counts them.

pub mod client;
pub mod domain;
mod headers;
mod log;
mod ports;
pub mod server;
pub mod tap;
pub mod wait;

pub use client::{CallError, Client, ConnectError, Pending};
pub use domain::{Domain, DomainError};
pub use log::forward_to_tracing;
pub use ports::most_memory;
pub use server::{Incoming, OpenError, ReplyError, ReplyOptions, ReplySink, Server, ServerOptions};
pub use tap::{TapEvent, TapMessage, TapReader};
pub use wait::{Wait, Woken, terminated};

use std::time::{SystemTime, UNIX_EPOCH};

/// The wall clock, as messages carry it: nanoseconds since the Unix epoch.
pub fn now_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64)
}

#[cfg(test)]
mod test_domain {
    use std::sync::atomic::{AtomicU32, Ordering};

    use crate::Domain;

    /// A domain that nobody else uses. The last port that is dropped tidies up.
    pub(crate) fn test_domain() -> Domain {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        Domain::new(&format!("unit-{}-{count}", std::process::id())).expect("a possible name")
    }
}
