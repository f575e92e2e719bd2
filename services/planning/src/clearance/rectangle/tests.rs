//! Facts about the exact clearance, and a dense recheck that shares no code with it.

use crate::budget::{Allowance, Budget};
use std::f64::consts::{FRAC_PI_2, PI};

use proptest::prelude::*;

use super::{
    Footprint, Met, TURNING_WHILE_MOVING_BOUND, clearance_rectangle_curve,
    clearance_rectangle_pose, nearest,
};
use crate::clearance::clothoid::{PRECISION, PlacedClothoid};
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::Vector;
use crate::geometry::number::Number;
use crate::motion::Curve;
use crate::motion::tests::clothoid;

pub(super) fn point(x: f64, y: f64) -> Vector<2> {
    Vector::<2>::new(x, y)
}

pub(super) fn walls(segments: &[[f64; 4]]) -> Walls<2> {
    let mut walls = Walls::default();
    for &[ax, ay, bx, by] in segments {
        walls.push(Wall { from: point(ax, ay), to: point(bx, by) });
    }
    walls
}

/// Pose after a part of a curve, by trigonometry.
pub(crate) fn pose(curve: &Curve<2>, part: f64) -> (f64, f64, f64) {
    match *curve {
        Curve::Line { from, to, heading, turned } => (
            from.x + (to.x - from.x) * part,
            from.y + (to.y - from.y) * part,
            heading - turned * (1.0 - part),
        ),
        Curve::Arc { center, radius, start_angle, sweep, reverse } => {
            let angle = start_angle + sweep * part;
            let tangent = angle + FRAC_PI_2.copysign(sweep);
            (
                center.x + radius * libm::cos(angle),
                center.y + radius * libm::sin(angle),
                if reverse { tangent + PI } else { tangent },
            )
        }
        Curve::Clothoid { from_heading, curvatures: [first, last], length, .. } => {
            let along = part * length;
            let turned = along * (first + 0.5 * (last - first) * part);
            let place = PlacedClothoid::of(curve).unwrap().at(part);
            (place.x, place.y, from_heading + turned)
        }
        Curve::Turn { position, from_heading, sweep } => {
            (position.x, position.y, from_heading + sweep * part)
        }
    }
}

type Point = (f64, f64);

fn point_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    let t = if square == 0.0 { 0.0 } else { ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square };
    let t = t.clamp(0.0, 1.0);
    let (x, y) = (p.0 - a.0 - t * dx, p.1 - a.1 - t * dy);
    (x * x + y * y).sqrt()
}

fn area(a: Point, b: Point, c: Point) -> f64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

fn segments_apart(a: Point, b: Point, c: Point, d: Point) -> f64 {
    let crossing = area(a, b, c) * area(a, b, d) < 0.0 && area(c, d, a) * area(c, d, b) < 0.0;
    if crossing {
        return 0.0;
    }
    point_to_segment(a, c, d)
        .min(point_to_segment(b, c, d))
        .min(point_to_segment(c, a, b))
        .min(point_to_segment(d, a, b))
}

/// Distance of the footprint at a pose to all walls, by its outline.
pub(crate) fn outline_distance(
    footprint: &Footprint,
    (x, y, heading): (f64, f64, f64),
    walls: &Walls<2>,
) -> f64 {
    let (front, rear, b) = (footprint.front(), footprint.rear(), footprint.width() / 2.0);
    let (sin, cos) = (libm::sin(heading), libm::cos(heading));
    let corner =
        |ahead: f64, left: f64| (x + ahead * cos - left * sin, y + ahead * sin + left * cos);
    let outline = [corner(front, b), corner(-rear, b), corner(-rear, -b), corner(front, -b)];
    let reach = libm::hypot(front.max(rear), b);
    let mut least = f64::INFINITY;
    for wall in walls.as_slice() {
        let (from, to) = ((wall.from.x, wall.from.y), (wall.to.x, wall.to.y));
        if point_to_segment((x, y), from, to) - reach > least {
            continue;
        }
        let mut inside = true;
        for side in 0..4 {
            let (p, q) = (outline[side], outline[(side + 1) % 4]);
            least = least.min(segments_apart(p, q, from, to));
            inside &= area(p, q, from) >= 0.0;
        }
        if inside {
            least = 0.0;
        }
    }
    least
}

/// Compares with `samples` placements, and with the best of them refined. The
/// body's distance changes by no more than its displacement.
pub(crate) fn check_densely(
    footprint: &Footprint,
    curve: &Curve<2>,
    walls: &Walls<2>,
    samples: usize,
    value: f64,
) {
    let distance = |part: f64| outline_distance(footprint, pose(curve, part), walls);
    let (mut least, mut at) = (f64::INFINITY, 0.0);
    for index in 0..=samples {
        let part = index as f64 / samples as f64;
        if distance(part) < least {
            (least, at) = (distance(part), part);
        }
    }
    let reach = libm::hypot(footprint.front().max(footprint.rear()), footprint.width() / 2.0);
    let displacement = match *curve {
        Curve::Line { turned, .. } => curve.length() + reach * turned.abs(),
        Curve::Arc { sweep, .. } => curve.length() + reach * sweep.abs(),
        Curve::Clothoid { curvatures, length, .. } => {
            length * (1.0 + reach * curvatures[0].abs().max(curvatures[1].abs()))
        }
        Curve::Turn { sweep, .. } => reach * sweep.abs(),
    };
    let step = 1.0 / samples as f64;
    assert!(value >= least - displacement * step / 2.0 - 1e-9, "{value} is below {least}");
    let (mut low, mut high) = ((at - step).max(0.0), (at + step).min(1.0));
    for _ in 0..45 {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if distance(left) <= distance(right) {
            high = right;
        } else {
            low = left;
        }
    }
    least = least.min(distance((low + high) / 2.0));
    assert!(value <= least + 1.1e-9, "{value} is above {least}, met after {low} of {curve:?}");
}

/// The exact value against the dense recheck; the place must hold the value.
fn check_curve(footprint: &Footprint, curve: &Curve<2>, walls: &Walls<2>) -> Met {
    let met = nearest(footprint, curve, walls, 0.1, &Budget::default()).unwrap();
    for guess in [1e-9, 10.0, f64::INFINITY] {
        let other = nearest(footprint, curve, walls, guess, &Budget::default()).unwrap();
        let turns_while_moving = matches!(curve, Curve::Line { turned, .. } if *turned != 0.0);
        let bound = match curve {
            Curve::Clothoid { length, .. } => PRECISION * (length + footprint.swing_radius()),
            _ if turns_while_moving => TURNING_WHILE_MOVING_BOUND,
            _ => 0.0,
        };
        assert!((met.value - other.value).abs() <= bound, "the guess {guess} matters");
    }
    check_densely(footprint, curve, walls, 200, met.value);
    let (x, y, heading) = pose(curve, met.along);
    let mut place = Walls::default();
    place.push(Wall { from: met.wall, to: met.wall });
    let there = outline_distance(footprint, (x, y, heading), &place);
    assert!((there - met.value).abs() < 2e-9, "{} at the place, not {}", there, met.value);
    met
}

/// The bound of the error can't be met where coordinates are farther apart than that.
#[test]
fn turning_while_moving_ends_at_any_size() {
    for (size, offset) in
        [(1e-9, 0.0), (1.0, 1e6), (1.0, 1e9), (1.0, 1e12), (1e6, 0.0), (1e12, 1e15), (1e100, 0.0)]
    {
        let footprint = Footprint::new(size, 1.5 * size).unwrap();
        let at = |x: f64, y: f64| point(offset + x * size, offset + y * size);
        let mut walls = Walls::default();
        walls.push(Wall { from: at(-9.0, 1.5), to: at(20.0, 2.5) });
        walls.push(Wall { from: at(5.0, -2.0), to: at(5.5, -1.25) });
        let curve =
            Curve::Line { from: at(0.0, 0.0), to: at(10.0, 0.5), heading: 0.05, turned: 3.0 };
        let budget = Budget::new(Allowance { steps: 1_000_000, ..Allowance::NONE });
        let near = clearance_rectangle_curve(&footprint, &curve, &walls, &budget);
        let value = near.map(|near| near.map_or(f64::INFINITY, |near| near.value / size));
        assert!(
            value.is_ok_and(|value| (0.0..2.0).contains(&value)),
            "{size}, {offset}: {value:?}"
        );
    }
}

pub(super) fn footprints() -> impl Strategy<Value = Footprint> {
    let centred =
        (0.1..2.0, 0.1..3.0).prop_map(|(width, length)| Footprint::new(width, length).unwrap());
    let reach = || prop_oneof![1 => Just(0.0), 4 => 0.05..2.0];
    let offset = (0.1..2.0, reach(), reach())
        .prop_filter("a length", |(_, front, rear)| front + rear > 0.0)
        .prop_map(|(width, front, rear)| Footprint::offset(width, front, rear).unwrap());
    prop_oneof![centred, offset]
}

pub(super) fn scenes() -> impl Strategy<Value = Walls<2>> {
    let free = (-4.0..4.0, -4.0..4.0, -3.0..3.0, -3.0..3.0)
        .prop_map(|(x, y, dx, dy)| [x, y, x + dx, y + dy]);
    let level = (-4.0..4.0, -4.0..4.0, -3.0..3.0).prop_map(|(x, y, dx)| [x, y, x + dx, y]);
    let dot = (-4.0..4.0, -4.0..4.0).prop_map(|(x, y)| [x, y, x, y]);
    prop::collection::vec(prop_oneof![3 => free, 2 => level, 1 => dot], 1..4)
        .prop_map(|segments| walls(&segments))
}

fn curves() -> impl Strategy<Value = Curve<2>> {
    let line = (-2.0..2.0, -2.0..2.0, -PI..PI, -4.0..4.0).prop_map(|(x, y, heading, length)| {
        let to = point(x + length * libm::cos(heading), y + length * libm::sin(heading));
        Curve::Line { from: point(x, y), to, heading, turned: 0.0 }
    });
    let moving = (-2.0..2.0, -2.0..2.0, -2.0..2.0, -2.0..2.0, -PI..PI, -PI..PI).prop_map(
        |(x, y, u, v, heading, turned)| Curve::Line {
            from: point(x, y),
            to: point(u, v),
            heading,
            turned,
        },
    );
    let arc = (-2.0..2.0, -2.0..2.0, 0.05..3.0, -PI..PI, -4.0..4.0, any::<bool>()).prop_map(
        |(x, y, radius, start_angle, sweep, reverse)| Curve::Arc {
            center: point(x, y),
            radius,
            start_angle,
            sweep,
            reverse,
        },
    );
    let turn = (-2.0..2.0, -2.0..2.0, -PI..PI, -PI..PI).prop_map(|(x, y, from_heading, sweep)| {
        Curve::Turn { position: point(x, y), from_heading, sweep }
    });
    prop_oneof![line, moving, arc, turn]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn exact_clearance_is_what_dense_placements_approach(
        footprint in footprints(),
        curve in curves(),
        walls in scenes(),
    ) {
        check_curve(&footprint, &curve, &walls);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn clearance_on_clothoids_is_what_dense_placements_approach(
        footprint in footprints(), walls in scenes(), (x, y) in (-1.5..1.5, -1.5..1.5),
        heading in -PI..PI, curvatures in prop::array::uniform2(-1.5..1.5_f64),
        length in 0.2..2.0_f64, reverse in any::<bool>(),
    ) {
        let curve = clothoid(point(x, y), heading, (curvatures, length), reverse);
        check_curve(&footprint, &curve, &walls);
    }
}

fn robot() -> Footprint {
    Footprint::new(1.0, 1.5).unwrap()
}

fn arc(center: Vector<2>, radius: f64, start_angle: f64, sweep: f64) -> Curve<2> {
    Curve::Arc { center, radius, start_angle, sweep, reverse: false }
}

#[test]
fn footprint_without_extent_is_rejected() {
    assert!(Footprint::new(0.0, 1.0).is_err());
    assert!(Footprint::new(1.0, -1.0).is_err());
    assert!(Footprint::new(f64::NAN, 1.0).is_err());
    assert!(Footprint::new(1.0, f64::INFINITY).is_err());
}

#[test]
fn no_walls_no_clearance() {
    let none = Walls::default();
    assert_eq!(
        clearance_rectangle_pose(&robot(), &point(0.0, 0.0), 1.0, &none, &Budget::default())
            .unwrap(),
        None
    );
    let turn = Curve::Turn { position: point(0.0, 0.0), from_heading: 0.0, sweep: 1.0 };
    assert_eq!(
        clearance_rectangle_curve(&robot(), &turn, &none, &Budget::default()).unwrap(),
        None
    );
}

#[test]
fn parallel_wall_is_met_where_it_begins() {
    let curve =
        Curve::Line { from: point(0.0, 0.0), to: point(10.0, 0.0), heading: 0.0, turned: 0.0 };
    let walls = walls(&[[9.0, 0.75, 4.0, 0.75]]);
    let clearance =
        clearance_rectangle_curve(&robot(), &curve, &walls, &Budget::default()).unwrap().unwrap();
    assert_eq!((clearance.value, clearance.at), (0.25, 3.25));
    assert_eq!(clearance.wall, point(4.0, 0.75));
}

#[test]
fn wall_across_a_line_is_touched_when_the_front_gets_there() {
    let curve =
        Curve::Line { from: point(0.0, 0.0), to: point(10.0, 0.0), heading: 0.0, turned: 0.0 };
    let walls = walls(&[[5.0, -3.0, 5.0, 3.0]]);
    let clearance =
        clearance_rectangle_curve(&robot(), &curve, &walls, &Budget::default()).unwrap().unwrap();
    assert_eq!((clearance.value, clearance.at), (0.0, 4.25));
}

#[test]
fn wall_through_the_body_is_contact_from_the_start() {
    // Neither end of the wall nor a corner of the body is near the other's outline.
    for curve in [
        Curve::Turn { position: point(0.0, 0.0), from_heading: 0.0, sweep: 0.1 },
        Curve::Line { from: point(0.0, 0.0), to: point(0.0, 0.0), heading: 0.0, turned: 0.1 },
    ] {
        let met = check_curve(&robot(), &curve, &walls(&[[0.1, -9.0, 0.2, 9.0]]));
        assert_eq!((met.value, met.along), (0.0, 0.0));
    }
}

#[test]
fn turn_in_place_is_closest_at_the_diagonal() {
    // r_b = sqrt(w^2 + h^2) / 2 where tan(beta) = h / w (docs/method.md 5.3).
    let curve = Curve::Turn { position: point(0.0, 0.0), from_heading: 0.0, sweep: FRAC_PI_2 };
    let met = check_curve(&robot(), &curve, &walls(&[[-5.0, 2.0, 5.0, 2.0]]));
    assert!((met.value - (2.0 - libm::hypot(0.5, 0.75))).abs() < 1e-15);
    let beta = FRAC_PI_2 - libm::atan2(0.5, 0.75);
    assert!((met.along - beta / FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn turn_into_a_wall_stops_at_first_contact() {
    // The corner (0.75, 0.5) reaches y = 0.8 where |corner| sin(phi) = 0.8.
    let curve = Curve::Turn { position: point(0.0, 0.0), from_heading: 0.0, sweep: FRAC_PI_2 };
    let met = check_curve(&robot(), &curve, &walls(&[[-5.0, 0.8, 5.0, 0.8]]));
    let angle = libm::asin(0.8 / libm::hypot(0.5, 0.75)) - libm::atan2(0.5, 0.75);
    assert_eq!(met.value, 0.0);
    assert!((met.along - angle / FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn corner_of_the_guiding_circle_is_the_gap_away_all_along() {
    let curve = arc(point(3.0, 8.0), 1.1, PI, -FRAC_PI_2);
    let met = check_curve(&robot(), &curve, &walls(&[[3.0, 0.0, 3.0, 8.0], [3.0, 8.0, 9.0, 8.0]]));
    assert!((met.value - 0.6).abs() < 1e-15);
    assert_eq!(met.along, 0.0);
}

#[test]
fn outer_wall_is_approached_on_the_outer_circle() {
    // W - R(gap) (docs/method.md 6.2).
    let curve = arc(point(0.0, 0.0), 1.5, PI, -FRAC_PI_2);
    let met = check_curve(&robot(), &curve, &walls(&[[-3.0, -9.0, -3.0, 3.0]]));
    assert!((met.value - (3.0 - libm::hypot(2.0, 0.75))).abs() < 1e-15);
}

/// 1 m wide, reaching 1.2 m ahead of its reference point and 0.3 m behind it.
fn car() -> Footprint {
    Footprint::offset(1.0, 1.2, 0.3).unwrap()
}

#[test]
fn reference_point_off_the_middle_is_within_the_rectangle() {
    assert_eq!((car().length(), car().front(), car().rear()), (1.5, 1.2, 0.3));
    assert_eq!(car().swing_radius(), libm::hypot(1.2, 0.5));
    assert_eq!(Footprint::offset(1.0, 0.75, 0.75), Ok(robot()));
    for [width, front, rear] in [
        [0.0, 1.0, 1.0],
        [1.0, -0.1, 1.0],
        [1.0, 1.0, -0.1],
        [1.0, 0.0, 0.0],
        [1.0, f64::NAN, 1.0],
        [1.0, f64::MAX, f64::MAX],
    ] {
        let error = Footprint::offset(width, front, rear).unwrap_err();
        assert!(error.to_string().contains(&format!("front {} m", Number(front))), "{error}");
    }
}

#[test]
fn turn_about_an_axle_is_closest_at_each_corner_in_turn() {
    let curve = Curve::Turn { position: point(0.0, 0.0), from_heading: 0.0, sweep: FRAC_PI_2 };
    let met = check_curve(&car(), &curve, &walls(&[[-5.0, 2.0, 5.0, 2.0]]));
    assert!((met.value - (2.0 - libm::hypot(1.2, 0.5))).abs() < 1e-15);
    assert!((met.along - (1.0 - libm::atan2(0.5, 1.2) / FRAC_PI_2)).abs() < 1e-12);
    // The right rear corner passes below.
    let met = check_curve(&car(), &curve, &walls(&[[-5.0, -2.0, 5.0, -2.0]]));
    assert!((met.value - (2.0 - libm::hypot(0.3, 0.5))).abs() < 1e-15);
    assert!((met.along - libm::atan2(0.3, 0.5) / FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn tail_swings_to_the_wall_behind_and_front_to_the_wall_ahead() {
    // A right turn about the origin, from heading up to heading right.
    let (left, top) = ([-3.0, -9.0, -3.0, 9.0], [-9.0, 3.0, 9.0, 3.0]);
    let forwards = arc(point(0.0, 0.0), 1.5, PI, -FRAC_PI_2);
    let Curve::Arc { center, radius, start_angle, sweep, .. } = forwards else { unreachable!() };
    let backwards = Curve::Arc { center, radius, start_angle, sweep, reverse: true };
    for (curve, behind, ahead) in [(forwards, 0.3, 1.2), (backwards, 1.2, 0.3)] {
        let met = check_curve(&car(), &curve, &walls(&[left]));
        assert!((met.value - (3.0 - libm::hypot(2.0, behind))).abs() < 1e-15, "{met:?}");
        let met = check_curve(&car(), &curve, &walls(&[top]));
        assert!((met.value - (3.0 - libm::hypot(2.0, ahead))).abs() < 1e-15, "{met:?}");
    }
}

#[test]
fn line_backwards_is_met_by_the_rear() {
    let curve =
        Curve::Line { from: point(0.0, 0.0), to: point(-10.0, 0.0), heading: 0.0, turned: 0.0 };
    let met = check_curve(&car(), &curve, &walls(&[[-5.0, -3.0, -5.0, 3.0]]));
    assert!(met.value == 0.0 && (met.along - 0.47).abs() < 1e-15, "{met:?}");
    // A wall beside the way is met where it begins.
    let met = check_curve(&car(), &curve, &walls(&[[-4.0, 0.75, -9.0, 0.75]]));
    assert_eq!((met.value, met.along, met.wall), (0.25, 0.37, point(-4.0, 0.75)));
}

#[test]
fn corner_in_the_centre_of_the_turn_stays() {
    // The left rear corner is the centre: the body sweeps what is ahead of it.
    let footprint = Footprint::offset(1.0, 1.0, 0.0).unwrap();
    let curve = arc(point(0.0, 0.0), 0.5, 0.0, FRAC_PI_2);
    let met = check_curve(&footprint, &curve, &walls(&[[-0.1, -0.1, -0.1, -0.1]]));
    assert!((met.value - 0.1).abs() < 1e-15);
    let met = check_curve(&footprint, &curve, &walls(&[[0.3, -0.2, 0.3, -0.2]]));
    assert!((met.value - 0.2).abs() < 1e-15);
}
