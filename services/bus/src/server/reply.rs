//! A request being answered: its reply goes into shared memory, part by part.
//!
//! Sending never waits. A part that finds its client's buffer full is kept here for a later try;
//! only the reply that it belongs to is held up.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::mem::MaybeUninit;
use std::rc::Rc;
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueClientId;
use iceoryx2::port::{LoanError, SendError};
use iceoryx2::prelude::{PayloadHeader, ipc};
use iceoryx2::response_mut_uninit::ResponseMutUninit;
use schemas::convert::{CellWriter, PartSink};
use schemas::wire::{self, previous};

use super::copy;
use super::ringer::Ringer;
use crate::error::{ReceiveError, ReplyError};
use crate::headers::{Current, UserHeader, Version};
use crate::ports::{PlanRequest, REPLY_BUFFER};
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

    /// How many cells the sender says that the payload has, whatever there is.
    fn claimed(&self) -> usize {
        let count = match self {
            Self::Current(active) => active.header().number_of_elements(),
            Self::Previous(active) => active.header().number_of_elements(),
        };
        usize::try_from(count).unwrap_or(usize::MAX)
    }

    /// The request's payload, the same in both versions. Its length is what the sender says.
    fn payload(&self) -> &[u64] {
        match self {
            Self::Current(active) => active.payload(),
            Self::Previous(active) => active.payload(),
        }
    }
}

/// How long to wait before another try to send a part for which there was no room: a try takes
/// longer the more clients there are. Each one that fails doubles it.
const PAUSE: (Duration, Duration) = (Duration::from_micros(50), Duration::from_millis(1));

/// A try that comes later than so many pauses is the planner's fault.
const LATE: u32 = 10;

/// Memory of so many parts is used again.
const SPARE: usize = 64;

/// Memory for parts that have to wait.
#[derive(Debug, Default)]
pub(super) struct Spare {
    cells: Vec<Vec<u64>>,
    lists: Vec<VecDeque<Part>>,
}

impl Spare {
    fn keep(&mut self, part: Option<Part>) {
        if self.cells.len() < SPARE {
            self.cells.extend(part.map(|part| part.cells));
        }
    }
}

/// What answering any request takes.
#[derive(Debug)]
pub(super) struct Desk {
    pub(super) ringer: Ringer,
    pub(super) tap: TapWriter,
    pub(super) patience: Duration,
    /// Memory for what is translated to the previous version.
    pub(super) old: Vec<u64>,
    pub(super) spare: Spare,
}

/// A part of a reply that is not sent yet.
#[derive(Debug)]
pub(super) struct Part {
    header: wire::ReplyHeader,
    cells: Vec<u64>,
}

impl Part {
    fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice())
    }
}

/// How much of a reply has gone where.
#[derive(Debug, Default)]
struct Progress {
    /// Parts that the client has.
    sent: usize,
    /// Parts that the tap has; none if it does not have the request.
    tapped: Option<usize>,
}

/// A request that waits for its answer. Dropping it ends the reply.
#[derive(Debug)]
pub struct Incoming {
    active: Active,
    /// As it was when the request was taken: its sender can still change the original.
    header: wire::RequestHeader,
    desk: Rc<RefCell<Desk>>,
    /// Whether to ring the client's bell.
    wake: bool,
    progress: Progress,
    /// Parts for which there was no room, in order.
    waiting: VecDeque<Part>,
    /// Their bytes.
    unsent: usize,
    /// Why they wait.
    held_up: Option<HeldUp>,
}

/// A reply whose client has no room.
#[derive(Debug, Clone, Copy)]
struct HeldUp {
    /// How long the first part has waited, as far as anybody looked: a planner that is itself held up
    /// does not hold it against the client.
    waited: Duration,
    /// When it was last tried.
    tried: Instant,
    /// When to try again, and how long to wait then.
    next: Instant,
    pause: Duration,
}

impl Incoming {
    pub(super) fn new(active: Active, desk: Rc<RefCell<Desk>>) -> Self {
        let header = active.header();
        let wake = header.wake != 0;
        let waiting = desk.borrow_mut().spare.lists.pop().unwrap_or_default();
        let progress = Progress::default();
        Self { active, header, desk, wake, progress, waiting, unsent: 0, held_up: None }
    }

    /// Copies the request out of shared memory, where its sender could still change it, and gives
    /// the tap this copy. A request that is never copied, and its reply, do not appear on the tap.
    ///
    /// # Errors
    ///
    /// If it has more than `most` cells, or says that it has more than it has.
    pub fn copy(
        &mut self,
        most: usize,
        cells: &mut Vec<u64>,
    ) -> Result<wire::RequestHeader, ReceiveError> {
        cells.clear();
        // iceoryx2 computes with the count.
        let claimed = self.active.claimed();
        if claimed > most {
            return Err(ReceiveError::TooLarge { cells: claimed, most });
        }
        // From here on the length is read once: its sender can change it.
        let payload = self.active.payload();
        if payload.len() > most {
            return Err(ReceiveError::TooLarge { cells: payload.len(), most });
        }
        copy::append(payload, cells)?;
        self.desk.borrow_mut().tap.request(&self.header, cells);
        self.progress.tapped = Some(0);
        Ok(self.header)
    }

    /// The request's header.
    pub fn header(&self) -> wire::RequestHeader {
        self.header
    }

    /// How many cells the request says that it has.
    pub fn cells(&self) -> usize {
        self.active.claimed()
    }

    pub(super) fn client_id(&self) -> UniqueClientId {
        match &self.active {
            Active::Current(active) => active.origin(),
            Active::Previous(active) => active.origin(),
        }
    }

    /// Whether the client still waits: it has neither dropped the request nor left. One that died
    /// waits until it is cleared away; see [`Server::sweep`](super::Server::sweep).
    pub fn is_waiting(&self) -> bool {
        self.active.is_connected()
    }

    /// Where the answer goes.
    pub fn reply(&mut self) -> ReplySink<'_> {
        self.reply_to_client().0
    }

    /// The same, and who waits for it.
    pub fn reply_to_client(&mut self) -> (ReplySink<'_>, ClientWatch<'_>) {
        let Self { active, header, desk, wake, progress, waiting, unsent, held_up } = self;
        let to = Recipient { active, desk, wake, client: header.client, progress };
        (ReplySink { to, waiting, unsent, held_up }, ClientWatch { active })
    }

    /// Takes a part that was written elsewhere.
    ///
    /// # Errors
    ///
    /// If the client has left, or the bus fails.
    pub fn push(&mut self, header: wire::ReplyHeader, cells: Vec<u64>) -> Result<(), ReplyError> {
        self.reply().push(Part { header, cells })
    }

    /// Tries to send what waits, and says how many bytes of it are left.
    ///
    /// # Errors
    ///
    /// If the client has left, or the bus fails, or the client has taken nothing for too long
    /// ([`ReplyOptions::patience`](crate::ReplyOptions)).
    pub fn flush(&mut self) -> Result<usize, ReplyError> {
        self.reply().flush()?;
        Ok(self.unsent)
    }

    /// Bytes of the reply that wait for room.
    pub fn unsent(&self) -> usize {
        self.unsent
    }

    /// Whether parts of the reply wait for room.
    pub fn is_held_up(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// When it is worth while to try again to send what waits, if anything does.
    pub fn next_try(&self) -> Option<Instant> {
        self.held_up.map(|held_up| held_up.next)
    }

    /// Waits until all that was written is sent, for servers that have nothing else to do.
    ///
    /// # Errors
    ///
    /// As [`Incoming::flush`].
    pub fn finish(mut self) -> Result<(), ReplyError> {
        while self.flush()? > 0 {
            std::thread::sleep(Duration::from_micros(50));
        }
        Ok(())
    }
}

impl Drop for Incoming {
    fn drop(&mut self) {
        let Ok(mut desk) = self.desk.try_borrow_mut() else { return };
        let mut waiting = std::mem::take(&mut self.waiting);
        waiting.drain(..).for_each(|part| desk.spare.keep(Some(part)));
        if waiting.capacity() > 0 && desk.spare.lists.len() < SPARE {
            desk.spare.lists.push(waiting);
        }
    }
}

/// Watches the client of a request that is being answered.
#[derive(Debug, Clone, Copy)]
pub struct ClientWatch<'a> {
    active: &'a Active,
}

impl ClientWatch<'_> {
    /// As [`Incoming::is_waiting`].
    pub fn is_waiting(&self) -> bool {
        self.active.is_connected()
    }
}

/// Streams a reply into shared memory, in the version of its request.
#[derive(Debug)]
pub struct ReplySink<'a> {
    to: Recipient<'a>,
    waiting: &'a mut VecDeque<Part>,
    unsent: &'a mut usize,
    held_up: &'a mut Option<HeldUp>,
}

impl PartSink for ReplySink<'_> {
    type Error = ReplyError;

    fn part(
        &mut self,
        header: &wire::ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), ReplyError> {
        // So many find room whatever the client does, and are written where they are read.
        if self.to.progress.sent < REPLY_BUFFER
            && self.waiting.is_empty()
            && let Some(loan) = self.to.loan(cells)?
        {
            return self.to.send_direct(loan, header, fill);
        }
        let mut memory = self.to.desk.borrow_mut().spare.cells.pop().unwrap_or_default();
        memory.clear();
        memory.resize(cells, 0);
        fill_all(&mut memory, fill);
        self.push(Part { header: *header, cells: memory })
    }
}

impl ReplySink<'_> {
    /// How many parts were written so far, sent or not.
    pub fn written(&self) -> usize {
        self.to.progress.sent + self.waiting.len()
    }

    fn push(&mut self, part: Part) -> Result<(), ReplyError> {
        *self.unsent += part.bytes();
        self.waiting.push_back(part);
        match self.held_up {
            Some(held_up) if Instant::now() < held_up.next => Ok(()),
            _ => self.flush(),
        }
    }

    fn flush(&mut self) -> Result<(), ReplyError> {
        while let Some(part) = self.waiting.front() {
            if !self.to.send(part)? {
                return self.hold_up();
            }
            *self.held_up = None;
            *self.unsent -= part.bytes();
            self.to.desk.borrow_mut().spare.keep(self.waiting.pop_front());
        }
        Ok(())
    }

    /// The first part found no room.
    fn hold_up(&mut self) -> Result<(), ReplyError> {
        let now = Instant::now();
        let (least, most) = PAUSE;
        let first = HeldUp { waited: Duration::ZERO, tried: now, next: now, pause: least };
        let HeldUp { waited, tried, pause, .. } = self.held_up.unwrap_or(first);
        let waited = waited + now.duration_since(tried).min(LATE * pause);
        let patience = self.to.desk.borrow().patience;
        if waited > patience {
            return Err(ReplyError::Slow { patience });
        }
        let pause = most.min(2 * pause);
        *self.held_up = Some(HeldUp { waited, tried: now, next: now + pause, pause });
        Ok(())
    }
}

/// Memory for a part, to be written.
type LoanOf<V> = ResponseMutUninit<ipc::Service, [MaybeUninit<u64>], <V as Version>::Reply>;
type Loan = LoanOf<Current>;

/// Where the parts of a reply go.
#[derive(Debug)]
struct Recipient<'a> {
    active: &'a Active,
    desk: &'a RefCell<Desk>,
    wake: &'a mut bool,
    client: u64,
    progress: &'a mut Progress,
}

impl Recipient<'_> {
    /// Memory that the client will read, if it speaks the current version and there is some.
    fn loan(&self, cells: usize) -> Result<Option<Loan>, ReplyError> {
        match self.active {
            Active::Current(active) => loan::<Current>(active, cells),
            Active::Previous(_) => Ok(None),
        }
    }

    /// Writes a part where it will be read.
    fn send_direct(
        &mut self,
        loan: Loan,
        header: &wire::ReplyHeader,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), ReplyError> {
        let header = self.stamped(header)?;
        let (desk, progress) = (self.desk, &mut *self.progress);
        let sent = send::<Current>(loan, header, |payload| {
            fill_all(payload, fill);
            progress.tap(&mut desk.borrow_mut().tap, &header, payload);
        })?;
        // Only parts of an earlier reply, which nobody took, can be in the way.
        if sent { self.count_sent() } else { Err(ReplyError::Full) }
    }

    /// Sends a part, in the version of its client. Whether there was room.
    fn send(&mut self, part: &Part) -> Result<bool, ReplyError> {
        let header = self.stamped(&part.header)?;
        let cells = part.cells.as_slice();
        let sent = match self.active {
            Active::Current(active) => match loan::<Current>(active, cells.len())? {
                Some(loan) => send::<Current>(loan, header, |into| into.copy_from_slice(cells))?,
                None => false,
            },
            Active::Previous(active) => {
                let old = &mut self.desk.borrow_mut().old;
                let header = previous::downgrade(&header, cells, old);
                match loan::<Previous>(active, old.len())? {
                    Some(loan) => send::<Previous>(loan, header, |into| into.copy_from_slice(old))?,
                    None => false,
                }
            }
        };
        if sent {
            self.progress.tap(&mut self.desk.borrow_mut().tap, &header, cells);
            self.count_sent()?;
        }
        Ok(sent)
    }

    /// The header of a part that is sent now, to a client that is there.
    fn stamped(&self, header: &wire::ReplyHeader) -> Result<wire::ReplyHeader, ReplyError> {
        // A closed channel takes parts and drops them silently.
        if !self.active.is_connected() {
            return Err(ReplyError::Gone);
        }
        Ok(wire::ReplyHeader { sent_ns: crate::clock::now_ns(), ..*header })
    }

    /// A part was sent: rings the client's bell.
    fn count_sent(&mut self) -> Result<(), ReplyError> {
        self.progress.sent += 1;
        if *self.wake && !self.desk.borrow_mut().ringer.ring(self.client) {
            *self.wake = false;
        }
        Ok(())
    }
}

impl Progress {
    /// Gives the tap the part that comes next, unless it has it from a try that failed.
    fn tap(&mut self, tap: &mut TapWriter, header: &wire::ReplyHeader, cells: &[u64]) {
        if self.tapped.is_some_and(|tapped| tapped <= self.sent) {
            tap.reply(header, cells);
            self.tapped = Some(self.sent + 1);
        }
    }
}

/// Memory for a part of so many cells, if there is some.
fn loan<V: Version>(
    active: &PlanRequest<V>,
    cells: usize,
) -> Result<Option<LoanOf<V>>, ReplyError> {
    match active.loan_slice_uninit(cells) {
        Ok(loan) => Ok(Some(loan)),
        Err(LoanError::OutOfMemory) => Ok(None),
        Err(error) => Err(ReplyError::Bus(error.into())),
    }
}

/// Sends one part, whose payload `write` writes. Whether there was room.
fn send<V: Version>(
    mut loan: LoanOf<V>,
    header: <V::Reply as UserHeader>::Plain,
    write: impl FnOnce(&mut [u64]),
) -> Result<bool, ReplyError> {
    loan.user_header_mut().set(header);
    let payload = loan.payload_mut();
    #[expect(unsafe_code, reason = "loaned memory is written where it will be read")]
    // SAFETY: the memory is mapped from the operating system, which hands it out
    // initialised, and every bit pattern is a u64.
    let payload = unsafe { &mut *(payload as *mut [_] as *mut [u64]) };
    write(payload);
    #[expect(unsafe_code, reason = "loaned memory is written where it will be read")]
    // SAFETY: as above: nothing of it was ever uninitialised.
    let response = unsafe { loan.assume_init() };
    match response.send() {
        Ok(()) => Ok(true),
        Err(SendError::UnableToDeliver) => Ok(false),
        Err(error) => Err(ReplyError::Bus(error.into())),
    }
}

fn fill_all(cells: &mut [u64], fill: impl FnOnce(&mut CellWriter)) {
    let count = cells.len();
    let mut writer = CellWriter::new(cells);
    fill(&mut writer);
    assert_eq!(writer.filled(), count, "a part is written in full");
}
