//! Closed forms for one turn of the rectangular robot (derived in `docs/method.md` 6):
//! what a corridor's width allows.

use crate::clearance::rectangle::Footprint;

/// Radius of the circle about the corner on which the robot's outer body corners
/// run, metres: R(gap) = sqrt((w + gap)^2 + h^2 / 4).
pub fn outer_radius(footprint: &Footprint, gap: f64) -> f64 {
    let (across, along) = (footprint.width() + gap, footprint.length() / 2.0);
    (across * across + along * along).sqrt()
}

/// Width that a corridor must exceed for a quarter turn, metres: R(0).
pub fn least_width(footprint: &Footprint) -> f64 {
    outer_radius(footprint, 0.0)
}

/// The gap at which the robot touches the outer wall of a corridor of this width in a quarter
/// turn, metres: R(gap) = width. Not positive if no gap is possible.
pub fn greatest_gap(footprint: &Footprint, width: f64) -> f64 {
    let along = footprint.length() / 2.0;
    ((width - along) * (width + along)).max(0.0).sqrt() - footprint.width()
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
    let (w, h) = (footprint.width(), footprint.length());
    (width * width - w * w - h * h / 4.0) / (2.0 * (width + w))
}
