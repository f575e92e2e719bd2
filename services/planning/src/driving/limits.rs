//! Closed forms for one turn of the rectangular robot (derived in `docs/method.md` 6):
//! what a corridor's width allows.
//!
//! On a turn about a corner the outer rear corner of the body comes closest to the outer wall
//! of the corridor that the robot leaves, the outer front corner to that of the corridor that
//! it enters. The public functions take the one of the two that is farther from the
//! reference point, and so hold for both corridors.

use std::cmp::Ordering;

use super::Corner;
use crate::clearance::rectangle::Footprint;

/// Radius of the circle about the corner on which the robot's farther outer body corner
/// runs, metres: R(gap) = sqrt((w + gap)^2 + e^2), e being the greater of front and rear.
pub fn outer_radius(footprint: &Footprint, gap: f64) -> f64 {
    TurnRoom::of(footprint, f64::INFINITY).outer_radius(gap)
}

/// Width that a corridor must exceed for a quarter turn, metres: R(0).
pub fn least_width(footprint: &Footprint) -> f64 {
    outer_radius(footprint, 0.0)
}

/// The gap at which the robot touches the outer wall of a corridor of this width in a quarter
/// turn, metres: R(gap) = width. Not positive if no gap is possible.
pub fn greatest_gap(footprint: &Footprint, width: f64) -> f64 {
    TurnRoom::of(footprint, width).greatest_gap()
}

/// The gap that leaves as much to the outer wall of a corridor of this width as to the corner,
/// metres: gap = width - R(gap). Not positive if no gap is possible.
///
/// ```
/// use planning::clearance::rectangle::Footprint;
/// use planning::driving::limits::{balanced_gap, greatest_gap, least_width};
///
/// // 1 m wide and 1.5 m long: R(0) = sqrt(1 + 0.75^2) = 1.25 m.
/// let footprint = Footprint::new(1.0, 1.5)?;
/// assert_eq!(least_width(&footprint), 1.25);
/// // In a corridor 3 m wide: (9 - 1 - 0.5625) / 8.
/// assert_eq!(balanced_gap(&footprint, 3.0), 0.9296875);
/// assert!(greatest_gap(&footprint, 3.0) > 1.9);
/// # Ok::<(), planning::clearance::rectangle::FootprintError>(())
/// ```
pub fn balanced_gap(footprint: &Footprint, width: f64) -> f64 {
    TurnRoom::of(footprint, width).balanced_gap()
}

/// A corridor at a corner, and the outer corner of the body that swings towards its outer
/// wall.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurnRoom {
    /// Width of the corridor, metres.
    pub(super) width: f64,
    /// Width of the body, metres.
    across: f64,
    /// How far ahead of the reference point, or behind it, the body corner is, metres.
    along: f64,
}

impl TurnRoom {
    fn of(footprint: &Footprint, width: f64) -> Self {
        let along = footprint.front().max(footprint.rear());
        Self { width, across: footprint.width(), along }
    }

    /// The corridors that the robot leaves and enters at a corner, the one with less room
    /// first.
    pub(super) fn at(footprint: &Footprint, corner: &Corner) -> [Self; 2] {
        let across = footprint.width();
        let leaves = Self { width: corner.width_in, across, along: footprint.rear() };
        let enters = Self { width: corner.width_out, across, along: footprint.front() };
        if leaves.compare(&enters).is_le() { [leaves, enters] } else { [enters, leaves] }
    }

    /// Which leaves the smaller gap. The same body corner needs no arithmetic, which could
    /// round the difference away.
    pub(super) fn compare(&self, other: &Self) -> Ordering {
        if self.along == other.along {
            self.width.total_cmp(&other.width)
        } else {
            self.balanced_gap().total_cmp(&other.balanced_gap())
        }
    }

    fn outer_radius(&self, gap: f64) -> f64 {
        let (across, along) = (self.across + gap, self.along);
        (across * across + along * along).sqrt()
    }

    pub(super) fn least_width(&self) -> f64 {
        self.outer_radius(0.0)
    }

    pub(super) fn greatest_gap(&self) -> f64 {
        let (width, along) = (self.width, self.along);
        ((width - along) * (width + along)).max(0.0).sqrt() - self.across
    }

    pub(super) fn balanced_gap(&self) -> f64 {
        let Self { width, across, along } = *self;
        (width * width - across * across - along * along) / (2.0 * (width + across))
    }
}
