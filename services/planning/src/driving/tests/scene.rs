//! Corridors: the worked ones, and random chains.

use crate::budget::Budget;
use proptest::prelude::*;

use crate::clearance::rectangle::Footprint;
use crate::driving::limits::{TurnRoom, least_width};
use crate::driving::{Corner, Drive, Goal, Pose, StartTurn, corners_of};
use crate::free_space::walls::{Complement, Walls};
use crate::free_space::{Chain, End};
use crate::geometry::{AxisBox, Vector};

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
        let mut chain = Chain::default();
        chain
            .build(channels, &start.position, End::Goal(goal.position), &Budget::default())
            .unwrap();
        let mut corners = Vec::new();
        corners_of(&chain, &mut corners);
        let mut walls = Walls::default();
        walls
            .set_complement(channels, None, &mut Complement::default(), &Budget::default())
            .unwrap();
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

    /// The safest gap of the narrowest corridor in closed form, metres.
    pub(super) fn balanced(&self) -> f64 {
        let rooms = self.corners.iter().flat_map(|corner| TurnRoom::at(&self.footprint, corner));
        rooms.min_by(TurnRoom::compare).map_or(f64::INFINITY, |room| room.balanced_gap())
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

/// The scene with x replaced by -x.
pub(super) fn mirrored(scene: &Scene) -> Scene {
    image(scene, |point| super::scene::point(-point.x, point.y), |h| std::f64::consts::PI - h)
}

/// The scene turned left by a quarter turn.
pub(super) fn turned(scene: &Scene) -> Scene {
    let quarter = std::f64::consts::FRAC_PI_2;
    image(scene, |point| super::scene::point(-point.y, point.x), |h| h + quarter)
}

fn image(
    scene: &Scene,
    map: impl Fn(Vector<2>) -> Vector<2>,
    heading: impl Fn(f64) -> f64,
) -> Scene {
    let channels: Vec<_> = scene
        .channels
        .iter()
        .map(|channel| {
            let (a, b) = (map(channel.min()), map(channel.max()));
            AxisBox::new(a.inf(&b), a.sup(&b)).unwrap()
        })
        .collect();
    let start = Pose { position: map(scene.start.position), heading: heading(scene.start.heading) };
    let goal = map(scene.goal.position);
    let mut other = Scene::new(&channels, start, [goal.x, goal.y]);
    other.goal.heading = scene.goal.heading.map(heading);
    other.start_turn = scene.start_turn;
    other.footprint = scene.footprint;
    other
}

/// One stretch of a random chain: which way it goes, how far past the corridor
/// before (the thickness of the wall between), how wide the corridor at its end
/// is beyond what the robot needs, and how far it goes on beyond that.
type Stretch = (bool, f64, f64, f64);

/// Robots with the reference point in the middle, and anywhere from front to rear.
pub(super) fn robots() -> impl Strategy<Value = Footprint> {
    let middle =
        (0.4..1.2, 0.4..2.0).prop_map(|(width, length)| Footprint::new(width, length).unwrap());
    let reach = || prop_oneof![1 => Just(0.0), 4 => 0.2..1.0];
    let offset = (0.4..1.2, reach(), reach())
        .prop_filter("a length", |(_, front, rear)| front + rear > 0.0)
        .prop_map(|(width, front, rear)| Footprint::offset(width, front, rear).unwrap());
    prop_oneof![middle, offset]
}

/// Random chains of 1 to `most` corners, S-turns and U-turns, with a random robot
/// that can pass them, starting and ending near the centre lines.
pub(super) fn corridors(most: usize) -> impl Strategy<Value = Scene> {
    let stretch = (any::<bool>(), 0.2..6.0, 0.3..2.5, prop_oneof![Just(0.0), 0.0..3.0]);
    (
        prop::collection::vec(stretch, 1..=most),
        (robots(), 0.3..2.5),
        (-0.25..0.25, -0.25..0.25, -0.05..0.05),
    )
        .prop_map(|(stretches, (footprint, room), offsets)| {
            chain(&stretches, footprint, room, offsets)
        })
}

fn chain(
    stretches: &[Stretch],
    footprint: Footprint,
    room: f64,
    (start_offset, goal_offset, heading_offset): (f64, f64, f64),
) -> Scene {
    let needs = least_width(&footprint);
    // The range of each corridor across its axis, and which way it is travelled.
    let mut across = vec![[0.0, needs + room]];
    let mut forwards = vec![];
    let mut before = [0.0, 8.0];
    for &(forward, wall, room, _) in stretches {
        let width = needs + room;
        across.push(if forward {
            [before[1] + wall, before[1] + wall + width]
        } else {
            [before[0] - wall - width, before[0] - wall]
        });
        forwards.push(forward);
        before = across[across.len() - 2];
    }
    forwards.push(true);
    let mut channels = Vec::new();
    for (index, own) in across.iter().enumerate() {
        let behind = if index == 0 { [0.0, 8.0] } else { across[index - 1] };
        let ahead = across.get(index + 1).copied().unwrap_or([behind[1], behind[1] + 9.0]);
        let more = stretches.get(index).map_or(0.0, |stretch| stretch.3);
        let (low, high) = if forwards[index] {
            (behind[0], ahead[1] + more)
        } else {
            (ahead[0] - more, behind[1])
        };
        let along = [low, high];
        channels.push(if index % 2 == 0 { channel(*own, along) } else { channel(along, *own) });
    }
    let middle = |range: [f64; 2]| (range[0] + range[1]) / 2.0;
    // Well before the first junction, and well behind the last one.
    let at_start = if forwards[0] { 1.8 } else { 6.2 };
    let start = Pose {
        position: point(middle(across[0]) + start_offset * room, at_start),
        heading: std::f64::consts::FRAC_PI_2.copysign(if forwards[0] { 1.0 } else { -1.0 })
            + heading_offset,
    };
    let last = across.len() - 1;
    let last_room = stretches.last().map_or(room, |stretch| stretch.2);
    let (x, y) = (across[last - 1][1] + 7.0, middle(across[last]) + goal_offset * last_room);
    let goal = if last % 2 == 0 { [y, x] } else { [x, y] };
    let mut scene = Scene::new(&channels, start, goal);
    scene.footprint = footprint;
    scene
}

/// An L corridor of one width for a robot with `room` more than it needs to turn.
pub(super) fn straight_ell((footprint, room): (Footprint, f64)) -> Scene {
    let wide = least_width(&footprint) + room;
    let mut scene = Scene::new(
        &[channel([0.0, wide], [0.0, 20.0 + wide]), channel([0.0, 30.0], [20.0, 20.0 + wide])],
        Pose { position: point(wide / 2.0, 3.0), heading: std::f64::consts::FRAC_PI_2 },
        [26.0, 20.0 + wide / 2.0],
    );
    scene.footprint = footprint;
    scene
}

/// The same, started and ended so that both angles of the turn are 0 with `gap`.
pub(super) fn approached_at(mut scene: Scene, gap: f64) -> Scene {
    let corner = scene.corners[0].point;
    let radius = scene.footprint.width() / 2.0 + gap;
    scene.start.position.x = corner.x - radius;
    scene.goal.position.y = corner.y + radius;
    scene
}
