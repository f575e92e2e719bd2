//! What is recovered of damaged files, and what is not.

use std::sync::Arc;

use super::*;
use crate::record::{Aside, Foreign};
use crate::recover::Recovered;

/// What is saved of a file, and what is said of the rest.
fn recovered(bytes: &[u8], unverified: bool) -> (Vec<Record>, Option<Recovered>) {
    let disk = Disk::new(usize::MAX);
    let create = |options| Writer::new(disk.clone(), options);
    match salvage(io::Cursor::new(bytes), unverified, fixed(), create).unwrap() {
        None => (Vec::new(), None),
        Some(recovered) => {
            let (records, error, summary) = read(&disk.bytes());
            assert!(error.is_none(), "{error:?}");
            assert_eq!(summary, Some(recovered.summary));
            (records, Some(recovered))
        }
    }
}

fn sequences(records: &[Record]) -> Vec<u32> {
    records.iter().map(|record| record.sequence).collect()
}

/// A recording whose second request carries `payload` in the place of a scene.
fn carrying(payload: &[u8]) -> (Vec<u8>, Vec<usize>) {
    let disk = Disk::new(usize::MAX);
    let mut writer = Writer::new(disk.clone(), fixed()).unwrap();
    let mut flushed = vec![disk.bytes().len()];
    for sequence in 0..3 {
        let mut request = request(sequence);
        if sequence == 1 {
            request.content = unreadable(payload);
        }
        writer.write_request(&request, 5).unwrap();
        writer.flush().unwrap();
        flushed.push(disk.bytes().len());
    }
    writer.finish().unwrap();
    (disk.bytes(), flushed)
}

#[test]
fn damage_in_the_last_chunk_is_counted() {
    let mut small = small();
    let at = small.flushed[2] + 100;
    small.bytes[at] ^= 1;
    let (records, found) = recovered(&small.bytes, false);
    assert_eq!(sequences(&records), [0, 1, 2, 3]);
    let found = found.unwrap();
    assert_eq!(found.summary, Summary { recorded: 4, lost: 2, gaps: 1, left_out: 0 });
    assert!(found.is_incomplete());
    assert!(matches!(found.dropped[..], [Dropped { damage: Damage::Checksum { .. }, .. }]));
    // Killed before it wrote its index.
    let end = small.flushed[3];
    let (records, found) = recovered(&small.bytes[..end], false);
    assert_eq!(sequences(&records), [0, 1, 2, 3]);
    assert_eq!(found.unwrap().summary.lost, 2);
}

#[test]
fn a_recording_inside_a_message_is_not_taken_for_the_recording() {
    let stranger = small_with(Options { id: Some(8), ..fixed() }).bytes;
    for unverified in [false, true] {
        let (mut bytes, flushed) = carrying(&stranger);
        let (whole, found) = recovered(&bytes, unverified);
        assert_eq!(sequences(&whole), [0, 1, 2]);
        assert!(!found.unwrap().is_incomplete());
        // The chunk around it is damaged, behind and before it, and in its length.
        for at in [flushed[1] + 60, flushed[2] - 200, flushed[1] + 3] {
            bytes[at] ^= 1;
            let (records, found) = recovered(&bytes, unverified);
            bytes[at] ^= 1;
            let found = found.unwrap();
            if !unverified {
                assert_eq!(sequences(&records), [0, 2], "damage at {at}");
                assert_eq!(found.summary.lost, 1);
            }
            assert!(found.is_incomplete());
            for record in records {
                let original = &whole[record.sequence as usize];
                assert_eq!(record.log_ns, original.log_ns, "a message of the payload");
            }
        }
        // Not even if it has the same number: it is not where it says that it was written.
        let (mut bytes, flushed) = carrying(&small_with(fixed()).bytes);
        bytes[flushed[1] + 60] ^= 1;
        let (records, _) = recovered(&bytes, false);
        assert!(records.iter().all(|record| record.log_ns == 5), "a message of the payload");
    }
}

#[test]
fn a_chunk_inside_a_message_of_another_writer_is_not_taken_either() {
    let message = schemas::codec::encode(&request(5));
    let inner = foreign(planning(), OURS, &message);
    let request = Request { content: unreadable(&inner), ..request(0) };
    let outer = schemas::codec::encode(&request);
    for emit in [true, false] {
        let options = planning().emit_summary_records(emit).emit_summary_offsets(emit);
        let whole = foreign(options, OURS, &outer);
        assert_eq!(recovered(&whole, false).0.len(), 1);
        // In the outer chunk's first message, and in its length.
        let begin = 8 + 9 + u64::from_le_bytes(whole[9..17].try_into().unwrap()) as usize;
        for at in [begin + 1, begin + 60] {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x40;
            let (records, _) = recovered(&bytes, false);
            let genuine = Message::Request(request.clone());
            assert!(records.iter().all(|record| record.message == genuine), "{emit}, {at}");
        }
    }
}

fn unreadable(payload: &[u8]) -> RequestContent {
    let cells = payload.chunks(8).map(|piece| {
        let mut cell = [0; 8];
        cell[..piece.len()].copy_from_slice(piece);
        u64::from_le_bytes(cell)
    });
    RequestContent::Unreadable { header: Vec::new(), cells: cells.collect() }
}

#[test]
fn parts_that_are_missing_twice_or_out_of_order_are_noticed() {
    let small = small();
    let mark = 85;
    // A part begins with its mark, which the flush before it wrote.
    let part =
        |index: usize| &small.bytes[small.flushed[index - 1] - mark..small.flushed[index] - mark];
    let (before, after) =
        (&small.bytes[..small.flushed[0] - mark], &small.bytes[small.flushed[3] - mark..]);
    let with = |parts: &[usize]| {
        let parts: Vec<_> = parts.iter().flat_map(|index| part(*index)).copied().collect();
        [before, &parts, after].concat()
    };
    assert_eq!(with(&[1, 2, 3]), small.bytes);

    let (records, error, _) = read(&with(&[1, 3]));
    assert_eq!((sequences(&records), error.is_some()), (vec![0, 1], true));
    let (records, found) = recovered(&with(&[1, 3]), false);
    assert_eq!(sequences(&records), [0, 1, 4, 5]);
    assert!(found.unwrap().is_incomplete());

    for order in [&[1, 1, 2, 3][..], &[1, 2, 3, 2], &[1, 2, 3, 3]] {
        assert!(read(&with(order)).1.is_some(), "{order:?}");
        let (records, found) = recovered(&with(order), false);
        assert_eq!(records, small.records, "{order:?}");
        assert!(found.unwrap().is_incomplete(), "{order:?}");
    }
    for order in [&[2, 1, 3][..], &[3, 2, 1], &[1, 3, 2]] {
        assert!(read(&with(order)).1.is_some(), "{order:?}");
        let (records, found) = recovered(&with(order), false);
        assert_eq!(records, small.records, "{order:?}");
        assert!(found.unwrap().is_incomplete(), "{order:?}");
    }
}

#[test]
fn what_no_checksum_vouches_for_is_kept_on_demand_and_marked() {
    let mut small = small();
    // In the request's identification, which no length depends on.
    let at = small.flushed[1] + 9 + 40 + 31 + 3;
    small.bytes[at] ^= 1;
    let (records, found) = recovered(&small.bytes, false);
    assert_eq!(sequences(&records), [0, 1, 4, 5]);
    assert_eq!(found.unwrap().unverified, 0);
    let (records, found) = recovered(&small.bytes, true);
    assert_eq!(sequences(&records), [0, 1, 2, 3, 4, 5]);
    let found = found.unwrap();
    assert_eq!((found.unverified, found.summary.lost), (2, 0));
    assert!(found.is_incomplete());
    assert_ne!(records[2], small.records[2]);
    assert_eq!(records[3], small.records[3]);
}

#[test]
fn a_damaged_beginning_costs_nothing() {
    let small = small();
    let mut bytes = small.bytes.clone();
    bytes[..60].fill(0);
    let (records, found) = recovered(&bytes, false);
    assert_eq!(records, small.records);
    assert!(matches!(found.unwrap().reason, Some(ReadError::NotMcap { .. })));
}

#[test]
fn bytes_that_look_like_chunks_cost_no_more_time_than_others() {
    // Each 49 bytes the head of a chunk that claims the rest of the file.
    let mut bytes = foreign(planning(), OURS, &schemas::codec::encode(&request(0)));
    let cut = bytes.len() / 2;
    bytes.truncate(cut);
    bytes.extend([0xff; 9]);
    const SIZE: u64 = 1 << 20;
    for at in (0..SIZE).step_by(49) {
        let left = SIZE - at;
        bytes.push(op::CHUNK);
        bytes.extend((left + 40).to_le_bytes());
        bytes.extend([0; 16]);
        bytes.extend(left.to_le_bytes());
        bytes.extend([1, 2, 3, 4, 0, 0, 0, 0]);
        bytes.extend(left.to_le_bytes());
    }
    let mut counted = Counting { input: io::Cursor::new(&bytes), read: 0 };
    let create = |options| Writer::new(Disk::new(usize::MAX), options);
    salvage(&mut counted, true, fixed(), create).unwrap();
    let most = 12 * bytes.len() as u64;
    assert!(counted.read <= most, "{} bytes read of {}", counted.read, bytes.len());
}

/// Counts what is read.
struct Counting<R> {
    input: R,
    read: u64,
}

impl<R: io::Read> io::Read for Counting<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(bytes)?;
        self.read += read as u64;
        Ok(read)
    }
}

impl<R: io::Seek> io::Seek for Counting<R> {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.input.seek(to)
    }
}

#[test]
fn what_stands_beside_messages_is_recovered() {
    let disk = Disk::new(usize::MAX);
    let mut writer = Writer::new(disk.clone(), fixed()).unwrap();
    writer.write_status("{\"first\": 1}", 1).unwrap();
    let channel = Arc::new(Foreign {
        topic: "/camera".to_owned(),
        encoding: "raw".to_owned(),
        metadata: [("frame".to_owned(), "map".to_owned())].into(),
        schema: Some(("Image".to_owned(), "raw".to_owned(), vec![1, 2])),
    });
    let image = |sequence| Aside::Foreign {
        channel: Arc::clone(&channel),
        message: vec![9; 50],
        sequence,
        log_ns: 7,
        publish_ns: 5,
    };
    writer.write_aside(&image(3)).unwrap();
    writer.write_request(&request(0), 2).unwrap();
    writer.write_aside(&image(4)).unwrap();
    writer.leave_out(3);
    writer.finish().unwrap();
    let copy = Disk::new(usize::MAX);
    let create = |options| Writer::new(copy.clone(), options);
    let found = salvage(io::Cursor::new(disk.bytes()), false, fixed(), create).unwrap().unwrap();
    assert_eq!((found.others, found.summary.recorded, found.summary.left_out), (2, 1, 3));
    let bytes = copy.bytes();
    let mut reader = Reader::new(&bytes[..]).unwrap();
    reader.keep_statuses();
    reader.keep_foreign();
    assert_eq!(reader.by_ref().map(|record| record.unwrap().sequence).collect::<Vec<_>>(), [0]);
    let json = "{\"first\": 1}".to_owned();
    assert_eq!(reader.take_asides(), [Aside::Status { json, log_ns: 1 }, image(3), image(4)]);
}
