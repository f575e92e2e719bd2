//! Random scenes.

use crate::budget::Budget;
use crate::free_space::solids::Solids;
use crate::geometry::{AxisBox, Direction, Sign, Vector};
use proptest::prelude::*;

/// Channels in no order, and a body in one of them.
#[derive(Debug, Clone)]
pub(super) struct Crowd<const D: usize> {
    pub(super) channels: Vec<AxisBox<D>>,
    pub(super) body: AxisBox<D>,
    pub(super) exit: Direction,
}

/// Up to `most` overlapping boxes, on a grid (so that sides coincide) or beside it.
pub(super) fn crowd<const D: usize>(most: usize) -> impl Strategy<Value = Crowd<D>> {
    let corner = proptest::array::uniform::<_, D>(0..6i8);
    let size = proptest::array::uniform::<_, D>(1..7i8);
    let shift = proptest::array::uniform::<_, D>(prop_oneof![Just(0.0), 0.0..0.9f64]);
    let channels = proptest::collection::vec((corner, size, shift), 2..=most);
    (channels, 0..D, any::<bool>(), proptest::array::uniform::<_, D>(0.0..1.0f64)).prop_map(
        |(channels, axis, positive, place)| {
            let make = |(corner, size, shift): &([i8; D], [i8; D], [f64; D])| {
                let min = Vector::from(corner.map(f64::from)) + Vector::from(*shift);
                AxisBox::new(min, min + Vector::from(size.map(f64::from))).expect("a box")
            };
            let channels: Vec<_> = channels.iter().map(make).collect();
            let size = Vector::repeat(0.8);
            let room = channels[0].size() - size;
            let min = channels[0].min() + room.component_mul(&Vector::from(place));
            let body = AxisBox::new(min, min + size).expect("a box");
            let body = channels[0].intersection(&body).expect("a body in its channel");
            let sign = if positive { Sign::Positive } else { Sign::Negative };
            Crowd { channels, body, exit: Direction { axis, sign } }
        },
    )
}

/// A chain of corridors of one width on a coarse grid: all of them maximal unless
/// they come near each other.
pub(super) fn corridors<const D: usize>(most: usize) -> impl Strategy<Value = Crowd<D>> {
    let step = (0..D.max(2), prop_oneof![3 => Just(true), 1 => Just(false)], 2..6i8);
    (proptest::collection::vec(step, 1..=most), 0.1..0.9f64).prop_map(|(steps, place)| {
        let mut center = Vector::<D>::zeros();
        let (mut axis, mut sign) = (0, Sign::Positive);
        let mut channels = Vec::new();
        for (turn, positive, length) in steps {
            axis = (axis + 1 + turn % (D - 1)) % D;
            sign = if positive { Sign::Positive } else { Sign::Negative };
            let mut next = center;
            next[axis] += sign.factor() * 2.0 * f64::from(length);
            let reach = Vector::repeat(0.75);
            let channel = AxisBox::new(center.inf(&next) - reach, center.sup(&next) + reach);
            channels.push(channel.expect("a box"));
            center = next;
        }
        // Where the first corridor begins.
        let min = Vector::repeat(place * 0.5 - 0.75);
        let body = AxisBox::new(min, min + Vector::repeat(1.0)).expect("a box");
        Crowd { channels, body, exit: Direction { axis, sign } }
    })
}

/// Fills everything but the channels with boxes, up to the mouth; the bounds.
pub(super) fn solids_around<const D: usize>(
    crowd: &Crowd<D>,
    solids: &mut Solids<D>,
) -> AxisBox<D> {
    let corners = crowd.channels.iter().map(|channel| (channel.min(), channel.max()));
    let (min, max) = corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))).expect("a channel");
    let bounds = AxisBox::new(min, max).expect("a box");
    let lines: [Vec<f64>; D] = std::array::from_fn(|axis| {
        let ends = crowd.channels.iter().flat_map(|c| [c.min()[axis], c.max()[axis]]);
        let mut lines: Vec<f64> = ends.collect();
        lines.sort_unstable_by(f64::total_cmp);
        lines.dedup();
        lines
    });
    let cells: usize = lines.iter().map(|lines| lines.len() - 1).product();
    for cell in 0..cells {
        let mut rest = cell;
        let places: [usize; D] = std::array::from_fn(|axis| {
            let place = rest % (lines[axis].len() - 1);
            rest /= lines[axis].len() - 1;
            place
        });
        let corner = |more: usize| {
            Vector::from(std::array::from_fn(|axis| lines[axis][places[axis] + more]))
        };
        let cell = AxisBox::new(corner(0), corner(1)).expect("a box");
        if !crowd.channels.iter().any(|channel| channel.contains(&cell)) {
            solids.push_box(cell, &Budget::default()).unwrap();
        }
    }
    bounds
}
