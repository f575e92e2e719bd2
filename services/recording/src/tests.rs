//! Files whole, cut, damaged and hostile.

mod conformance;
mod mutations;
mod recovery;
mod series;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::error::Error as _;
use std::io::{self, Write};
use std::rc::Rc;

use mcap::records::{MessageHeader, op};
use schemas::message::{
    Body, Clearance, ClearanceWish, Gap, ReplyPart, Request, RequestContent, RequestKey, Sample,
    SceneRequest, Task, Trajectory,
};
use schemas::topic;

use super::*;
use crate::recover::{Problem, salvage};

/// With a number that is the same each time.
fn fixed() -> Options {
    Options { id: Some(7), ..Options::default() }
}

fn key(sequence: u64) -> RequestKey {
    RequestKey { client: 0x1234_5678_9abc_def0, sequence }
}

fn request(sequence: u64) -> Request {
    let scene = SceneRequest {
        id: Some(sequence),
        task: Task::Disassemble,
        body: Body::Polygon(vec![[4.5, 1.01].into(), [4.5, 4.0].into(), [6.99, 4.0].into()]),
        clearance: ClearanceWish::Gap(Gap::Uniform(0.2)),
        ..SceneRequest::empty()
    };
    Request { key: key(sequence), sent_ns: 1_000 + sequence, content: RequestContent::Scene(scene) }
}

fn reply(sequence: u64, samples: usize) -> ReplyPart {
    let sample =
        |at| Sample { t: at as f64 * 0.02, position: [0.1, 0.3, 0.0], ..Sample::default() };
    let trajectory = Trajectory {
        dimension: 2,
        length: 7.4,
        clearance: Clearance { value: 0.01, at: 0.0, wall: [6.99, 1.0].into() },
        samples: (0..samples).map(sample).collect(),
        ..Trajectory::default()
    };
    ReplyPart {
        key: key(sequence),
        id: Some(sequence),
        sent_ns: 1_500 + sequence,
        part: 0,
        last: true,
        answer: 0,
        answers: 1,
        content: Ok(trajectory),
    }
}

/// A disk with `room` bytes left.
#[derive(Clone)]
struct Disk {
    bytes: Rc<RefCell<Vec<u8>>>,
    room: usize,
}

impl Disk {
    fn new(room: usize) -> Self {
        Self { bytes: Rc::default(), room }
    }

    fn bytes(&self) -> Vec<u8> {
        self.bytes.borrow().clone()
    }
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.room - self.bytes.borrow().len());
        if taken == 0 && !bytes.is_empty() {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.bytes.borrow_mut().extend_from_slice(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A small finished recording of three chunks with two messages each; where each chunk's
/// flush ended; its messages.
struct Small {
    bytes: Vec<u8>,
    flushed: Vec<usize>,
    records: Vec<Record>,
}

fn small() -> Small {
    small_with(fixed())
}

fn small_with(options: Options) -> Small {
    let disk = Disk::new(usize::MAX);
    let mut writer = Writer::new(disk.clone(), options).unwrap();
    let mut flushed = vec![disk.bytes().len()];
    let mut records = Vec::new();
    for at in 0..3_u64 {
        writer.write_request(&request(at), 2_000 + at).unwrap();
        writer.write_reply(&reply(at, 2), 3_000 + at).unwrap();
        writer.flush().unwrap();
        flushed.push(disk.bytes().len());
        records.push(Record {
            message: Message::Request(request(at)),
            log_ns: 2_000 + at,
            publish_ns: 1_000 + at,
            sequence: 2 * at as u32,
        });
        records.push(Record {
            message: Message::Reply(reply(at, 2)),
            log_ns: 3_000 + at,
            publish_ns: 1_500 + at,
            sequence: 2 * at as u32 + 1,
        });
    }
    let summary = writer.finish().unwrap();
    assert_eq!(summary, Summary { recorded: 6, lost: 0, gaps: 0, left_out: 0 });
    Small { bytes: disk.bytes(), flushed, records }
}

/// What a reader gives: the messages before the first error, the error, the summary.
fn read(bytes: &[u8]) -> (Vec<Record>, Option<ReadError>, Option<Summary>) {
    let mut reader = match Reader::new(bytes) {
        Ok(reader) => reader,
        Err(error) => return (Vec::new(), Some(error), None),
    };
    let mut records = Vec::new();
    let error = loop {
        match reader.next() {
            Some(Ok(record)) => records.push(record),
            Some(Err(error)) => break Some(error),
            None => break None,
        }
    };
    assert!(reader.next().is_none(), "a reader goes on after its end");
    (records, error, reader.summary())
}

/// What can be saved of a file.
fn salvaged(bytes: &[u8]) -> Vec<Record> {
    let disk = Disk::new(usize::MAX);
    let create = |options| Writer::new(disk.clone(), options);
    match salvage(io::Cursor::new(bytes), false, fixed(), create) {
        Ok(Some(_)) => read(&disk.bytes()).0,
        Ok(None) | Err(Problem::Read(_)) => Vec::new(),
        Err(problem) => panic!("{problem:?}"),
    }
}

#[test]
fn what_was_written_is_read() {
    let small = small();
    let (records, error, summary) = read(&small.bytes);
    assert!(error.is_none(), "{error:?}");
    assert_eq!(records, small.records);
    assert_eq!(summary, Some(Summary { recorded: 6, lost: 0, gaps: 0, left_out: 0 }));
}

#[test]
fn equal_messages_give_equal_bytes() {
    assert_eq!(small().bytes, small().bytes);
}

#[test]
fn losses_show_where_they_are() {
    let disk = Disk::new(usize::MAX);
    let mut writer = Writer::new(disk.clone(), fixed()).unwrap();
    writer.write_request(&request(0), 1).unwrap();
    writer.lost(2);
    writer.lost(1);
    writer.write_request(&request(1), 2).unwrap();
    writer.lost(4);
    writer.leave_out(5);
    let expected = Summary { recorded: 2, lost: 7, gaps: 2, left_out: 5 };
    assert_eq!(writer.finish().unwrap(), expected);

    let bytes = disk.bytes();
    let mut reader = Reader::new(&bytes[..]).unwrap();
    let sequences: Vec<_> = reader.by_ref().map(|record| record.unwrap().sequence).collect();
    assert_eq!(sequences, [0, 4]);
    assert_eq!((reader.lost(), reader.gaps()), (7, 2), "the last mark tells of the last four");
    assert_eq!(reader.summary(), Some(expected));
}

#[test]
fn sequence_numbers_wrap_around() {
    let mut gaps = gaps::Gaps::default();
    assert_eq!(gaps.before(u32::MAX / 2), u64::from(u32::MAX / 2));
    assert_eq!(gaps.before(u32::MAX - 1), u64::from(u32::MAX / 2 - 1));
    assert_eq!(gaps.before(1), 2);
    assert_eq!(gaps.before(2), 0);
    assert_eq!(gaps.before(0), 0, "a new count");
    assert_eq!(gaps.before(1), 0);
}

#[test]
fn a_large_message_goes_into_one_chunk() {
    let disk = Disk::new(usize::MAX);
    let mut writer = Writer::new(disk.clone(), fixed()).unwrap();
    let big = reply(0, 300_000);
    writer.write_reply(&reply(0, 14_000), 0).unwrap();
    writer.write_reply(&big, 1).unwrap();
    writer.finish().unwrap();
    let (records, error, _) = read(&disk.bytes());
    assert!(error.is_none(), "{error:?}");
    assert_eq!(records[1].message, Message::Reply(big));
}

#[test]
fn a_cut_costs_what_came_after_the_last_flush() {
    let small = small();
    for end in 0..small.bytes.len() {
        let (records, error, summary) = read(&small.bytes[..end]);
        let error = error.unwrap_or_else(|| panic!("the cut at {end} is not noticed"));
        assert!(error.is_cut(), "cut at {end}: {error}");
        let flushes = small.flushed.iter().filter(|flushed| **flushed <= end).count();
        let kept = 2 * flushes.saturating_sub(1);
        assert!(records.len() >= kept, "cut at {end}: {} of {kept} are left", records.len());
        assert_eq!(records, small.records[..records.len()], "cut at {end}");
        assert!(summary.is_none_or(|summary| summary.recorded == 6));
        assert_eq!(salvaged(&small.bytes[..end]), records, "cut at {end}");
    }
}

#[test]
fn a_killed_writers_file_holds_everything_flushed() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = Writer::create(folder.path().join("killed.mcap"), Options::default()).unwrap();
    let path = folder.path().join("killed.mcap.part");
    let empty = std::fs::read(&path).unwrap();
    writer.write_request(&request(0), 1).unwrap();
    writer.flush().unwrap();
    writer.write_request(&request(1), 2).unwrap();
    let killed = std::fs::read(&path).unwrap();
    drop(writer);
    let dropped = std::fs::read(&path).unwrap();

    let check = |bytes: &[u8], count: usize, cut: bool| {
        let (records, error, summary) = read(bytes);
        assert_eq!(records.len(), count);
        assert_eq!(error.is_some_and(|error| error.is_cut()), cut);
        assert_eq!(summary, None);
    };
    check(&empty, 0, true);
    check(&killed, 1, true);
    check(&dropped, 2, false);
}

#[test]
fn no_flipped_bit_passes() {
    let small = small();
    let mut bytes = small.bytes.clone();
    for at in 0..bytes.len() {
        for bit in 0..8 {
            bytes[at] ^= 1 << bit;
            let (records, error, _) = read(&bytes);
            assert!(error.is_some(), "bit {bit} of byte {at}, flipped, is not noticed");
            // A chunk that no longer says it is one is passed over, and its messages missed.
            assert!(records.is_sorted_by_key(|record| record.sequence));
            for record in &records {
                let written = &small.records[record.sequence as usize];
                assert_eq!(record, written, "bit {bit} of byte {at}");
            }
            bytes[at] ^= 1 << bit;
        }
    }
}

#[test]
fn recovery_takes_everything_but_the_damaged_chunk() {
    let small = small();
    let mut bytes = small.bytes.clone();
    for at in 0..bytes.len() {
        let bit = at % 8;
        bytes[at] ^= 1 << bit;
        let saved = salvaged(&bytes);
        bytes[at] ^= 1 << bit;
        // The channels are in the first chunk, and in the index.
        let of = |range: std::ops::Range<usize>| {
            small.flushed.partition_point(|end| *end <= at) == range.start
        };
        let expected: Vec<_> = if at < small.flushed[0] {
            small.records.clone()
        } else {
            let hit = (1..4).find(|chunk| of(*chunk..4)).map(|chunk| 2 * (chunk - 1));
            let whole = saved.len() == small.records.len();
            let lost =
                |index: &usize| !whole && hit.is_some_and(|hit| (hit..hit + 2).contains(index));
            (0..6).filter(|index| !lost(index)).map(|index| small.records[index].clone()).collect()
        };
        assert_eq!(saved, expected, "bit {bit} of byte {at}");
    }
}

#[test]
fn a_length_of_2_to_the_56_is_refused() {
    let small = small();
    let mut bytes = small.bytes;
    let chunk = small.flushed[0];
    assert_eq!(bytes[chunk], op::CHUNK);
    bytes[chunk + 8] = 1;
    let (records, error, _) = read(&bytes);
    assert!(records.is_empty());
    let offset = chunk as u64;
    assert!(
        matches!(error, Some(ReadError::Damaged { offset: at, damage: Damage::TooLong { claimed, .. } })
            if at == offset && claimed > 1 << 56),
        "{error:?}"
    );
}

/// Hostile bytes under a right checksum: anything but a panic.
#[test]
fn hostile_chunks_are_survived() {
    let small = small();
    let chunk = small.flushed[0];
    let size = u64::from_le_bytes(small.bytes[chunk + 1..chunk + 9].try_into().unwrap()) as usize;
    let inside = chunk + 49..chunk + 9 + size;
    let mut refused = 0;
    for at in inside.clone() {
        for value in [0, 1, 0x7f, 0x80, 0xff] {
            let mut bytes = small.bytes.clone();
            bytes[at] = value;
            let checksum = crc32fast::hash(&bytes[inside.clone()]);
            bytes[chunk + 33..chunk + 37].copy_from_slice(&checksum.to_le_bytes());
            refused += usize::from(read(&bytes).1.is_some());
            salvaged(&bytes);
        }
    }
    assert!(refused > inside.len(), "only {refused} were refused");
}

#[test]
fn a_full_disk_is_final_and_named() {
    let whole = small().bytes.len();
    for room in 0..whole {
        let disk = Disk::new(room);
        let attempt = (|| {
            let mut writer = Writer::new(disk.clone(), fixed())?;
            for at in 0..3 {
                let results = [
                    writer.write_request(&request(at), 2_000 + at),
                    writer.write_reply(&reply(at, 2), 3_000 + at),
                    writer.flush(),
                ];
                let failed = results.iter().position(Result::is_err).unwrap_or(3);
                assert!(results[failed..].iter().all(Result::is_err), "an error is not final");
                results.into_iter().collect::<Result<(), _>>()?;
            }
            writer.finish()
        })();
        let error = attempt.err().unwrap_or_else(|| panic!("{room} bytes were enough"));
        let WriteError::Output { source } = &error else { panic!("{error}") };
        assert_eq!(source.kind(), io::ErrorKind::StorageFull, "with {room} bytes");
        let (records, error, _) = read(&disk.bytes());
        assert!(error.is_some_and(|error| error.is_cut()), "with {room} bytes");
        let small = small();
        let flushes = small.flushed.iter().filter(|end| **end <= room).count();
        assert_eq!(records, small.records[..records.len()]);
        assert!(records.len() >= 2 * flushes.saturating_sub(1), "with {room} bytes");
    }
}

#[test]
fn a_full_device_says_so() {
    let Err(error) = Writer::create("/dev/full", Options::overwriting()) else {
        panic!("/dev/full took a recording");
    };
    assert!(error.to_string().contains("No space left on device"), "{error}");
}

#[test]
fn files_are_not_overwritten_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    std::fs::write(&path, "mine").unwrap();
    let refused = Writer::create(&path, Options::default());
    assert!(matches!(refused, Err(WriteError::Exists { .. })));
    assert_eq!(std::fs::read(&path).unwrap(), b"mine");
    Writer::create(&path, Options::overwriting()).unwrap().finish().unwrap();
    assert!(read(&std::fs::read(&path).unwrap()).1.is_none());
}

#[test]
fn a_message_above_the_limit_counts_as_lost() {
    let disk = Disk::new(usize::MAX);
    let mut writer = Writer::new(disk.clone(), fixed()).unwrap();
    let cells = vec![0; MOST_MESSAGE_BYTES / 8];
    let content = RequestContent::Unreadable { header: Vec::new(), cells };
    let error = writer.write_request(&Request { content, ..request(0) }, 0).unwrap_err();
    assert!(matches!(error, WriteError::TooLarge { .. }), "{error}");
    writer.write_request(&request(1), 0).unwrap();
    assert_eq!(writer.finish().unwrap(), Summary { recorded: 1, lost: 1, gaps: 1, left_out: 0 });
    assert_eq!(read(&disk.bytes()).0[0].sequence, 1);
}

/// A file by the `mcap` crate alone: `layout` names channel, message encoding and
/// schema text of the one message in it; `version` is that of its channel.
fn versioned(
    version: Option<&str>,
    options: mcap::WriteOptions,
    layout: [&str; 3],
    message: &[u8],
) -> Vec<u8> {
    let metadata = version.map(|version| (format::VERSION_KEY.to_owned(), version.to_owned()));
    let metadata = BTreeMap::from_iter(metadata);
    let mut bytes = io::Cursor::new(Vec::new());
    let mut writer = options.compression(None).create(&mut bytes).unwrap();
    let schema = writer.add_schema("clearway.Request", topic::ENCODING, layout[2].as_bytes());
    let channel = writer.add_channel(schema.unwrap(), layout[0], layout[1], &metadata).unwrap();
    let header = MessageHeader { channel_id: channel, sequence: 0, log_time: 1, publish_time: 1 };
    writer.write_to_known_channel(&header, message).unwrap();
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

fn foreign(options: mcap::WriteOptions, layout: [&str; 3], message: &[u8]) -> Vec<u8> {
    versioned(Some("3"), options, layout, message)
}

fn planning() -> mcap::WriteOptions {
    mcap::WriteOptions::new().profile(topic::PROFILE)
}

const OURS: [&str; 3] = [topic::REQUEST, topic::ENCODING, schemas::codec::REQUEST_SCHEMA];

#[track_caller]
fn check_refused(bytes: &[u8], expected: &str) {
    let (records, error, _) = read(bytes);
    assert!(records.is_empty());
    let error = error.map(|error| error.to_string()).unwrap_or_default();
    assert!(error.contains(expected), "{error:?} does not say {expected:?}");
}

#[test]
fn files_of_other_tools_are_read_or_refused_by_name() {
    let message = schemas::codec::encode(&request(0));
    let (records, error, _) = read(&foreign(planning(), OURS, &message));
    assert!(error.is_none(), "{error:?}");
    assert_eq!(records[0].message, Message::Request(request(0)));

    let other = ["/viewer/path", "json", "{}"];
    let viewer = foreign(planning(), other, b"{}");
    let mut reader = Reader::new(&viewer[..]).unwrap();
    assert!(reader.next().is_none());
    assert_eq!(reader.skipped(), 1);

    check_refused(b"", "ends at byte 0");
    check_refused(b"{\"task\"", "not an MCAP file");
    let elsewhere = foreign(mcap::WriteOptions::new().profile("ros2"), other, b"{}");
    let said = "no recording of planning: an MCAP file of profile \"ros2\" with 1 messages of \
                /viewer/path";
    check_refused(&elsewhere, said);
    let json = [OURS[0], "json", OURS[2]];
    check_refused(&foreign(planning(), json, &message), "the message encoding of /planner/request");
    check_refused(&foreign(planning(), OURS, &message[..20]), "can't be decoded");
    let longer = [&message[..], &[0]].concat();
    check_refused(&foreign(planning(), OURS, &longer), "can't be decoded");
}

#[test]
fn the_words_of_a_schema_are_not_compared() {
    let message = schemas::codec::encode(&request(0));
    let reworded = [OURS[0], OURS[1], "a corrected typo"];
    let (records, error, _) = read(&foreign(planning(), reworded, &message));
    assert!(error.is_none(), "{error:?}");
    assert_eq!(records[0].message, Message::Request(request(0)));
}

#[test]
fn a_channel_without_a_version_is_of_version_1() {
    let message = schemas::codec::encode(&request(0));
    let of = |version| {
        let (records, error, _) = read(&versioned(version, planning(), OURS, &message));
        let cause = error.and_then(|error| Some(error.source()?.to_string()));
        records.first().map(|record| record.message.clone()).ok_or(cause)
    };
    // Version 1 lays a request out in another way, and says so in the same words.
    assert_eq!(of(Some("3")), Ok(Message::Request(request(0))));
    let as_version_1 = of(Some("1")).unwrap_err();
    assert!(as_version_1.is_some());
    assert_eq!(of(None), Err(as_version_1));
}

#[test]
fn newer_versions_are_refused_with_both_numbers() {
    let message = schemas::codec::encode(&request(0));
    let of = |version| versioned(Some(version), planning(), OURS, &message);
    check_refused(
        &of("4"),
        "/planner/request holds clearway.Request version 4, this program reads versions 1 to 3",
    );
    check_refused(&of("0"), "version 0, this program reads versions 1 to 3");
    let named = "the schema_version of /planner/request is \"two\", expected \"a number\"";
    check_refused(&of("two"), named);
}

#[test]
fn recover_makes_a_finished_file() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("cut.mcap"), folder.path().join("whole.mcap"));
    let small = small();
    std::fs::write(&from, &small.bytes[..small.flushed[2] + 60]).unwrap();

    let same = recover(&from, &from, false, Options::overwriting());
    assert!(matches!(same, Err(RecoverError::SameFile { .. })));

    let recovered = recover(&from, &to, false, Options::default()).unwrap();
    assert_eq!(recovered.summary, Summary { recorded: 4, lost: 0, gaps: 0, left_out: 0 });
    assert!(recovered.reason.is_some_and(|reason| reason.is_cut()));
    let (records, error, summary) = read(&std::fs::read(&to).unwrap());
    assert!(error.is_none(), "{error:?}");
    assert_eq!(records, small.records[..4]);
    assert_eq!(summary, Some(recovered.summary));

    let again = recover(&from, &to, false, Options::default());
    assert!(matches!(again, Err(RecoverError::Write(WriteError::Exists { .. }))));
    std::fs::write(&from, "no recording").unwrap();
    let nothing = recover(&from, &folder.path().join("none.mcap"), false, Options::default());
    assert!(matches!(nothing, Err(RecoverError::Nothing { .. })));
    assert!(!folder.path().join("none.mcap").exists());
}

#[test]
fn recovery_counts_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("damaged.mcap"), folder.path().join("whole.mcap"));
    let mut small = small();
    small.bytes[small.flushed[1] + 100] ^= 1;
    std::fs::write(&from, &small.bytes).unwrap();
    let recovered = recover(&from, &to, false, Options::default()).unwrap();
    assert_eq!(recovered.summary, Summary { recorded: 4, lost: 2, gaps: 1, left_out: 0 });
    assert!(matches!(recovered.reason, Some(ReadError::Damaged { .. })));
    let sequences: Vec<_> =
        read(&std::fs::read(&to).unwrap()).0.iter().map(|record| record.sequence).collect();
    assert_eq!(sequences, [0, 1, 4, 5]);
}
