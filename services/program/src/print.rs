//! Printing results and errors.

use std::error::Error;
use std::fmt;
use std::io::{self, Write};

use crate::log_format;

/// Writing to stdout failed.
#[derive(Debug, thiserror::Error)]
#[error("can't write to stdout: {0}")]
pub struct PrintError(pub io::Error);

impl From<io::Error> for PrintError {
    fn from(error: io::Error) -> Self {
        Self(error)
    }
}

impl PrintError {
    /// Whether the reader closed stdout.
    pub fn is_closed(&self) -> bool {
        self.0.kind() == io::ErrorKind::BrokenPipe
    }

    /// Whether `error`, or one of its sources, is a closed stdout.
    pub(crate) fn is_closed_in(error: &(dyn Error + 'static)) -> bool {
        chain(error).any(|error| error.downcast_ref().is_some_and(Self::is_closed))
    }
}

fn chain<'a>(error: &'a (dyn Error + 'static)) -> impl Iterator<Item = &'a (dyn Error + 'static)> {
    std::iter::successors(Some(error), |error: &&'a (dyn Error + 'static)| (*error).source())
}

/// Prints to stderr what ended the program: the error and its sources, in one line.
pub fn report(program: &str, error: &(dyn Error + 'static)) {
    if log_format::are_json() {
        return tracing::error!(program, "{}", Chain(error));
    }
    warn(format_args!("{program}: {}", Chain(error)));
}

/// Prints a line to stderr. A closed stderr is ignored.
pub fn warn(text: fmt::Arguments) {
    if log_format::are_json() {
        return tracing::warn!("{text}");
    }
    let _ = writeln!(io::stderr(), "{text}");
}

/// An error and its sources, except those whose text it already contains.
struct Chain<'a>(&'a (dyn Error + 'static));

impl fmt::Display for Chain<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut said = self.0.to_string();
        f.write_str(&said)?;
        for source in chain(self.0).skip(1) {
            let text = source.to_string();
            if !said.contains(&text) {
                write!(f, ": {text}")?;
                said = text;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("can't start")]
    struct Outer(#[source] Middle);

    #[derive(Debug, thiserror::Error)]
    #[error("no memory: {0}")]
    struct Middle(#[source] io::Error);

    #[test]
    fn sources_are_told_once() {
        let error = Outer(Middle(io::Error::other("disk full")));
        assert_eq!(Chain(&error).to_string(), "can't start: no memory: disk full");
    }

    #[test]
    fn a_closed_stdout_is_found_among_sources() {
        #[derive(Debug, thiserror::Error)]
        #[error("wrapped")]
        struct Wrapped(#[from] PrintError);
        let closed = Wrapped(PrintError(io::ErrorKind::BrokenPipe.into()));
        assert!(PrintError::is_closed_in(&closed));
        let full = Wrapped(PrintError(io::ErrorKind::StorageFull.into()));
        assert!(!PrintError::is_closed_in(&full));
    }
}
