//! What it costs to cross the border: `cargo bench -p schemas`.

use divan::Bencher;
use divan::counter::ItemsCount;
use schemas::convert::{self, CellWriter, PartSink, TrajectoryWriter};
use schemas::message::{AxisBox, Reply, RequestKey, SceneRequest, Trajectory};
use schemas::wire::{self, PART_CELLS, ReplyHeader, Sample};
use schemas::{codec, json};

const SECTION_4: &str = include_str!("../../recordings/scenes/disassemble-channels.json");
const KEY: RequestKey = RequestKey { client: 1, sequence: 2 };
const SAMPLES: u32 = 1000;

fn main() {
    divan::main();
}

#[divan::bench]
fn read_section_4_from_memory(bencher: Bencher) {
    let scene = json::read_scene(SECTION_4).unwrap();
    let mut cells = Vec::new();
    let header = convert::write_scene(&scene, KEY, 0, &mut cells).unwrap();
    let mut read = SceneRequest::empty();
    bencher.bench_local(|| {
        convert::read_scene(divan::black_box(&header), divan::black_box(&cells), &mut read)
    });
}

#[divan::bench]
fn write_section_4_to_memory(bencher: Bencher) {
    let scene = json::read_scene(SECTION_4).unwrap();
    let mut cells = Vec::new();
    bencher.bench_local(|| {
        cells.clear();
        convert::write_scene(divan::black_box(&scene), KEY, 0, &mut cells)
    });
}

#[divan::bench]
fn read_section_4_from_json(bencher: Bencher) {
    bencher.bench(|| json::read_scene(divan::black_box(SECTION_4)));
}

const CHANNELS: usize = 100_000;

#[divan::bench]
fn read_100_000_channels_from_json(bencher: Bencher) {
    let channel = |at: usize| {
        let x = at as f64 * 0.37;
        format!(r#"{{"min": [{x}, 1], "max": [{}, 6.25]}}"#, x + 2.5)
    };
    let channels: Vec<_> = (0..CHANNELS).map(channel).collect();
    let text = format!(
        r#"{{"task": "drive", "free_space": {{"channels": [{}]}}, "clearance": "safest",
            "body": {{"footprint": {{"width": 1, "length": 1.5}}}}}}"#,
        channels.join(", ")
    );
    bencher
        .counter(ItemsCount::new(CHANNELS))
        .bench(|| json::read_scene(divan::black_box(&text)).unwrap());
}

#[divan::bench]
fn write_1000_samples_as_json(bencher: Bencher) {
    let sample = |t: u32| Sample { t: f64::from(t) * 0.02, heading: 0.1, ..Sample::default() };
    let samples = (0..SAMPLES).map(sample).collect();
    let trajectory = Trajectory { dimension: 2, samples, ..Trajectory::default() };
    let reply = Reply { key: KEY, id: Some(7), answers: Ok(vec![Ok(trajectory)]) };
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench(|| json::reply_to_json(divan::black_box(&reply)));
}

/// Memory that is always written to the same place.
struct Place(Vec<u64>);

impl PartSink for Place {
    type Error = std::convert::Infallible;

    fn part(
        &mut self,
        _: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Self::Error> {
        fill(&mut CellWriter::new(&mut self.0[..cells]));
        Ok(())
    }
}

fn write_samples(place: &mut Place) -> ReplyHeader {
    let mut header = ReplyHeader { version: wire::VERSION, dimension: 2, ..Default::default() };
    let count = divan::black_box(SAMPLES);
    let writer = TrajectoryWriter {
        gaps: [0.2; 4].into_iter(),
        route: [0, 1, 2].into_iter(),
        channels: std::iter::empty::<AxisBox>(),
        legs: [wire::Leg::default(); 3].into_iter(),
        samples: (0..count).map(|t| Sample { t: f64::from(t), ..Sample::default() }),
    };
    writer.write(&mut header, true, place).unwrap_or_else(|never| match never {});
    header
}

#[divan::bench]
fn write_1000_samples_to_memory(bencher: Bencher) {
    let mut place = Place(vec![0; PART_CELLS]);
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| write_samples(&mut place));
}

#[divan::bench]
fn read_1000_samples_from_memory(bencher: Bencher) {
    let mut place = Place(vec![0; PART_CELLS]);
    let header = ReplyHeader { part: 0, ..write_samples(&mut place) };
    let cells = &place.0[..4 + 3 + 3 * wire::LEG_CELLS + SAMPLES as usize * wire::SAMPLE_CELLS];
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench(|| convert::read_part(divan::black_box(&header), divan::black_box(cells)).unwrap());
}

#[divan::bench]
fn record_1000_samples(bencher: Bencher) {
    let mut place = Place(vec![0; PART_CELLS]);
    let header = ReplyHeader { part: 0, ..write_samples(&mut place) };
    let cells = &place.0[..4 + 3 + 3 * wire::LEG_CELLS + SAMPLES as usize * wire::SAMPLE_CELLS];
    let part = convert::read_part(&header, cells).unwrap();
    let mut bytes = Vec::new();
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        bytes.clear();
        codec::encode_into(divan::black_box(&part), &mut bytes);
    });
}
