//! The two corridors that stand in for figure 8, digit by digit.

use super::scene::{Scene, corridor_a, corridor_b};
use crate::budget::Budget;
use crate::driving::{CornerGaps, DrivingPath, drive, safest};
use crate::motion::Curve;

/// `worked-corridors.txt` was computed by an independent program and checked
/// against 50 digits; its corners count down to J1.
const WORKED: &str = include_str!("worked-corridors.txt");

fn close(value: f64, wanted: f64) {
    let off = (value - wanted).abs() / wanted.abs().max(1.0);
    assert!(off <= 1e-12, "{value} should be {wanted}");
}

/// The numbers after `name=`: one, or two in parentheses.
fn numbers(text: &str, name: &str) -> Vec<f64> {
    let mark = format!("{name}=");
    let rest = &text[text.find(&mark).unwrap_or_else(|| panic!("{name} in {text}")) + mark.len()..];
    match rest.strip_prefix('(') {
        Some(pair) => pair.split(')').next().unwrap().split(',').map(parse).collect(),
        None => vec![parse(rest.split_whitespace().next().unwrap())],
    }
}

fn parse(text: &str) -> f64 {
    text.trim().parse().unwrap()
}

fn number(text: &str, name: &str) -> f64 {
    numbers(text, name)[0]
}

fn check_block(block: &str) {
    let (head, rows) = block.split_once('\n').unwrap();
    let scene = if head.starts_with('A') { corridor_a() } else { corridor_b() };
    let gap = number(head, "gap");
    let mut path = DrivingPath::default();
    drive(&scene.drive(), CornerGaps::Uniform(gap), &mut path, &Budget::default()).unwrap();

    close(path.length(), number(head, "total"));
    let lengths: Vec<_> = path.legs().iter().map(|leg| leg.curve.length()).collect();
    close(*lengths.last().unwrap(), number(head, "last line"));
    let (overall, turning) = (path.clearance().unwrap(), path.turning().unwrap());
    let within =
        |value: f64, wanted: f64| assert!((value - wanted).abs() <= 1e-9, "{value} {wanted}");
    within(overall.value, number(head, "overall"));
    within(turning.value, number(head, "turning"));

    let rows: Vec<_> = rows.lines().collect();
    assert_eq!(rows.len(), 2 * scene.corners.len());
    for (corner, row) in rows.chunks(2).map(|lines| lines.join(" ")).enumerate() {
        check_corner(&scene, &path, corner, gap, &row);
    }
}

fn check_corner(scene: &Scene, path: &DrivingPath, corner: usize, gap: f64, row: &str) {
    let place = &scene.corners[corner];
    let rule = place.rule;
    assert!(row.contains(&format!(" R{} ", rule.number)), "rule {} in {row}", rule.number);
    assert_eq!(rule.turn.factor(), number(row, " s"));
    assert_eq!(place.point.as_slice(), numbers(row, " p"));

    let of_corner = |leg: &&crate::motion::Leg<2>| leg.junction == Some(corner);
    let legs: Vec<_> = path.legs().iter().filter(of_corner).collect();
    assert!(legs.iter().all(|leg| leg.rule == Some(rule.name())));
    let [line, arc] = legs.as_slice() else { panic!("{legs:?}") };
    close(line.curve.length(), number(row, "line_in"));
    close(arc.curve.length(), number(row, "arc"));
    let Curve::Arc { center, radius, start_angle, sweep, .. } = arc.curve else {
        panic!("{arc:?}")
    };
    close(radius, gap + 0.5);
    close(sweep, rule.turn.factor() * number(row, "sweep"));
    for (name, angle) in [("ma", start_angle), ("ml", start_angle + sweep)] {
        let wanted = numbers(row, name);
        close(center.x + radius * libm::cos(angle), wanted[0]);
        close(center.y + radius * libm::sin(angle), wanted[1]);
    }
    // The angles of table 2 at the arriving and the leaving point.
    let Curve::Line { from, to, heading, .. } = line.curve else { panic!("{line:?}") };
    let wanted = numbers(row, "ma");
    close(to.x, wanted[0]);
    close(to.y, wanted[1]);
    let arriving = rule.arriving_angle(&from, &place.point, radius);
    close(arriving, number(row, "Ta"));
    let (sin, cos) = libm::sincos(heading);
    close(libm::sin(number(row, "Ta")), rule.leave.coordinate(&super::scene::point(cos, sin)));
    close(std::f64::consts::FRAC_PI_2 - arriving - sweep.abs(), number(row, "Tl"));
}

#[test]
fn worked_corridors_come_out_to_the_last_digits() {
    let blocks: Vec<_> = WORKED.trim().split("\n\n").collect();
    assert_eq!(blocks.len(), 8);
    for block in blocks {
        check_block(block);
    }
}

#[test]
fn three_metre_corridors_are_safest_with_119_128ths() {
    for scene in [corridor_a(), corridor_b()] {
        let mut path = DrivingPath::default();
        assert_eq!(safest(&scene.drive(), &mut path, &Budget::default()), Ok(119.0 / 128.0));
        let turning = path.turning().unwrap().value;
        assert!((turning - 119.0 / 128.0).abs() < 1e-12, "{turning}");
    }
}

#[test]
fn rules_of_the_worked_corridors() {
    let numbers = |scene: Scene| -> Vec<u8> {
        scene.corners.iter().map(|corner| corner.rule.number).collect()
    };
    assert_eq!(numbers(corridor_a()), [1, 5, 1]);
    assert_eq!(numbers(corridor_b()), [1, 7, 2, 5, 1]);
}

#[test]
fn clearance_is_met_first_where_the_front_passes_the_corner() {
    // The gap is left from half a length before the first arriving point on
    // (docs/method.md 6.1), and equally at every corner after.
    let scene = corridor_a();
    let mut path = DrivingPath::default();
    drive(&scene.drive(), CornerGaps::Uniform(0.2), &mut path, &Budget::default()).unwrap();
    let clearance = path.clearance().unwrap();
    close(clearance.at, 45.0_f64.sqrt() - 0.75);
    assert!((clearance.wall - scene.corners[0].point).amax() < 1e-12);
}
