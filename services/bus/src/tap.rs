//! The planner's copy of all traffic, and its reader.
//!
//! One sequence runs over requests and replies, in the order in which the planner took and
//! sent them, whatever version their client speaks: the tap carries the current one.
//! Nothing is copied while nobody listens. A heartbeat carries the next sequence number,
//! so a loss at the very end shows as well, and the free space that the next request names, if
//! somebody listens who has not seen it. The number outlasts the planner (`ledger`):
//! the next one goes on counting, so that what is lost at a restart is counted exactly.

use std::collections::{BTreeSet, VecDeque};
use std::time::{Duration, Instant};

use iceoryx2::identifiers::{UniquePublisherId, UniqueSubscriberId};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{AllocationStrategy, CallbackProgression, PortFactory, ipc};
use schemas::convert::{self, Malformed};
use schemas::message::{Digest, ReplyPart, Request, Sample};
use schemas::wire;

use crate::cause::Cause;
use crate::clock::now_ns;
use crate::connect;
use crate::domain::Domain;
use crate::error::ConnectError;
use crate::headers::{TapHeader, UserHeader};
use crate::ledger::Ledger;
use crate::member::Member;
use crate::memory;
use crate::ports;
use crate::presence::Visitor;
use crate::wait;

/// Cells of one message of the tap: a whole reply part with its header; longer requests
/// are cut into pieces.
const MESSAGE_CELLS: usize = wire::PART_CELLS + size_of::<wire::ReplyHeader>() / 8;

/// Time between heartbeats.
const HEARTBEAT: Duration = Duration::from_millis(100);

/// Names that the writer remembers having shown. Beyond, it shows them once more.
const MOST_SHOWN: usize = 4096;

/// Kinds of messages, as in [`wire::TapHeader`].
const REQUEST: u32 = 0;
const REPLY: u32 = 1;
const BEAT: u32 = 2;

/// The planner's end of the tap.
#[derive(Debug)]
pub(crate) struct TapWriter {
    port: Publisher<ipc::Service, [u64], TapHeader>,
    service: ports::Tap,
    ledger: Ledger,
    beaten: Instant,
    /// Who listened when a free space was last looked for.
    listeners: Vec<UniqueSubscriberId>,
    /// The named free spaces that all of them were shown.
    shown: BTreeSet<Digest>,
}

impl TapWriter {
    pub(crate) fn create(service: ports::Tap, ledger: Ledger) -> Result<Self, Cause> {
        let port = service
            .publisher_builder()
            .initial_max_slice_len(MESSAGE_CELLS)
            .allocation_strategy(AllocationStrategy::Static)
            .max_loaned_samples(1)
            .create()
            .map_err(Cause::from)?;
        let (listeners, shown) = (Vec::new(), BTreeSet::new());
        Ok(Self { port, service, ledger, beaten: Instant::now(), listeners, shown })
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

    /// Whether somebody listens who was not shown the free space of this name.
    pub(crate) fn lacks(&mut self, name: Digest) -> bool {
        if !self.listened_to() {
            return false;
        }
        let mut is_new = false;
        let mut now = Vec::with_capacity(self.listeners.len());
        self.service.dynamic_config().list_subscribers(|subscriber| {
            is_new |= !self.listeners.contains(&subscriber.subscriber_id);
            now.push(subscriber.subscriber_id);
            CallbackProgression::Continue
        });
        self.listeners = now;
        if is_new || self.shown.len() > MOST_SHOWN {
            self.shown.clear();
        }
        !self.shown.contains(&name)
    }

    /// Shows a request that would make the free space of this name known. It is none of the bus's messages, and
    /// has no number of its own. One that would fill half of a recorder's buffer is not shown: it
    /// would push messages out.
    pub(crate) fn show(&mut self, name: Digest, header: &wire::RequestHeader, cells: &[u64]) {
        self.shown.insert(name);
        let head: &[u64] = bytemuck::cast_slice(bytemuck::bytes_of(header));
        let pieces = (head.len() + cells.len()).div_ceil(MESSAGE_CELLS);
        let most = self.service.static_config().subscriber_max_buffer_size() / 2;
        if pieces > most.max(1) {
            return tracing::warn!(%name, pieces, most, "a free space is too large for the tap");
        }
        let next = self.ledger.next();
        self.send_all(BEAT, next, head, cells);
    }

    /// If it is time to, announces the next sequence number, or forgets the last who listened.
    /// Whether anybody listens and it was time.
    pub(crate) fn heartbeat(&mut self) -> bool {
        if self.beaten.elapsed() < HEARTBEAT {
            return false;
        }
        self.beaten = Instant::now();
        let is_due = self.listened_to();
        if is_due {
            let next = self.ledger.next();
            self.send(BEAT, next, Piece { index: 0, ends: true }, &[], &[]);
        } else if let Err(error) = self.port.update_connections() {
            tracing::debug!(?error, "can't forget a recorder");
        }
        is_due
    }

    fn publish(&mut self, kind: u32, head: &[u64], cells: &[u64]) {
        // Counted first: what a kill keeps from being sent is lost, and shows.
        let sequence = self.ledger.take();
        self.send_all(kind, sequence, head, cells);
    }

    fn send_all(&mut self, kind: u32, sequence: u64, mut head: &[u64], mut cells: &[u64]) {
        for index in 0.. {
            let (now, later) = cells.split_at(cells.len().min(MESSAGE_CELLS - head.len()));
            let piece = Piece { index, ends: later.is_empty() };
            self.send(kind, sequence, piece, head, now);
            if piece.ends {
                return;
            }
            (head, cells) = (&[], later);
        }
    }

    /// What can't be sent is lost, and shows as a gap in the sequence.
    fn send(&mut self, kind: u32, sequence: u64, piece: Piece, head: &[u64], cells: &[u64]) {
        let mut sample = match self.port.loan_slice_uninit(head.len() + cells.len()) {
            Ok(sample) => sample,
            Err(error) => {
                let cause = Cause::from(error);
                return tracing::warn!(%cause, "the tap lost a message");
            }
        };
        let piece = piece.code();
        let header = wire::TapHeader { sequence, time_ns: now_ns(), kind, piece };
        sample.user_header_mut().set(header);
        let (first, second) = sample.payload_mut().split_at_mut(head.len());
        first.write_copy_of_slice(head);
        second.write_copy_of_slice(cells);
        #[expect(unsafe_code, reason = "two slices are copied into one")]
        // SAFETY: all cells are written.
        let written = unsafe { sample.assume_init() };
        if let Err(error) = written.send() {
            tracing::warn!(cause = %Cause::from(error), "the tap lost a message");
        }
    }
}

/// Which piece of a message this is, as in [`wire::TapHeader::piece`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Piece {
    /// Its number in the message, from 0.
    index: u32,
    /// Whether it is the last.
    ends: bool,
}

impl Piece {
    fn code(self) -> u32 {
        self.index << 1 | u32::from(self.ends)
    }

    fn from_code(code: u32) -> Self {
        Self { index: code >> 1, ends: code & 1 != 0 }
    }
}

/// What a [`TapReader`] sees.
#[derive(Debug, Clone, PartialEq)]
pub enum TapEvent {
    /// A message.
    Message(TapMessage),
    /// A request that made a free space known before this reader joined. The next request refers to
    /// it by its name.
    FreeSpace(Request),
    /// Messages came too fast and are lost.
    Lost {
        /// How many bus messages.
        messages: u64,
    },
    /// Another planner took over. It goes on with the message numbers; what the old one could
    /// not deliver is counted as lost.
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

impl TapEvent {
    /// The samples of a part of a reply, if it is one with a path.
    fn samples(&mut self) -> Option<&mut Vec<Sample>> {
        let Self::Message(TapMessage::Reply(part)) = self else { return None };
        part.content.as_mut().ok().map(|trajectory| &mut trajectory.samples)
    }

    fn take_samples(&mut self) -> Vec<Sample> {
        self.samples().map(std::mem::take).unwrap_or_default()
    }

    fn set_samples(&mut self, samples: &[Sample]) {
        if let Some(own) = self.samples() {
            *own = samples.to_vec();
        }
    }
}

/// A recorder's end of the tap.
///
/// ```no_run
/// use bus::{Domain, TapEvent, TapReader};
///
/// let mut tap = TapReader::connect(&Domain::default())?;
/// while !tap.terminated() {
///     match tap.receive() {
///         Some(TapEvent::Message(message)) => println!("{message:?}"),
///         Some(TapEvent::FreeSpace(request)) => println!("sent before: {request:?}"),
///         Some(TapEvent::Lost { messages }) => println!("{messages} messages lost"),
///         Some(TapEvent::Restarted) => println!("another planner"),
///         None => std::thread::sleep(std::time::Duration::from_millis(1)),
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct TapReader {
    port: Subscriber<ipc::Service, [u64], TapHeader>,
    service: ports::Tap,
    /// None where the planner is of an earlier version.
    ledger: Option<Ledger>,
    /// The planner whose messages are being received.
    publisher: Option<UniquePublisherId>,
    /// The number of the next message when this began to listen.
    begin: u64,
    /// None before the first message.
    place: Option<Place>,
    /// A message that is not complete yet.
    begun: Vec<u64>,
    /// A free space that is not complete yet, and how many of its pieces came.
    shown: (Vec<u64>, u32),
    /// Events that wait behind another.
    waiting: VecDeque<TapEvent>,
    /// Stays in the domain for as long as the port is open.
    node: Member,
}

impl TapReader {
    /// Listens to the planner of a domain.
    pub fn connect(domain: &Domain) -> Result<Self, ConnectError> {
        let node = domain.join(Visitor::RECORDER)?;
        let failed = |cause| connect::failed(&node, domain, connect::TAP, cause);
        let service = ports::open_tap(&node).map_err(failed)?;
        let settings = service.static_config();
        let (buffer, most) = (settings.subscriber_max_buffer_size(), settings.max_subscribers());
        memory::check_room(memory::CONNECTION + memory::WAITING * buffer as u64)?;
        let port = service.subscriber_builder().buffer_size(buffer).create();
        let port = port.map_err(|error| match error.into() {
            Cause::Full => connect::full(domain, connect::RECORDERS, most),
            cause => failed(cause),
        })?;
        // In this order: what is sent in between is received, and begins earlier.
        let ledger = Ledger::find(&node.directory());
        let begin = ledger.as_ref().map_or(u64::MAX, Ledger::next);
        Ok(Self {
            port,
            service,
            ledger,
            begin,
            publisher: None,
            place: None,
            begun: Vec::new(),
            shown: (Vec::new(), 0),
            waiting: VecDeque::new(),
            node,
        })
    }

    /// Whether a signal has asked to end.
    pub fn terminated(&self) -> bool {
        wait::terminated()
    }

    /// The next event, if there is one.
    pub fn receive(&mut self) -> Option<TapEvent> {
        self.receive_in_place(|mut event, samples| {
            event.set_samples(samples);
            event
        })
    }

    /// Hands the next event to `take`, if there is one; samples of a part of a reply are not in it,
    /// but beside it, where the planner wrote them.
    pub fn receive_in_place<T>(
        &mut self,
        take: impl FnOnce(TapEvent, &[Sample]) -> T,
    ) -> Option<T> {
        loop {
            if let Some(mut event) = self.waiting.pop_front() {
                let samples = event.take_samples();
                return Some(take(event, &samples));
            }
            let sample = match self.port.receive() {
                Ok(sample) => sample?,
                Err(error) => {
                    tracing::warn!(cause = %Cause::from(error), "can't receive from the tap");
                    return None;
                }
            };
            let header = *sample.user_header().plain();
            let publisher = sample.header().publisher_id();
            let restarted = self.publisher.replace(publisher).is_some_and(|old| old != publisher);
            if restarted && self.ledger.is_none() {
                // It counts anew.
                (self.place, self.begin) = (None, u64::MAX);
            }
            let piece = match header.kind {
                BEAT => None,
                _ => Some(Piece::from_code(header.piece)),
            };
            let place =
                self.place.unwrap_or_else(|| Place::first(self.begin, header.sequence, piece));
            let (step, next) = place.step(header.sequence, piece);
            self.place = Some(next);
            self.waiting.extend(restarted.then_some(TapEvent::Restarted));
            let lost = (step.lost > 0).then_some(TapEvent::Lost { messages: step.lost });
            self.waiting.extend(lost);
            if header.kind == BEAT && !sample.payload().is_empty() {
                let piece = Piece::from_code(header.piece);
                let shown = self.assemble_shown(piece, sample.payload());
                self.waiting.extend(shown.map(TapEvent::FreeSpace));
            }
            let Some(piece) = piece.filter(|_| step.keep) else { continue };
            let whole = if piece == (Piece { index: 0, ends: true }) {
                None
            } else if let Some(cells) = self.assemble(piece, sample.payload()) {
                Some(cells)
            } else {
                continue;
            };
            let cells = whole.as_deref().unwrap_or(sample.payload());
            let Some((message, samples)) = read_message(&header, cells) else { continue };
            let mut event = TapEvent::Message(message);
            if self.waiting.is_empty() {
                return Some(take(event, samples));
            }
            event.set_samples(samples);
            self.waiting.push_back(event);
        }
    }

    /// The number of the next message: those before were received, or are lost.
    pub fn place(&self) -> u64 {
        let begin = if self.ledger.is_some() { self.begin } else { 0 };
        self.place.map_or(begin, |place| place.message)
    }

    /// The number of the message that the planner sends next.
    pub fn announced(&self) -> u64 {
        self.ledger.as_ref().map_or_else(|| self.place(), Ledger::next)
    }

    /// Messages that were sent and not received yet; some of them may be lost already.
    pub fn waiting(&self) -> u64 {
        self.announced().saturating_sub(self.place())
    }

    /// Whether a planner is there. One that was killed counts until it is cleared away, which this
    /// does.
    pub fn sees_planner(&self) -> bool {
        self.node.sweep();
        self.service.dynamic_config().number_of_publishers() > 0
    }

    /// The memory of a message in pieces that is complete with this one.
    fn assemble(&mut self, piece: Piece, cells: &[u64]) -> Option<Vec<u64>> {
        if piece.index == 0 {
            self.begun.clear();
        }
        self.begun.extend_from_slice(cells);
        piece.ends.then(|| std::mem::take(&mut self.begun))
    }

    /// The request with a free space that is complete with this piece. One that lacks a piece is
    /// dropped.
    fn assemble_shown(&mut self, piece: Piece, cells: &[u64]) -> Option<Request> {
        let (begun, pieces) = &mut self.shown;
        if piece.index == 0 {
            begun.clear();
            *pieces = 0;
        }
        if piece.index != *pieces {
            (*begun, *pieces) = (Vec::new(), u32::MAX);
            return None;
        }
        begun.extend_from_slice(cells);
        *pieces += 1;
        if !piece.ends {
            return None;
        }
        let cells = std::mem::take(begun);
        *pieces = u32::MAX;
        let read = split::<wire::RequestHeader>(&cells);
        let read = read.map(|(header, cells)| convert::read_request(&header, cells));
        read.inspect_err(|error| tracing::warn!(%error, "unreadable free space on the tap")).ok()
    }
}

/// How far a reader has come in the sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    /// The message that comes next, or is being put together.
    message: u64,
    /// How many of its pieces came.
    pieces: u32,
}

/// What a sample of the tap means for its reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Step {
    /// Bus messages that are now known to be lost.
    lost: u64,
    /// Whether the sample's piece is of use.
    keep: bool,
}

impl Place {
    /// Where a reader begins that joined before message `begin` and then received this.
    fn first(begin: u64, message: u64, piece: Option<Piece>) -> Self {
        // The rest of a message that had begun before is none that was missed.
        let is_rest = message < begin && piece.is_some_and(|piece| piece.index > 0);
        let message = if is_rest { message + 1 } else { message.min(begin) };
        Self { message, pieces: 0 }
    }

    /// Takes in a piece of the message with this number, or (`None`) a heartbeat, which
    /// carries the number of the next message. A message that lacks a piece is lost once.
    fn step(self, message: u64, piece: Option<Piece>) -> (Step, Self) {
        if message < self.message {
            // The rest of a message that counts as lost.
            return (Step { lost: 0, keep: false }, self);
        }
        let before = message - self.message;
        let Some(Piece { index, ends }) = piece else {
            return (Step { lost: before, keep: false }, Self { message, pieces: 0 });
        };
        let expected = if before == 0 { self.pieces } else { 0 };
        let whole = index == expected;
        let step = Step { lost: before + u64::from(!whole), keep: whole };
        let next = match whole && !ends {
            true => Self { message, pieces: index + 1 },
            false => Self { message: message + 1, pieces: 0 },
        };
        (step, next)
    }
}

/// A message, and the samples of a part of a reply, which stay where they are.
fn read_message<'a>(
    header: &wire::TapHeader,
    cells: &'a [u64],
) -> Option<(TapMessage, &'a [Sample])> {
    let read = match header.kind {
        REQUEST => split::<wire::RequestHeader>(cells).map(|(header, cells)| {
            (TapMessage::Request(convert::read_request(&header, cells)), &[][..])
        }),
        REPLY => split::<wire::ReplyHeader>(cells)
            .and_then(|(header, cells)| convert::read_part_in_place(&header, cells))
            .map(|(part, samples)| (TapMessage::Reply(part), samples)),
        code => Err(Malformed::UnknownCode {
            what: "tap kind",
            code: code.into(),
            greatest: BEAT.into(),
        }),
    };
    // A planner of this version writes no such thing.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Walks a reader over samples `(message, index, ends)`; gives what was kept and the losses.
    #[track_caller]
    fn check(samples: &[(u64, u32, bool)], beat: u64, kept: &[u64], lost: u64) {
        let mut place = Place { message: 0, pieces: 0 };
        let mut losses = 0;
        let mut complete = Vec::new();
        let pieces = samples.iter().map(|&(message, index, ends)| {
            (message, Some(Piece::from_code(Piece { index, ends }.code())))
        });
        for (message, piece) in pieces.chain([(beat, None)]) {
            let (step, next) = place.step(message, piece);
            place = next;
            losses += step.lost;
            if step.keep && piece.is_some_and(|piece| piece.ends) {
                complete.push(message);
            }
        }
        assert_eq!((complete.as_slice(), losses), (kept, lost));
    }

    #[test]
    fn an_unbroken_sequence_loses_nothing() {
        check(&[(0, 0, true), (1, 0, false), (1, 1, true), (2, 0, true)], 3, &[0, 1, 2], 0);
    }

    #[test]
    fn a_message_that_lacks_its_beginning_is_lost_once() {
        check(&[(0, 1, false), (0, 2, true), (1, 0, true)], 2, &[1], 1);
    }

    #[test]
    fn a_message_that_lacks_its_middle_is_lost_once() {
        check(&[(0, 0, false), (0, 2, false), (0, 3, true), (1, 0, true)], 2, &[1], 1);
    }

    #[test]
    fn a_message_that_lacks_its_end_is_lost_once() {
        check(&[(0, 0, false), (1, 0, true)], 2, &[1], 1);
    }

    #[test]
    fn a_gap_over_two_cut_messages_loses_both_and_what_lies_between() {
        check(&[(0, 0, false), (4, 2, true), (5, 0, true)], 6, &[5], 5);
    }

    #[test]
    fn the_heartbeat_shows_what_is_lost_at_the_end() {
        check(&[(0, 0, true), (1, 0, false)], 5, &[0], 4);
    }
}
