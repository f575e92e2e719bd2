//! Corridors made by hand: corners and walls of channels in travel order.

use crate::clearance::rectangle::Footprint;
use crate::clearance::walls::{Wall, Walls};
use crate::driving::{Corner, Drive, Goal, Pose, StartTurn};
use crate::geometry::{AxisBox, Direction, Sign, Vector};

pub(super) fn point(x: f64, y: f64) -> Vector<2> {
    Vector::<2>::new(x, y)
}

pub(super) fn channel(x: [f64; 2], y: [f64; 2]) -> AxisBox<2> {
    AxisBox::new(point(x[0], y[0]), point(x[1], y[1])).unwrap()
}

#[derive(Debug, Clone)]
pub(super) struct Scene {
    pub(super) footprint: Footprint,
    pub(super) start: Pose,
    pub(super) goal: Goal,
    pub(super) start_turn: StartTurn,
    pub(super) channels: Vec<AxisBox<2>>,
    pub(super) corners: Vec<Corner>,
    pub(super) walls: Walls<2>,
}

impl Scene {
    pub(super) fn new(channels: &[AxisBox<2>], start: Pose, goal: [f64; 2]) -> Self {
        let goal = Goal { position: point(goal[0], goal[1]), heading: None };
        let junctions: Vec<_> =
            channels.windows(2).map(|pair| pair[0].intersection(&pair[1]).unwrap()).collect();
        let mut places = vec![start.position];
        places.extend(junctions.iter().map(AxisBox::center));
        places.push(goal.position);
        // A channel's axis is the one in which its junction is a proper part of it.
        let axis = |channel: &AxisBox<2>, junction: &AxisBox<2>| {
            usize::from(channel.size().x == junction.size().x)
        };
        let corners = junctions
            .iter()
            .enumerate()
            .map(|(i, junction)| {
                let along = |channel: &AxisBox<2>, way: Vector<2>| {
                    let axis = axis(channel, junction);
                    Direction { axis, sign: Sign::of(way[axis]) }
                };
                let approach = along(&channels[i], places[i + 1] - places[i]);
                let leave = along(&channels[i + 1], places[i + 2] - places[i + 1]);
                Corner::new(junction, approach, leave).unwrap()
            })
            .collect();
        let mut walls = Walls::default();
        for channel in channels {
            push_walls(channel, channels, &mut walls);
        }
        Self {
            footprint: Footprint::new(1.0, 1.5).unwrap(),
            start,
            goal,
            start_turn: StartTurn::InPlace,
            channels: channels.to_vec(),
            corners,
            walls,
        }
    }

    pub(super) fn drive(&self) -> Drive<'_> {
        Drive {
            footprint: self.footprint,
            start: self.start,
            goal: self.goal,
            start_turn: self.start_turn,
            first: self.channels[0],
            last: *self.channels.last().unwrap(),
            corners: &self.corners,
            walls: &self.walls,
        }
    }
}

/// What of a channel's outline is not in another channel.
fn push_walls(channel: &AxisBox<2>, channels: &[AxisBox<2>], walls: &mut Walls<2>) {
    for axis in 0..2 {
        let along = 1 - axis;
        for at in [channel.min()[axis], channel.max()[axis]] {
            let outwards = if at == channel.max()[axis] { 1.0 } else { -1.0 };
            let mut rest = vec![(channel.min()[along], channel.max()[along])];
            for other in channels {
                // Free just outside of the outline?
                let beyond = if outwards > 0.0 {
                    other.min()[axis] <= at && at < other.max()[axis]
                } else {
                    other.min()[axis] < at && at <= other.max()[axis]
                };
                if beyond {
                    let (low, high) = (other.min()[along], other.max()[along]);
                    rest = rest
                        .into_iter()
                        .flat_map(|(a, b)| [(a, b.min(low)), (a.max(high), b)])
                        .filter(|(a, b)| a < b)
                        .collect();
                }
            }
            for (a, b) in rest {
                let end = |value: f64| {
                    let mut point = point(at, at);
                    point[along] = value;
                    point
                };
                walls.push(Wall { from: end(a), to: end(b) });
            }
        }
    }
}

/// Worked corridor A: three junctions, S-turns.
pub(super) fn corridor_a() -> Scene {
    Scene::new(
        &[
            channel([0.0, 3.0], [0.0, 11.0]),
            channel([0.0, 13.0], [8.0, 11.0]),
            channel([9.0, 13.0], [8.0, 20.0]),
            channel([9.0, 22.0], [16.0, 20.0]),
        ],
        Pose { position: point(1.2, 1.5), heading: std::f64::consts::FRAC_PI_2 },
        [20.5, 18.25],
    )
}

/// Worked corridor B: five junctions, two U-turns.
pub(super) fn corridor_b() -> Scene {
    Scene::new(
        &[
            channel([0.0, 3.0], [0.0, 14.0]),
            channel([0.0, 8.0], [10.5, 14.0]),
            channel([4.5, 8.0], [2.0, 14.0]),
            channel([4.5, 14.0], [2.0, 5.0]),
            channel([10.0, 14.0], [2.0, 16.0]),
            channel([10.0, 22.0], [12.0, 16.0]),
        ],
        Pose { position: point(1.25, 1.5), heading: std::f64::consts::FRAC_PI_2 },
        [20.5, 14.5],
    )
}
