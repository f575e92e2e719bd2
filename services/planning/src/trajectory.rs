//! From legs to timed states: limits, the speed profile over the legs, and samples of it.
//!
//! [`Limits`] bound the motion, [`Profile::plan`] times it along the legs, and a
//! [`Sampler`] evaluates it at the times that a [`Sampling`] asks for. Sampling is for
//! output only: durations and lengths are closed forms.
//!
//! The profile is the fastest one whose speed is bounded leg by leg and whose
//! tangential acceleration is bounded throughout (a trapezoid or a triangle of
//! speed on every leg). With a limit on jerk each change of speed has three phases, and
//! every leg begins and ends without acceleration. On an arc of radius rho the speed also obeys
//! `v <= yaw_rate * rho` and `v^2 <= lateral_acceleration * rho`. The yaw rate
//! jumps where a line meets an arc, because the curvature does; the limit on
//! yaw acceleration applies to turns in place, to clothoids, and with [`Stops::AtJoints`]
//! everywhere.
//!
//! ```
//! use planning::budget::Budget;
//! use planning::geometry::Vector;
//! use planning::motion::{Curve, Leg};
//! use planning::trajectory::{Limits, Profile, Sampling, Stops};
//!
//! // 2 m at most 1 m/s and 1 m/s2: 1 s to reach the top speed, 1 s at it, 1 s to stop.
//! let limits = Limits::new(1.0, 1.0, 1.0, 1.0, 1.0)?;
//! let curve = Curve::translation(Vector::from([0.0, 0.0]), Vector::from([0.0, 2.0]));
//! let legs = [Leg { curve, junction: None, rule: None, rung: None }];
//! let mut profile = Profile::default();
//! profile.plan(&legs, &limits, Stops::EveryLeg, &Budget::default())?;
//! assert_eq!((profile.duration(), profile.length()), (3.0, 2.0));
//!
//! let sampling = Sampling::period(1.0)?;
//! let heights: Vec<_> = profile.samples(&legs, sampling).map(|state| state.position.y).collect();
//! assert_eq!(heights, [0.0, 0.5, 1.5, 2.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod clothoid_bounds;
mod jerk;
mod limits;
mod profile;
mod ramp;
mod rounding;
mod sampler;
mod sampling;
mod smooth_turn;
mod smoothing;
mod state;
#[cfg(test)]
mod tests;
mod track;

pub use limits::{LimitError, Limits};
pub use profile::{Profile, Stops, YawJumps};
pub use rounding::{CornerShape, round_corners};
pub use sampler::Sampler;
pub use sampling::{Sampling, SamplingError};
pub use smoothing::{SmoothDriving, SmoothedDrive, smooth_drive};
pub use state::State;
