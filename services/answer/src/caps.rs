//! What one request may cost.

use planning::budget::Allowance;
use schemas::message::Refusal;
use serde::{Deserialize, Serialize};

use crate::refuse;

/// The most that one request may cost, in memory and in time. A request that would cost more is
/// refused, and the refusal names the cap.
///
/// The same request under the same caps has the same reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Caps {
    /// The size of a request, in cells of 8 bytes. 2^26: 512 MiB.
    pub cells: usize,
    /// Steps of any kind, all answers to a request together. Bounds time: about 10 ns
    /// each. 10^9.
    pub steps: u64,
    /// Bytes of memory held for a request at a time, its replies included. 2^30: 1 GiB.
    pub bytes: u64,
    /// Answers to one request (`each`, `curve`). Bounds time. 10,000.
    pub answers: u64,
    /// Samples of one trajectory. Bounds time and the reply: 72 bytes each. 1,000,000.
    pub samples: u64,
    /// Boxes that solids are cut into where channels are made from them. Bounds memory: some
    /// 200 bytes each. 2^20.
    pub pieces: usize,
    /// Channels made from solids. Bounds memory: some 100 bytes each. 2^18.
    pub channels: usize,
    /// Boxes looked at to make channels from solids. Bounds time: 10 to 100 ns each. 2^26.
    pub channel_steps: usize,
    /// Junctions of all channels, when a route is searched through them. Bounds memory: 16 bytes
    /// each, and more while the route is sought. 2^22.
    pub junctions: usize,
    /// Pairs of junctions looked at for one route. Bounds time and memory. 2^24.
    pub route_steps: usize,
}

impl Default for Caps {
    fn default() -> Self {
        Self {
            cells: 1 << 26,
            steps: 1_000_000_000,
            bytes: 1 << 30,
            answers: 10_000,
            samples: 1_000_000,
            pieces: 1 << 20,
            channels: 1 << 18,
            channel_steps: 1 << 26,
            junctions: 1 << 22,
            route_steps: 1 << 24,
        }
    }
}

impl Caps {
    /// Each cap with its name in the configuration, its value, and its least and greatest value.
    pub fn ranges(&self) -> [(&'static str, f64, f64, f64); 10] {
        let most = (1_u64 << 31) as f64;
        let long = (1_u64 << 40) as f64;
        let longest = (1_u64 << 53) as f64;
        [
            ("caps.cells", self.cells as f64, 1.0, long),
            ("caps.steps", self.steps as f64, 1.0, longest),
            ("caps.bytes", self.bytes as f64, 1.0, longest),
            ("caps.answers", self.answers as f64, 1.0, most),
            ("caps.samples", self.samples as f64, 2.0, long),
            ("caps.pieces", self.pieces as f64, 1.0, most),
            ("caps.channels", self.channels as f64, 1.0, most),
            ("caps.channel_steps", self.channel_steps as f64, 1.0, long),
            ("caps.junctions", self.junctions as f64, 1.0, most),
            ("caps.route_steps", self.route_steps as f64, 1.0, long),
        ]
    }

    /// Refuses a request that has too many cells.
    pub fn check_cells(&self, cells: usize) -> Result<(), Refusal> {
        if cells <= self.cells {
            return Ok(());
        }
        Err(refuse::cells(cells as u64, self.cells as u64))
    }

    /// What a request's budget begins with.
    pub fn limits(&self) -> Allowance {
        let Self { steps, bytes, pieces, channels, channel_steps, junctions, route_steps, .. } =
            *self;
        Allowance {
            steps,
            bytes,
            pieces: pieces as u64,
            channels: channels as u64,
            channel_steps: channel_steps as u64,
            junctions: junctions as u64,
            route_steps: route_steps as u64,
        }
    }
}
