//! Waiting for the other side: spinning, sleeping, or both.

use std::time::{Duration, Instant};

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::{Node, ipc};

/// How a process waits for messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wait {
    /// Sleeps at once; costs nothing while idle, two wake-ups per round trip.
    Event,
    /// Spins for [`SPIN`], then sleeps: fast under load, free while idle.
    #[default]
    Hybrid,
    /// Never sleeps: fastest, takes a core.
    Poll,
}

/// How long [`Wait::Hybrid`] spins: about as long as two wake-ups across cores take.
pub const SPIN: Duration = Duration::from_micros(50);

/// How long a sleep lasts at most: the net under lost wake-ups and the longest time
/// until a signal is seen.
pub const NET: Duration = Duration::from_millis(100);

/// Why [`wait`] returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Woken {
    /// There may be something to do; look.
    Look,
    /// SIGINT or SIGTERM asks to end.
    Terminate,
}

/// Waits until `ready` holds or the bell rings, at most until `until`, at most [`NET`].
///
/// Who polls has no bell, so that the other side does not ring it.
pub(crate) fn wait(
    how: Wait,
    node: &Node<ipc::Service>,
    bell: Option<&Listener<ipc::Service>>,
    until: Option<Instant>,
    mut ready: impl FnMut() -> bool,
) -> Woken {
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
    if terminated(node) {
        return Woken::Terminate;
    }
    if let Some(bell) = bell {
        let rest = end.saturating_duration_since(Instant::now());
        if !rest.is_zero() && bell.timed_wait(|_| {}, rest).is_ok_and(|rings| rings != 0) {
            silence(bell);
        }
        if terminated(node) {
            return Woken::Terminate;
        }
    }
    Woken::Look
}

/// Takes up all rings. Once is not enough: between marking a bell as rung and ringing
/// it, a notifier can see its ring taken up with another's; the bell then counts as
/// rung, nobody rings it again, and the sleeper sleeps on. A round that finds
/// nothing leaves the bell unmarked.
pub(crate) fn silence(bell: &Listener<ipc::Service>) {
    while bell.try_wait(|_| {}).is_ok_and(|rings| rings != 0) {}
}

/// Whether SIGINT or SIGTERM has asked to end.
pub(crate) fn terminated(node: &Node<ipc::Service>) -> bool {
    node.wait(Duration::ZERO).is_err()
}
