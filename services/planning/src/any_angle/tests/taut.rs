//! The taut path of a disc against a visibility graph of all its tangents.

use std::f64::consts::TAU;

use proptest::prelude::*;

use super::scene::{Room, floor, rooms};
use crate::any_angle::disc::{Disc, distance_to};
use crate::any_angle::taut::{TautPath, TautSearch, TurnRadii};
use crate::budget::Budget;
use crate::driving::tangent::{Circle, Tangent, tangent};
use crate::free_space::walls::Walls;
use crate::geometry::distance::distance_segment_segment;
use crate::geometry::{AxisBox, Vector, unit};

/// The least length of a path of a disc, by Dijkstra's search over all tangents of all circles
/// about all ends of walls, each checked against all walls.
fn shortest(walls: &Walls<2>, radius: f64, start: Vector<2>, goal: Vector<2>) -> Option<f64> {
    const TOLERANCE: f64 = 1e-10;
    let walls = walls.as_slice();
    let mut centers: Vec<Vector<2>> = walls.iter().flat_map(|wall| [wall.from, wall.to]).collect();
    centers.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    centers.dedup();
    let mut circles = vec![
        Circle { center: start, signed_radius: 0.0 },
        Circle { center: goal, signed_radius: 0.0 },
    ];
    for center in centers {
        for sense in [1.0, -1.0] {
            circles.push(Circle { center, signed_radius: sense * radius });
        }
    }
    let is_clear = |from: &Vector<2>, to: &Vector<2>| {
        walls.iter().all(|wall| {
            let near = distance_segment_segment((from, to), (&wall.from, &wall.to));
            near.distance >= radius - TOLERANCE
        })
    };
    struct Line {
        from: usize,
        to: usize,
        line: Tangent,
    }
    let mut lines = Vec::new();
    for (from, one) in circles.iter().enumerate() {
        for (to, other) in circles.iter().enumerate() {
            if from != to
                && from != 1
                && to != 0
                && let Some(line) = tangent(one, other)
                && is_clear(&line.from, &line.to)
            {
                lines.push(Line { from, to, line });
            }
        }
    }
    let mut lengths: Vec<f64> = lines
        .iter()
        .map(|line| if line.from == 0 { line.line.length } else { f64::INFINITY })
        .collect();
    let mut done = vec![false; lines.len()];
    loop {
        let next = (0..lines.len())
            .filter(|index| !done[*index] && lengths[*index].is_finite())
            .min_by(|a, b| lengths[*a].total_cmp(&lengths[*b]))?;
        done[next] = true;
        let Line { to, line, .. } = &lines[next];
        if *to == 1 {
            return Some(lengths[next]);
        }
        let circle = &circles[*to];
        let sense = circle.signed_radius.signum();
        for (index, other) in lines.iter().enumerate() {
            if other.from != *to || done[index] {
                continue;
            }
            let angle = |way: &Vector<2>| libm::atan2(way.y, way.x);
            let begin = angle(&line.direction);
            let sweep = sense * (angle(&other.line.direction) - begin);
            let sweep = if sweep < -1e-9 { sweep + TAU } else { sweep.max(0.0) };
            let length = lengths[next] + radius * sweep + other.line.length;
            if length >= lengths[index] {
                continue;
            }
            let steps = (sweep * 64.0).ceil() as usize;
            let is_free = (0..=steps).all(|step| {
                let heading = begin + sense * sweep * step as f64 / steps.max(1) as f64;
                let normal = unit(heading + sense * std::f64::consts::FRAC_PI_2);
                let at = circle.center - normal * radius;
                // The steps leave out what is a little nearer between them.
                walls.iter().all(|wall| distance_to(wall, &at) >= radius - TOLERANCE)
            });
            if is_free {
                lengths[index] = length;
            }
        }
    }
}

fn find(walls: &Walls<2>, radius: f64, start: Vector<2>, goal: Vector<2>) -> Option<TautPath> {
    let floor = floor(walls);
    let budget = Budget::default();
    let disc = Disc::new(radius, [start, goal], (walls, floor.rounding()), &budget).unwrap();
    let mut search = TautSearch::default();
    search.find(&floor, &disc, TurnRadii::DISC, &budget).unwrap()
}

fn points() -> impl Strategy<Value = [[f64; 2]; 2]> {
    prop::array::uniform2(prop::array::uniform2(0.3..9.7f64))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn taut_path_is_the_shortest(room in rooms(), ends in points(), radius in 0.02..0.6f64) {
        let [start, goal] = ends.map(Vector::from);
        prop_assume!(!room.is_taken(&start, radius) && !room.is_taken(&goal, radius));
        let walls = room.walls(|point| point);
        let found = find(&walls, radius, start, goal).map(|path| path.length);
        let expected = shortest(&walls, radius, start, goal);
        match (found, expected) {
            (Some(found), Some(expected)) => {
                prop_assert!((found - expected).abs() <= 1e-7, "{found} {expected}");
            }
            (None, None) => {}
            _ => prop_assert!(false, "{found:?} {expected:?}"),
        }
    }

    /// A scene that is turned and moved has a path as long.
    #[test]
    fn turned_and_moved_scenes_have_the_same_length(
        room in rooms(),
        ends in points(),
        radius in 0.02..0.6f64,
        turn in -3.0..3.0f64,
        far in prop_oneof![Just(0.0), Just(1e6)],
        scale in prop_oneof![Just(1.0), Just(1e3), Just(1e-3)],
    ) {
        let [start, goal] = ends.map(Vector::from);
        prop_assume!(!room.is_taken(&start, radius + 1e-6) && !room.is_taken(&goal, radius + 1e-6));
        let (sin, cos) = libm::sincos(turn);
        let place = |point: Vector<2>| {
            let turned = [cos * point.x - sin * point.y + far, sin * point.x + cos * point.y - far];
            Vector::from(turned) * scale
        };
        let length = |room: &Room, place: &dyn Fn(Vector<2>) -> Vector<2>, scale: f64| {
            let path = find(&room.walls(place), radius * scale, place(start), place(goal));
            path.map(|path| path.length / scale)
        };
        let plain = length(&room, &|point| point, 1.0);
        let placed = length(&room, &place, scale);
        match (plain, placed) {
            (Some(plain), Some(placed)) => {
                prop_assert!((plain - placed).abs() <= 1e-8, "{plain} {placed}");
            }
            (None, None) => {}
            _ => prop_assert!(false, "{plain:?} {placed:?}"),
        }
    }
}

/// SplitMix64.
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn part(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, most: f64) -> f64 {
        (self.part() * most).floor()
    }
}

/// A square of `side` cells with random blocks two cells wide, and two places in it where a disc
/// of this radius is free.
fn blocks(side: f64, radius: f64, random: &mut Random) -> Option<(Walls<2>, [Vector<2>; 2])> {
    let mut walls = Walls::default();
    let mut push = |x: f64, y: f64, size: f64| {
        let (min, max) = (Vector::from([x, y]), Vector::from([x + size, y + size]));
        walls.push_box(&AxisBox::new(min, max).expect("a box"));
    };
    push(0.0, 0.0, side);
    for _ in 0..4 + random.below(side * side / 9.0) as usize {
        push(random.below(side - 1.0), random.below(side - 1.0), 2.0);
    }
    walls.index(&Budget::default()).expect("no limits");
    let mut place = || {
        let at = Vector::from([random.part(), random.part()]) * side;
        let is_inside = walls.as_slice().chunks(4).skip(1).any(|block| {
            let [low, high] = [block[0].from, block[0].from.add_scalar(2.0)];
            low.x < at.x && at.x < high.x && low.y < at.y && at.y < high.y
        });
        let is_free = walls.as_slice().iter().all(|wall| distance_to(wall, &at) > radius);
        (is_free && !is_inside).then_some(at)
    };
    let ends = [place()?, place()?];
    Some((walls, ends))
}

#[test]
fn pockets_hide_no_path() {
    let mut random = Random(7);
    let (mut with, mut without) = (TautSearch::default(), TautSearch::default());
    with.turns_before_pockets = Some(1);
    without.turns_before_pockets = Some(u32::MAX);
    let (mut found, mut turns) = (0, 0);
    for _ in 0..4_000 {
        let radius = random.part() * 0.9 + 0.1;
        let Some((walls, ends)) = blocks(12.0 + random.below(28.0), radius, &mut random) else {
            continue;
        };
        let budget = Budget::default();
        let floor = floor(&walls);
        let disc = Disc::new(radius, ends, (&walls, floor.rounding()), &budget).unwrap();
        let [one, other] = [&mut with, &mut without].map(|search| {
            search.forget();
            search.find(&floor, &disc, TurnRadii::DISC, &budget).unwrap()
        });
        let length = |path: &Option<TautPath>| path.as_ref().map(|path| path.length);
        assert_eq!(length(&one), length(&other), "{ends:?}, {radius} m");
        found += usize::from(one.is_some());
        turns += one.map_or(0, |path| path.turns.len());
    }
    assert!(found > 300 && turns > 1_000, "{found} paths with {turns} turns");
}
