//! Recordings made of recordings: `bless`, `extract`, `merge`.

use std::path::Path;
use std::process::Command;

use recording::{Message, Options, Reader, Record, Writer};
use schemas::codec;
use schemas::message::RequestKey;

use crate::recorded::{Folder, keep, record, record_named, request, samples};

fn records(path: &Path) -> Vec<Record> {
    Reader::open(path).unwrap().collect::<Result<_, _>>().unwrap()
}

/// The bytes of each message, with its times and sequence.
fn bytes(record: &Record) -> (Vec<u8>, u64, u64, u32) {
    let bytes = match &record.message {
        Message::Request(request) => codec::encode(request),
        Message::Reply(part) => codec::encode(part),
    };
    (bytes, record.log_ns, record.publish_ns, record.sequence)
}

/// Requests 0 and 2 have moved, 1 has not.
fn moved() -> Folder {
    Folder::with("a.mcap", |part| {
        if part.key.sequence != 1 {
            samples(part)[4].position[1] += 0.5;
        }
        true
    })
}

fn git(folder: &Folder, arguments: &[&str]) {
    let identity = ["-c", "user.name=test", "-c", "user.email=test@localhost"];
    let mut command = Command::new("git");
    command.args(identity).args(arguments).current_dir(folder.path(""));
    let output = command.output().unwrap();
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn what_is_blessed_is_equal_and_nothing_else_changes() {
    let folder = moved();
    let before = records(&folder.path("a.mcap"));
    let (code, out, error) = folder.run(&["bless", "a.mcap", "--uncommitted"]);
    assert_eq!((code, error.as_str()), (0, ""), "{out}");
    assert!(out.contains("a.mcap: request 0 (0000000000000007/0, id 0) accepted\n    answer 0 moved: position by 0.5 m"), "{out}");
    assert!(out.ends_with("a.mcap: 2 of 3 replies accepted\n"), "{out}");
    folder.check(&["check", "a.mcap"], 0, "3 equal", "");
    let after = records(&folder.path("a.mcap"));
    // A planner sends long replies in several parts: compared by what they belong to.
    let of = |records: &[Record], key: u64, replies: bool| -> Vec<_> {
        let its = records.iter().filter(|record| match &record.message {
            Message::Request(request) => !replies && request.key.sequence == key,
            Message::Reply(part) => replies && part.key.sequence == key,
        });
        its.map(|record| {
            let (bytes, log, sent, _) = bytes(record);
            (bytes, log, sent)
        })
        .collect()
    };
    for key in 0..3 {
        assert_eq!(of(&before, key, false), of(&after, key, false), "request {key}");
    }
    assert_eq!(of(&before, 1, true), of(&after, 1, true), "an equal reply");
    assert_ne!(of(&before, 0, true), of(&after, 0, true));
    folder.check(&["bless", "a.mcap"], 0, "a.mcap: 0 of 3 replies accepted\n", "");
    assert!(!folder.path("a.mcap.new").exists());
}

#[test]
fn only_what_is_named_is_blessed() {
    let folder = moved();
    let bless = |only: &str, said: &str| {
        let arguments = ["bless", "a.mcap", "--uncommitted", "--only", only];
        folder.check(&arguments, 0, said, "");
    };
    bless("vanished", "0 of 3 replies accepted");
    bless("id=2", "1 of 3 replies accepted");
    folder.check(&["check", "a.mcap"], 4, "2 equal, 1 different", "");
    bless("request=1", "0 of 3 replies accepted");
    bless("moved", "1 of 3 replies accepted");
    folder.check(&["check", "a.mcap"], 0, "3 equal", "");
    folder.check(&["bless", "a.mcap", "--only", "all"], 2, "", "must be request=N, id=ID, ");
}

#[test]
fn what_git_does_not_have_is_not_overwritten() {
    let folder = moved();
    let before = std::fs::read(folder.path("a.mcap")).unwrap();
    let bless = ["bless", "a.mcap"];
    folder.check(&bless, 1, "", "it is not in a git repository; --uncommitted");
    git(&folder, &["init", "-q"]);
    folder.check(&bless, 1, "", "git does not know a.mcap; --uncommitted overwrites it");
    git(&folder, &["add", "a.mcap"]);
    folder.check(&bless, 1, "", "a.mcap has changes that git does not have");
    assert_eq!(std::fs::read(folder.path("a.mcap")).unwrap(), before);
    git(&folder, &["commit", "-q", "-m", "recordings"]);
    folder.check(&bless, 0, "2 of 3 replies accepted", "");
    folder.check(&["check", "a.mcap"], 0, "3 equal", "");
}

#[test]
fn damaged_recordings_are_not_blessed() {
    let folder = moved();
    let whole = std::fs::read(folder.path("a.mcap")).unwrap();
    std::fs::write(folder.path("a.mcap"), &whole[..whole.len() / 2]).unwrap();
    let said = "a.mcap is left as it is: ";
    folder.check(&["bless", "a.mcap", "--uncommitted"], 3, "", said);
    assert_eq!(std::fs::read(folder.path("a.mcap")).unwrap(), whole[..whole.len() / 2]);
}

#[test]
fn failing_requests_are_extracted_with_their_replies() {
    let folder = moved();
    let extract = ["extract", "a.mcap", "--failing", "-o", "b.mcap"];
    folder.check(&extract, 0, "b.mcap: 2 requests, 4 messages\n", "");
    let extracted = records(&folder.path("b.mcap"));
    let whole = records(&folder.path("a.mcap"));
    let kept: Vec<_> = [0, 1, 4, 5].iter().map(|at| bytes(&whole[*at]).0).collect();
    assert_eq!(extracted.iter().map(|record| bytes(record).0).collect::<Vec<_>>(), kept);
    folder.check(&["check", "b.mcap"], 4, "2 requests, 2 different", "");
    folder.check(&extract, 1, "", "b.mcap exists; --overwrite replaces it");
    let by_id = ["extract", "a.mcap", "--id", "1", "--request", "0", "-o", "b.mcap", "--overwrite"];
    folder.check(&by_id, 0, "b.mcap: 2 requests", "");
    folder.check(&["check", "b.mcap"], 4, "2 requests, 1 equal, 1 different", "");
    folder.check(&["extract", "a.mcap", "--id", "9", "-o", "c.mcap"], 1, "", "nothing written");
    assert!(!folder.path("c.mcap").exists());
    folder.check(&["extract", "a.mcap", "-o", "c.mcap"], 2, "", "--failing");
    let over = ["extract", "a.mcap", "--id", "1", "-o", "a.mcap", "--overwrite"];
    folder.check(&over, 1, "", "a.mcap is read from");
}

#[test]
fn an_extracted_request_brings_the_free_space_that_it_names() {
    let folder = Folder::new();
    record_named(folder.path("a.mcap"));
    folder.check(&["extract", "a.mcap", "--request", "1", "-o", "b.mcap"], 0, "1 requests", "");
    folder.check(&["check", "b.mcap"], 0, "1 requests, 1 equal", "");
}

#[test]
fn recordings_are_merged_by_time() {
    let folder = Folder::new();
    record(&folder.path("a.mcap"), 7, keep);
    record(&folder.path("b.mcap"), 8, |part| part.key.sequence != 1);
    let merge = ["merge", "a.mcap", "b.mcap", "-o", "c.mcap"];
    folder.check(&merge, 0, "c.mcap: 6 requests, 11 messages\n", "");
    let merged = records(&folder.path("c.mcap"));
    let keys = |records: &[Record]| -> Vec<RequestKey> {
        let keys = records.iter().map(|record| match &record.message {
            Message::Request(request) => request.key,
            Message::Reply(part) => part.key,
        });
        keys.collect()
    };
    // Of equal times, the file named first; within a file, its order.
    assert_eq!(keys(&merged)[..2].iter().map(|key| key.client).collect::<Vec<_>>(), [7, 8]);
    for (name, client) in [("a.mcap", 7), ("b.mcap", 8)] {
        let its: Vec<_> = keys(&merged).into_iter().filter(|key| key.client == client).collect();
        assert_eq!(its, keys(&records(&folder.path(name))));
    }
    folder.check(&["check", "c.mcap"], 3, "6 requests, 5 equal, 1 incomplete", "");
    folder.check(&merge, 1, "", "c.mcap exists");
    let twice = ["merge", "a.mcap", "a.mcap", "-o", "d.mcap"];
    folder.check(&twice, 1, "", "request 0000000000000007/0 is in a.mcap and in a.mcap");
    assert!(!folder.path("d.mcap").exists());
}

#[test]
fn what_is_missing_stays_missing_in_a_merger() {
    let folder = Folder::new();
    let mut writer = Writer::create(folder.path("a.mcap"), Options::default()).unwrap();
    writer.write_request(&request(7, 0), 1).unwrap();
    writer.lost(5);
    writer.finish().unwrap();
    record(&folder.path("b.mcap"), 8, keep);
    let merge = ["merge", "a.mcap", "b.mcap", "-o", "c.mcap"];
    folder.check(&merge, 3, "4 requests, 7 messages, 5 messages are missing", "");
    folder.check(&["info", "c.mcap"], 3, "5 messages in 1 gaps", "");
}
