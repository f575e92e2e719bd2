//! Waiting for the other side: spinning, sleeping, or both.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use std::os::fd::{AsFd, BorrowedFd};

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::FileDescriptorBased;
use iceoryx2::service::Service;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

/// How a process waits for messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wait {
    /// Sleeps at once: idle costs nothing, a round trip costs two wake-ups.
    Event,
    /// Spins for [`SPIN`], then sleeps: fast under load, free while idle.
    #[default]
    Hybrid,
    /// Never sleeps: fastest, takes a core.
    Poll,
}

/// How long [`Wait::Hybrid`] spins: about as long as two wake-ups across cores take.
pub const SPIN: Duration = Duration::from_micros(50);

/// The longest wait: a safety net for lost wake-ups, and the longest time until a signal is
/// seen.
pub const NET: Duration = Duration::from_millis(100);

/// The longest first sleep of a wait: a finer net for what [`silence`] makes rare but can't
/// rule out, a notifier held up for longer than the rounds of silencing take.
const NAP: Duration = Duration::from_millis(1);

/// Why a wait ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Woken {
    /// There may be something to do; look.
    Look,
    /// A signal asks the process to end.
    Terminate,
}

/// Waits until `ready` holds, the bell rings or one of `others` can be read, at most until
/// `until`, at most [`NET`].
///
/// A poller has no bell, so the other side rings none.
pub(crate) fn wait<'a, S: Service>(
    how: Wait,
    (bell, others): (Option<&Listener<S>>, impl Iterator<Item = BorrowedFd<'a>>),
    until: Option<Instant>,
    mut ready: impl FnMut() -> bool,
) -> Woken
where
    Listener<S>: FileDescriptorBased,
{
    let spin = match how {
        Wait::Event => Duration::ZERO,
        Wait::Hybrid => SPIN,
        Wait::Poll => NET,
    };
    let begin = Instant::now();
    let end = until.map_or(begin + NET, |until| until.min(begin + NET));
    loop {
        if ready() {
            return Woken::Look;
        }
        let now = Instant::now();
        if now >= end || now.duration_since(begin) >= spin {
            break;
        }
        for _ in 0..16 {
            std::hint::spin_loop();
        }
    }
    if !terminated()
        && let Some(bell) = bell
    {
        sleep((bell, &others.collect::<Vec<_>>()), end, ready);
    }
    if terminated() { Woken::Terminate } else { Woken::Look }
}

/// What ended a [`sleep`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ended {
    /// There was something to do already.
    Ready,
    /// The bell.
    Rung,
    /// Its time, or a signal.
    Unrung,
}

/// Sleeps until the bell rings, at most until `end`.
///
/// The bell is silenced *before* the last look, so whoever rings afterwards wakes the
/// sleeper. In the other order, what came between look and silence would be missed.
fn sleep<S: Service>(
    (bell, others): (&Listener<S>, &[BorrowedFd<'_>]),
    end: Instant,
    mut ready: impl FnMut() -> bool,
) -> Ended
where
    Listener<S>: FileDescriptorBased,
{
    silence(bell);
    for most in [NAP, NET] {
        if ready() {
            return Ended::Ready;
        }
        let rest = end.saturating_duration_since(Instant::now());
        if rest.is_zero() || terminated() {
            break;
        }
        let rung = match others {
            [] => bell.timed_wait(|_| {}, rest.min(most)).is_ok_and(|rings| rings != 0),
            others => sleep_for_any(bell, others, rest.min(most)),
        };
        if rung {
            return Ended::Rung;
        }
    }
    Ended::Unrung
}

/// Sleeps until `source` can be read, at most so long.
pub(crate) fn sleep_for(source: impl AsFd, most: Duration) {
    let most = Timespec::try_from(most).ok();
    // A signal ends it as well.
    let _ = poll(&mut [PollFd::new(&source, PollFlags::IN)], most.as_ref());
}

/// Whether the bell rang or one of `others` can be read, before the time was over.
fn sleep_for_any<S: Service>(bell: &Listener<S>, others: &[BorrowedFd<'_>], most: Duration) -> bool
where
    Listener<S>: FileDescriptorBased,
{
    #[expect(unsafe_code, reason = "iceoryx2 lends its file descriptor as a number only")]
    // SAFETY: it stays open as long as the listener, which is borrowed here.
    let bell = unsafe { BorrowedFd::borrow_raw(bell.file_descriptor().native_handle()) };
    let mut all: Vec<_> = std::iter::once(&bell)
        .chain(others)
        .map(|source| PollFd::new(source, PollFlags::IN))
        .collect();
    let most = Timespec::try_from(most).ok();
    poll(&mut all, most.as_ref()).is_ok_and(|ready| ready > 0)
}

/// Takes up all rings until a round finds none, which leaves the bell unmarked.
///
/// One round is not enough: a notifier's ring can be taken up together with another's
/// before the notifier has marked the bell as rung. The bell then counts as rung, nobody
/// rings it again, and whoever only listens for rings sleeps on.
pub(crate) fn silence<S: Service>(bell: &Listener<S>) {
    while bell.try_wait(|_| {}).is_ok_and(|rings| rings != 0) {}
}

/// The last SIGINT, SIGTERM or SIGHUP, or 0.
///
/// iceoryx2's own handler keeps only the last of a dozen kinds of signals, and forgets it
/// once asked.
static TERMINATED: LazyLock<Result<Arc<AtomicUsize>, String>> = LazyLock::new(|| {
    let last = Arc::default();
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        // Started by `nohup`, a process outlives its terminal.
        if signal == SIGHUP && is_ignored(SIGHUP) {
            continue;
        }
        signal_hook::flag::register_usize(signal, Arc::clone(&last), signal as usize)
            .map_err(|error| format!("can't handle signals: {error}"))?;
    }
    Ok(last)
});

/// Whether this process was started with a signal ignored.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// From now on SIGINT, SIGTERM and SIGHUP ask the process to end instead of ending it, so
/// that ports are dropped and leave nothing behind in shared memory. A SIGHUP that was
/// ignored from the start, as under `nohup`, stays ignored.
pub(crate) fn handle_signals() -> Result<(), String> {
    if LEFT_ALONE.load(Ordering::Relaxed) {
        return Ok(());
    }
    TERMINATED.as_ref().map(|_| ()).map_err(Clone::clone)
}

static LEFT_ALONE: AtomicBool = AtomicBool::new(false);

/// Leaves signals to the program, which is for libraries to call before they join a domain.
/// [`terminated`] is never true from then on.
pub fn leave_signals_alone() {
    LEFT_ALONE.store(true, Ordering::Relaxed);
}

/// Whether SIGINT, SIGTERM or SIGHUP has asked to end since this process first joined a
/// domain, or first called this. Costs one load.
pub fn terminated() -> bool {
    termination_signal().is_some()
}

/// The number of the signal that [`terminated`] is about, the last if there were several.
pub fn termination_signal() -> Option<i32> {
    if LEFT_ALONE.load(Ordering::Relaxed) {
        return None;
    }
    let last = TERMINATED.as_ref().map_or(0, |last| last.load(Ordering::Relaxed));
    (last != 0).then_some(last as i32)
}

#[cfg(test)]
mod tests;
