//! Routes of robots, against all ways looked at one by one.

use super::*;
use crate::clearance::clothoid::PlacedClothoid;
use crate::clearance::rectangle::Footprint;
use crate::driving::{self, CornerGaps, Drive, DrivingError, Goal, Pose, StartTurn, corners_of};
use crate::free_space::walls::{Complement, Wall, Walls};
use crate::geometry::box_tree::distance_squared_box_box;
use crate::geometry::unit;
use crate::motion::Curve;

/// A robot among channels, from somewhere in the first to somewhere in the last.
#[derive(Debug, Clone)]
struct Errand {
    channels: Vec<AxisBox<2>>,
    start: Vector<2>,
    goal: Vector<2>,
    /// Its extent each way, metres.
    size: f64,
    gap: f64,
    walls: Walls<2>,
}

impl Errand {
    fn needs(&self) -> f64 {
        self.size + self.gap
    }

    fn robot(&self) -> RobotMover {
        let needs = Vector::repeat(self.needs());
        RobotMover::new(self.start, self.goal, needs, (self.size, self.gap))
    }

    /// The length of the drive through these channels, all walls considered.
    fn length_along(
        &self,
        route: &[usize],
        path: &mut driving::DrivingPath,
    ) -> Result<f64, Refused> {
        let channels: Vec<_> = route.iter().map(|index| self.channels[*index]).collect();
        self.length_within(&channels, (self.size, self.gap), &self.walls, path)
    }

    /// Whether the centre's path leads from channel to channel through their junctions,
    /// looked at point by point, not just touching them.
    fn stays_in(&self, route: &[usize], path: &driving::DrivingPath) -> bool {
        let channels: Vec<_> = route.iter().map(|index| self.channels[*index]).collect();
        let junctions: Vec<_> = channels
            .windows(2)
            .map(|pair| {
                let junction = pair[0].intersection(&pair[1]).expect("a junction");
                let inset = Vector::repeat(1e-3);
                AxisBox::new(junction.min() + inset, junction.max() - inset).expect("a box")
            })
            .collect();
        // By the length of the guiding circles' radius from every wall, where it turns.
        let radius = self.size / 2.0 + self.gap - 1e-9;
        let walls: Vec<_> = self.walls.as_slice().iter().map(Wall::bounds).collect();
        let clear = |point: &Vector<2>| {
            let ends = (point, point);
            let far = |wall: &(Vector<2>, Vector<2>)| {
                distance_squared_box_box((&wall.0, &wall.1), ends) >= radius * radius
            };
            walls.iter().all(far)
        };
        // In which channels it can be there.
        let mut can_be = vec![false; channels.len()];
        can_be[0] = true;
        for point in path.legs().iter().flat_map(|leg| points(&leg.curve)) {
            if !clear(&point) {
                return false;
            }
            for index in 0..channels.len() {
                let comes = index > 0 && can_be[index - 1] && junctions[index - 1].holds(&point);
                can_be[index] = (can_be[index] || comes) && channels[index].holds(&point);
            }
        }
        can_be[channels.len() - 1]
    }

    fn length_within(
        &self,
        channels: &[AxisBox<2>],
        (size, gap): (f64, f64),
        walls: &Walls<2>,
        path: &mut driving::DrivingPath,
    ) -> Result<f64, Refused> {
        let (mut chain, mut corners) = (Chain::default(), Vec::new());
        chain
            .build(channels, &self.start, End::Goal(self.goal), &Budget::default())
            .map_err(|_| Refused::Chain)?;
        corners_of(&chain, &mut corners);
        let task = Drive {
            footprint: Footprint::new(size, size).expect("a footprint"),
            start: Pose { position: self.start, heading: 0.0 },
            goal: Goal { position: self.goal, heading: None },
            start_turn: StartTurn::InPlace,
            first: channels[0],
            last: channels[channels.len() - 1],
            corners: &corners,
            walls,
        };
        driving::drive(&task, CornerGaps::Uniform(gap), path, &Budget::default())
            .map_err(Refused::Drive)?;
        Ok(path.length())
    }

    /// The route found and its length, and whether one was blocked before.
    fn find(&self) -> (Result<(Vec<usize>, f64), RouteError>, bool) {
        let mut blocked = false;
        let (mut graph, mut router) = (Graph::default(), Router::default());
        graph.build(&self.channels, &Budget::default()).expect("few junctions");
        let mut path = driving::DrivingPath::default();
        let (walls, mut robot) = (Some(&self.walls), self.robot());
        let found = router.find_judged(
            &graph,
            walls,
            &mut robot,
            &Budget::default(),
            |route, _| match self.length_along(route, &mut path) {
                Ok(length) => Ok(Judgement::Accepted { length, value: route.to_vec() }),
                Err(Refused::Drive(error)) => {
                    blocked = true;
                    Judgement::of_refusal(&error, path.legs())
                }
                Err(Refused::Chain) => panic!("{route:?} makes no chain"),
            },
        );
        let found = found.map(|accepted| {
            assert_eq!(router.route(), accepted, "what was made of another route is returned");
            (accepted, router.length())
        });
        (found, blocked)
    }

    /// The least length over all ways of up to `most` channels that do not go straight
    /// back, and over those of them that stay in their channels.
    fn brute_force(&self, most: usize) -> (f64, f64) {
        let holds = |index: &usize, point: &Vector<2>| self.channels[*index].holds(point);
        let passable = |a: usize, b: usize| {
            a != b
                && self.channels[a].intersection(&self.channels[b]).is_some_and(|junction| {
                    junction.size().iter().all(|extent| *extent > self.needs())
                })
        };
        let mut path = driving::DrivingPath::default();
        let mut least = (f64::INFINITY, f64::INFINITY);
        let all = 0..self.channels.len();
        let starts = all.clone().filter(|index| holds(index, &self.start));
        let mut routes: Vec<Vec<usize>> = starts.map(|index| vec![index]).collect();
        while let Some(route) = routes.pop() {
            let last = route[route.len() - 1];
            if holds(&last, &self.goal)
                && let Ok(length) = self.length_along(&route, &mut path)
            {
                least.0 = least.0.min(length);
                if length < least.1 && self.stays_in(&route, &path) {
                    least.1 = length;
                }
            }
            if route.len() == most {
                continue;
            }
            for next in all.clone() {
                let back = route.len() > 1 && route[route.len() - 2] == next;
                if passable(last, next) && !back {
                    routes.push(route.iter().copied().chain([next]).collect());
                }
            }
        }
        least
    }
}

/// Points on a curve, one in 5 mm.
fn points(curve: &Curve<2>) -> Vec<Vector<2>> {
    let count = 2 + (curve.length() / 0.005) as usize;
    (0..=count)
        .map(|index| {
            let part = index as f64 / count as f64;
            match curve {
                Curve::Line { from, to, .. } => from + (to - from) * part,
                Curve::Arc { center, radius, start_angle, sweep, .. } => {
                    center + unit(start_angle + sweep * part) * *radius
                }
                Curve::Clothoid { .. } => PlacedClothoid::of(curve).unwrap().at(part),
                Curve::Turn { position, .. } => *position,
            }
        })
        .collect()
}

enum Refused {
    Chain,
    Drive(DrivingError),
}

fn check_shortest(errand: &Errand, most: usize) {
    let (least, within) = errand.brute_force(most);
    let (found, blocked) = errand.find();
    match found {
        Ok((route, length)) => {
            let mut path = driving::DrivingPath::default();
            let along = errand.length_along(&route, &mut path).ok();
            assert_eq!(along, Some(length), "{route:?}");
            // What is known to block a line may rule out more than it must.
            assert!(blocked || length <= within + 1e-9, "{route:?}: {length} > {within}");
            if route.len() <= most {
                assert!(length >= least - 1e-9, "{route:?}: {length} < {least}");
            }
        }
        Err(error) => assert!(blocked || within.is_infinite(), "{error}, but {within}"),
    }
}

/// A floor with blocks on it, all of its maximal channels, and a robot that is to go from
/// one place to another.
fn errands() -> impl Strategy<Value = Errand> {
    let place = || proptest::array::uniform2(0.05..0.95f64);
    let block = (place(), proptest::array::uniform2(0.5..4.0f64));
    let blocks = proptest::collection::vec(block, 1..6);
    (blocks, place(), place(), 0.2..0.8f64, 0.05..0.5f64).prop_filter_map(
        "a place in a channel",
        |(blocks, start, goal, size, gap)| {
            let bounds = space([0.0; 2], [12.0; 2]);
            let mut solids = Solids::default();
            let mut walls = Walls::default();
            for (place, size) in blocks {
                let min = Vector::from(place) * 12.0;
                let block = AxisBox::new(min, min + Vector::from(size)).expect("a box");
                walls.push_box(&block);
                solids.push_box(block, &Budget::default()).unwrap();
            }
            walls.push_inside(&bounds);
            let mut channels = Vec::new();
            let room = Vector::repeat(size);
            solids.channels(&bounds, &room, &Budget::default(), &mut channels).expect("few");
            let (start, goal) = (Vector::from(start) * 12.0, Vector::from(goal) * 12.0);
            let holds = |point| channels.iter().any(|channel| channel.holds(point));
            let inside = holds(&start) && holds(&goal);
            inside.then_some(Errand { channels, start, goal, size, gap, walls })
        },
    )
}

/// Blocks of half a metre, four metres apart and a little out of line.
fn pillars(side: usize) -> Errand {
    let width = 4.0 * side as f64 + 2.0;
    let bounds = space([0.0; 2], [width; 2]);
    let (mut solids, mut walls) = (Solids::default(), Walls::default());
    for index in 0..side * side {
        let (i, j) = (index / side, index % side);
        let x = 4.0 * i as f64 + 2.0 + 0.13 * ((i * 7 + j * 3) % 5) as f64;
        let y = 4.0 * j as f64 + 2.0 + 0.11 * ((i * 5 + j * 11) % 7) as f64;
        let pillar = space([x, y], [x + 0.5, y + 0.5]);
        walls.push_box(&pillar);
        solids.push_box(pillar, &Budget::default()).unwrap();
    }
    walls.push_inside(&bounds);
    walls.index(&Budget::default()).unwrap();
    let mut channels = Vec::new();
    let room = Vector::repeat(0.6);
    solids.channels(&bounds, &room, &Budget::default(), &mut channels).expect("channels");
    let (start, goal) = ([1.0, 1.0].into(), [width - 1.2, width - 1.0].into());
    Errand { channels, start, goal, size: 0.6, gap: 0.2, walls }
}

#[test]
fn way_through_pillars_is_hardly_longer_than_the_shortest() {
    // By a graph of all tangents between the pillars' corners.
    for (side, shortest) in [(5, 28.451787695406345), (10, 56.70280686501991)] {
        let (_, length) = pillars(side).find().0.expect("a route");
        assert!(length > shortest - 1e-9, "{length} < {shortest}");
        assert!(length < shortest * 1.002, "{length} > {shortest}");
    }
}

#[test]
fn worked_corridors_are_put_in_order() {
    // A and B of docs/method.md 7, their channels in another order; lengths at gap 0.2.
    let check = |channels: &[([f64; 2], [f64; 2])], start: [f64; 2], goal: [f64; 2]| {
        let order: Vec<_> = channels.iter().map(|(min, max)| space(*min, *max)).collect();
        let mut walls = Walls::default();
        walls.set_complement(&order, None, &mut Complement::default(), &Budget::default()).unwrap();
        let channels: Vec<_> = order.iter().rev().copied().collect();
        let (start, goal) = (start.into(), goal.into());
        let errand = Errand { channels, start, goal, size: 1.0, gap: 0.2, walls };
        let (route, length) = errand.find().0.expect("a route");
        let backwards: Vec<_> = (0..order.len()).rev().collect();
        assert_eq!(route, backwards);
        let mut path = driving::DrivingPath::default();
        assert_eq!(errand.length_along(&backwards, &mut path).ok(), Some(length));
    };
    check(
        &[
            ([0., 0.], [3., 11.]),
            ([0., 8.], [13., 11.]),
            ([9., 8.], [13., 20.]),
            ([9., 16.], [22., 20.]),
        ],
        [1.2, 1.5],
        [20.5, 18.25],
    );
    check(
        &[
            ([0., 0.], [3., 14.]),
            ([0., 10.5], [8., 14.]),
            ([4.5, 2.], [8., 14.]),
            ([4.5, 2.], [14., 5.]),
            ([10., 2.], [14., 16.]),
            ([10., 12.], [22., 16.]),
        ],
        [1.25, 1.5],
        [20.5, 14.5],
    );
}

#[test]
fn robot_that_can_not_turn_round_goes_round_the_block() {
    // It stands in a street 1.05 m wide, 1.13 m from corner to corner, its goal behind it.
    let channels = vec![
        space([0., 0.], [20., 1.05]),
        space([0., 0.], [3., 9.]),
        space([17., 0.], [20., 9.]),
        space([0., 6.], [20., 9.]),
    ];
    let mut walls = Walls::default();
    walls.set_complement(&channels, None, &mut Complement::default(), &Budget::default()).unwrap();
    let (start, goal) = ([8.0, 0.5].into(), [1.5, 4.0].into());
    let errand = Errand { channels, start, goal, size: 0.8, gap: 0.05, walls };
    let ((route, _), blocked) = (errand.find().0.expect("a route"), errand.find().1);
    assert!(blocked);
    assert_eq!(route, [0, 2, 3, 1]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn no_drive_is_shorter(errand in errands()) {
        check_shortest(&errand, 5);
    }
}
