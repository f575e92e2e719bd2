//! What bounds the motion on a clothoid.

use super::limits::Limits;

/// What parts of the limit on acceleration a part on a curve has along and across its path: at right
/// angles they make the whole.
pub(super) const ALONG: f64 = 0.8;
pub(super) const ACROSS: f64 = 0.6;

/// What part of the limit on yaw acceleration a robot on a clothoid has at even speed.
const STEADY: f64 = 0.8;

/// What parts of the limit on jerk a part on a clothoid has along its path by change of speed and by
/// the curvature, and across it by each of its two terms: 0.7 and 0.6, at right angles less than the
/// whole.
const JERK_ALONG: f64 = 0.5;
const JERK_BY_CURVATURE: f64 = 0.2;
const JERK_ACROSS: f64 = 0.3;

/// What bounds the motion on a clothoid follows from how sharply it bends.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClothoidBounds {
    /// The greatest curvature, rad/m.
    curvature: f64,
    /// How fast it changes, rad/m2.
    sharpness: f64,
}

/// The square of the greatest speed, the greatest acceleration and the greatest jerk along the path.
type PathBounds = (f64, f64, f64);

impl ClothoidBounds {
    pub(super) fn of([first, last]: [f64; 2], length: f64) -> Self {
        let curvature = first.abs().max(last.abs());
        Self { curvature, sharpness: (last - first).abs() / length }
    }

    /// Those of a robot. With the curvature k, the sharpness c, the speed v and the acceleration a
    /// along the path, the yaw rate is k v, the acceleration across the path k v^2, and the yaw
    /// acceleration k a + c v^2. Its second term has most of the limit: through a corner the speed is mostly
    /// even.
    pub(super) fn driven(&self, limits: &Limits) -> PathBounds {
        let Self { curvature, sharpness } = *self;
        let square = |x: f64| x * x;
        let [steady, changing] =
            [STEADY, 1.0 - STEADY].map(|part| part * limits.yaw_acceleration());
        let most = square(limits.speed())
            .min(square(limits.yaw_rate() / curvature))
            .min(limits.lateral_acceleration() / curvature)
            .min(steady / sharpness);
        (most, limits.acceleration().min(changing / curvature), limits.jerk())
    }

    /// Those of a part. Along the path its jerk is j - k^2 v^3, across it 3 k v a + c v^3, for the
    /// change j of the acceleration along the path.
    pub(super) fn translated(&self, limits: &Limits) -> PathBounds {
        let Self { curvature, sharpness } = *self;
        let square = |x: f64| x * x;
        let mut most = square(limits.speed()).min(ACROSS * limits.acceleration() / curvature);
        let mut acceleration = ALONG * limits.acceleration();
        let jerk = limits.jerk();
        if jerk < f64::INFINITY {
            let fastest = libm::cbrt(JERK_BY_CURVATURE * jerk / square(curvature))
                .min(libm::cbrt(JERK_ACROSS * jerk / sharpness));
            most = most.min(square(fastest));
            acceleration = acceleration.min(JERK_ACROSS * jerk / (3.0 * curvature * most.sqrt()));
        }
        (most, acceleration, JERK_ALONG * jerk)
    }
}
