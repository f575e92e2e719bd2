use super::*;
use crate::free_space::End;
use crate::free_space::random::{Scene, scenes};
use crate::geometry::Direction;
use crate::motion::Rule;
use crate::section_4::{CHANNELS, MALE};
use proptest::prelude::*;

mod optimum;
mod shortest;

const PLUS_Z: Direction = Direction { axis: 1, sign: Sign::Positive };

fn space<const D: usize>(min: [f64; D], max: [f64; D]) -> AxisBox<D> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

/// Section 4 of the paper.
fn section_4() -> Scene<2> {
    Scene {
        channels: CHANNELS.map(|[min, max]| space(min, max)).to_vec(),
        body: space(MALE[0], MALE[1]),
        exit: PLUS_Z,
    }
}

fn plan<const D: usize>(
    scene: &Scene<D>,
    gap: Gap<'_, D>,
) -> Result<(Chain<D>, DisassemblyPath<D>), DisassemblyError> {
    let (mut chain, mut path) = (Chain::default(), DisassemblyPath::default());
    chain
        .build(&scene.channels, &scene.body.center(), End::Exit(scene.exit), &Budget::default())
        .expect("a chain");
    disassemble(&chain, &scene.body, gap, &mut path, &Budget::default())?;
    Ok((chain, path))
}

fn way_points<const D: usize>(path: &DisassemblyPath<D>) -> Vec<Vector<D>> {
    let ends = path.legs().iter().map(|leg| match leg.curve {
        Curve::Line { from, to, heading: 0.0, turned: 0.0 } => (from, to),
        other => panic!("{other:?} is no translation"),
    });
    let ends: Vec<_> = ends.collect();
    for pair in ends.windows(2) {
        assert_eq!(pair[0].1, pair[1].0, "legs join");
    }
    ends.iter().map(|(from, _)| *from).chain(ends.last().map(|(_, to)| *to)).collect()
}

fn rules<const D: usize>(path: &DisassemblyPath<D>) -> Vec<Option<(u8, u8)>> {
    path.legs().iter().map(|leg| leg.rule.map(|rule| (rule.table, rule.number))).collect()
}

/// Way-points of m1 and the total length, from docs/method.md 4.
#[track_caller]
fn check_section_4(gap: Gap<'_, 2>, m1: [[f64; 2]; 4], length: f64) {
    let (_, path) = plan(&section_4(), gap).expect("a path");
    for (found, known) in way_points(&path).iter().zip(m1) {
        let known = Vector::from(known) - Vector::from([4.5, 1.01]);
        assert!((found - known).amax() < 2e-15, "{found} is not {known}");
    }
    assert!((path.length() - length).abs() < 2e-15, "{:?}", path.length());
    assert_eq!(rules(&path), [Some((1, 1)), Some((1, 3)), None]);
    let junctions: Vec<_> = path.legs().iter().map(|leg| leg.junction).collect();
    assert_eq!(junctions, [Some(0), Some(1), None]);
}

#[test]
fn section_4_at_three_gaps() {
    let near = [[4.5, 1.01], [4.01, 2.01], [2.5, 3.0], [2.5, 7.0]];
    check_section_4(Gap::Uniform(0.01), near, 6.919200165541185);
    let middle = [[4.5, 1.01], [4.2, 2.2], [2.31, 2.81], [2.31, 7.0]];
    check_section_4(Gap::Uniform(0.2), middle, 7.40323366632768);
    let safest = [[4.5, 1.01], [4.255, 2.505], [1.755, 2.505], [1.755, 7.0]];
    check_section_4(Gap::Safest, safest, 8.50994224312348);
    check_section_4(Gap::Fraction(1.0), safest, 8.50994224312348);
}

#[test]
fn section_4_has_the_limits_of_3_1() {
    let (_, path) = plan(&section_4(), Gap::Safest).expect("a path");
    let known = [[0.255, 0.505], [0.755, 0.505]];
    for (limit, known) in path.limits().iter().zip(known) {
        assert!((limit - Vector::from(known)).amax() < 2e-16);
    }
    assert_eq!(path.gaps(), path.limits());
}

#[test]
fn forms_of_the_gap_agree() {
    let scene = section_4();
    let legs = |gap| plan(&scene, gap).expect("a path").1.legs().to_vec();
    let each = [Vector::from([0.1, 0.2]), Vector::from([0.1, 0.2])];
    assert_eq!(legs(Gap::PerAxis(each[0])), legs(Gap::PerJunction(&each)));
    let same = [Vector::repeat(0.2), Vector::repeat(0.2)];
    assert_eq!(legs(Gap::Uniform(0.2)), legs(Gap::PerJunction(&same)));
    let (_, half) = plan(&scene, Gap::Fraction(0.5)).expect("a path");
    for (gap, limit) in half.gaps().iter().zip(half.limits()) {
        assert_eq!(*gap, limit / 2.0);
    }
    assert_eq!(legs(Gap::Fraction(0.5)), legs(Gap::PerJunction(half.gaps())));
}

#[test]
fn assembly_is_the_exact_reverse() {
    let (_, path) = plan(&section_4(), Gap::Uniform(0.2)).expect("a path");
    let mut back = path.clone();
    back.reverse();
    let mut points = way_points(&path);
    points.reverse();
    assert_eq!(way_points(&back), points);
    assert_eq!(rules(&back), [None, Some((1, 3)), Some((1, 1))]);
    assert_eq!((back.gaps(), back.length()), (path.gaps(), path.length()));
    back.reverse();
    assert_eq!(back.legs(), path.legs());
}

#[test]
fn path_ends_with_the_body_at_the_mouth() {
    let (chain, path) = plan(&section_4(), Gap::Uniform(0.2)).expect("a path");
    let end = way_points(&path)[3];
    assert_eq!(section_4().body.min()[1] + end[1], chain.mouth().expect("a mouth").bound);
}

#[test]
fn one_channel_needs_only_the_exit() {
    let scene = Scene { channels: vec![space([4., 1.], [7., 6.])], ..section_4() };
    let (_, path) = plan(&scene, Gap::Uniform(0.2)).expect("a path");
    assert_eq!(way_points(&path), [Vector::<2>::zeros(), Vector::from([0.0, 6.0 - 1.01])]);
    assert_eq!(rules(&path), [None]);
}

/// Mirrors the point in x (bit 0) and z (bit 1), and swaps its axes (bit 2).
fn turned(point: Vector<2>, version: u8) -> Vector<2> {
    let x = if version & 1 == 0 { point[0] } else { -point[0] };
    let z = if version & 2 == 0 { point[1] } else { -point[1] };
    if version & 4 == 0 { Vector::from([x, z]) } else { Vector::from([z, x]) }
}

fn turned_box(space: &AxisBox<2>, version: u8) -> AxisBox<2> {
    let (a, b) = (turned(space.min(), version), turned(space.max(), version));
    AxisBox::new(a.inf(&b), a.sup(&b)).expect("a box")
}

fn turned_scene(scene: &Scene<2>, version: u8) -> Scene<2> {
    let mirrored = version >> scene.exit.axis & 1 == 1;
    let sign = if mirrored { scene.exit.sign.opposite() } else { scene.exit.sign };
    let axis = if version & 4 == 0 { scene.exit.axis } else { 1 - scene.exit.axis };
    Scene {
        channels: scene.channels.iter().map(|channel| turned_box(channel, version)).collect(),
        body: turned_box(&scene.body, version),
        exit: Direction { axis, sign },
    }
}

/// The rule of an L in one of its eight versions; its path is turned with it.
#[track_caller]
fn check_l_turn(version: u8, rule: u8) {
    // Up, then right: rule 2.
    let upright = Scene {
        channels: vec![space([0., 0.], [3., 8.]), space([0., 5.], [9., 8.])],
        body: space([0.5, 0.25], [1.75, 2.0]),
        exit: Direction { axis: 0, sign: Sign::Positive },
    };
    let (_, path) = plan(&upright, Gap::Uniform(0.25)).expect("a path");
    let (_, other) = plan(&turned_scene(&upright, version), Gap::Uniform(0.25)).expect("a path");
    assert_eq!(rules(&other), [Some((1, rule)), None]);
    let expected: Vec<_> = way_points(&path).iter().map(|point| turned(*point, version)).collect();
    assert_eq!(way_points(&other), expected);
    assert_eq!(other.length(), path.length());
}

#[test]
fn all_eight_rules_in_the_eight_versions_of_an_l() {
    check_l_turn(0b001, 1); // up, left
    check_l_turn(0b000, 2); // up, right
    check_l_turn(0b110, 3); // left, up
    check_l_turn(0b100, 4); // right, up: swapped
    check_l_turn(0b011, 5); // down, left
    check_l_turn(0b010, 6); // down, right
    check_l_turn(0b111, 7); // left, down
    check_l_turn(0b101, 8); // right, down
}

/// The law behind table 1: margins on the entering side along the approach and
/// on the leaving side along the other axis, all 24 combinations of D axes.
fn check_table<const D: usize>(rules: u8) {
    let mut numbers = Vec::new();
    let signs = [Sign::Negative, Sign::Positive];
    for (a, b) in (0..D).flat_map(|a| (0..D).map(move |b| (a, b))).filter(|(a, b)| a != b) {
        for (s_in, s_out) in signs.into_iter().flat_map(|s| signs.map(|t| (s, t))) {
            let approach = Direction { axis: a, sign: s_in };
            let leaving = Direction { axis: b, sign: s_out };
            let turn = turn_in::<D>(approach, leaving);
            let margins = [turn.horizontal, turn.vertical];
            let on = |axis| margins.iter().find(|(of, _)| *of == axis).expect("in the plane").1;
            let entering = if s_in == Sign::Positive { Margin::Least } else { Margin::Greatest };
            let out = if s_out == Sign::Positive { Margin::Greatest } else { Margin::Least };
            assert_eq!((on(a), on(b)), (entering, out), "{:?}", turn.rule);
            assert_eq!(turn.rule.table, 1);
            numbers.push(turn.rule.number);
        }
    }
    numbers.sort_unstable();
    assert_eq!(numbers, (1..=rules).collect::<Vec<_>>());
}

#[test]
fn table_1_has_one_rule_for_every_turn() {
    check_table::<2>(8);
    check_table::<3>(24);
}

#[test]
fn planes_of_three_dimensions_number_their_rules_alike() {
    let number = |a, b| {
        let up = |axis| Direction { axis, sign: Sign::Positive };
        turn_in::<3>(up(a), up(b)).rule
    };
    // Rule 2 is "up, then right", rule 4 "right, then up".
    let rules =
        [number(2, 0), number(0, 2), number(2, 1), number(1, 2), number(1, 0), number(0, 1)];
    assert_eq!(rules.map(|rule| rule.number), [2, 4, 10, 12, 18, 20]);
    assert_eq!(rules[0], Rule { table: 1, number: 2 });
}

/// Up, then along x; wide and idle along y.
fn three_dimensional() -> Scene<3> {
    Scene {
        channels: vec![space([0., 0., 0.], [3., 6., 8.]), space([0., 2., 5.], [9., 6., 8.])],
        body: space([1., 0.5, 1.], [2., 1.5, 2.]),
        exit: Direction { axis: 0, sign: Sign::Positive },
    }
}

#[test]
fn idle_axis_is_held_and_clamped() {
    let scene = three_dimensional();
    let (_, path) = plan(&scene, Gap::Uniform(0.25)).expect("a path");
    // y: from 0.5 up to 2 + 0.25, the least that is safe in the junction.
    let known = [[0., 0., 0.], [0.75, 1.75, 4.25], [8.0, 1.75, 4.25]];
    assert_eq!(way_points(&path), known.map(Vector::from));
    let inside = Scene { body: space([1., 4.5, 1.], [2., 5.5, 2.]), ..scene };
    let (_, path) = plan(&inside, Gap::Uniform(0.25)).expect("a path");
    assert_eq!(way_points(&path)[1], Vector::from([0.75, 0.0, 4.25]));
}

#[test]
fn safest_centers_the_idle_axis_too() {
    let (_, path) = plan(&three_dimensional(), Gap::Safest).expect("a path");
    assert_eq!(way_points(&path)[1], Vector::from([0.0, 3.0, 5.0]));
    assert_eq!(path.gaps(), [Vector::from([1.0, 1.5, 1.0])]);
}

#[track_caller]
fn check_error<const D: usize>(scene: &Scene<D>, gap: Gap<'_, D>, error: DisassemblyError) {
    assert_eq!(plan(scene, gap).map(|_| ()), Err(error));
}

#[track_caller]
fn check_gap_rejected(gap: f64) {
    let most = (3.0 - (6.99 - 4.5)) / 2.0;
    let error = DisassemblyError::GapOutOfRange { junction: 0, axis: 0, gap, least: 0.0, most };
    check_error(&section_4(), Gap::Uniform(gap), error);
}

#[test]
fn closed_gap_is_rejected() {
    check_gap_rejected(0.0);
    check_gap_rejected(-0.1);
}

#[test]
fn gap_at_or_above_the_limit_is_rejected() {
    check_gap_rejected((3.0 - (6.99 - 4.5)) / 2.0);
    check_gap_rejected(0.255);
    check_gap_rejected(0.3);
    check_gap_rejected(f64::INFINITY);
}

#[test]
fn gap_that_is_no_number_is_rejected() {
    let error = plan(&section_4(), Gap::Uniform(f64::NAN)).map(|_| ()).unwrap_err();
    assert!(matches!(error, DisassemblyError::GapOutOfRange { junction: 0, axis: 0, .. }));
}

#[test]
fn gap_must_fit_on_the_idle_axis() {
    let low = Scene {
        channels: vec![space([0., 0., 0.], [3., 2., 8.]), space([0., 0., 5.], [9., 2., 8.])],
        ..three_dimensional()
    };
    let error =
        DisassemblyError::GapOutOfRange { junction: 0, axis: 1, gap: 0.5, least: 0.0, most: 0.5 };
    check_error(&low, Gap::Uniform(0.5), error);
}

#[test]
fn gap_is_checked_in_every_junction() {
    let gaps = [Vector::from([0.1, 0.1]), Vector::from([0.1, 0.75])];
    let most = (4.0 - (4.0 - 1.01)) / 2.0;
    let error =
        DisassemblyError::GapOutOfRange { junction: 1, axis: 1, gap: 0.75, least: 0.0, most };
    check_error(&section_4(), Gap::PerJunction(&gaps), error);
}

#[test]
fn wrong_number_of_gaps_is_rejected() {
    let error = DisassemblyError::WrongNumberOfGaps { has: 1, needs: 2 };
    check_error(&section_4(), Gap::PerJunction(&[Vector::repeat(0.1)]), error);
}

#[test]
fn fraction_outside_its_range_is_rejected() {
    for fraction in [0.0, -1.0, 1.5] {
        let error = DisassemblyError::FractionOutOfRange { fraction, least: 0.0, most: 1.0 };
        check_error(&section_4(), Gap::Fraction(fraction), error);
    }
}

#[test]
fn body_as_wide_as_a_junction_is_rejected() {
    let wide = Scene { body: space([4., 1.], [7., 4.]), ..section_4() };
    let error = DisassemblyError::JunctionTooSmall { junction: 0, axis: 0, needs: 3.0, has: 3.0 };
    check_error(&wide, Gap::Uniform(0.01), error);
    let high = Scene { body: space([4.5, 1.0], [6.99, 5.25]), ..section_4() };
    let error = DisassemblyError::JunctionTooSmall { junction: 0, axis: 1, needs: 4.25, has: 4.0 };
    check_error(&high, Gap::Uniform(0.01), error);
    assert_eq!(
        error.to_string(),
        "junction 0 is 4 m wide along coordinate 1, the body needs more than 4.25 m"
    );
}

#[test]
fn body_outside_the_first_channel_is_rejected() {
    let left = Scene { body: space([3.5, 1.5], [6., 4.]), ..section_4() };
    let error = DisassemblyError::BodyOutside { axis: 0, body: 3.5, channel: 4.0 };
    check_error(&left, Gap::Uniform(0.01), error);
    let high = Scene { body: space([4.5, 3.5], [6., 6.5]), ..section_4() };
    let error = DisassemblyError::BodyOutside { axis: 1, body: 6.5, channel: 6.0 };
    check_error(&high, Gap::Uniform(0.01), error);
}

#[test]
fn contact_with_the_first_channel_is_accepted() {
    let resting = Scene { body: space([4.5, 1.0], [7.0, 4.0]), ..section_4() };
    assert!(plan(&resting, Gap::Uniform(0.01)).is_ok());
}

#[test]
fn unbuilt_chain_is_rejected() {
    let mut path = DisassemblyPath::default();
    let body = section_4().body;
    let found = disassemble(&Chain::default(), &body, Gap::Safest, &mut path, &Budget::default());
    assert_eq!(found, Err(DisassemblyError::NoChannels));
}

/// In every junction the body keeps its gaps, and no more than the limit allows.
fn check_margins<const D: usize>(scene: &Scene<D>, fraction: f64) {
    let (chain, path) = plan(scene, Gap::Fraction(fraction)).expect("a path");
    let points = way_points(&path);
    assert_eq!(points.len(), chain.junctions().len() + 2);
    assert_eq!(points[0], Vector::<D>::zeros());
    for ((junction, gap), point) in chain.junctions().iter().zip(path.gaps()).zip(&points[1..]) {
        let body = scene.body.translated(point);
        let least = body.min() - junction.space.min();
        let greatest = junction.space.max() - body.max();
        for axis in 0..D {
            let margin = least[axis].min(greatest[axis]);
            assert!(margin > gap[axis] - 1e-12, "{margin} is less than {}", gap[axis]);
        }
        // Towards the corner that the taut string turns round, exactly the gap.
        let hugged = match junction.approach.sign {
            Sign::Positive => least,
            Sign::Negative => greatest,
        };
        let axis = junction.approach.axis;
        assert!((hugged[axis] - gap[axis]).abs() < 1e-12);
    }
    let (exit, body) = (scene.exit, scene.body);
    let end = points[points.len() - 1] - points[points.len() - 2];
    assert!(exit.coordinate(&end) > 0.0);
    assert_eq!(end.norm(), exit.coordinate(&end), "a pure exit motion");
    let last = body.translated(&points[points.len() - 1]);
    let side = exit.coordinate(&last.min()).min(exit.coordinate(&last.max()));
    let mouth = exit.sign.factor() * chain.mouth().expect("a mouth").bound;
    assert!((side - mouth).abs() < 1e-12);
}

fn moved<const D: usize>(scene: &Scene<D>, by: &Vector<D>) -> Scene<D> {
    Scene {
        channels: scene.channels.iter().map(|channel| channel.translated(by)).collect(),
        body: scene.body.translated(by),
        exit: scene.exit,
    }
}

proptest! {
    #[test]
    fn margins_are_kept_in_two_dimensions(scene in scenes::<2>(12), fraction in 0.01..1.0f64) {
        check_margins(&scene, fraction);
    }

    #[test]
    fn margins_are_kept_in_three_dimensions(scene in scenes::<3>(12), fraction in 0.01..1.0f64) {
        check_margins(&scene, fraction);
    }

    #[test]
    fn turned_scene_has_the_turned_path(scene in scenes::<2>(8), version in 0..8u8) {
        let (_, path) = plan(&scene, Gap::Fraction(0.5)).expect("a path");
        let (_, other) = plan(&turned_scene(&scene, version), Gap::Fraction(0.5)).expect("a path");
        let expected: Vec<_> =
            way_points(&path).iter().map(|point| turned(*point, version)).collect();
        prop_assert_eq!(way_points(&other), expected);
    }

    #[test]
    fn moved_scene_has_the_same_path(scene in scenes::<3>(8)) {
        // A shift that rounds nothing of note.
        let shifted = moved(&scene, &Vector::from([16.0, -32.0, 8.0]));
        // The body's side may round out of a channel that it touches.
        prop_assume!(shifted.channels[0].contains(&shifted.body));
        let (_, path) = plan(&scene, Gap::Fraction(0.5)).expect("a path");
        let (_, other) = plan(&shifted, Gap::Fraction(0.5)).expect("a path");
        for (a, b) in way_points(&path).iter().zip(way_points(&other)) {
            prop_assert!((a - b).amax() < 1e-12);
        }
    }
}
