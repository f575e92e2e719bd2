//! Ends the request in hand when its deadline passes or the process is asked to end.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use answer::{StopFlag, StopReason};

/// How long a request without a deadline runs on, at most, after the process was asked to end.
const LOOK: Duration = Duration::from_millis(100);

/// A thread that watches the request in hand.
///
/// Watching a request without a deadline costs the service two uncontended locks.
#[derive(Debug)]
pub(crate) struct Watchdog {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    watch: Mutex<Watch>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Watch {
    /// The request in hand, if there is one.
    in_hand: Option<InHand>,
    ended: bool,
}

#[derive(Debug)]
struct InHand {
    stop: Arc<StopFlag>,
    deadline: Option<Instant>,
}

impl Watchdog {
    /// Starts to watch; `terminated` tells whether the process was asked to end.
    pub(crate) fn start(terminated: impl Fn() -> bool + Send + 'static) -> Self {
        let shared = Arc::new(Shared::default());
        let watched = Arc::clone(&shared);
        let thread = thread::Builder::new()
            .name("watchdog".into())
            .spawn(move || watched.run(terminated))
            .inspect_err(|error| tracing::warn!(%error, "no watchdog: deadlines are not kept"))
            .ok();
        Self { shared, thread }
    }

    /// Runs `answer` and sets `stop` if `deadline` passes or the process is asked to end
    /// meanwhile.
    pub(crate) fn watch<T>(
        &self,
        stop: &Arc<StopFlag>,
        deadline: Option<Instant>,
        answer: impl FnOnce(&StopFlag) -> T,
    ) -> T {
        self.shared.lock().in_hand = Some(InHand { stop: Arc::clone(stop), deadline });
        if deadline.is_some() {
            self.shared.changed.notify_one();
        }
        let answered = answer(stop);
        self.shared.lock().in_hand = None;
        answered
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.shared.lock().ended = true;
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic was reported by the thread itself.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Watch> {
        // No invariant spans two fields, so a panic leaves nothing half done.
        self.watch.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, terminated: impl Fn() -> bool) {
        let mut watch = self.lock();
        while !watch.ended {
            let mut wait = LOOK;
            if let Some(InHand { stop, deadline }) = &watch.in_hand {
                let now = Instant::now();
                match deadline.map(|deadline| deadline.saturating_duration_since(now)) {
                    Some(Duration::ZERO) => stop.stop(StopReason::Deadline),
                    Some(left) => wait = wait.min(left),
                    None => {}
                }
                if terminated() {
                    stop.stop(StopReason::Shutdown);
                }
            }
            let waited = self.changed.wait_timeout(watch, wait);
            watch = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// Waits until the flag is set, for ten seconds at most.
    fn wait_for_stop(stop: &StopFlag) -> Option<StopReason> {
        let begun = Instant::now();
        while stop.reason().is_none() && begun.elapsed() < Duration::from_secs(10) {
            thread::sleep(Duration::from_millis(1));
        }
        stop.reason()
    }

    #[test]
    fn passed_deadline_stops_the_request() {
        let watchdog = Watchdog::start(|| false);
        let stop = Arc::new(StopFlag::new());
        let deadline = Instant::now() + Duration::from_millis(5);
        let reason = watchdog.watch(&stop, Some(deadline), wait_for_stop);
        assert_eq!(reason, Some(StopReason::Deadline));
        assert!(Instant::now() >= deadline);
    }

    #[test]
    fn request_that_is_done_is_not_stopped_by_its_deadline() {
        let watchdog = Watchdog::start(|| false);
        let stop = Arc::new(StopFlag::new());
        watchdog.watch(&stop, Some(Instant::now() + Duration::from_millis(20)), |_| ());
        thread::sleep(Duration::from_millis(60));
        assert_eq!(stop.reason(), None);
    }

    #[test]
    fn end_of_the_process_stops_the_request() {
        let terminated = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&terminated);
        let watchdog = Watchdog::start(move || asked.load(Ordering::Relaxed));
        let stop = Arc::new(StopFlag::new());
        let reason = watchdog.watch(&stop, None, |stop| {
            terminated.store(true, Ordering::Relaxed);
            wait_for_stop(stop)
        });
        assert_eq!(reason, Some(StopReason::Shutdown));
    }
}
