//! The number of the tap's next message, in a small mapped file that outlasts the planner.
//!
//! So a planner that takes over goes on counting where the one before ended, however that ended,
//! and a recorder sees how far the planner has come without receiving anything.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::mm::{MapFlags, ProtFlags};

/// The file's name in the directory of a domain.
const NAME: &str = "tap";

/// Its first eight bytes: the version of its layout. The number follows.
const VERSION: u64 = 1;

/// Its size, bytes.
const BYTES: usize = 16;

/// The mapped file.
#[derive(Debug)]
pub(crate) struct Ledger {
    memory: NonNull<AtomicU64>,
}

impl Ledger {
    /// Opens it to count in, in the directory of a domain; makes it if it is missing.
    pub(crate) fn create(directory: &Path) -> io::Result<Self> {
        let path = directory.join(NAME);
        let mut open = OpenOptions::new();
        open.read(true).write(true).create(true).truncate(false).mode(0o600);
        let file = open.open(path)?;
        if file.metadata()?.len() < BYTES as u64 {
            file.set_len(BYTES as u64)?;
        }
        let ledger = Self::map(&file, ProtFlags::READ | ProtFlags::WRITE)?;
        if ledger.cell(0).load(Ordering::Relaxed) != VERSION {
            ledger.cell(1).store(0, Ordering::Relaxed);
            ledger.cell(0).store(VERSION, Ordering::Release);
        }
        Ok(ledger)
    }

    /// Opens it to look at; none if a planner of an earlier version made the domain.
    pub(crate) fn find(directory: &Path) -> Option<Self> {
        let file = File::open(directory.join(NAME)).ok()?;
        if file.metadata().ok()?.len() < BYTES as u64 {
            return None;
        }
        let ledger = Self::map(&file, ProtFlags::READ).ok()?;
        (ledger.cell(0).load(Ordering::Acquire) == VERSION).then_some(ledger)
    }

    fn map(file: &File, access: ProtFlags) -> io::Result<Self> {
        #[expect(unsafe_code, reason = "two processes share a file")]
        // SAFETY: a new mapping, which nothing else in this process knows of. The file has `BYTES`
        // bytes, and programs of this user never make it shorter.
        let memory = unsafe {
            rustix::mm::mmap(std::ptr::null_mut(), BYTES, access, MapFlags::SHARED, file, 0)
        }?;
        let memory = NonNull::new(memory.cast()).ok_or(io::ErrorKind::OutOfMemory)?;
        Ok(Self { memory })
    }

    fn cell(&self, index: usize) -> &AtomicU64 {
        assert!(index < BYTES / 8, "the file has two cells");
        #[expect(unsafe_code, reason = "two processes share a file")]
        // SAFETY: the mapping lives as long as `self`, is aligned to a page, and has that many
        // cells; all access to it is atomic, and none to a read-only mapping writes.
        unsafe {
            self.memory.add(index).as_ref()
        }
    }

    /// The number of the next message.
    pub(crate) fn next(&self) -> u64 {
        self.cell(1).load(Ordering::Acquire)
    }

    /// Takes a number for a message that is about to be sent.
    pub(crate) fn take(&self) -> u64 {
        self.cell(1).fetch_add(1, Ordering::AcqRel)
    }
}

impl Drop for Ledger {
    fn drop(&mut self) {
        #[expect(unsafe_code, reason = "two processes share a file")]
        // SAFETY: the mapping that `map` made; no reference to it outlives `self`.
        let _ = unsafe { rustix::mm::munmap(self.memory.as_ptr().cast(), BYTES) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_outlast_who_counts() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Ledger::find(folder.path()).is_none());
        let first = Ledger::create(folder.path()).unwrap();
        let seen = Ledger::find(folder.path()).unwrap();
        assert_eq!((first.take(), first.take(), seen.next()), (0, 1, 2));
        drop(first);
        let second = Ledger::create(folder.path()).unwrap();
        assert_eq!((second.take(), seen.next()), (2, 3));
    }

    #[test]
    fn another_layout_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(NAME), [7; BYTES]).unwrap();
        assert!(Ledger::find(folder.path()).is_none());
        assert_eq!(Ledger::create(folder.path()).unwrap().next(), 0);
    }
}
