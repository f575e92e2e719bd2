//! Random chains of channels with a body in the first, for property tests.

use crate::geometry::{AxisBox, Direction, Sign, Vector};
use proptest::prelude::*;

/// Channels that a body can pass, and the body in its assembled state.
#[derive(Debug, Clone)]
pub(crate) struct Scene<const D: usize> {
    pub(crate) channels: Vec<AxisBox<D>>,
    pub(crate) body: AxisBox<D>,
    pub(crate) exit: Direction,
}

/// One channel: which other axis, whether forwards, how long, how wide.
type ChannelStep<const D: usize> = (usize, bool, f64, [f64; D]);

fn step<const D: usize>() -> impl Strategy<Value = ChannelStep<D>> {
    let widths = proptest::array::uniform::<_, D>(0.0..1.0f64);
    (0..D.max(2), any::<bool>(), 3.0..9.0f64, widths)
}

/// Chains of 1 to `most` channels. Every junction is larger than the body by at
/// least 0.2 m along every axis.
pub(crate) fn scenes<const D: usize>(most: usize) -> impl Strategy<Value = Scene<D>> {
    let body = proptest::array::uniform::<_, D>(0.3..1.0f64);
    let place = proptest::array::uniform::<_, D>(0.0..1.0f64);
    (proptest::collection::vec(step(), 1..=most), body, place).prop_map(|(steps, half, place)| {
        let half = Vector::from(half);
        let mut center = Vector::<D>::zeros();
        let mut channels = Vec::new();
        let mut axis = 0;
        let mut sign = Sign::Positive;
        for (turn, positive, length, widths) in &steps {
            // Any axis but the one before.
            axis = (axis + 1 + turn % (D - 1)) % D;
            sign = if *positive { Sign::Positive } else { Sign::Negative };
            let mut next = center;
            next[axis] += sign.factor() * length;
            let reach = half + Vector::from(*widths) + Vector::repeat(0.1);
            let channel = AxisBox::new(center.inf(&next) - reach, center.sup(&next) + reach);
            channels.push(channel.expect("extents are positive"));
            center = next;
        }
        let room = channels[0].size() - half * 2.0;
        let min = channels[0].min() + room.component_mul(&Vector::from(place));
        let body = AxisBox::new(min, min + half * 2.0).expect("extents are positive");
        // Rounding must not push the body through the channel's side.
        let inside = channels[0].intersection(&body).expect("the body is in the channel");
        Scene { channels, body: inside, exit: Direction { axis, sign } }
    })
}
