//! Taking shared memory before it is written.
//!
//! Files in `/dev/shm` are sparse: a page is taken when it is first written, and if none is left
//! then, the writer dies of SIGBUS. To take it before turns that into an error.

use std::fs::OpenOptions;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use rustix::fs::FallocateFlags;
use rustix::io::Errno;
use rustix::mm::{Advice, madvise};

use crate::site::MEMORY;

/// What connecting takes at most, beside the memory for messages and for what is open or waits.
pub(crate) const CONNECTION: u64 = 128 << 10;

/// What it takes for each request that can be open, at most.
pub(crate) const OPEN_REQUEST: u64 = 16 << 10;

/// What it takes for each message that can wait for a recorder, at most.
pub(crate) const WAITING: u64 = 32;

/// What iceoryx2 writes to manage memory for messages before they are written.
pub(crate) const MANAGEMENT: u64 = 64 << 10;

/// Less shared memory is free than is needed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shortage {
    /// Bytes needed.
    pub(crate) needs: u64,
    /// Bytes free.
    pub(crate) free: u64,
}

/// Shared memory that is free on this machine, bytes, where that can be told.
pub fn free_memory() -> Option<u64> {
    let memory = rustix::fs::statvfs(MEMORY).ok()?;
    Some(memory.f_bavail.saturating_mul(memory.f_frsize))
}

/// Checks that so many bytes are free. Others can still take them.
pub(crate) fn check_room(needs: u64) -> Result<(), Shortage> {
    match free_memory() {
        Some(free) if free < needs => Err(Shortage { needs, free }),
        _ => Ok(()),
    }
}

/// Takes all memory of those of these files that `wanted` names.
pub(crate) fn take_files(names: &[String], wanted: impl Fn(&str) -> bool) -> Result<(), Shortage> {
    for name in names.iter().filter(|name| wanted(name)) {
        // Whoever left meanwhile needs nothing.
        let Ok(file) = OpenOptions::new().write(true).open(Path::new(MEMORY).join(name)) else {
            continue;
        };
        let Ok(found) = file.metadata() else { continue };
        let taken = loop {
            match rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, found.len()) {
                Err(Errno::INTR) => {}
                done => break done,
            }
        };
        if let Err(Errno::NOSPC | Errno::NOMEM) = taken {
            let needs = found.len().saturating_sub(found.blocks() * 512);
            return Err(Shortage { needs, free: free_memory().unwrap_or(0) });
        }
    }
    Ok(())
}

/// Takes the memory of a part of a file that is about to be written.
pub(crate) fn take_slice<T>(memory: &mut [T]) -> Result<(), Shortage> {
    let page = rustix::param::page_size();
    let begin = memory.as_mut_ptr().addr();
    let skipped = begin % page;
    let bytes = size_of_val(memory);
    let first = memory.as_mut_ptr().cast::<u8>().wrapping_sub(skipped);
    #[expect(unsafe_code, reason = "a system call on memory that is mapped to be written")]
    // SAFETY: these are the pages that `memory` lies in; to populate them changes no content.
    let taken = unsafe { madvise(first.cast(), skipped + bytes, Advice::LinuxPopulateWrite) };
    match taken {
        Err(Errno::FAULT | Errno::NOMEM) => {
            Err(Shortage { needs: bytes as u64, free: free_memory().unwrap_or(0) })
        }
        // Before Linux 5.14 only what is free is known.
        Err(Errno::INVAL) => check_room(bytes as u64),
        _ => Ok(()),
    }
}
