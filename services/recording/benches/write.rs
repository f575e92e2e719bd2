//! Writing 6.4 KB messages: a recording beside a plain buffered file and the bare `mcap` writer.

use std::collections::BTreeMap;
use std::fs::File;
use std::hint::black_box;
use std::io::{BufWriter, Write};

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use mcap::records::MessageHeader;
use recording::{CHUNK_BYTES, Compression, Options, Reader, Writer};
use schemas::codec;
use schemas::message::{Clearance, ReplyPart, RequestKey, Sample, Trajectory};

const MESSAGES: usize = 5_000;

const COMPRESSIONS: [Compression; 3] = [Compression::None, Compression::Lz4, Compression::Zstd];

fn main() {
    divan::main();
}

fn part() -> ReplyPart {
    let sample = |at| Sample { t: f64::from(at) * 0.02, ..Sample::default() };
    let clearance = Clearance { wall: [6.99, 1.0].into(), ..Clearance::default() };
    ReplyPart {
        key: RequestKey { client: 1, sequence: 2 },
        id: None,
        sent_ns: 3,
        part: 0,
        last: true,
        answer: 0,
        answers: 1,
        content: Ok(Trajectory {
            dimension: 2,
            clearance,
            samples: (0..86).map(sample).collect(),
            ..Trajectory::default()
        }),
    }
}

#[divan::bench(sample_count = 20)]
fn plain_file(bencher: Bencher) {
    let folder = tempfile::tempdir().unwrap();
    let bytes = codec::encode(&part());
    bencher
        .counter(BytesCount::new(MESSAGES * bytes.len()))
        .counter(ItemsCount::new(MESSAGES))
        .bench_local(|| {
            let mut file = BufWriter::with_capacity(
                1 << 20,
                File::create(folder.path().join("plain")).unwrap(),
            );
            for _ in 0..MESSAGES {
                file.write_all(black_box(&bytes)).unwrap();
            }
            file.flush().unwrap();
        });
}

#[divan::bench(sample_count = 20)]
fn plain_file_encoding(bencher: Bencher) {
    let folder = tempfile::tempdir().unwrap();
    let (part, mut bytes) = (part(), Vec::new());
    bencher
        .counter(BytesCount::new(MESSAGES * codec::encode(&part).len()))
        .counter(ItemsCount::new(MESSAGES))
        .bench_local(|| {
            let mut file = BufWriter::with_capacity(
                1 << 20,
                File::create(folder.path().join("plain")).unwrap(),
            );
            for _ in 0..MESSAGES {
                bytes.clear();
                codec::encode_into(black_box(&part), &mut bytes);
                file.write_all(&bytes).unwrap();
            }
            file.flush().unwrap();
        });
}

/// The bare writer with the same chunks, checksums and channel.
#[divan::bench(sample_count = 20, args = COMPRESSIONS)]
fn bare_mcap(bencher: Bencher, compression: Compression) {
    let folder = tempfile::tempdir().unwrap();
    let (part, mut bytes) = (part(), Vec::new());
    bencher
        .counter(BytesCount::new(MESSAGES * codec::encode(&part).len()))
        .counter(ItemsCount::new(MESSAGES))
        .bench_local(|| {
            let file = File::create(folder.path().join("bare.mcap")).unwrap();
            let file = BufWriter::with_capacity(64 << 10, file);
            let mut writer = mcap::WriteOptions::new()
                .compression(match compression {
                    Compression::None => None,
                    Compression::Lz4 => Some(mcap::Compression::Lz4),
                    Compression::Zstd => Some(mcap::Compression::Zstd),
                })
                .compression_level(u32::from(compression == Compression::Zstd))
                .compression_threads(0)
                .chunk_size(Some(CHUNK_BYTES))
                .disable_seeking(true)
                .create(mcap::write::NoSeek::new(file))
                .unwrap();
            let schema = writer.add_schema("reply", "bincode", b"words").unwrap();
            let channel = writer.add_channel(schema, "/reply", "bincode", &BTreeMap::new());
            let channel_id = channel.unwrap();
            for at in 0..MESSAGES as u64 {
                bytes.clear();
                codec::encode_into(black_box(&part), &mut bytes);
                let (log_time, publish_time) = (at, at);
                let sequence = at as u32;
                let header = MessageHeader { channel_id, sequence, log_time, publish_time };
                writer.write_to_known_channel(&header, &bytes).unwrap();
            }
            writer.finish().unwrap();
        });
}

#[divan::bench(sample_count = 20, args = COMPRESSIONS)]
fn recording(bencher: Bencher, compression: Compression) {
    let folder = tempfile::tempdir().unwrap();
    let part = part();
    bencher
        .counter(BytesCount::new(MESSAGES * codec::encode(&part).len()))
        .counter(ItemsCount::new(MESSAGES))
        .bench_local(|| {
            let path = folder.path().join("recording.mcap");
            let options = Options { compression, ..Options::overwriting() };
            let mut writer = Writer::create(path, options).unwrap();
            for at in 0..MESSAGES as u64 {
                writer.write_reply(black_box(&part), at).unwrap();
            }
            writer.finish().unwrap();
        });
}

#[divan::bench(sample_count = 20)]
fn reading(bencher: Bencher) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recording.mcap");
    let part = part();
    let mut writer = Writer::create(&path, Options::default()).unwrap();
    for at in 0..MESSAGES as u64 {
        writer.write_reply(&part, at).unwrap();
    }
    writer.finish().unwrap();
    bencher
        .counter(BytesCount::new(MESSAGES * codec::encode(&part).len()))
        .counter(ItemsCount::new(MESSAGES))
        .bench_local(|| Reader::open(&path).unwrap().filter(|record| record.is_ok()).count());
}
