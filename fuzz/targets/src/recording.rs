//! Recordings, read and recovered.

use std::fs;

use ::recording::{Options, Reader, recover};
use tempfile::TempDir;

/// A recording. It is read as it is, and once more with the checksums of its chunks corrected,
/// so that what is behind them is reached.
pub fn recording(bytes: &[u8]) {
    read_and_recover(bytes);
    let mut corrected = bytes.to_vec();
    if correct_checksums(&mut corrected) > 0 {
        read_and_recover(&corrected);
    }
}

fn read_and_recover(bytes: &[u8]) {
    let (read, whole) = match Reader::new(bytes) {
        Err(_) => (0, false),
        Ok(mut reader) => {
            let read = reader.by_ref().take_while(Result::is_ok).count();
            (read as u64, reader.summary().is_some())
        }
    };
    thread_local! {
        static FOLDER: TempDir = TempDir::new().expect("the system has room for files");
    }
    FOLDER.with(|folder| {
        let [from, to] = ["from.mcap", "to.mcap"].map(|name| folder.path().join(name));
        fs::write(&from, bytes).expect("the folder takes files");
        let Ok(recovered) = recover(&from, &to, false, Options::overwriting()) else { return };
        let saved = recovered.summary;
        assert!(!whole || saved.recorded >= read, "{read} messages were read, {saved:?}");
        let mut reader = Reader::open(&to).expect("what was recovered is a recording");
        let mut again = 0;
        for record in reader.by_ref() {
            record.expect("its messages are whole");
            again += 1;
        }
        assert_eq!(again, saved.recorded);
        assert_eq!(reader.summary(), Some(saved));
    });
}

const MAGIC_BYTES: usize = 8;
const CHUNK: u8 = 6;

/// Gives each chunk the checksum of its bytes; how many were wrong.
fn correct_checksums(bytes: &mut [u8]) -> usize {
    let (mut at, mut wrong) = (MAGIC_BYTES, 0);
    while let Some(head) = bytes.get(at..at + 9) {
        let kind = head[0];
        let length = u64::from_le_bytes(head[1..].try_into().expect("8 bytes"));
        let from = at + 9;
        let Some(to) = usize::try_from(length).ok().and_then(|length| from.checked_add(length))
        else {
            break;
        };
        let Some(body) = bytes.get_mut(from..to) else { break };
        // Times (16), size (8), checksum (4), compression (a string), size (8), records.
        if kind == CHUNK && body.len() >= 32 {
            let name = u32::from_le_bytes(body[28..32].try_into().expect("4 bytes")) as usize;
            if let Some(records) = 40_usize.checked_add(name).and_then(|begin| body.get(begin..)) {
                let checksum = crc32fast::hash(records).to_le_bytes();
                wrong += usize::from(body[24..28] != checksum);
                body[24..28].copy_from_slice(&checksum);
            }
        }
        at = to;
    }
    wrong
}
