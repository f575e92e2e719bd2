//! Recordings in several files, and what their files say of each other.

use std::path::Path;

use schemas::message::{AxisBox, Digest, ErrorCode, FreeSpace, Refusal};

use super::*;

/// A request over this free space.
fn over(sequence: u64, free_space: FreeSpace) -> Request {
    let scene = SceneRequest { free_space, ..SceneRequest::empty() };
    Request { content: RequestContent::Scene(scene), ..request(sequence) }
}

fn named(name: Digest) -> FreeSpace {
    FreeSpace { named: Some(name), ..FreeSpace::default() }
}

fn channels() -> FreeSpace {
    FreeSpace { channels: Some(vec![AxisBox::default()]), ..FreeSpace::default() }
}

fn read(path: &Path) -> (Reader, usize) {
    let mut reader = Reader::open(path).unwrap();
    let records = reader.by_ref().map(Result::unwrap).count();
    (reader, records)
}

#[test]
fn marks_announce_what_was_sent_and_no_more() {
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, Options { chunk_bytes: 1, ..fixed() }).unwrap();
    // Every message closes the chunk of the one before.
    writer.write_request(&request(0), 50).unwrap();
    writer.heartbeat(60, 9);
    for sequence in 1..5 {
        writer.write_request(&request(sequence), 70).unwrap();
    }
    writer.flush().unwrap();
    for sequence in 5..12 {
        writer.write_request(&request(sequence), 80).unwrap();
    }
    writer.finish().unwrap();
    // The last mark before each place at which the file could be cut.
    let beats: BTreeMap<u64, Heartbeat> = (100..bytes.len())
        .filter_map(|end| {
            let mut reader = Reader::new(&bytes[..end]).ok()?;
            let _ = reader.by_ref().count();
            reader.heartbeat().map(|beat| (beat.sequence, beat))
        })
        .collect();
    let announced = beats.values().map(|beat| (beat.sequence, beat.announced, beat.time_ns));
    let few = (2..=10).map(|sequence| (sequence, 10, 60));
    let many = (11..=12).map(|sequence| (sequence, sequence, 60));
    assert_eq!(
        announced.skip_while(|beat| beat.0 < 2).collect::<Vec<_>>(),
        few.chain(many).collect::<Vec<_>>()
    );
}

#[test]
fn both_files_name_the_exchanges_between_which_they_part() {
    let folder = tempfile::tempdir().unwrap();
    let split = Split { bytes: Some(1), ..Split::default() };
    let mut series = Series::create(&folder.path().join("run.mcap"), fixed(), split).unwrap();
    // At this size each message is a file.
    series.write_request(&request(0), 1).unwrap();
    series.write_request(&request(1), 2).unwrap();
    series.write_reply(&reply(0, 3), 3).unwrap();
    series.write_reply(&reply(1, 3), 4).unwrap();
    assert_eq!(series.finish().unwrap().files, 4);
    let files: Vec<_> =
        (0..4).map(|index| read(&folder.path().join(format!("run-{index:04}.mcap"))).0).collect();
    let keys = |keys: &[u64]| {
        let keys = keys.iter().map(|sequence| key(*sequence).to_string()).collect::<Vec<_>>();
        Some(keys.join(" ")).filter(|keys| !keys.is_empty())
    };
    let open: [&[u64]; 5] = [&[], &[0], &[0, 1], &[1], &[]];
    for (file, (before, after)) in files.iter().zip(open.iter().zip(&open[1..])) {
        assert_eq!(file.description().get(CONTINUES_KEY).cloned(), keys(before));
        assert_eq!(file.notes().get(CONTINUED_KEY).cloned(), keys(after));
    }
}

#[test]
fn free_spaces_that_nobody_told_are_named_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut series = Series::create(&path, fixed(), Split::default()).unwrap();
    let (right, wrong, unknown) = (channels().digest(), Digest([7; 32]), Digest([9; 32]));
    // The planner refuses it, so it makes nothing known.
    series.write_request(&over(0, FreeSpace { named: Some(wrong), ..channels() }), 1).unwrap();
    series.write_request(&over(1, named(wrong)), 1).unwrap();
    series.write_reply(&reply(1, 3), 2).unwrap();
    // The planner does not know it either.
    series.write_request(&over(2, named(unknown)), 1).unwrap();
    let refusal = Refusal::new(ErrorCode::UnknownFreeSpace, "no");
    series.write_reply(&ReplyPart { content: Err(refusal), ..reply(2, 0) }, 2).unwrap();
    // Told before it is named.
    series.know_one(&over(3, FreeSpace { named: Some(right), ..channels() }));
    series.write_request(&over(4, named(right)), 1).unwrap();
    series.write_reply(&reply(4, 3), 2).unwrap();
    assert_eq!(series.finish().unwrap().missing, [wrong].into());
    let (mut reader, records) = read(&path);
    assert_eq!(records, 7);
    assert_eq!(reader.take_free_spaces().len(), 1);
    assert_eq!(reader.notes()["missing_free_spaces"], wrong.to_string());
}
