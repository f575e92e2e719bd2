//! Bounds on speed and acceleration.

use crate::geometry::number::Number;
use thiserror::Error;

/// The least value of any limit, in its SI unit.
const LEAST: f64 = 1e-9;
/// The greatest value of any limit, in its SI unit: its square cannot overflow.
const MOST: f64 = 1e12;

/// Bounds on a body's motion, each a number from 1e-9 to 1e12 in SI units.
///
/// In assembly tasks only `speed` and `acceleration` matter. [`Default`]:
/// 1 m/s, 0.5 m/s2, 1 rad/s, 1 rad/s2, 0.5 m/s2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    speed: f64,
    acceleration: f64,
    yaw_rate: f64,
    yaw_acceleration: f64,
    lateral_acceleration: f64,
    /// Infinite where there is no limit.
    jerk: f64,
    yaw_jerk: f64,
}

/// Why numbers are no [`Limits`].
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum LimitError {
    /// A limit is not a number, not positive, or beyond any machine.
    #[error("{field} is {}, it must be between {least:e} and {most:e}", Number(*value))]
    OutOfRange {
        /// Name of the limit, as in a request.
        field: &'static str,
        /// The number given.
        value: f64,
        /// The least value allowed.
        least: f64,
        /// The greatest value allowed.
        most: f64,
    },
}

impl Limits {
    /// Limits on speed (m/s), tangential acceleration (m/s2), yaw rate (rad/s),
    /// yaw acceleration in turns in place (rad/s2) and lateral acceleration (m/s2).
    pub fn new(
        speed: f64,
        acceleration: f64,
        yaw_rate: f64,
        yaw_acceleration: f64,
        lateral_acceleration: f64,
    ) -> Result<Self, LimitError> {
        for (field, value) in [
            ("speed", speed),
            ("acceleration", acceleration),
            ("yaw_rate", yaw_rate),
            ("yaw_acceleration", yaw_acceleration),
            ("lateral_acceleration", lateral_acceleration),
        ] {
            in_range(field, value)?;
        }
        let rates = Self { yaw_rate, yaw_acceleration, ..Self::default() };
        Ok(Self { speed, acceleration, lateral_acceleration, ..rates })
    }

    /// The same with limits on the change of acceleration: along the path (m/s3) and in turns in
    /// place (rad/s3). `None`: no limit.
    pub fn with_jerk(self, jerk: Option<f64>, yaw_jerk: Option<f64>) -> Result<Self, LimitError> {
        let limit = |field, value: Option<f64>| {
            value.map_or(Ok(f64::INFINITY), |value| in_range(field, value))
        };
        let (jerk, yaw_jerk) = (limit("jerk", jerk)?, limit("yaw_jerk", yaw_jerk)?);
        Ok(Self { jerk, yaw_jerk, ..self })
    }

    /// Greatest speed of the reference point, m/s.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Greatest change of speed along the path, m/s2.
    pub fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// Greatest rate of turning, rad/s.
    pub fn yaw_rate(&self) -> f64 {
        self.yaw_rate
    }

    /// Greatest change of the yaw rate in a turn in place, rad/s2.
    pub fn yaw_acceleration(&self) -> f64 {
        self.yaw_acceleration
    }

    /// Greatest acceleration across the path on arcs, m/s2.
    pub fn lateral_acceleration(&self) -> f64 {
        self.lateral_acceleration
    }

    /// Greatest change of acceleration along the path, m/s3; infinite if there is no limit.
    pub fn jerk(&self) -> f64 {
        self.jerk
    }

    /// Greatest change of yaw acceleration in a turn in place, rad/s3; infinite if there is no
    /// limit.
    pub fn yaw_jerk(&self) -> f64 {
        self.yaw_jerk
    }
}

fn in_range(field: &'static str, value: f64) -> Result<f64, LimitError> {
    // A NaN lies in no range.
    if (LEAST..=MOST).contains(&value) {
        Ok(value)
    } else {
        Err(LimitError::OutOfRange { field, value, least: LEAST, most: MOST })
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            speed: 1.0,
            acceleration: 0.5,
            yaw_rate: 1.0,
            yaw_acceleration: 1.0,
            lateral_acceleration: 0.5,
            jerk: f64::INFINITY,
            yaw_jerk: f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_limits_are_admissible() {
        let limits = Limits::default();
        let Limits { speed, acceleration, yaw_rate, yaw_acceleration, .. } = limits;
        let lateral_acceleration = limits.lateral_acceleration;
        let checked =
            Limits::new(speed, acceleration, yaw_rate, yaw_acceleration, lateral_acceleration);
        assert_eq!(checked, Ok(Limits::default()));
    }

    #[test]
    fn every_limit_is_checked_by_name() {
        let fields =
            ["speed", "acceleration", "yaw_rate", "yaw_acceleration", "lateral_acceleration"];
        for (index, name) in fields.into_iter().enumerate() {
            for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-10, 1e13] {
                let mut numbers = [1.0; 5];
                numbers[index] = bad;
                let [a, b, c, d, e] = numbers;
                let LimitError::OutOfRange { field, value, .. } =
                    Limits::new(a, b, c, d, e).unwrap_err();
                assert_eq!((field, value.to_bits()), (name, bad.to_bits()));
            }
        }
    }

    #[test]
    fn limits_on_jerk_are_checked_by_name() {
        for (jerk, yaw_jerk, name) in [(-1.0, 1.0, "jerk"), (1.0, f64::NAN, "yaw_jerk")] {
            let LimitError::OutOfRange { field, .. } =
                Limits::default().with_jerk(Some(jerk), Some(yaw_jerk)).unwrap_err();
            assert_eq!(field, name);
        }
        assert_eq!(Limits::default().with_jerk(None, None), Ok(Limits::default()));
    }

    #[test]
    fn message_names_field_and_numbers() {
        let error = Limits::new(1.0, -0.5, 1.0, 1.0, 1.0).unwrap_err();
        assert_eq!(error.to_string(), "acceleration is -0.5, it must be between 1e-9 and 1e12");
    }
}
