//! Domains keep systems on the same machine apart.

use std::fs::File;
use std::os::unix::fs::DirBuilderExt;
use std::time::Duration;

use iceoryx2::prelude::{
    CallbackProgression, Config, FileName, Node, NodeBuilder, NodeName, Path, SemanticString,
    SignalHandlingMode, ipc,
};
use rustix::fs::FlockOperation;
use thiserror::Error;

use crate::cause::Cause;
use crate::wait;

/// The directory for the small files of the bus; the memory itself is in `/dev/shm`.
const ROOT: &str = "/tmp/iceoryx2";

/// Prefix of all files of the bus; the one that iceoryx2's own tools look for.
const PREFIX: &str = "iox2_";

/// Longest name of a domain, bytes; names of files are made from it.
const MOST_NAME: usize = 64;

/// A system: only programs in the same domain reach each other.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Domain {
    /// Empty for the default domain.
    name: String,
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
            Ok(Self { name: name.to_owned() })
        } else {
            Err(DomainError::Name(name.to_owned()))
        }
    }

    fn config(&self) -> Config {
        let mut config = Config::default();
        if !self.name.is_empty() {
            config.global.prefix = FileName::new(format!("{PREFIX}{}_", self.name).as_bytes())
                .expect("the domain's name was checked");
            config.global.set_root_path(
                &Path::new(format!("{ROOT}/{}", self.name).as_bytes())
                    .expect("the domain's name was checked"),
            );
        }
        // Opening a service takes as long as a busy machine needs.
        config.global.creation_timeout = Duration::from_secs(5);
        config
    }

    /// Joins this domain as `role`, after removing what died in it.
    pub(crate) fn join(&self, role: &str) -> Result<Node<ipc::Service>, DomainError> {
        let failed = |cause: String| DomainError::Join { domain: self.clone(), cause };
        wait::handle_signals().map_err(failed)?;
        let _lock =
            lock(FlockOperation::LockShared).map_err(|error| failed(format!("{ROOT}: {error}")))?;
        NodeBuilder::new()
            .name(&NodeName::new(role).expect("roles are short"))
            .config(&self.config())
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|error| failed(Cause::from(error).to_string()))
    }

    /// Removes what iceoryx2 leaves behind when the last program has left: a file of
    /// 16 bytes in `/dev/shm` and empty directories. Does nothing while any program, dead
    /// or alive, is in the domain.
    pub fn tidy(&self) {
        // Nobody joins meanwhile, and whoever has joined is listed.
        let Ok(_lock) = lock(FlockOperation::LockExclusive) else { return };
        let config = self.config();
        let mut nodes = 0;
        let listed = Node::<ipc::Service>::list(&config, |_| {
            nodes += 1;
            CallbackProgression::Stop
        });
        if listed.is_err() || nodes > 0 {
            return;
        }
        if let Err(error) = remove_counters(&config.global.prefix.to_string()) {
            tracing::debug!(domain = %self, %error, "could not remove the last file");
        }
        // Only empty directories go.
        for directory in [config.global.node_dir(), config.global.service_dir()] {
            let _ = std::fs::remove_dir(directory.to_string());
        }
        if !self.name.is_empty() {
            let _ = std::fs::remove_dir(config.global.root_path().to_string());
        }
    }
}

/// Removes the files in which iceoryx2 counts the nodes of a domain, which no longer has
/// any: `PREFIX` 40 hexadecimal digits `_node.` version `.global_mgmt`.
fn remove_counters(prefix: &str) -> std::io::Result<()> {
    for entry in std::fs::read_dir("/dev/shm")? {
        let entry = entry?;
        let name = entry.file_name();
        let hash = name
            .to_str()
            .and_then(|name| name.strip_prefix(prefix)?.strip_suffix(".global_mgmt"))
            .and_then(|name| Some(name.split_once("_node.")?.0));
        // The default domain's prefix begins those of all others.
        if hash.is_some_and(|hash| hash.len() == 40 && hash.bytes().all(|c| c.is_ascii_hexdigit()))
        {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Tidies up the domain when everything else is gone.
#[derive(Debug)]
pub(crate) struct Tidy(pub(crate) Domain);

impl Drop for Tidy {
    fn drop(&mut self) {
        self.0.tidy();
    }
}

/// Locks all domains until the result is dropped: shared to join, alone to tidy up.
fn lock(how: FlockOperation) -> std::io::Result<File> {
    std::fs::DirBuilder::new().recursive(true).mode(0o750).create(ROOT)?;
    let root = File::open(ROOT)?;
    rustix::fs::flock(&root, how)?;
    Ok(root)
}

impl std::fmt::Display for Domain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if self.name.is_empty() { "default" } else { &self.name })
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
    use crate::test_domain::test_domain;

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
        assert_eq!(Domain::default().to_string(), "default");
    }

    #[test]
    fn the_longest_name_can_be_joined() {
        let name = format!("{:x<width$}", test_domain(), width = MOST_NAME);
        let domain = Domain::new(&name).unwrap();
        drop(domain.join("test").unwrap());
        domain.tidy();
        assert!(!std::path::Path::new(ROOT).join(name).exists());
    }

    /// The files of this domain in `/dev/shm`.
    fn files(domain: &Domain) -> Vec<String> {
        let prefix = format!("{PREFIX}{domain}_");
        let entries = std::fs::read_dir("/dev/shm").unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.starts_with(&prefix)).collect()
    }

    #[test]
    fn the_last_to_leave_leaves_nothing() {
        let (domain, other) = (test_domain(), test_domain());
        // Its files begin with the first domain's prefix, as all do with the default's.
        let longer = Domain::new(&format!("{domain}_{:040x}", 7)).unwrap();
        let (node, kept) = (domain.join("test").unwrap(), longer.join("test").unwrap());
        assert_eq!(files(&domain).len(), 2, "{:?}", files(&domain));
        domain.tidy();
        assert_eq!(files(&domain).len(), 2, "somebody is there: {:?}", files(&domain));
        drop(node);
        other.tidy();
        domain.tidy();
        assert_eq!(files(&domain), files(&longer));
        assert_eq!(files(&longer).len(), 1);
        drop(kept);
        longer.tidy();
        assert_eq!(files(&domain), [""; 0]);
    }

    #[test]
    fn who_comes_while_the_last_one_tidies_up_can_join() {
        let domain = test_domain();
        std::thread::scope(|threads| {
            for _ in 0..3 {
                threads.spawn(|| {
                    for _ in 0..50 {
                        drop(domain.join("test").unwrap());
                        domain.tidy();
                    }
                });
            }
        });
    }
}
