//! Clearance where only channels are given: beyond the mouth the last channel's own strip is free,
//! and nothing else. Compared with the distance to every cell of a grid that is not free.

use answer::{Caps, reply_to};
use proptest::prelude::*;
use schemas::json::read_scene;
use schemas::message::{Curve, Request, RequestContent, RequestKey, Trajectory};

type Sides = [[f64; 2]; 2];

/// Section 4's male part in a cavity that is higher than its mouth: channels up, across and up.
fn plan(channels: &[Sides], in_order: bool, body: Sides, gap: f64) -> Option<Trajectory> {
    let sides = |[min, max]: Sides| format!(r#"{{"min": {min:?}, "max": {max:?}}}"#);
    let text = format!(
        r#"{{"task": "disassemble", "free_space": {{"in_order": {in_order}, "channels": [{}]}},
            "body": {{"box": {}}}, "clearance": {{"gap": {gap}}}, "sampling": {{"count": 2}}}}"#,
        channels.iter().copied().map(sides).collect::<Vec<_>>().join(", "),
        sides(body)
    );
    let content = RequestContent::Scene(read_scene(&text).unwrap());
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    reply_to(&request, &Caps::default()).answers.ok()?.remove(0).ok()
}

/// Farther out than anything is measured.
const FAR: f64 = 1e3;

/// All cells between the sides of channels and strip that are not free.
fn solid_cells(channels: &[Sides], last: Sides) -> Vec<Sides> {
    let [[left, _], [right, top]] = last;
    let strip = [[left, top], [right, FAR]];
    let free: Vec<_> = channels.iter().copied().chain([strip]).collect();
    let ends = |axis: usize| {
        let mut ends: Vec<_> = free.iter().flatten().map(|corner| corner[axis]).collect();
        ends.extend([-FAR, FAR]);
        ends.sort_by(f64::total_cmp);
        ends
    };
    let (xs, zs) = (ends(0), ends(1));
    let mut cells = Vec::new();
    for x in xs.windows(2).filter(|x| x[0] < x[1]) {
        for z in zs.windows(2).filter(|z| z[0] < z[1]) {
            let middle = [0.5 * (x[0] + x[1]), 0.5 * (z[0] + z[1])];
            let holds = |[min, max]: &Sides| {
                (0..2).all(|axis| min[axis] < middle[axis] && middle[axis] < max[axis])
            };
            if !free.iter().any(holds) {
                cells.push([[x[0], z[0]], [x[1], z[1]]]);
            }
        }
    }
    cells
}

/// The distance from a body, displaced, to a cell.
fn distance(body: Sides, by: [f64; 2], cell: Sides) -> f64 {
    let apart = |axis: usize| {
        let before = cell[0][axis] - (body[1][axis] + by[axis]);
        before.max(body[0][axis] + by[axis] - cell[1][axis]).max(0.0)
    };
    apart(0).hypot(apart(1))
}

/// The least distance over the legs. On a line it is a convex function of the place, so a ternary
/// search finds it.
fn least_distance(found: &Trajectory, body: Sides, cells: &[Sides]) -> f64 {
    let mut least = f64::INFINITY;
    for leg in &found.legs {
        let Curve::Line { from, to, .. } = &leg.curve else { panic!("{leg:?}") };
        let (from, to) = (from.as_slice(), to.as_slice());
        for cell in cells {
            let at = |part: f64| {
                let by = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
                distance(body, by, *cell)
            };
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..100 {
                let third = (high - low) / 3.0;
                if at(low + third) <= at(high - third) {
                    high -= third;
                } else {
                    low += third;
                }
            }
            least = least.min(at(0.0)).min(at(1.0)).min(at(0.5 * (low + high)));
        }
    }
    least
}

#[track_caller]
fn check(channels: &[Sides], in_order: bool, body: Sides, gap: f64) -> Option<f64> {
    let found = plan(channels, in_order, body, gap)?;
    let last = channels[*found.route.last().unwrap() as usize];
    let expected = least_distance(&found, body, &solid_cells(channels, last));
    let value = found.clearance.value;
    assert!((value - expected).abs() < 1e-9, "{value} for {expected}: {channels:?}, {body:?}");
    Some(value)
}

/// The body stands 0.01 m from a wall that goes on above the mouth.
#[test]
fn wall_above_the_mouth_is_a_wall() {
    let channels = [[[0.0, 0.0], [3.0, 10.0]], [[0.0, 0.0], [9.0, 3.0]], [[6.0, 0.0], [9.0, 5.0]]];
    let value = check(&channels, true, [[1.99, 8.0], [2.99, 9.0]], 0.5).unwrap();
    assert!((value - 0.01).abs() < 1e-12, "{value}");
}

/// A channel beside the last that ends at the same height is closed there.
#[test]
fn other_channels_have_no_mouth() {
    let channels = [[[0.0, 0.0], [3.0, 5.0]], [[0.0, 0.0], [9.0, 3.0]], [[6.0, 0.0], [9.0, 5.0]]];
    let value = check(&channels, true, [[1.0, 3.5], [2.0, 4.9]], 0.5).unwrap();
    assert!((value - 0.1).abs() < 1e-12, "{value}");
}

/// Channels up and across by turns, so wide that a body of 1 m x 1 m has room, the last one up.
fn chains() -> impl Strategy<Value = (Vec<Sides>, Sides)> {
    let turn = (any::<bool>(), 1.5..4.0_f64, 0.0..6.0_f64);
    let place = (0.0..1.0_f64, 0.0..1.0_f64);
    (1..4_usize, proptest::collection::vec(turn, 7), place).prop_map(|(turns, steps, place)| {
        let mut channels = vec![];
        let [_, first_width, first_length] = [0.0, steps[0].1, steps[0].2 + 4.5];
        let mut last = [[0.0, 0.0], [first_width, first_length]];
        channels.push(last);
        for (at, (positive, width, length)) in steps.into_iter().skip(1).take(2 * turns).enumerate()
        {
            let [[left, low], [right, high]] = last;
            let length = length + 1.5;
            last = if at % 2 == 0 {
                // Across, at the lower or the upper end of the last one, or somewhere between.
                let z = low + place.0 * (high - low - width).max(0.0);
                let ends = if positive { [left, right + length] } else { [left - length, right] };
                [[ends[0], z], [ends[1], z + width]]
            } else {
                let x = if positive { right - width } else { left };
                let down = if place.1 < 0.5 { 0.0 } else { length };
                [[x, low - down], [x + width, high + length]]
            };
            channels.push(last);
        }
        let [min, max] = channels[0];
        let corner = [0, 1].map(|axis| {
            let room = max[axis] - min[axis] - 1.0;
            min[axis] + [place.0, place.1][axis] * room
        });
        (channels, [corner, corner.map(|c| c + 1.0)])
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn clearance_is_exact((channels, body) in chains(), gap in 0.01..0.3_f64, in_order: bool) {
        check(&channels, in_order, body, gap);
    }
}

/// The scenes above are mostly answered, and many have walls beyond their mouths.
#[test]
fn random_chains_are_answered() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;

    let mut runner = TestRunner::deterministic();
    let scenes = || chains().new_tree(&mut runner).unwrap().current();
    let scenes: Vec<_> = std::iter::repeat_with(scenes).take(300).collect();
    let answered =
        scenes.iter().filter(|(channels, body)| check(channels, true, *body, 0.1).is_some());
    let higher = |channels: &Vec<Sides>| {
        let top = channels.last().unwrap()[1][1];
        channels.iter().any(|channel| channel[1][1] > top)
    };
    assert!(answered.count() > 150);
    assert!(scenes.iter().filter(|(channels, _)| higher(channels)).count() > 30);
}
