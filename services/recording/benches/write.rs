//! Writing and reading recordings, beside a plain buffered file and the bare `mcap` writer with the
//! same chunks and checksums. All take turns, so that the ratios of a round hold on a busy machine;
//! printed are medians over the rounds.
//!
//! `cargo bench -p clearway-recording`

use std::collections::BTreeMap;
use std::fs::File;
use std::hint::black_box;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use mcap::records::MessageHeader;
use recording::{CHUNK_BYTES, Compression, Options, Reader, Writer};
use rustix::time::{ClockId, clock_gettime};
use schemas::codec;
use schemas::message::{Clearance, ReplyPart, RequestKey, Sample, Trajectory};

const ROUNDS: usize = 15;

/// Bytes of messages in a file.
const BYTES: usize = 32 << 20;

const COMPRESSIONS: [Compression; 3] = [Compression::None, Compression::Lz4, Compression::Zstd];

/// Samples of a message: 0.5, 6.4 and 32 kB.
const SAMPLES: [u32; 3] = [4, 86, 445];

fn main() {
    let folder = tempfile::tempdir().expect("a place for files");
    for samples in SAMPLES {
        measure(&parts(samples), folder.path());
    }
}

/// Parts of replies, all different, and more of them than a chunk takes: else they would compress to
/// nothing.
fn parts(samples: u32) -> Vec<ReplyPart> {
    let bytes = codec::encode(&part(samples, 0)).len();
    (0..2 * CHUNK_BYTES as usize / bytes).map(|number| part(samples, number as u32)).collect()
}

/// A part whose samples are those of a motion along an arc, one of many.
fn part(samples: u32, number: u32) -> ReplyPart {
    let sample = |at: u32| {
        let t = f64::from(at) * 0.02 + f64::from(number) * 0.77;
        let (sin, cos) = t.sin_cos();
        Sample {
            t,
            position: [3.0 + cos, 4.0 + sin, 0.0],
            heading: t,
            velocity: [-sin, cos, 0.0],
            yaw_rate: 1.0,
        }
    };
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
            samples: (0..samples).map(sample).collect(),
            ..Trajectory::default()
        }),
    }
}

/// What one way took, round by round: the time, and the time of the processor.
#[derive(Default)]
struct Took(Vec<(Duration, Duration)>);

impl Took {
    fn time(&mut self, work: impl FnOnce()) {
        let processor = || {
            let now = clock_gettime(ClockId::ThreadCPUTime);
            Duration::new(now.tv_sec as u64, now.tv_nsec as u32)
        };
        let (begun, before) = (Instant::now(), processor());
        work();
        self.0.push((begun.elapsed(), processor() - before));
    }

    /// The median of how many times as long as this the other took, in each round.
    fn beside(&self, other: &Self) -> f64 {
        let pairs = self.0.iter().zip(&other.0);
        median(pairs.map(|(own, other)| other.0.as_secs_f64() / own.0.as_secs_f64()).collect())
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

fn measure(parts: &[ReplyPart], folder: &Path) {
    let encoded = codec::encode(&parts[0]);
    let messages = BYTES / encoded.len();
    let mut raw = Took::default();
    let mut bare = COMPRESSIONS.map(|_| Took::default());
    let mut ours = COMPRESSIONS.map(|_| Took::default());
    let mut read = COMPRESSIONS.map(|_| Took::default());
    let mut sizes = [0; 3];
    // A new file each time: to cut an old one costs as much as to write it.
    let path = folder.join("file");
    let remove = || std::fs::remove_file(&path).expect("it was written");
    for _ in 0..ROUNDS {
        raw.time(|| write_plain(&path, &encoded, messages));
        remove();
        for (index, compression) in COMPRESSIONS.into_iter().enumerate() {
            bare[index].time(|| write_bare(&path, parts, messages, compression));
            remove();
            ours[index].time(|| write(&path, parts, messages, compression));
            sizes[index] = path.metadata().expect("it was written").len();
            read[index].time(|| {
                let mut count = 0;
                for record in Reader::open(&path).expect("it was written") {
                    black_box(record).expect("it is whole");
                    count += 1;
                }
                assert_eq!(count, messages);
            });
            remove();
        }
    }
    println!(
        "\n{messages} messages of {} bytes{:>16} {:>9} {:>9} {:>12} {:>9}",
        encoded.len(),
        "MB/s",
        "of raw",
        "of bare",
        "CPU, µs each",
        "size"
    );
    let line = |what: &str, took: &Took, bare: Option<&Took>, size: u64| {
        let times = |which: fn(&(Duration, Duration)) -> Duration| {
            median(took.0.iter().map(|took| which(took).as_secs_f64()).collect())
        };
        let rate = (messages * encoded.len()) as f64 / times(|took| took.0) / 1e6;
        let each = times(|took| took.1) / messages as f64 * 1e6;
        let percent = |ratio: f64| format!("{:.0} %", 100.0 * ratio);
        let (of_raw, of_bare) = (percent(took.beside(&raw)), bare.map(|bare| took.beside(bare)));
        let of_bare = of_bare.map_or(String::new(), percent);
        let size = percent(size as f64 / (messages * encoded.len()) as f64);
        println!("{what:<40} {rate:>9.0} {of_raw:>9} {of_bare:>9} {each:>12.2} {size:>9}");
    };
    line("raw", &raw, None, (messages * encoded.len()) as u64);
    for (index, compression) in COMPRESSIONS.into_iter().enumerate() {
        let size = sizes[index];
        line(&format!("mcap, {compression:?}"), &bare[index], None, size);
        line(&format!("a recording, {compression:?}"), &ours[index], Some(&bare[index]), size);
        line(&format!("reading it, {compression:?}"), &read[index], None, size);
    }
}

fn write_plain(path: &Path, bytes: &[u8], messages: usize) {
    let mut file = BufWriter::with_capacity(1 << 20, File::create(path).expect("a new file"));
    for _ in 0..messages {
        file.write_all(black_box(bytes)).expect("there is room");
    }
    file.flush().expect("there is room");
}

fn write_bare(path: &Path, parts: &[ReplyPart], messages: usize, compression: Compression) {
    let file = BufWriter::with_capacity(64 << 10, File::create(path).expect("a new file"));
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
        .expect("there is room");
    let schema = writer.add_schema("reply", "bincode", b"words").expect("there is room");
    let channel = writer.add_channel(schema, "/reply", "bincode", &BTreeMap::new());
    let channel_id = channel.expect("there is room");
    let mut bytes = Vec::new();
    for at in 0..messages as u64 {
        bytes.clear();
        let part = black_box(&parts[at as usize % parts.len()]);
        let samples = &part.content.as_ref().expect("a path").samples;
        codec::encode_part_into(part, samples, &mut bytes);
        let (log_time, publish_time, sequence) = (at, at, at as u32);
        let header = MessageHeader { channel_id, sequence, log_time, publish_time };
        writer.write_to_known_channel(&header, &bytes).expect("there is room");
    }
    writer.finish().expect("there is room");
}

fn write(path: &Path, parts: &[ReplyPart], messages: usize, compression: Compression) {
    let options = Options { compression, ..Options::default() };
    let mut writer = Writer::create(path, options).expect("a new file");
    for at in 0..messages as u64 {
        writer
            .write_reply(black_box(&parts[at as usize % parts.len()]), at)
            .expect("there is room");
    }
    writer.finish().expect("there is room");
}
