//! How much a recorder takes in: the traffic at which it begins to lose messages beside a plain
//! buffered write in the same run, beside what is lost if the samples of the same traffic are only
//! looked at, or only written to a plain file; and how long it, or its disk, may stand still.
//!
//! `cargo bench -p clearway-recorder [-- none|lz4|zstd|"a plain file"|"only looked at"|standing]`

use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bus::{Client, Domain, Server, ServerOptions, TapEvent, TapReader, Wait};
use recorder::Settings;
use recording::Compression;
use rustix::process::{Pid, Signal, kill_process};
use rustix::time::{ClockId, clock_gettime};
use schemas::convert::PartSink;
use schemas::message::{Sample, SceneRequest};
use schemas::wire::{PART_CELLS, ReplyHeader, SAMPLE_CELLS, VERSION};

/// Names the recording to a process that records it; the folder of the domain, and the compression.
const OUTPUT: &str = "CLEARWAY_BENCH_OUTPUT";
const COMPRESSION: &str = "CLEARWAY_BENCH_COMPRESSION";

/// What stands for no recording: nothing is done, or samples are written to a file one after the other.
const LOOK: &str = "only looked at";
const PLAIN: &str = "a plain file";

/// Names what is about standing still.
const STANDING: &str = "standing";

/// How long each rate is kept up.
const TIME: Duration = Duration::from_secs(2);

/// Samples of a part that is full.
const FULL: usize = PART_CELLS / SAMPLE_CELLS;

fn main() {
    let folder = match std::env::var_os(OUTPUT) {
        Some(output) => return record(Path::new(&output)),
        None => tempfile::tempdir().expect("a place for files"),
    };
    let raw = raw_bandwidth(folder.path());
    println!("a plain buffered write: {:.0} MB/s", raw / 1e6);
    let mut bus = Bus::open(folder.path());
    let only = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    for compression in [LOOK, PLAIN, "none", "lz4", "zstd"] {
        if only.as_ref().is_some_and(|only| only != compression) {
            continue;
        }
        println!("\n{compression}: MB/s asked for, sent; messages sent, lost; CPU, µs per MB");
        for percent in [10, 20, 30, 40, 50, 60, 70, 80, 90, 100] {
            bus.keep_up(compression, percent, raw * f64::from(percent) / 100.0);
        }
    }
    if only.is_some_and(|only| only != STANDING) {
        return;
    }
    println!("\nthe longest time without a loss that the recorder, or its disk, stands still");
    for rate in [1_000, 10_000, 50_000] {
        let frozen = longest(|time| bus.freezes(rate, time));
        let stuck = longest(|time| bus.disk_stops(rate, time));
        println!("{rate:>7} messages of 0.8 kB/s: {frozen:>8.0?} {stuck:>8.0?}");
    }
}

fn domain(folder: &Path) -> Domain {
    Domain::new("bench").expect("a name").under(&folder.join("root"))
}

/// Records until told to end, and says what is lost.
fn record(output: &Path) {
    let folder = output.parent().expect("it is in a folder");
    let compression = match std::env::var(COMPRESSION).as_deref() {
        Ok(LOOK) => return take_samples(folder, |_| {}),
        Ok(PLAIN) => {
            let file = File::create(output).expect("a new file");
            let mut file = BufWriter::with_capacity(1 << 20, file);
            return take_samples(folder, |bytes| file.write_all(bytes).expect("there is room"));
        }
        Ok("lz4") => Compression::Lz4,
        Ok("zstd") => Compression::Zstd,
        _ => Compression::None,
    };
    let overwrite = true;
    let settings = Settings::new(output.to_owned(), domain(folder));
    let ended = recorder::run(&Settings { compression, overwrite, ..settings });
    let summary = ended.expect("there is room").finished.summary;
    println!("{} {} {}", summary.recorded, summary.lost, processor_us());
}

/// Takes samples off the tap until told to end, and says how many messages came and were lost.
fn take_samples(folder: &Path, mut take: impl FnMut(&[u8])) {
    let mut tap = TapReader::connect(&domain(folder)).expect("a planner");
    let (mut messages, mut lost) = (0, 0);
    loop {
        let ends = tap.terminated();
        let taken = tap.receive_in_place(|event, samples| match event {
            TapEvent::Lost { messages } => lost += messages,
            TapEvent::Message(_) => {
                messages += 1;
                take(bytemuck::cast_slice(samples));
            }
            _ => {}
        });
        match taken {
            None if ends => break,
            None => std::thread::sleep(Duration::from_millis(1)),
            Some(()) => {}
        }
    }
    println!("{messages} {} {}", lost + tap.waiting(), processor_us());
}

/// Bytes per second of a plain buffered write for as long as the traffic takes: the best of two. What
/// fits into the page cache is written several times as fast as what the disk has to take.
fn raw_bandwidth(folder: &Path) -> f64 {
    let (path, piece) = (folder.join("plain"), vec![7; 32 << 10]);
    let rates = [(); 2].map(|()| {
        let (begun, mut pieces) = (Instant::now(), 0);
        let mut file = BufWriter::with_capacity(1 << 20, File::create(&path).expect("a new file"));
        while begun.elapsed() < TIME {
            file.write_all(&piece).expect("there is room");
            pieces += 1;
        }
        file.flush().expect("there is room");
        let rate = (pieces * piece.len()) as f64 / begun.elapsed().as_secs_f64();
        std::fs::remove_file(&path).expect("it was written");
        rate
    });
    rates[0].max(rates[1])
}

/// The time that this process has had of the processors, microseconds.
fn processor_us() -> u128 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(now.tv_sec as u64, now.tv_nsec as u32).as_micros()
}

/// The longest time for which `holds`, up to 1/16 of it.
fn longest(mut holds: impl FnMut(Duration) -> bool) -> Duration {
    let mut time = Duration::from_millis(4);
    while time < Duration::from_secs(4) && holds(time * 2) {
        time *= 2;
    }
    for part in [2, 4, 8, 16] {
        let more = time + time / part;
        time = if holds(more) { more } else { time };
    }
    time
}

/// A planner and a client in one thread.
struct Bus<'a> {
    folder: &'a Path,
    server: Server,
    client: Client,
    cells: Vec<u64>,
    motion: Vec<Sample>,
}

impl<'a> Bus<'a> {
    fn open(folder: &'a Path) -> Self {
        let domain = domain(folder);
        let server = Server::open(&domain, &ServerOptions::default()).expect("the only planner");
        let client = Client::connect(&domain, Wait::Poll).expect("a planner");
        let sample = |at: usize| {
            let t = at as f64 * 0.37;
            Sample { t, position: [t + 0.04, t + 0.08, 0.0], heading: t, ..Sample::default() }
        };
        Self { folder, server, client, cells: Vec::new(), motion: (0..FULL).map(sample).collect() }
    }

    /// A request and a reply of so many parts. Its bytes in a recording, about.
    fn call(&mut self, parts: u32, samples: usize) -> usize {
        let pending = self.client.send(&SceneRequest::empty()).expect("a place");
        let mut incoming = self.server.receive().expect("the request is there");
        let header = incoming.copy(usize::MAX, &mut self.cells).expect("it is whole");
        for part in 0..parts {
            let header = ReplyHeader {
                version: VERSION,
                dimension: 2,
                client: header.client,
                sequence: header.sequence,
                answers: 1,
                part,
                samples: samples as u32,
                last: u32::from(part + 1 == parts),
                ..ReplyHeader::default()
            };
            let motion = &self.motion[..samples];
            let fill = |writer: &mut schemas::convert::CellWriter<'_>| {
                motion.iter().for_each(|sample| writer.push_pod(sample));
            };
            let cells = samples * SAMPLE_CELLS;
            incoming.reply().part(&header, cells, fill).expect("the client is there");
        }
        drop(incoming);
        drop(pending);
        parts as usize * samples * SAMPLE_CELLS * 8
    }

    /// Calls at a rate in bytes per second, for a time. How many calls, and bytes.
    fn calls(&mut self, (parts, samples): (u32, usize), rate: f64, time: Duration) -> (u64, usize) {
        let (begun, mut calls, mut bytes) = (Instant::now(), 0, 0);
        while begun.elapsed() < time {
            if (bytes as f64) < rate * begun.elapsed().as_secs_f64() {
                bytes += self.call(parts, samples);
                calls += 1;
            } else {
                self.server.wait(Some(Instant::now() + Duration::from_micros(20)));
            }
        }
        (calls, bytes)
    }

    fn recorder(&self, output: &str, compression: &str) -> Child {
        let child = Command::new(std::env::current_exe().expect("this program"))
            .env(OUTPUT, self.folder.join(output))
            .env(COMPRESSION, compression)
            .stdout(Stdio::piped())
            .spawn()
            .expect("this program runs");
        // Until it is there.
        let unknown = schemas::message::Digest([7; 32]);
        while !self.server.recorders_lack(unknown) {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(700));
        child
    }

    /// Messages recorded and lost, and the recorder's time of the processors, microseconds.
    fn end(&mut self, child: Child) -> (u64, u64, u64) {
        // The last heartbeat.
        let until = Instant::now() + Duration::from_millis(150);
        while Instant::now() < until {
            self.server.wait(Some(until));
        }
        kill_process(Pid::from_child(&child), Signal::TERM).expect("it runs");
        let done = child.wait_with_output().expect("it runs");
        let said = String::from_utf8(done.stdout).expect("numbers");
        let mut numbers = said.split_whitespace().map(|text| text.parse().expect("a number"));
        let mut next = || numbers.next().expect("three numbers");
        (next(), next(), next())
    }

    fn keep_up(&mut self, compression: &str, percent: u32, rate: f64) {
        let child = self.recorder("run.mcap", compression);
        let (calls, bytes) = self.calls((4, FULL), rate, TIME);
        let (recorded, lost, processor) = self.end(child);
        assert_eq!(recorded + lost, calls * 5);
        let each = processor as f64 / (recorded.max(1) as f64 * bytes as f64 / (calls * 5) as f64);
        let sent = bytes as f64 / TIME.as_secs_f64() / 1e6;
        let asked = rate / 1e6;
        let sum = recorded + lost;
        println!("{percent:>4} % {asked:>7.0} {sent:>7.0} {sum:>9} {lost:>9} {:>7.0}", 1e6 * each);
        let _ = std::fs::remove_file(self.folder.join("run.mcap"));
    }

    /// Small messages: two a call.
    fn small_calls(&mut self, rate: u32, time: Duration) {
        let bytes = 8 * SAMPLE_CELLS * 8;
        self.calls((1, 8), f64::from(rate / 2) * bytes as f64, time);
    }

    /// Whether nothing is lost when the recorder stands still for so long.
    fn freezes(&mut self, rate: u32, time: Duration) -> bool {
        let child = self.recorder("run.mcap", "none");
        self.small_calls(rate, Duration::from_millis(50));
        let pid = Pid::from_child(&child);
        kill_process(pid, Signal::STOP).expect("it runs");
        self.small_calls(rate, time);
        kill_process(pid, Signal::CONT).expect("it runs");
        self.small_calls(rate, Duration::from_millis(50));
        let (_, lost, _) = self.end(child);
        std::fs::remove_file(self.folder.join("run.mcap")).expect("it was recorded");
        lost == 0
    }

    /// The same when what it writes to takes nothing for so long.
    fn disk_stops(&mut self, rate: u32, time: Duration) -> bool {
        let pipe = self.folder.join("pipe.mcap");
        let made = Command::new("mkfifo").arg(&pipe).status();
        assert!(made.is_ok_and(|made| made.success()), "a pipe");
        let is_stuck = Arc::new(AtomicBool::new(false));
        let drain = std::thread::spawn({
            let (pipe, is_stuck) = (pipe.clone(), Arc::clone(&is_stuck));
            move || {
                let mut pipe = File::open(pipe).expect("a pipe");
                let mut bytes = vec![0; 64 << 10];
                while pipe.read(&mut bytes).expect("a pipe") > 0 {
                    while is_stuck.load(Ordering::Relaxed) {
                        std::thread::sleep(Duration::from_micros(100));
                    }
                }
            }
        });
        let child = self.recorder("pipe.mcap", "none");
        self.small_calls(rate, Duration::from_millis(50));
        is_stuck.store(true, Ordering::Relaxed);
        self.small_calls(rate, time);
        is_stuck.store(false, Ordering::Relaxed);
        self.small_calls(rate, Duration::from_millis(50));
        let (_, lost, _) = self.end(child);
        drain.join().expect("it only reads");
        std::fs::remove_file(pipe).expect("a pipe");
        lost == 0
    }
}
