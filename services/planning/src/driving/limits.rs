//! Closed forms for one turn of the rectangular robot (`docs/errata.md` derives
//! them): what a corridor's width allows.

use crate::clearance::rectangle::Footprint;

/// Radius of the circle about the corner on which the robot's outer body corners
/// run, metres: R(gap) = sqrt((w + gap)^2 + h^2 / 4).
pub fn outer_radius(footprint: &Footprint, gap: f64) -> f64 {
    let (across, along) = (footprint.width() + gap, footprint.length() / 2.0);
    (across * across + along * along).sqrt()
}

/// Width that a corridor must exceed for a full quarter turn with the least gap,
/// metres: R(0).
pub fn least_width(footprint: &Footprint) -> f64 {
    outer_radius(footprint, 0.0)
}

/// The gap at which the robot, in a full quarter turn, touches the outer wall of
/// a corridor `width` wide, metres: R(gap) = width. Not positive where no gap
/// will do.
pub fn greatest_gap(footprint: &Footprint, width: f64) -> f64 {
    let along = footprint.length() / 2.0;
    ((width - along) * (width + along)).max(0.0).sqrt() - footprint.width()
}

/// The gap that leaves as much to the outer wall of a corridor `width` wide as to
/// the corner, metres: gap = width - R(gap). Not positive where no gap will do.
pub fn balanced_gap(footprint: &Footprint, width: f64) -> f64 {
    let (w, h) = (footprint.width(), footprint.length());
    (width * width - w * w - h * h / 4.0) / (2.0 * (width + w))
}
