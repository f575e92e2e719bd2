//! What the planner counts, and says of itself.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use answer::CacheStats;
use hdrhistogram::Histogram;
use schemas::convert::{CellWriter, PartSink};
use schemas::message::ErrorCode;
use schemas::status::{CacheStatus, Latency, QueueStatus, Status, WorkerStatus};
use schemas::wire::ReplyHeader;

use crate::desk::Load;

/// The shortest and the longest time told apart, nanoseconds: 100 ns and an hour.
const SPAN: (u64, u64) = (100, 3_600_000_000_000);

/// Digits of times.
const DIGITS: u8 = 2;

/// Counts since the start.
#[derive(Debug)]
pub(crate) struct Statistics {
    started: Instant,
    pub(crate) requests: u64,
    pub(crate) answered: u64,
    pub(crate) undelivered: u64,
    /// By the place of their code in [`ErrorCode::ALL`].
    refused: Vec<u64>,
    /// Nanoseconds.
    latency: Histogram<u64>,
    sum: Duration,
}

/// A sink whose refusals are counted.
#[derive(Debug)]
pub(crate) struct Counted<'a, S> {
    pub(crate) sink: S,
    pub(crate) statistics: &'a mut Statistics,
}

impl<S: PartSink> PartSink for Counted<'_, S> {
    type Error = S::Error;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), S::Error> {
        let mut first = None;
        self.sink.part(header, cells, |writer| {
            fill(writer);
            first = writer.written().first().copied();
        })?;
        self.statistics.count_part(header, first);
        Ok(())
    }
}

/// What else belongs to the status.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Present {
    pub(crate) load: Load,
    pub(crate) workers: usize,
    pub(crate) queue: usize,
    pub(crate) cache: CacheStats,
}

impl Statistics {
    pub(crate) fn new() -> Self {
        let (shortest, longest) = SPAN;
        let latency = Histogram::new_with_bounds(shortest, longest, DIGITS);
        Self {
            started: Instant::now(),
            requests: 0,
            answered: 0,
            undelivered: 0,
            refused: vec![0; ErrorCode::ALL.len()],
            latency: latency.expect("the bounds are constants"),
            sum: Duration::ZERO,
        }
    }

    /// A part was written, which may be a refusal: then its code is the first cell.
    pub(crate) fn count_part(&mut self, header: &ReplyHeader, first: Option<u64>) {
        let code = first.filter(|_| header.kind == 1);
        let place = code.and_then(|code| usize::try_from(code).ok());
        if let Some(count) = place.and_then(|place| self.refused.get_mut(place)) {
            *count += 1;
        }
    }

    /// A reply was sent in full, so long after its request was taken.
    pub(crate) fn count_answered(&mut self, took: Duration) {
        self.answered += 1;
        self.sum += took;
        self.latency.saturating_record(took.as_nanos().try_into().unwrap_or(u64::MAX));
    }

    pub(crate) fn status(&self, present: &Present) -> Status {
        let Present { load, workers, queue, cache } = *present;
        let counts = ErrorCode::ALL.iter().zip(&self.refused).filter(|(_, count)| **count > 0);
        let refused: BTreeMap<_, _> =
            counts.map(|(code, count)| (code.name().to_owned(), *count)).collect();
        let micros = |nanos: u64| nanos as f64 / 1e3;
        let at = |quantile| micros(self.latency.value_at_quantile(quantile));
        Status {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            pid: std::process::id(),
            uptime: self.started.elapsed().as_secs_f64(),
            requests: self.requests,
            answered: self.answered,
            undelivered: self.undelivered,
            refused,
            queue: QueueStatus {
                requests: load.waiting.requests as u64,
                most: queue as u64,
                bytes: load.waiting.bytes as u64,
            },
            workers: WorkerStatus { count: workers as u64, planning: load.planning as u64 },
            unsent: load.unsent as u64,
            cache: CacheStatus {
                hits: cache.hits,
                misses: cache.misses,
                entries: cache.entries as u64,
                bytes: cache.bytes as u64,
            },
            latency: Latency {
                count: self.latency.len(),
                sum: self.sum.as_secs_f64() * 1e6,
                p50: at(0.5),
                p90: at(0.9),
                p99: at(0.99),
                p999: at(0.999),
                max: micros(self.latency.max()),
            },
            config: Default::default(),
        }
    }
}
