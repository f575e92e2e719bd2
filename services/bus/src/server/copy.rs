//! Copying what a peer says lies in shared memory.

use crate::client::SURE;
use crate::error::ReceiveError;

/// Appends a request's cells. Beyond [`SURE`] the operating system copies them, and says so where
/// there is less memory than the sender claims: to read there would end the process.
pub(super) fn append(payload: &[u64], cells: &mut Vec<u64>) -> Result<(), ReceiveError> {
    if payload.len() <= SURE {
        cells.extend_from_slice(payload);
        return Ok(());
    }
    cells.reserve_exact(payload.len());
    let bytes = size_of_val(payload);
    let from = libc::iovec { iov_base: payload.as_ptr() as *mut libc::c_void, iov_len: bytes };
    let into = libc::iovec { iov_base: cells.as_mut_ptr().cast(), iov_len: bytes };
    #[expect(unsafe_code, reason = "a system call on plain memory")]
    // SAFETY: `into` is memory of `cells` with room for `bytes`; `from` is only read, by the
    // operating system, which checks that it is there.
    let copied = unsafe { libc::process_vm_readv(libc::getpid(), &into, 1, &from, 1, 0) };
    if copied < 0 && !is_fault(&std::io::Error::last_os_error()) {
        // Forbidden, as in some containers.
        cells.extend_from_slice(payload);
        return Ok(());
    }
    let copied = usize::try_from(copied).unwrap_or(0);
    if copied < bytes {
        return Err(ReceiveError::Short { cells: payload.len(), has: copied / size_of::<u64>() });
    }
    #[expect(unsafe_code, reason = "written by the operating system")]
    // SAFETY: all of it was written.
    unsafe {
        cells.set_len(payload.len());
    }
    Ok(())
}

fn is_fault(error: &std::io::Error) -> bool {
    error.raw_os_error() == Some(libc::EFAULT)
}
