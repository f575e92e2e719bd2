//! No wake-up is slept over.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::*;
use crate::ports;
use crate::server::ServerOptions;
use crate::test_domain::test_domain;

/// How wake-ups went.
#[derive(Debug, Default)]
struct Counts {
    wakes: u64,
    /// Something was there, but only the first, short net found it.
    napped: u64,
    /// Something was there, but only the long net found it.
    slept_over: u64,
}

/// Two notifiers post and ring, each again as soon as its post was taken. `sleep` sleeps
/// until one has posted.
fn stress(
    time: Duration,
    mut sleep: impl FnMut(&Listener<ipc::Service>, &mut dyn FnMut() -> bool) -> bool,
) -> Counts {
    const NOTIFIERS: usize = 2;
    let domain = test_domain();
    let node = domain.join("stress").unwrap();
    let bell = ports::create_wake(&node, &ServerOptions::default()).unwrap();
    let listener = bell.listener_builder().create().unwrap();
    let posted: [AtomicU64; NOTIFIERS] = Default::default();
    let taken: [AtomicU64; NOTIFIERS] = Default::default();
    let stop = AtomicBool::new(false);
    let mut counts = Counts::default();
    std::thread::scope(|threads| {
        for (posted, taken) in posted.iter().zip(&taken) {
            let (domain, stop) = (&domain, &stop);
            threads.spawn(move || {
                let node = domain.join("notifier").unwrap();
                let ringer = ports::open_wake(&node).unwrap().notifier_builder().create().unwrap();
                while !stop.load(Ordering::Relaxed) {
                    posted.fetch_add(1, Ordering::SeqCst);
                    ringer.notify().unwrap();
                    let mut rounds = 0;
                    while taken.load(Ordering::SeqCst) != posted.load(Ordering::SeqCst)
                        && !stop.load(Ordering::Relaxed)
                    {
                        rounds += 1;
                        if rounds > 200 {
                            std::thread::yield_now();
                        }
                    }
                }
            });
        }
        let begin = Instant::now();
        while begin.elapsed() < time {
            let mut ready = || {
                posted.iter().zip(&taken).any(|(posted, taken)| {
                    posted.load(Ordering::SeqCst) != taken.load(Ordering::SeqCst)
                })
            };
            let before = Instant::now();
            let rung = sleep(&listener, &mut ready);
            counts.wakes += 1;
            // A machine under load holds both notifiers back now and then: then nothing is
            // there when the net opens, or it has only just come.
            if !rung && before.elapsed() >= NET && ready() {
                counts.slept_over += 1;
            } else if !rung && before.elapsed() >= NAP && ready() {
                counts.napped += 1;
            }
            for (posted, taken) in posted.iter().zip(&taken) {
                taken.store(posted.load(Ordering::SeqCst), Ordering::SeqCst);
            }
        }
        stop.store(true, Ordering::Relaxed);
    });
    drop(listener);
    drop(bell);
    drop(node);
    domain.tidy();
    println!("{counts:?}");
    counts
}

fn ours(bell: &Listener<ipc::Service>, ready: &mut dyn FnMut() -> bool) -> bool {
    sleep(bell, Instant::now() + NET, ready) != Ended::Unrung
}

/// What the waiting loops of iceoryx2's examples do: one look at the bell, then sleep on
/// its file descriptor.
fn undrained() -> impl FnMut(&Listener<ipc::Service>, &mut dyn FnMut() -> bool) -> bool {
    use std::os::fd::BorrowedFd;

    use iceoryx2::prelude::FileDescriptorBased;
    |bell, ready| {
        if ready() {
            return true;
        }
        let descriptor = bell.file_descriptor();
        #[expect(unsafe_code, reason = "the descriptor is the listener's")]
        // SAFETY: the listener outlives this call.
        let descriptor = unsafe { BorrowedFd::borrow_raw(descriptor.native_handle()) };
        let mut polled = [rustix::event::PollFd::new(&descriptor, rustix::event::PollFlags::IN)];
        let net = rustix::time::Timespec { tv_sec: 0, tv_nsec: NET.as_nanos() as _ };
        let rung = rustix::event::poll(&mut polled, Some(&net)).unwrap() > 0;
        bell.try_wait(|_| {}).unwrap();
        rung
    }
}

#[test]
fn no_wake_up_is_slept_over() {
    let seconds = std::env::var("BUS_STRESS").map_or(1, |seconds| seconds.parse().unwrap());
    let counts = stress(Duration::from_secs(seconds), ours);
    assert_eq!(counts.slept_over, 0, "{counts:?}");
}

/// The same without silencing the bell: shows that the stress finds what it is for.
#[test]
#[ignore = "needs some ten seconds, and luck"]
fn without_silencing_wake_ups_are_slept_over() {
    let seconds = std::env::var("BUS_STRESS").map_or(60, |seconds| seconds.parse().unwrap());
    let counts = stress(Duration::from_secs(seconds), undrained());
    assert_ne!(counts.slept_over, 0, "{counts:?}");
}

#[test]
fn a_wait_ends_with_its_limit() {
    let begin = Instant::now();
    for how in [Wait::Event, Wait::Hybrid, Wait::Poll] {
        assert_eq!(wait(how, None, Some(begin), || false), Woken::Look);
    }
}
