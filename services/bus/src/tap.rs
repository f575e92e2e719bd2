//! The planner's copy of all traffic, and its reader.
//!
//! One sequence runs over requests and replies, in the order in which the planner
//! took and sent them. Nothing is copied while nobody listens. A heartbeat carries
//! the next sequence number, so that a loss at the very end shows as well.

use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniquePublisherId;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{AllocationStrategy, PortFactory, ipc};
use schemas::convert::{self, Malformed};
use schemas::message::{ReplyPart, Request};
use schemas::wire;

use crate::client::ConnectError;
use crate::domain::Domain;
use crate::headers::TapHeader;
use crate::ports;
use crate::server::Tidy;
use crate::wait;

/// Cells of one message of the tap: a whole reply part with its header fits; longer
/// requests are cut.
const MESSAGE_CELLS: usize = wire::PART_CELLS + size_of::<wire::ReplyHeader>() / 8;

/// How often the heartbeat comes.
const HEARTBEAT: Duration = Duration::from_millis(100);

/// Kinds of messages, as in [`wire::TapHeader`].
const REQUEST: u32 = 0;
const REPLY: u32 = 1;
const BEAT: u32 = 2;

/// [`wire::TapHeader::piece`]: the message begins here; it ends here.
const BEGINS: u32 = 1;
const ENDS: u32 = 2;

/// The planner's end of the tap.
#[derive(Debug)]
pub(crate) struct TapWriter {
    port: Publisher<ipc::Service, [u64], TapHeader>,
    service: ports::Tap,
    sequence: u64,
    beaten: Instant,
}

impl TapWriter {
    pub(crate) fn create(service: ports::Tap) -> Result<Self, String> {
        let port = service
            .publisher_builder()
            .initial_max_slice_len(MESSAGE_CELLS)
            .allocation_strategy(AllocationStrategy::Static)
            .max_loaned_samples(1)
            .create()
            .map_err(ports::said)?;
        Ok(Self { port, service, sequence: 0, beaten: Instant::now() })
    }

    fn listened_to(&self) -> bool {
        self.service.dynamic_config().number_of_subscribers() > 0
    }

    pub(crate) fn request(&mut self, header: &wire::RequestHeader, cells: &[u64]) {
        if self.listened_to() {
            self.publish(REQUEST, bytemuck::cast_slice(bytemuck::bytes_of(header)), cells);
        }
    }

    pub(crate) fn reply(&mut self, header: &wire::ReplyHeader, cells: &[u64]) {
        if self.listened_to() {
            self.publish(REPLY, bytemuck::cast_slice(bytemuck::bytes_of(header)), cells);
        }
    }

    /// Says how far the sequence has come, if it is time to and anybody listens.
    pub(crate) fn heartbeat(&mut self) {
        if self.beaten.elapsed() >= HEARTBEAT && self.listened_to() {
            self.beaten = Instant::now();
            self.send(BEAT, BEGINS | ENDS, &[], &[]);
        }
    }

    fn publish(&mut self, kind: u32, mut head: &[u64], mut cells: &[u64]) {
        let mut piece = BEGINS;
        loop {
            let (now, later) = cells.split_at(cells.len().min(MESSAGE_CELLS - head.len()));
            piece |= if later.is_empty() { ENDS } else { 0 };
            self.send(kind, piece, head, now);
            if later.is_empty() {
                return;
            }
            (piece, head, cells) = (0, &[], later);
        }
    }

    fn send(&mut self, kind: u32, piece: u32, head: &[u64], cells: &[u64]) {
        let header =
            wire::TapHeader { sequence: self.sequence, time_ns: crate::now_ns(), kind, piece };
        if kind != BEAT {
            self.sequence += 1;
        }
        // Not sent is lost, and shows in the sequence.
        match self.port.loan_slice_uninit(head.len() + cells.len()) {
            Ok(mut sample) => {
                sample.user_header_mut().0 = header;
                let written = sample.write_from_fn(|at| {
                    head.get(at).copied().unwrap_or_else(|| cells[at - head.len()])
                });
                if let Err(error) = written.send() {
                    tracing::warn!(?error, "the tap lost a message");
                }
            }
            Err(error) => tracing::warn!(?error, "the tap lost a message"),
        }
    }
}

/// What a [`TapReader`] sees.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly every event is a message")]
pub enum TapEvent {
    /// A message.
    Message(TapMessage),
    /// Messages that came too fast and are lost.
    Lost {
        /// How many bus messages.
        messages: u64,
    },
    /// Another planner took over; its sequence starts anew. What the old one sent last
    /// may be lost.
    Restarted,
}

/// A message seen on the tap.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "messages are passed on, not kept in lists")]
pub enum TapMessage {
    /// A request.
    Request(Request),
    /// A part of a reply.
    Reply(ReplyPart),
}

/// A recorder's end of the tap.
#[derive(Debug)]
pub struct TapReader {
    port: Subscriber<ipc::Service, [u64], TapHeader>,
    /// Whose sequence is being followed.
    publisher: Option<UniquePublisherId>,
    /// The sequence number that comes next; none before the first message.
    next: Option<u64>,
    /// A message that is not complete yet.
    begun: Vec<u64>,
    /// An event that waits behind a loss.
    waiting: Option<TapMessage>,
    _tidy: Tidy,
}

impl TapReader {
    /// Listens to the planner of a domain.
    pub fn connect(domain: &Domain) -> Result<Self, ConnectError> {
        let node = domain.join("recorder")?;
        let failed = |cause| ConnectError::NoPlanner { domain: domain.clone(), cause };
        let service = ports::open_tap(&node).map_err(failed)?;
        let buffer = service.static_config().subscriber_max_buffer_size();
        let port = service.subscriber_builder().buffer_size(buffer).create().map_err(|error| {
            ConnectError::Full { domain: domain.clone(), cause: ports::said(error) }
        })?;
        Ok(Self {
            port,
            publisher: None,
            next: None,
            begun: Vec::new(),
            waiting: None,
            _tidy: Tidy(domain.clone()),
        })
    }

    /// Whether SIGINT or SIGTERM has asked to end.
    pub fn terminated(&self) -> bool {
        wait::terminated()
    }

    /// The next thing that happened, if anything has.
    pub fn receive(&mut self) -> Option<TapEvent> {
        if let Some(message) = self.waiting.take() {
            return Some(TapEvent::Message(message));
        }
        loop {
            let sample = match self.port.receive() {
                Ok(sample) => sample?,
                Err(error) => {
                    tracing::warn!(?error, "could not receive from the tap");
                    return None;
                }
            };
            let header = sample.user_header().0;
            let publisher = sample.header().publisher_id();
            let restarted = self.publisher.replace(publisher).is_some_and(|old| old != publisher);
            let expected = self.next.filter(|_| !restarted).unwrap_or(header.sequence);
            let beat = header.kind == BEAT;
            self.next = Some(if beat { header.sequence } else { header.sequence.wrapping_add(1) });
            let lost = header.sequence.wrapping_sub(expected);
            let gap = match (restarted, lost) {
                (true, _) => Some(TapEvent::Restarted),
                (false, 0) => None,
                (false, messages) => Some(TapEvent::Lost { messages }),
            };
            if gap.is_some() {
                self.begun.clear();
            }
            let message = if beat { None } else { self.assemble(&header, sample.payload()) };
            match (gap, message) {
                (None, None) => {}
                (None, Some(message)) => return Some(TapEvent::Message(message)),
                (Some(gap), message) => {
                    self.waiting = message;
                    return Some(gap);
                }
            }
        }
    }

    /// The message that is complete with this piece.
    fn assemble(&mut self, header: &wire::TapHeader, cells: &[u64]) -> Option<TapMessage> {
        match (header.piece & BEGINS != 0, header.piece & ENDS != 0) {
            (true, true) => read_message(header, cells),
            (true, false) => {
                self.begun.clear();
                self.begun.extend_from_slice(cells);
                None
            }
            // The beginning is lost.
            (false, _) if self.begun.is_empty() => None,
            (false, false) => {
                self.begun.extend_from_slice(cells);
                None
            }
            (false, true) => {
                self.begun.extend_from_slice(cells);
                let whole = std::mem::take(&mut self.begun);
                read_message(header, &whole)
            }
        }
    }
}

fn read_message(header: &wire::TapHeader, cells: &[u64]) -> Option<TapMessage> {
    let read = match header.kind {
        REQUEST => split::<wire::RequestHeader>(cells)
            .map(|(header, cells)| TapMessage::Request(convert::read_request(&header, cells))),
        REPLY => split::<wire::ReplyHeader>(cells)
            .and_then(|(header, cells)| convert::read_part(&header, cells))
            .map(TapMessage::Reply),
        code => Err(Malformed::UnknownCode {
            what: "tap kind",
            code: code.into(),
            greatest: BEAT.into(),
        }),
    };
    // A planner of this layout writes no such thing.
    read.inspect_err(|error| tracing::warn!(%error, "unreadable message on the tap")).ok()
}

fn split<T: bytemuck::Pod>(cells: &[u64]) -> Result<(T, &[u64]), Malformed> {
    let size = size_of::<T>() / 8;
    match cells.split_at_checked(size) {
        Some((head, rest)) => Ok((bytemuck::pod_read_unaligned(bytemuck::cast_slice(head)), rest)),
        None => {
            Err(Malformed::TooShort { what: "header", needs: size as u64, has: cells.len() as u64 })
        }
    }
}
