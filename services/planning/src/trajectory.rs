//! From legs to a trajectory: limits, the speed profile over the legs, and the
//! states sampled from it.
//!
//! Three steps, each a value of its own: [`Limits`] say what the body may do,
//! [`Profile::plan`] finds when it is where along the legs, and a [`Sampler`]
//! evaluates that at the times which [`Sampling`] asks for. Sampling is for
//! output only: durations and lengths are closed forms.
//!
//! The profile is the fastest one whose speed is bounded leg by leg and whose
//! tangential acceleration is bounded throughout (a trapezoid or a triangle of
//! speed on every leg). On an arc of radius rho the speed also obeys
//! `v <= yaw_rate * rho` and `v^2 <= lateral_acceleration * rho`. The yaw rate
//! steps where a line meets an arc, because the curvature does; the limit of
//! yaw acceleration binds turns in place only.

mod limits;
mod profile;
mod sampler;
mod sampling;
mod state;
#[cfg(test)]
mod tests;
mod track;

pub use limits::{LimitError, Limits};
pub use profile::{Profile, Stops};
pub use sampler::Sampler;
pub use sampling::{Sampling, SamplingError};
pub use state::State;
