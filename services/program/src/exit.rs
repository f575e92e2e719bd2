//! Exit codes.

use std::error::Error;
use std::process::ExitCode;

use crate::{PrintError, report};

/// How a program ends. The numbers are part of the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything was done.
    Done = 0,
    /// Something failed.
    Failure = 1,
    /// The arguments are wrong. (The argument parser uses the same number.)
    Usage = 2,
    /// Data was lost.
    Lost = 3,
    /// Replies differ from what they should be.
    Regression = 4,
    /// SIGHUP ended it. (128 + the signal's number, as shells report it; so are the next.)
    HungUp = 129,
    /// SIGINT (Ctrl-C) ended it.
    Interrupted = 130,
    /// SIGTERM ended it.
    Terminated = 143,
}

impl Exit {
    /// The exit code.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// How a program ends that the signal with this number interrupts.
    pub const fn interrupted_by(signal: i32) -> Self {
        match signal {
            1 => Self::HungUp,
            15 => Self::Terminated,
            _ => Self::Interrupted,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        exit.code().into()
    }
}

/// Runs a program and reports the error it ends with, if any.
///
/// A reader that closed stdout early (`plan ... | head`) has seen enough: that is no failure.
pub fn main(name: &str, run: impl FnOnce() -> Result<Exit, Box<dyn Error>>) -> ExitCode {
    let exit = match run() {
        Ok(exit) => exit,
        Err(error) if PrintError::is_closed_in(&*error) => Exit::Done,
        Err(error) => {
            report(name, &*error);
            Exit::Failure
        }
    };
    exit.into()
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    #[test]
    fn a_signal_adds_its_number_to_128() {
        for signal in [1, 2, 15] {
            assert_eq!(i32::from(Exit::interrupted_by(signal).code()), 128 + signal);
        }
    }

    #[test]
    fn a_closed_stdout_is_no_failure() {
        let end =
            |kind: io::ErrorKind| main("test", || Err(Box::new(PrintError(io::Error::from(kind)))));
        assert_eq!(end(io::ErrorKind::BrokenPipe), ExitCode::SUCCESS);
        assert_eq!(end(io::ErrorKind::StorageFull), ExitCode::FAILURE);
        // The same error from anything but stdout is a failure.
        let other = main("test", || Err(Box::new(io::Error::from(io::ErrorKind::BrokenPipe))));
        assert_eq!(other, ExitCode::FAILURE);
    }
}
