//! Domains keep systems on the same machine apart.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::root::{self, RootError};

/// Longest name of a domain, bytes; names of files are made from it.
const MOST_NAME: usize = 64;

/// The name of the default domain.
const DEFAULT: &str = "default";

/// A system: only programs of the same user in the same domain reach each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Domain {
    name: String,
    /// None for what the environment says.
    root: Option<PathBuf>,
}

/// Why a domain can't be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum DomainError {
    /// Its name can't be part of a file's name.
    #[error(
        "domain {0:?}: a name has 1 to {MOST_NAME} letters, digits, '-' or '_' and starts with a letter \
         or digit"
    )]
    Name(String),
    /// There is no place for its files.
    #[error(transparent)]
    Root(#[from] RootError),
    /// It can't be joined.
    #[error("can't join domain {domain}: {cause}")]
    Join {
        /// The domain.
        domain: Domain,
        /// Why not.
        cause: String,
    },
}

impl Domain {
    /// The domain of this name.
    pub fn new(name: &str) -> Result<Self, DomainError> {
        let letters = name.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'-' || c == b'_');
        let first = name.bytes().next().is_some_and(|c| c.is_ascii_alphanumeric());
        if letters && first && name.len() <= MOST_NAME {
            Ok(Self { name: name.to_owned(), root: None })
        } else {
            Err(DomainError::Name(name.to_owned()))
        }
    }

    /// The domain of the same name under another directory than that of the environment.
    pub fn under(self, root: &Path) -> Self {
        Self { root: Some(root.to_owned()), ..self }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The directory under which it is: that of [`Domain::under`], else `CLEARWAY_ROOT`, else
    /// `clearway` in the runtime directory of the user (`XDG_RUNTIME_DIR`), else
    /// `/tmp/clearway-UID`.
    pub fn root(&self) -> Result<PathBuf, DomainError> {
        Ok(root::find(self.chosen_root())?.0)
    }

    pub(crate) fn chosen_root(&self) -> Option<&Path> {
        self.root.as_deref()
    }
}

impl Default for Domain {
    fn default() -> Self {
        Self { name: DEFAULT.to_owned(), root: None }
    }
}

impl std::fmt::Display for Domain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name)
    }
}

impl std::str::FromStr for Domain {
    type Err = DomainError;

    fn from_str(name: &str) -> Result<Self, DomainError> {
        Self::new(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(name: &str, possible: bool) {
        assert_eq!(Domain::new(name).is_ok(), possible, "{name:?}");
    }

    #[test]
    fn names_are_parts_of_file_names() {
        check("a", true);
        check("7-Of_9", true);
        check(&"x".repeat(MOST_NAME), true);
        check(&"x".repeat(MOST_NAME + 1), false);
        for name in ["", "-a", "_a", "a/b", "..", "a b", "\u{e4}", "a\0"] {
            check(name, false);
        }
    }

    #[test]
    fn a_name_is_read_and_shown() {
        assert_eq!("lab-2".parse::<Domain>().unwrap().to_string(), "lab-2");
        assert_eq!(Domain::default(), "default".parse().unwrap());
    }
}
