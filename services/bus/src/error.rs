//! Why something on the bus failed.

use std::time::Duration;

use schemas::convert::Malformed;
use schemas::message::{AssembleError, Refusal};
use schemas::wire;
use thiserror::Error;

use crate::cause::Cause;
use crate::domain::{Domain, DomainError};
use crate::memory::Shortage;

/// Why there is no connection to a planner.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ConnectError {
    /// The domain can't be joined.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// No planner is there.
    #[error(
        "no planner runs in domain {domain}{} (start one with `planner --domain {domain}`)",
        place(domain)
    )]
    NoPlanner {
        /// The domain.
        domain: Domain,
    },
    /// The planner there serves older versions of the messages only.
    #[error(
        "the planner in domain {domain} speaks version {planner} of the messages, this program \
         version {current}: upgrade the planner",
        current = wire::VERSION
    )]
    OlderPlanner {
        /// The domain.
        domain: Domain,
        /// The newest version it serves.
        planner: u32,
    },
    /// The planner there means something else by this version of the messages.
    #[error(
        "the planner in domain {domain} has another layout of version {current} of the messages \
         than this program ({layout:016x}): build both from the same release",
        current = wire::VERSION
    )]
    OtherLayout {
        /// The domain.
        domain: Domain,
        /// This program's layout; see [`wire::layout_hash`].
        layout: u64,
    },
    /// All places are taken.
    #[error(
        "{} connected in domain {domain}, the most this planner takes (`{setting}`)",
        count(*most, who)
    )]
    Full {
        /// The domain.
        domain: Domain,
        /// Clients or recorders.
        who: &'static str,
        /// How many the planner takes.
        most: usize,
        /// The planner's setting.
        setting: &'static str,
    },
    /// Shared memory is too small; to connect even so could end the program by SIGBUS.
    #[error(
        "/dev/shm has {free} bytes free, connecting to the planner needs {needs}: remove files \
         there, or enlarge it"
    )]
    SharedMemory {
        /// Bytes needed.
        needs: u64,
        /// Bytes free.
        free: u64,
    },
    /// The operating system has no random numbers.
    #[error("can't draw a random number to identify this client: {0}")]
    Random(String),
    /// Something else is wrong with shared memory.
    #[error("can't open {what} in domain {domain}: {cause}")]
    Service {
        /// What can't be opened.
        what: &'static str,
        /// The domain.
        domain: Domain,
        /// Why not.
        cause: Cause,
    },
}

/// So many of them.
fn count(most: usize, who: &str) -> String {
    match most {
        1 => format!("1 {} is", who.trim_end_matches('s')),
        most => format!("{most} {who} are"),
    }
}

/// Where a domain was looked for.
fn place(domain: &Domain) -> String {
    domain.root().map_or_else(|_| String::new(), |root| format!(" under {}", root.display()))
}

/// Why a request has no reply.
#[derive(Debug, Error)]
pub enum CallError {
    /// The scene can't be sent as it is.
    #[error("{}", .0.message)]
    Scene(Refusal),
    /// This client has too many open requests.
    #[error(
        "{most} requests of this client are open, the most this planner takes (`requests_per_client`)"
    )]
    TooManyRequests {
        /// How many the planner takes.
        most: usize,
    },
    /// Shared memory is too small for the request.
    #[error(
        "/dev/shm has {free} bytes free, this request needs {needs}: remove files there, or \
         enlarge it"
    )]
    SharedMemory {
        /// Bytes needed.
        needs: u64,
        /// Bytes free.
        free: u64,
    },
    /// It could not be sent.
    #[error("can't send the request: {0}")]
    Send(Cause),
    /// What came could not be taken from shared memory.
    #[error("can't receive the reply: {0}")]
    Receive(Cause),
    /// The planner ended before it had replied.
    #[error(
        "planner_lost: the planner ended before it replied, perhaps because of this request; \
         if not, send it again"
    )]
    PlannerLost,
    /// The planner gave up the reply because nobody took it.
    #[error("the planner gave up this reply: no part of it was taken for too long (`patience`)")]
    GivenUp,
    /// No reply came in time.
    #[error("no reply after {waited:?} (limit {limit:?})")]
    TimedOut {
        /// Time waited.
        waited: Duration,
        /// Time allowed.
        limit: Duration,
    },
    /// What the planner wrote is not a reply.
    #[error("the reply is malformed: {0}")]
    Malformed(#[from] Malformed),
    /// A part of it can't be where it says that it is.
    #[error("the reply is malformed: a part claims {claimed} cells, but has at most {most}")]
    LongPart {
        /// Cells that it claims.
        claimed: u64,
        /// Cells that any part has room for.
        most: usize,
    },
    /// Parts of the reply are missing.
    #[error("the reply is incomplete: {0}")]
    Incomplete(#[from] AssembleError),
    /// SIGINT, SIGTERM or SIGHUP came.
    #[error("interrupted")]
    Interrupted,
    /// The client was connected by a process of which this is a fork.
    #[error("forked: this client was connected before the process was forked; connect another")]
    Forked,
}

/// Why the planner's side can't be opened.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum OpenError {
    /// The domain can't be joined.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Another planner answers requests there.
    #[error("another planner serves domain {0}")]
    AnotherPlanner(Domain),
    /// Shared memory is too small, which would only show as a SIGBUS later.
    #[error(
        "/dev/shm has {free} bytes free, these settings can need {needs}: lower max_clients, \
         requests_per_client, max_recorders or tap_buffer, or enlarge /dev/shm"
    )]
    SharedMemory {
        /// Bytes needed in the worst case.
        needs: u64,
        /// Bytes free.
        free: u64,
    },
    /// The operating system refuses something.
    #[error("can't wait for requests: {0}")]
    System(String),
    /// A service can't be opened.
    #[error("can't open {what} in domain {domain}: {cause}")]
    Service {
        /// Which one.
        what: &'static str,
        /// The domain.
        domain: Domain,
        /// Why not.
        cause: Cause,
    },
}

/// Why a request can't be taken from shared memory.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ReceiveError {
    /// It is larger than allowed.
    #[error("the request has {cells} cells; at most {most} are allowed")]
    TooLarge {
        /// Cells that it has.
        cells: usize,
        /// Cells allowed.
        most: usize,
    },
    /// Its sender claims more than there is.
    #[error("the request should have {cells} cells, but its memory ends after {has}")]
    Short {
        /// Cells that it claims.
        cells: usize,
        /// Cells that are there.
        has: usize,
    },
}

/// Why the rest of a reply can't be sent. It concerns nobody but its client.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ReplyError {
    /// The client has dropped its request, or left, or another took its place.
    #[error("the client has left")]
    Gone,
    /// The client did not take the parts before.
    #[error("the client took no part of its reply for {patience:?} (`patience`)")]
    Slow {
        /// Time waited.
        patience: Duration,
    },
    /// Parts of an earlier reply fill the client's buffer. The part is lost: to go on, write it
    /// again with [`Incoming::push`](crate::Incoming::push).
    #[error("parts of an earlier reply are in the way")]
    Full,
    /// The bus refused.
    #[error("can't send the reply: {0}")]
    Bus(Cause),
}

impl From<Shortage> for ConnectError {
    fn from(Shortage { needs, free }: Shortage) -> Self {
        Self::SharedMemory { needs, free }
    }
}

impl From<Shortage> for CallError {
    fn from(Shortage { needs, free }: Shortage) -> Self {
        Self::SharedMemory { needs, free }
    }
}

impl From<Shortage> for OpenError {
    fn from(Shortage { needs, free }: Shortage) -> Self {
        Self::SharedMemory { needs, free }
    }
}
