//! What a command found, as an exit code.

use comparison::exchanges::Contents;
use program::Exit;

/// What was found; the worst of it becomes the exit code.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Findings {
    /// Replies differ.
    pub(crate) regression: bool,
    /// Something failed.
    pub(crate) failure: bool,
    /// Data was lost.
    pub(crate) loss: bool,
    /// Whether messages that no checksum covers are a failure.
    pub(crate) strict: bool,
    /// A signal came while a planner was asked.
    pub(crate) interrupted: Option<i32>,
}

impl Findings {
    /// Adds what is wrong with a recording.
    pub(crate) fn add(&mut self, contents: &Contents) {
        self.failure |= contents.failure().is_some();
        self.failure |= self.strict && !contents.coverage.is_whole();
        self.loss |= contents.is_incomplete();
    }

    pub(crate) fn exit(self) -> Exit {
        match self {
            Self { interrupted: Some(signal), .. } => Exit::interrupted_by(signal),
            Self { regression: true, .. } => Exit::Regression,
            Self { failure: true, .. } => Exit::Failure,
            Self { loss: true, .. } => Exit::Lost,
            Self { .. } => Exit::Done,
        }
    }
}
