//! Which programs are in a domain, and which have died there.
//!
//! Each has a file there for as long as it stays, which it locks. The operating system drops
//! the lock when the program dies, however it dies; so a file that nobody locks is that of a
//! program that died, and the sign that there may be more to clear away.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;
use std::sync::LazyLock;

use rustix::fs::FlockOperation;
use rustix::io::Errno;

use crate::site::{self, Site};

/// The environment variable that tells a supervised planner the process of its supervisor.
pub const SUPERVISOR_VARIABLE: &str = "CLEARWAY_SUPERVISOR";

/// This program's file. Dropping it says that the program has left.
#[derive(Debug)]
pub(crate) struct Presence {
    path: PathBuf,
    _locked: File,
}

/// A program that is in a domain, or died there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Visitor {
    /// Its process, as iceoryx2 names it.
    pub(crate) host: u32,
    /// Its process, as it sees itself.
    pub(crate) process: u32,
    /// What it is there.
    pub(crate) role: String,
    /// Whether it lives.
    pub(crate) lives: bool,
    path: PathBuf,
}

impl Presence {
    /// Shows that this program is in a domain, under the lock of the root.
    pub(crate) fn show(site: &Site, role: &str) -> io::Result<Self> {
        let random = getrandom::u64().map_err(|error| io::Error::other(error.to_string()))?;
        // Of a supervised planner it is the supervisor: whom people started, and can signal.
        let supervisor =
            std::env::var(SUPERVISOR_VARIABLE).ok().filter(|_| role == Visitor::PLANNER);
        let supervisor = supervisor.and_then(|process| process.parse().ok());
        let process = supervisor.unwrap_or_else(std::process::id);
        let path = site.visitors().join(format!("{}-{process}-{role}-{random:016x}", *HOST));
        let file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&path)?;
        // Somebody may be looking whether it is locked, which takes microseconds.
        while let Err(error) = rustix::fs::flock(&file, FlockOperation::LockExclusive) {
            if error != Errno::INTR {
                return Err(error.into());
            }
        }
        Ok(Self { path, _locked: file })
    }
}

impl Drop for Presence {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

impl Visitor {
    pub(crate) const PLANNER: &str = "planner";
    pub(crate) const CLIENT: &str = "client";
    pub(crate) const RECORDER: &str = "recorder";
    pub(crate) const WATCHER: &str = "watcher";

    /// Forgets one that died, under the lock of the root.
    pub(crate) fn forget(&self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// All who are in a domain, and those who died there.
pub(crate) fn visitors(site: &Site) -> impl Iterator<Item = Visitor> {
    let directory = site.visitors();
    let names: Vec<_> = site::names(&directory).collect();
    names.into_iter().filter_map(move |name| {
        let path = directory.join(&name);
        let mut parts = name.split('-');
        let host = parts.next()?.parse().ok()?;
        let process = parts.next()?.parse().ok()?;
        let role = parts.next()?.to_owned();
        // One that has just left is not there.
        let file = site::open(&path)?;
        let lives = rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive).is_err();
        Some(Visitor { host, process, role, lives, path })
    })
}

/// The processes that live among these.
pub(crate) fn living(visitors: &[Visitor]) -> BTreeSet<u32> {
    visitors.iter().filter(|visitor| visitor.lives).map(|visitor| visitor.host).collect()
}

/// The number of this process in the names of iceoryx2's files.
pub(crate) fn host() -> u32 {
    *HOST
}

/// This process, as iceoryx2 writes it into the names of its files: in a container, its
/// number outside, if that is known.
static HOST: LazyLock<u32> = LazyLock::new(|| {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let numbers = status.lines().find_map(|line| line.strip_prefix("NSpid:"));
    let first = numbers.and_then(|numbers| numbers.split_whitespace().next()?.parse().ok());
    first.unwrap_or_else(std::process::id)
});
