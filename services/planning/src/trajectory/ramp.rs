//! Changes of speed under limits on acceleration and jerk.
//!
//! A ramp takes the body from one speed to another, with no acceleration at either end. Its jerk is
//! at its limit, none, and at its limit again: seven phases on a leg are two ramps and the cruise
//! between them. Without a limit on jerk a ramp is a time of constant acceleration.

/// What bounds a change of speed: m/s2 and m/s3, or rad/s2 and rad/s3 in place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ramping {
    pub(super) acceleration: f64,
    /// Infinite where there is no limit.
    pub(super) jerk: f64,
}

/// How long a ramp takes, and how far it goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ramp {
    pub(super) time: f64,
    pub(super) distance: f64,
}

/// Halvings after which a bracket of two positive numbers can't shrink further.
const HALVINGS: usize = 200;

impl Ramping {
    pub(super) fn has_jerk(&self) -> bool {
        self.jerk < f64::INFINITY
    }

    /// The change of speed from which on a ramp reaches the limit on acceleration.
    fn full(&self) -> f64 {
        self.acceleration * self.acceleration / self.jerk
    }

    /// How long the acceleration takes to reach its greatest value in a ramp of this duration.
    pub(super) fn onset(&self, time: f64) -> f64 {
        (0.5 * time).min(self.acceleration / self.jerk)
    }

    /// The ramp between two speeds, up or down.
    pub(super) fn ramp(&self, from: f64, to: f64) -> Ramp {
        let change = (to - from).abs();
        let time = if change <= self.full() {
            2.0 * (change / self.jerk).sqrt()
        } else {
            change / self.acceleration + self.acceleration / self.jerk
        };
        Ramp { time, distance: 0.5 * (from + to) * time }
    }

    /// The greatest speed that a ramp from `speed` reaches within `length`.
    pub(super) fn reach(&self, speed: f64, length: f64) -> f64 {
        let Self { acceleration, jerk } = *self;
        // Where the acceleration reaches its limit: d (d / a + a / j) + 2 v (d / a + a / j) = 2 l.
        let half = 0.5 * acceleration * acceleration / jerk + speed;
        let rest = 2.0 * (acceleration * length - speed * acceleration * acceleration / jerk);
        let change = rest / (half + (half * half + rest).max(0.0).sqrt());
        if change >= self.full() {
            return speed + change;
        }
        // Where it doesn't: j s^3 + 2 v s = l for s, the half of the ramp's time. The one real
        // root, as a hyperbolic sine.
        let (p, q) = (2.0 * speed / jerk, length / jerk);
        let s = if p <= 0.0 {
            libm::cbrt(q)
        } else {
            let scale = (p / 3.0).sqrt();
            2.0 * scale * libm::sinh(libm::asinh(0.5 * q / (scale * scale * scale)) / 3.0)
        };
        speed + jerk * s * s
    }

    /// The greatest speed, at most `most`, between ramps from `entry` and to `exit` that have room
    /// on `length`.
    pub(super) fn peak(&self, (entry, exit): (f64, f64), most: f64, length: f64) -> f64 {
        let least = entry.max(exit);
        let fits =
            |peak: f64| self.ramp(entry, peak).distance + self.ramp(peak, exit).distance <= length;
        if most <= least || fits(most) {
            return most.max(least);
        }
        let Self { acceleration, jerk } = *self;
        // Both reach the limit on acceleration: p^2 - (v^2 + w^2) / 2 + (2 p + v + w) a^2 / 2 j = a l.
        let delay = acceleration * acceleration / jerk;
        let sum = acceleration * length + 0.5 * (entry * entry + exit * exit)
            - 0.5 * delay * (entry + exit);
        let full = (0.25 * delay * delay + sum).max(0.0).sqrt() - 0.5 * delay;
        let peak = if full - least >= delay {
            full
        } else if entry == 0.0 && exit == 0.0 {
            // From rest to rest without reaching it: p^(3/2) = l j^(1/2) / 2.
            libm::cbrt(0.25 * jerk * length * length)
        } else {
            return bracketed(least, most, fits);
        };
        peak.clamp(least, most)
    }
}

/// The greatest speed between two that fits: a longer distance is a greater speed.
fn bracketed(least: f64, most: f64, fits: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (least, most);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || high <= middle {
            break;
        }
        if fits(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const UNIT: Ramping = Ramping { acceleration: 1.0, jerk: 1.0 };

    /// By hand: 1 s of jerk up, 1 s down, from rest to 1 m/s over 1 m; at 3 m/s 2 s of constant
    /// acceleration are between.
    #[test]
    fn ramps_of_unit_limits_are_those_worked_by_hand() {
        assert_eq!(UNIT.ramp(0.0, 1.0), Ramp { time: 2.0, distance: 1.0 });
        assert_eq!(UNIT.ramp(0.0, 0.25), Ramp { time: 1.0, distance: 0.125 });
        assert_eq!(UNIT.ramp(3.0, 0.0), Ramp { time: 4.0, distance: 6.0 });
        assert_eq!(UNIT.onset(4.0), 1.0);
        assert_eq!(UNIT.onset(1.0), 0.5);
        assert!((UNIT.reach(0.0, 0.125) - 0.25).abs() < 1e-15);
        assert_eq!(UNIT.reach(0.0, 6.0), 3.0);
        // Up and down again over twice the way.
        assert!((UNIT.peak((0.0, 0.0), 9.0, 0.25) - 0.25).abs() < 1e-15);
        assert_eq!(UNIT.peak((0.0, 0.0), 9.0, 12.0), 3.0);
        assert_eq!(UNIT.peak((0.0, 0.0), 2.0, 12.0), 2.0);
    }

    #[test]
    fn without_a_limit_on_jerk_acceleration_is_constant() {
        let ramping = Ramping { acceleration: 2.0, jerk: f64::INFINITY };
        assert_eq!(ramping.ramp(1.0, 3.0), Ramp { time: 1.0, distance: 2.0 });
    }

    fn any_ramping() -> impl Strategy<Value = Ramping> {
        (-2.0..2.0_f64, -3.0..4.0_f64).prop_map(|(acceleration, jerk)| Ramping {
            acceleration: libm::pow(10.0, acceleration),
            jerk: libm::pow(10.0, jerk),
        })
    }

    proptest! {
        #[test]
        fn reach_is_the_end_of_a_ramp(
            ramping in any_ramping(), speed in 0.0..3.0_f64, length in 1e-6..100.0_f64,
        ) {
            let reached = ramping.reach(speed, length);
            prop_assert!(reached >= speed);
            // To rounding of the speed, which on a short ramp is a large part of the change.
            let [short, long] = [-4.0, 4.0].map(|part| {
                let near = reached * (1.0 + part * f64::EPSILON);
                ramping.ramp(speed, near.max(speed)).distance
            });
            let is_within = short <= length * (1.0 + 1e-12) && length <= long * (1.0 + 1e-12);
            prop_assert!(is_within, "{short} {length} {long}");
        }

        #[test]
        fn peak_leaves_no_room(
            ramping in any_ramping(), (v, w) in (0.0..3.0_f64, 0.0..3.0_f64),
            rests in 0..4_u8, more in 1e-3..50.0_f64,
        ) {
            let entry = if rests & 1 == 0 { v } else { 0.0 };
            let exit = if rests & 2 == 0 { w } else { 0.0 };
            let length = ramping.ramp(entry, exit).distance + more;
            let peak = ramping.peak((entry, exit), 1e6, length);
            prop_assert!(peak >= entry.max(exit));
            let used = ramping.ramp(entry, peak).distance + ramping.ramp(peak, exit).distance;
            prop_assert!((used - length).abs() <= 1e-9 * length, "{used} of {length}");
        }
    }
}
