//! A request being answered: streaming its reply into shared memory.

use std::cell::Cell;
use std::time::{Duration, Instant};

use iceoryx2::port::SendError;
use iceoryx2::prelude::{Node, ipc};
use schemas::convert::{CellWriter, PartSink};
use schemas::wire::{self, previous};

use super::ringer::Ringer;
use crate::cause::Cause;
use crate::error::ReplyError;
use crate::headers::{Current, UserHeader, Version};
use crate::ports::PlanRequest;
use crate::previous::Previous;
use crate::tap::TapWriter;

/// A request of one of the versions that the planner serves.
#[derive(Debug)]
pub(super) enum Active {
    Current(PlanRequest<Current>),
    Previous(PlanRequest<Previous>),
}

impl Active {
    /// The request's header, in the current version.
    pub(super) fn header(&self) -> wire::RequestHeader {
        match self {
            Self::Current(active) => Current::upgrade(active.user_header().plain()),
            Self::Previous(active) => Previous::upgrade(active.user_header().plain()),
        }
    }

    /// Whether the client still waits for the reply.
    fn is_connected(&self) -> bool {
        match self {
            Self::Current(active) => active.is_connected(),
            Self::Previous(active) => active.is_connected(),
        }
    }

    /// The request's payload, the same in both versions.
    pub(super) fn payload(&self) -> &[u64] {
        match self {
            Self::Current(active) => active.payload(),
            Self::Previous(active) => active.payload(),
        }
    }
}

/// Memory for what is translated to the previous version.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    cells: Vec<u64>,
    old: Vec<u64>,
}

/// What answering any request takes.
#[derive(Debug)]
pub(super) struct Desk {
    pub(super) ringer: Ringer,
    pub(super) tap: TapWriter,
    pub(super) scratch: Scratch,
    pub(super) patience: Duration,
}

/// A request that waits for its answer.
#[derive(Debug)]
pub struct Incoming<'a> {
    pub(super) active: Active,
    pub(super) desk: &'a mut Desk,
    pub(super) node: &'a Node<ipc::Service>,
}

impl Incoming<'_> {
    /// Copies the request out of shared memory, where its sender could still change it.
    pub fn copy(&self, cells: &mut Vec<u64>) -> wire::RequestHeader {
        cells.clear();
        cells.extend_from_slice(self.active.payload());
        self.active.header()
    }

    /// The request's header.
    pub fn header(&self) -> wire::RequestHeader {
        self.active.header()
    }

    /// How many cells the request's payload has.
    pub fn cells(&self) -> usize {
        self.active.payload().len()
    }

    /// Where the answer goes.
    pub fn reply(&mut self) -> ReplySink<'_> {
        self.reply_to_client().0
    }

    /// The same, and who waits for it.
    pub fn reply_to_client(&mut self) -> (ReplySink<'_>, ClientWatch<'_>) {
        let header = self.active.header();
        let wake = (header.wake != 0).then_some(header.client);
        let Self { active, desk, node } = self;
        let watch = ClientWatch { active, node, swept: Cell::new(Instant::now()) };
        (ReplySink { active, desk, wake }, watch)
    }
}

/// Watches the client of a request that is being answered.
#[derive(Debug)]
pub struct ClientWatch<'a> {
    active: &'a Active,
    node: &'a Node<ipc::Service>,
    /// The last look for peers that died.
    swept: Cell<Instant>,
}

impl ClientWatch<'_> {
    /// Whether the client still waits: it has neither dropped the request nor left. That it died
    /// is found out by looking for dead peers, once a second.
    pub fn is_waiting(&self) -> bool {
        let now = Instant::now();
        if now.duration_since(self.swept.get()) >= SWEEP {
            self.node.try_cleanup_dead_nodes();
            self.swept.set(now);
        }
        self.active.is_connected()
    }
}

/// How often a planner looks for peers that died: about 0.1 ms for each that lives.
pub(super) const SWEEP: Duration = Duration::from_secs(1);

/// Streams a reply into shared memory, in the version of its request.
#[derive(Debug)]
pub struct ReplySink<'a> {
    active: &'a Active,
    desk: &'a mut Desk,
    wake: Option<u64>,
}

impl PartSink for ReplySink<'_> {
    type Error = ReplyError;

    fn part(
        &mut self,
        header: &wire::ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), ReplyError> {
        // A closed channel takes parts and drops them silently.
        if !self.active.is_connected() {
            return Err(ReplyError::Gone);
        }
        let header = wire::ReplyHeader { sent_ns: crate::clock::now_ns(), ..*header };
        let Desk { ringer, tap, scratch, patience } = &mut *self.desk;
        let sent = match self.active {
            Active::Current(active) => {
                send::<Current>(active, header, cells, fill, |cells| tap.reply(&header, cells))
            }
            Active::Previous(active) if previous::same_cells(&header) => {
                let old = previous::downgrade_header(&header);
                send::<Previous>(active, old, cells, fill, |cells| {
                    tap.reply(&header, cells);
                    previous::downgrade_trajectory(&header, cells);
                })
            }
            Active::Previous(active) => {
                scratch.cells.clear();
                scratch.cells.resize(cells, 0);
                fill_all(&mut scratch.cells, fill);
                tap.reply(&header, &scratch.cells);
                let cells = &mut scratch.old;
                let old = previous::downgrade_refusal(&header, &scratch.cells, cells);
                let fill = |writer: &mut CellWriter| cells.iter().for_each(|c| writer.push(*c));
                send::<Previous>(active, old, cells.len(), fill, |_| {})
            }
        };
        sent.map_err(|error| match error {
            SendError::UnableToDeliver => ReplyError::Slow { patience: *patience },
            error => ReplyError::Bus(Cause::from(error)),
        })?;
        if let Some(client) = self.wake
            && !ringer.ring(client)
        {
            self.wake = None;
        }
        Ok(())
    }
}

/// Sends one part: `fill` writes its payload into the loaned memory, `finish` has it before
/// it goes.
fn send<V: Version>(
    active: &PlanRequest<V>,
    header: <V::Reply as UserHeader>::Plain,
    cells: usize,
    fill: impl FnOnce(&mut CellWriter),
    finish: impl FnOnce(&mut [u64]),
) -> Result<(), SendError> {
    let mut response = active.loan_slice_uninit(cells)?;
    response.user_header_mut().set(header);
    let payload = response.payload_mut();
    #[expect(unsafe_code, reason = "loaned memory is written where it will be read")]
    // SAFETY: the memory is mapped from the operating system, which hands it out
    // initialised, and every bit pattern is a u64. All of it is written below.
    let payload = unsafe { &mut *(payload as *mut [_] as *mut [u64]) };
    fill_all(payload, fill);
    #[expect(unsafe_code, reason = "loaned memory is written where it will be read")]
    // SAFETY: all cells are written, as just checked.
    let mut response = unsafe { response.assume_init() };
    finish(response.payload_mut());
    response.send()
}

fn fill_all(cells: &mut [u64], fill: impl FnOnce(&mut CellWriter)) {
    let count = cells.len();
    let mut writer = CellWriter::new(cells);
    fill(&mut writer);
    assert_eq!(writer.filled(), count, "a part is written in full");
}
