//! Why there is no reply.

use std::fmt;

use bus::{CallError, ConnectError};
use schemas::message::{ErrorCode, Refusal};
use thiserror::Error;

/// Why there is no reply.
#[derive(Debug, Error)]
pub enum Error {
    /// There is no connection to a planner.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The planner, or whoever read the scene, refuses it, and says what would have to change.
    #[error(transparent)]
    Refused(#[from] Refused),
    /// The request was sent, and no reply came.
    #[error(transparent)]
    Call(CallError),
}

impl From<CallError> for Error {
    fn from(error: CallError) -> Self {
        match error {
            CallError::Scene(refusal) => Self::Refused(refusal.into()),
            error => Self::Call(error),
        }
    }
}

/// A refusal with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Refused(Box<Refusal>);

impl Refused {
    /// What kind of refusal it is.
    pub fn code(&self) -> ErrorCode {
        self.0.code
    }

    /// All that it says: message, field, and numbers.
    pub fn refusal(&self) -> &Refusal {
        &self.0
    }
}

impl From<Refusal> for Refused {
    fn from(refusal: Refusal) -> Self {
        Self(Box::new(refusal))
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.code(), self.0.message)
    }
}

impl std::error::Error for Refused {}
