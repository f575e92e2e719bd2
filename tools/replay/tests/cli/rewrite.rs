//! Recordings made of recordings: `bless`, `extract`, `merge`.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use answer::{Answerer, Caps};
use recording::{
    Aside, Compression, FILE_KEY, Message, Options, Reader, Record, SERIES_KEY, Writer,
};
use schemas::codec;
use schemas::message::{RequestContent, RequestKey};

use crate::recorded::{Folder, keep, parts, record, record_named, request, samples};

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
    folder.check(&["extract", "a.mcap", "--request", "1", "-o", "b.mcap"], 0, "1 request, ", "");
    folder.check(&["check", "b.mcap"], 0, "1 request, 1 equal", "");
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
    folder.check(&["info", "c.mcap"], 3, "5 messages in 1 gap", "");
}

/// The planner's settings with this cap, as the recorder writes them.
fn described(host: &str, steps: u64) -> BTreeMap<String, String> {
    let config = format!("{{\"caps\":{{\"steps\":{steps}}}}}");
    [("host", host), ("config", &config)]
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .into()
}

/// Two requests by a client with a status each; the second only names its free space, which was
/// made known before the recording. The reply to the first has moved.
fn record_described(path: &Path, client: u64, options: Options) {
    let mut writer = Writer::create(path, options).unwrap();
    let mut upload = request(client, 99);
    let RequestContent::Scene(scene) = &mut upload.content else { unreachable!() };
    scene.free_space.named = Some(scene.free_space.digest());
    let alone = scene.with_name_alone();
    let mut answerer = Answerer::new(&Caps::default());
    answerer.reply_to(&upload);
    for sequence in 0..2 {
        let mut asked = request(client, sequence);
        if sequence == 1 {
            writer.write_free_space(&upload, 1).unwrap();
            asked.content = RequestContent::Scene(alone.clone());
        }
        writer.write_status(&format!("{{\"of\":{client},\"n\":{sequence}}}"), 2).unwrap();
        writer.write_request(&asked, 10 + sequence).unwrap();
        for mut part in parts(answerer.reply_to(&asked)) {
            if sequence == 0 {
                samples(&mut part)[4].position[1] += 0.5;
            }
            writer.write_reply(&part, 20 + sequence).unwrap();
        }
    }
    writer.write_status("{\"end\":true}", 30).unwrap();
    writer.finish().unwrap();
}

/// What stands beside the messages.
fn asides(path: &Path) -> Vec<Aside> {
    let mut reader = Reader::open(path).unwrap();
    reader.keep_statuses();
    assert!(reader.by_ref().all(|record| record.is_ok()));
    reader.take_asides()
}

fn description(path: &Path) -> BTreeMap<String, String> {
    let mut reader = Reader::open(path).unwrap();
    assert!(reader.next().is_some());
    reader.description().clone()
}

#[test]
fn a_merger_keeps_descriptions_statuses_and_free_spaces() {
    let folder = Folder::new();
    let options = |host| Options { description: described(host, 1_000_000), ..Options::default() };
    record_described(&folder.path("a.mcap"), 7, options("one"));
    record_described(&folder.path("b.mcap"), 8, options("two"));
    let merge = ["merge", "a.mcap", "b.mcap", "-o", "c.mcap"];
    folder.check(&merge, 0, "c.mcap: 4 requests, 8 messages\n", "");
    let mut expected = described("one; two", 1_000_000);
    let merged = description(&folder.path("c.mcap"));
    expected.insert("id".to_owned(), merged["id"].clone());
    assert_eq!(merged, expected);
    let both = [asides(&folder.path("a.mcap")), asides(&folder.path("b.mcap"))].concat();
    let merged = asides(&folder.path("c.mcap"));
    assert_eq!(merged.len(), both.len());
    assert!(both.iter().all(|aside| merged.contains(aside)));
    folder.check(&["check", "c.mcap"], 4, "4 requests, 2 equal, 2 different\n", "");

    let other = Options { description: described("one", 2_000_000), ..Options::default() };
    record_described(&folder.path("d.mcap"), 9, other);
    let merge = ["merge", "a.mcap", "d.mcap", "-o", "e.mcap"];
    folder.check(&merge, 1, "", "a.mcap and d.mcap were planned under different caps");
    assert!(!folder.path("e.mcap").exists() && !folder.path("e.mcap.part").exists());
}

#[test]
fn what_is_blessed_keeps_all_else() {
    let folder = Folder::new();
    let options = Options {
        description: described("one", 1_000_000),
        compression: Compression::Zstd,
        first: 40,
        id: Some(5),
        ..Options::default()
    };
    let path = folder.path("a.mcap");
    record_described(&path, 7, options);
    let before = (description(&path), asides(&path), records(&path)[2..].to_vec());
    folder.check(&["bless", "a.mcap", "--uncommitted"], 0, "1 of 2 replies accepted", "");
    folder.check(&["check", "a.mcap"], 0, "2 requests, 2 equal\n", "");
    let mut reader = Reader::open(&path).unwrap();
    assert!(reader.by_ref().all(|record| record.is_ok()));
    let kept = (reader.compression(), reader.id(), reader.begin());
    assert_eq!(kept, (Compression::Zstd, Some(5), Some(40)));
    // A planner sends long replies in several parts: later messages have other numbers.
    let now = records(&path);
    let now = now[now.len() - before.2.len()..].to_vec();
    let unnumbered = |records: &[Record]| -> Vec<_> {
        records.iter().map(|record| (bytes(record).0, record.log_ns)).collect()
    };
    assert_eq!((description(&path), asides(&path)), (before.0, before.1));
    assert_eq!(unnumbered(&now), unnumbered(&before.2));
}

/// A recording of three requests in a file each, the last of which begins within a reply; one
/// message is missing between the first and the second.
fn record_series(folder: &Folder) -> [String; 3] {
    let mut messages = Vec::new();
    for sequence in 0..3 {
        let request = request(7, sequence);
        let mut parts = parts(answer::reply_to(&request, &Caps::default()));
        if sequence != 1 {
            samples(&mut parts[0])[4].position[1] += 0.5;
        }
        messages.push((request, parts));
    }
    let names = [0, 1, 2].map(|index| format!("run-{index:04}.mcap"));
    let mut first = 0;
    for (index, name) in names.iter().enumerate() {
        let description = [(SERIES_KEY, "5".to_owned()), (FILE_KEY, index.to_string())];
        let description = description.map(|(name, value)| (name.to_owned(), value)).into();
        let options = Options { description, first, ..Options::default() };
        let mut writer = Writer::create(folder.path(name), options).unwrap();
        let mut write = |index: usize, replies: bool| {
            let (request, parts) = &messages[index];
            match replies {
                false => writer.write_request(request, 10).unwrap(),
                true => parts.iter().for_each(|part| writer.write_reply(part, 20).unwrap()),
            }
        };
        match index {
            0 => (write(0, false), write(0, true)),
            1 => (write(1, false), write(2, false)),
            _ => (write(1, true), write(2, true)),
        };
        first = writer.sequence() + u64::from(index == 0);
        writer.finish().unwrap();
    }
    names
}

#[test]
fn all_files_of_a_recording_are_blessed() {
    let folder = Folder::new();
    let names = record_series(&folder);
    let files: Vec<&str> = names.iter().map(String::as_str).collect();
    let said = "run-0000.mcap and 2 more: 3 requests, 1 equal, 2 different, 1 message lost";
    folder.check(&[&["check"], &files[..]].concat(), 4, said, "the recorder missed 1 message");
    // What git lacks of one file keeps all as they are.
    git(&folder, &["init", "-q"]);
    git(&folder, &["add", files[0], files[1]]);
    git(&folder, &["commit", "-q", "-m", "recordings"]);
    let untouched = std::fs::read(folder.path(files[0])).unwrap();
    let bless = [&["bless"], &files[..]].concat();
    folder.check(&bless, 1, "", "git does not know run-0002.mcap");
    assert_eq!(std::fs::read(folder.path(files[0])).unwrap(), untouched);
    git(&folder, &["add", files[2]]);
    git(&folder, &["commit", "-q", "-m", "the last"]);
    folder.check(&bless, 3, "run-0000.mcap: 2 of 3 replies accepted\n", "");
    let said = "run-0000.mcap and 2 more: 3 requests, 3 equal, 1 message lost";
    folder.check(&[&["check"], &files[..]].concat(), 3, said, "the recorder missed 1 message");
}

#[test]
fn recordings_of_several_files_are_compared_as_one() {
    let folder = Folder::new();
    for name in ["a", "b"] {
        let inner = Folder::new();
        let names = record_series(&inner);
        std::fs::create_dir(folder.path(name)).unwrap();
        for file in names {
            std::fs::copy(inner.path(&file), folder.path(name).join(&file)).unwrap();
        }
    }
    let said = "3 equal, 0 different, 0 only in a, 0 only in b";
    folder.check(&["diff", "a", "b"], 3, said, "the recorder missed 1 message");
    record(&folder.path("c.mcap"), 8, keep);
    folder.check(&["diff", "a", "c.mcap"], 4, "1 equal, 2 different, 0 only in a", "");
    std::fs::copy(folder.path("c.mcap"), folder.path("a/z.mcap")).unwrap();
    let said = "a holds 2 recordings; diff takes one as A and one as B";
    folder.check(&["diff", "a", "b"], 1, "", said);
}
