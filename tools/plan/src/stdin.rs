//! Standard input that a signal interrupts.

use std::io::{self, Read};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// How long a read waits before it looks for signals that came just before it.
const NET: Timespec = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };

/// Unbuffered standard input. A read fails once `interrupted` holds: a signal whose handler
/// only sets a flag does not end a blocking read otherwise.
pub(crate) struct Stdin<I> {
    interrupted: I,
}

impl<I: Fn() -> bool> Stdin<I> {
    pub(crate) fn new(interrupted: I) -> Self {
        Self { interrupted }
    }
}

impl<I: Fn() -> bool> Read for Stdin<I> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let stdin = io::stdin();
        loop {
            if (self.interrupted)() {
                return Err(io::Error::other("interrupted"));
            }
            let mut waiting = [PollFd::new(&stdin, PollFlags::IN)];
            match poll(&mut waiting, Some(&NET)) {
                Ok(0) | Err(Errno::INTR) => continue,
                Ok(_) => {}
                Err(error) => return Err(error.into()),
            }
            match rustix::io::read(&stdin, &mut *buffer) {
                Err(Errno::INTR) => {}
                read => return Ok(read?),
            }
        }
    }
}
