use super::*;
use crate::budget::Allowance;
use crate::section_4::{CHANNELS, FEMALE, MALE};
use proptest::prelude::*;

const UP: Direction = Direction { axis: 1, sign: Sign::Positive };

fn space<const D: usize>(min: [f64; D], max: [f64; D]) -> AxisBox<D> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

fn polygon(vertices: &[[f64; 2]]) -> Polygon {
    Polygon::new(vertices.iter().map(|vertex| Vector::from(*vertex)).collect(), &Budget::default())
        .expect("a polygon")
}

fn find<const D: usize>(
    solids: &mut Solids<D>,
    bounds: &AxisBox<D>,
    body: [f64; D],
) -> Vec<AxisBox<D>> {
    let mut channels = Vec::new();
    solids.channels(bounds, &body.into(), &Budget::default(), &mut channels).expect("within caps");
    channels
}

fn with_boxes<const D: usize>(boxes: &[AxisBox<D>]) -> Solids<D> {
    let mut solids = Solids::default();
    boxes.iter().for_each(|solid| solids.push_box(*solid, &Budget::default()).unwrap());
    solids
}

#[track_caller]
fn check<const D: usize>(
    boxes: &[AxisBox<D>],
    bounds: AxisBox<D>,
    body: [f64; D],
    expected: &[AxisBox<D>],
) {
    assert_eq!(find(&mut with_boxes(boxes), &bounds, body), expected);
}

#[test]
fn section_4_has_the_channels_of_the_paper() {
    let mut solids = Solids::default();
    solids.push_polygon(&polygon(&FEMALE), &Budget::default()).expect("a solid");
    let male = space(MALE[0], MALE[1]);
    let bounds = solids.cavity(&male, UP).expect("there is a solid");
    assert_eq!(bounds, space([0., 0.], [8., 7.]));
    let [c_3, c_2, c_1] = CHANNELS.map(|[min, max]| space(min, max));
    assert_eq!(find(&mut solids, &bounds, [2.49, 2.99]), [c_1, c_2, c_3]);
    // The fourth is too narrow for the male part.
    let fourth = space([4., 1.], [5., 7.]);
    assert_eq!(find(&mut solids, &bounds, [0.99, 2.99]), [c_1, c_2, fourth, c_3]);
}

#[test]
fn cavity_has_room_for_a_body_that_sticks_out() {
    let solids = with_boxes(&[space([0., 0.], [9., 5.])]);
    let check = |body, exit, cavity| assert_eq!(solids.cavity(&body, exit), Some(cavity));
    check(space([1., 1.], [2., 4.]), UP, space([0., 0.], [9., 5.]));
    check(space([1., 1.], [2., 6.]), UP, space([0., 0.], [9., 11.]));
    check(space([1., 1.], [2., 5.]), UP, space([0., 0.], [9., 9.]));
    let down = Direction { axis: 1, sign: Sign::Negative };
    check(space([1., -1.], [2., 5.]), down, space([0., -7.], [9., 5.]));
    assert_eq!(Solids::<2>::default().cavity(&space([1., 1.], [2., 4.]), UP), None);
}

#[test]
fn without_solids_all_is_one_channel() {
    check(&[], space([0., 0.], [9., 5.]), [1., 1.], &[space([0., 0.], [9., 5.])]);
    check(&[], space([0., 0.], [9., 5.]), [9., 1.], &[]);
}

#[test]
fn solid_outside_the_bounds_does_not_count() {
    let bounds = space([0., 0.], [9., 5.]);
    check(&[space([9., 0.], [12., 5.]), space([-3., -3.], [0., 9.])], bounds, [1., 1.], &[bounds]);
}

#[test]
fn solids_that_fill_everything_leave_no_channel() {
    let bounds = space([0., 0., 0.], [2., 2., 2.]);
    check(&[space([-1., -1., -1.], [3., 3., 1.]), bounds], bounds, [0.1; 3], &[]);
}

#[test]
fn island_has_a_channel_on_each_side() {
    let solid = space([3., 2.], [5., 4.]);
    let channels = [
        space([0., 0.], [3., 6.]),
        space([0., 0.], [8., 2.]),
        space([0., 4.], [8., 6.]),
        space([5., 0.], [8., 6.]),
    ];
    check(&[solid], space([0., 0.], [8., 6.]), [1., 1.], &channels);
    // Twice the same, and once more in parts that touch and overlap.
    let parts = [space([3., 2.], [4., 4.]), space([4., 2.], [5., 4.]), space([3.5, 2.], [5., 3.])];
    check(&[solid, solid], space([0., 0.], [8., 6.]), [1., 1.], &channels);
    check(&parts, space([0., 0.], [8., 6.]), [1., 1.], &channels);
    // Equality is not enough: the side ways are 2 m wide.
    check(&[solid], space([0., 0.], [8., 6.]), [2., 2.], &[channels[0], channels[3]]);
}

#[test]
fn hole_between_solids_is_a_channel() {
    let ring = [
        space([0., 0.], [9., 1.]),
        space([0., 8.], [9., 9.]),
        space([0., 0.], [1., 9.]),
        space([8., 0.], [9., 9.]),
    ];
    check(&ring, space([-1., -1.], [10., 10.]), [3., 3.], &[space([1., 1.], [8., 8.])]);
}

#[test]
fn deepest_solid_is_named() {
    let mut solids = Solids::default();
    solids.push_box(space([0., 0.], [1., 9.]), &Budget::default()).unwrap();
    // In two boxes, and still one solid.
    let corner = polygon(&[[0., 0.], [9., 0.], [9., 1.], [2., 1.], [2., 9.], [0., 9.]]);
    solids.push_polygon(&corner, &Budget::default()).expect("a solid");
    solids.push_box(space([6., 0.], [9., 9.]), &Budget::default()).unwrap();
    let check = |min: [f64; 2], max: [f64; 2], deepest| {
        assert_eq!(solids.deepest(&min.into(), &max.into()), deepest);
    };
    check([2.5, 2.0], [5.5, 4.0], None);
    // Contact is none.
    check([2.0, 1.0], [6.0, 4.0], None);
    check([1.75, 2.0], [5.5, 4.0], Some((1, 0, 0.25)));
    check([1.75, 2.0], [6.5, 4.0], Some((2, 0, 0.5)));
    check([2.5, 0.5], [4.0, 4.0], Some((1, 1, 0.5)));
    // A point.
    check([7.0, 5.0], [7.0, 5.0], Some((2, 0, 1.0)));
    check([5.0, 5.0], [5.0, 5.0], None);
}

#[test]
fn slanted_edge_is_refused() {
    let mut solids = Solids::default();
    let roof = polygon(&[[0., 0.], [8., 0.], [8., 1.], [4., 2.], [0., 1.]]);
    let error = solids.push_polygon(&roof, &Budget::default()).unwrap_err();
    let [from, to] = [[8., 1.], [4., 2.]].map(Vector::from);
    assert_eq!(error, SolidsError::Slanted { edge: 2, from, to });
    assert_eq!(error.to_string(), "edge 2 of the polygon, from (8, 1) to (4, 2), is slanted");
    assert_eq!(solids.boxes(), []);
}

#[test]
fn pieces_of_polygons_are_counted() {
    let corner = polygon(&[[0., 0.], [9., 0.], [9., 1.], [2., 1.], [2., 9.], [0., 9.]]);
    let few = Budget::new(Allowance { pieces: 2, ..Allowance::NONE });
    let result = Solids::default().push_polygon(&corner, &few);
    assert_eq!(result, Err(Spent::Limit { cap: Cap::Pieces, most: 2 }.into()));
}

#[test]
fn caps_are_kept() {
    let boxes: Vec<_> =
        (0..20).map(|i| space([2.0 * f64::from(i), 0.], [2.0 * f64::from(i) + 1.0, 1.])).collect();
    let bounds = space([-1., -1.], [40., 3.]);
    let check = |limits, cap, most| {
        let mut channels = vec![bounds];
        let budget = Budget::new(limits);
        let body = Vector::repeat(0.5);
        let result = with_boxes(&boxes).channels(&bounds, &body, &budget, &mut channels);
        assert_eq!((result, &channels[..]), (Err(Spent::Limit { cap, most }), &[][..]));
        // What was held is given back.
        assert_eq!(budget.drawn(Cap::Bytes), 0);
    };
    let none = Allowance::NONE;
    check(Allowance { pieces: 19, ..none }, Cap::Pieces, 19);
    check(Allowance { channels: 5, ..none }, Cap::Channels, 5);
    check(Allowance { channel_steps: 9, ..none }, Cap::ChannelSteps, 9);
    check(Allowance { steps: 300, ..none }, Cap::Steps, 300);
    check(Allowance { bytes: 4_000, ..none }, Cap::Bytes, 4_000);
}

/// Every box between grid lines, looked at one by one.
fn brute_force<const D: usize>(
    boxes: &[AxisBox<D>],
    bounds: &AxisBox<D>,
    body: &Vector<D>,
) -> Vec<AxisBox<D>> {
    let lines: [Vec<f64>; D] = std::array::from_fn(|axis| {
        let all = boxes.iter().chain([bounds]).flat_map(|b| [b.min()[axis], b.max()[axis]]);
        let (least, greatest) = (bounds.min()[axis], bounds.max()[axis]);
        let mut lines: Vec<f64> = all.filter(|at| (least..=greatest).contains(at)).collect();
        lines.sort_unstable_by(f64::total_cmp);
        lines.dedup();
        lines
    });
    let free = |part: &AxisBox<D>| boxes.iter().all(|solid| solid.intersection(part).is_none());
    let counts: [usize; D] = std::array::from_fn(|axis| lines[axis].len());
    let mut found = Vec::new();
    let total: usize = counts.iter().map(|count| count * count).product();
    for code in 0..total {
        let mut rest = code;
        let ends: [(usize, usize); D] = std::array::from_fn(|axis| {
            let low = rest % counts[axis];
            rest /= counts[axis];
            let high = rest % counts[axis];
            rest /= counts[axis];
            (low, high)
        });
        let part = |ends: &[(usize, usize); D]| {
            let min = Vector::from(std::array::from_fn(|axis| lines[axis][ends[axis].0]));
            let max = Vector::from(std::array::from_fn(|axis| lines[axis][ends[axis].1]));
            AxisBox::new(min, max).ok()
        };
        let Some(this) = part(&ends)
            .filter(|part| (0..D).all(|axis| part.size()[axis] > body[axis]) && free(part))
        else {
            continue;
        };
        let extends = (0..D).any(|axis| {
            let (mut less, mut more) = (ends, ends);
            less[axis].0 = less[axis].0.wrapping_sub(1);
            more[axis].1 += 1;
            (ends[axis].0 > 0 && part(&less).is_some_and(|part| free(&part)))
                || (more[axis].1 < counts[axis] && part(&more).is_some_and(|part| free(&part)))
        });
        if !extends {
            found.push(this);
        }
    }
    found
}

fn sorted<const D: usize>(mut boxes: Vec<AxisBox<D>>) -> Vec<AxisBox<D>> {
    let key =
        |b: &AxisBox<D>| -> Vec<f64> { b.min().iter().chain(b.max().iter()).copied().collect() };
    boxes.sort_by(|a, b| key(a).partial_cmp(&key(b)).expect("finite numbers"));
    boxes
}

/// Boxes on a coarse grid, so that they touch, overlap and repeat, partly out of bounds.
fn boxes<const D: usize>(most: usize, extent: i8) -> impl Strategy<Value = Vec<AxisBox<D>>> {
    let corner = proptest::array::uniform::<_, D>(-1..extent);
    let size = proptest::array::uniform::<_, D>(1..4i8);
    proptest::collection::vec((corner, size), 0..=most).prop_map(|boxes| {
        let make = |(corner, size): &([i8; D], [i8; D])| {
            let corner = Vector::from(corner.map(f64::from));
            AxisBox::new(corner, corner + Vector::from(size.map(f64::from))).expect("a box")
        };
        boxes.iter().map(make).collect()
    })
}

fn body<const D: usize>() -> impl Strategy<Value = [f64; D]> {
    proptest::array::uniform::<_, D>(prop_oneof![Just(0.5), Just(1.0), Just(1.5)])
}

/// The outline of a row of columns of various heights, on one line below, with some of the columns in two
/// parts of the same height.
fn skyline() -> impl Strategy<Value = Vec<[f64; 2]>> {
    proptest::collection::vec((1..4i8, 1..9i8), 1..9).prop_map(|columns| {
        let mut vertices = vec![[0.0, 0.0]];
        let mut x = 0.0;
        for (width, height) in columns {
            let (width, height) = (f64::from(width), f64::from(height));
            vertices.extend([[x, height], [x + width, height]]);
            x += width;
        }
        vertices.push([x, 0.0]);
        vertices.dedup();
        vertices
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn channels_are_those_of_brute_force_in_two_dimensions(boxes in boxes::<2>(14, 9), body in body()) {
        let bounds = space([0., 0.], [9., 9.]);
        let expected = sorted(brute_force(&boxes, &bounds, &body.into()));
        prop_assert_eq!(find(&mut with_boxes(&boxes), &bounds, body), expected);
    }

    #[test]
    fn order_of_solids_does_not_matter(boxes in boxes::<3>(20, 9), body in body()) {
        let bounds = space([0.; 3], [9.; 3]);
        let forwards = find(&mut with_boxes(&boxes), &bounds, body);
        let reversed: Vec<_> = boxes.iter().rev().copied().collect();
        prop_assert_eq!(find(&mut with_boxes(&reversed), &bounds, body), forwards);
    }

    #[test]
    fn polygon_is_the_union_of_its_boxes_which_do_not_overlap(
        vertices in skyline(),
        points in proptest::collection::vec((0.0..30.0f64, 0.0..9.0f64), 40),
        (turned, backwards) in any::<(bool, bool)>(),
    ) {
        // Upright, or lying on its side.
        let place = |[x, z]: [f64; 2]| Vector::from(if turned { [z, x] } else { [x, z] });
        let mut corners: Vec<_> = vertices.iter().copied().map(place).collect();
        if backwards {
            corners.reverse();
        }
        let polygon = Polygon::new(corners, &Budget::default()).expect("simple");
        let mut solids = Solids::default();
        solids.push_polygon(&polygon, &Budget::default()).expect("a solid");
        for (x, z) in points {
            let point = place([x, z]);
            let covered = solids.boxes().iter().any(|solid| {
                (0..2).all(|i| solid.min()[i] <= point[i] && point[i] <= solid.max()[i])
            });
            prop_assert_eq!(covered, polygon.contains(&point), "{:?}", point);
        }
        let shoelace: f64 = vertices
            .iter()
            .zip(vertices.iter().cycle().skip(1))
            .map(|(a, b)| (b[0] - a[0]) * (a[1] + b[1]) / 2.0)
            .sum();
        let area: f64 = solids.boxes().iter().map(|solid| solid.size().product()).sum();
        prop_assert_eq!(area, shoelace);
        for (index, one) in solids.boxes().iter().enumerate() {
            for other in &solids.boxes()[..index] {
                prop_assert_eq!(one.intersection(other), None);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn channels_are_those_of_brute_force_in_three_dimensions(boxes in boxes::<3>(8, 5), body in body()) {
        let bounds = space([0.; 3], [5.; 3]);
        let expected = sorted(brute_force(&boxes, &bounds, &body.into()));
        prop_assert_eq!(find(&mut with_boxes(&boxes), &bounds, body), expected);
    }
}

mod scale;
