//! The headings of a search over poses.

use std::f64::consts::{PI, TAU};

use super::passage::GateAxis;
use super::probe::Probe;
use crate::motion::wrapped;

/// Headings of narrow passages beside those.
const MOST_PASSAGES: usize = 16;

/// Headings closer than this are one, radians.
pub(super) const SAME_HEADING: f64 = 1e-6;

/// The headings of a search, radians in [0, 2 pi), in order.
#[derive(Debug, Default)]
pub(super) struct Headings {
    pub(super) all: Vec<f64>,
}

impl Headings {
    /// So many even parts of a turn from the start's heading, the goal's heading, and those of
    /// the first passages.
    pub(super) fn set(&mut self, probe: &Probe<'_>, parts: u16, axes: &[GateAxis]) {
        self.all.clear();
        for part in 0..parts {
            self.all.push(TAU * f64::from(part) / f64::from(parts));
        }
        if let Some(heading) = probe.goal_heading {
            self.add(heading);
            self.add(heading + PI);
        }
        let most = self.all.len() + 2 * MOST_PASSAGES;
        for GateAxis { direction, .. } in axes {
            if self.all.len() < most {
                let heading = libm::atan2(direction.y, direction.x);
                self.add(heading);
                self.add(heading + PI);
            }
        }
        self.all.sort_by(f64::total_cmp);
    }

    fn add(&mut self, heading: f64) {
        let heading = heading - TAU * (heading / TAU).floor();
        if self.all.iter().all(|other| wrapped(other - heading).abs() > SAME_HEADING) {
            self.all.push(heading);
        }
    }
}
