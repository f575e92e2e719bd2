use super::*;
use crate::free_space::graph::tests::streets;
use crate::free_space::random::scenes;
use crate::free_space::{Mouth, mouth_of};
use crate::geometry::{Direction, work};
use crate::section_4::CHANNELS;
use proptest::prelude::*;

fn space<const D: usize>(min: [f64; D], max: [f64; D]) -> AxisBox<D> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

fn complement<const D: usize>(channels: &[AxisBox<D>], mouth: Option<Mouth<D>>) -> Walls<D> {
    let mut walls = Walls::default();
    walls.set_complement(channels, mouth, &mut Complement::default(), &Budget::default()).unwrap();
    walls
}

/// Where a channel ends along an exit.
fn out_of<const D: usize>(
    channel: AxisBox<D>,
    (axis, sign): (usize, Sign),
    reach: f64,
) -> Option<Mouth<D>> {
    Some(Mouth { plane: mouth_of(&channel, Direction { axis, sign }), channel, reach })
}

const UP: (usize, Sign) = (1, Sign::Positive);

#[track_caller]
fn check_walls(channels: &[AxisBox<2>], mouth: Option<Mouth<2>>, expected: &[[f64; 4]]) {
    let found: Vec<[f64; 4]> = complement(channels, mouth)
        .as_slice()
        .iter()
        .map(|wall| [wall.from[0], wall.from[1], wall.to[0], wall.to[1]])
        .collect();
    assert_eq!(found, expected);
}

#[test]
fn section_4_has_the_cavity_of_the_female_part() {
    let channels = CHANNELS.map(|[min, max]| space(min, max));
    let cavity = [
        [1., 2., 1., 7.],
        [4., 1., 4., 2.],
        [5., 6., 5., 7.],
        [7., 1., 7., 6.],
        [4., 1., 7., 1.],
        [1., 2., 4., 2.],
        [5., 6., 7., 6.],
    ];
    check_walls(&channels, out_of(channels[2], UP, 0.0), &cavity);
    // Without a mouth it is closed: the lid comes last.
    let closed: Vec<_> = cavity.into_iter().chain([[1., 7., 5., 7.]]).collect();
    check_walls(&channels, None, &closed);
}

#[test]
fn walls_are_always_those_asked_for_last() {
    let first = [space([0., 0.], [2., 9.]), space([1., 5.], [3., 6.])];
    let second = [space([0., 0.], [2., 9.]), space([1., 5.], [4., 6.])];
    let mouth = out_of(first[0], UP, 0.0);
    let (mut walls, mut memory) = (Walls::default(), Complement::default());
    let asked =
        [(&first, mouth), (&first, mouth), (&first, None), (&second, None), (&first, mouth)];
    for (channels, mouth) in asked {
        walls.set_complement(channels, mouth, &mut memory, &Budget::default()).unwrap();
        assert_eq!(walls.as_slice(), complement(channels, mouth).as_slice());
        walls.push_box(&space([5., 5.], [6., 6.]));
    }
}

#[test]
fn wall_is_merged_over_channels() {
    let channels = [space([0., 0.], [2., 1.]), space([0., 1.], [2., 3.])];
    let expected = [[0., 0., 0., 3.], [2., 0., 2., 3.], [0., 0., 2., 0.], [0., 3., 2., 3.]];
    check_walls(&channels, None, &expected);
}

#[test]
fn only_the_strip_is_free_beyond_a_lower_mouth() {
    let channels = [space([0., 0.], [2., 9.]), space([1., 5.], [3., 6.])];
    let walls = [
        [0., 0., 0., 9.],
        [2., 0., 2., 5.],
        [3., 5., 3., 6.],
        [0., 0., 2., 0.],
        [2., 5., 3., 5.],
        [0., 9., 1., 9.],
    ];
    check_walls(&channels, out_of(channels[1], UP, 0.0), &walls);
    // The sides of the strip, from where they leave the first channel.
    let mut walls = walls.to_vec();
    walls[2][3] = 10.0;
    walls.insert(1, [1., 9., 1., 10.]);
    check_walls(&channels, out_of(channels[1], UP, 4.0), &walls);
}

#[test]
fn ring_leaves_its_island() {
    let ring = [
        space([0., 0.], [5., 1.]),
        space([4., 0.], [5., 5.]),
        space([0., 4.], [5., 5.]),
        space([0., 0.], [1., 5.]),
    ];
    let inner = [[1., 1., 1., 4.], [4., 1., 4., 4.], [1., 1., 4., 1.], [1., 4., 4., 4.]];
    let walls = complement(&ring, None);
    for [x0, z0, x1, z1] in inner {
        let side = Wall { from: Vector::from([x0, z0]), to: Vector::from([x1, z1]) };
        assert!(walls.as_slice().contains(&side), "{side:?}");
    }
    assert_eq!(walls.as_slice().len(), 8);
}

/// Marks the cells of an integer grid that are free.
fn grid<const D: usize>(channels: &[AxisBox<D>], cell: [i32; D]) -> bool {
    let middle = Vector::from(cell.map(|c| f64::from(c) + 0.5));
    channels.iter().any(|channel| {
        (0..D).all(|axis| channel.min()[axis] < middle[axis] && middle[axis] < channel.max()[axis])
    })
}

const EDGE: i32 = 12;

fn whole_boxes<const D: usize>(most: usize) -> impl Strategy<Value = Vec<AxisBox<D>>> {
    let corner = proptest::array::uniform::<_, D>(0..EDGE - 4);
    let size = proptest::array::uniform::<_, D>(1..=4);
    proptest::collection::vec((corner, size), 1..most).prop_map(|boxes| {
        let number = |v: [i32; D]| Vector::from(v.map(f64::from));
        let space = |(c, s)| AxisBox::new(number(c), number(c) + number(s)).expect("a box");
        boxes.into_iter().map(space).collect()
    })
}

/// Every side of a grid cell is wall exactly once if free space ends there, and otherwise not;
/// beyond a mouth the strip is free, and its sides are walls within reach.
fn check_grid<const D: usize>(channels: &[AxisBox<D>], mouth: Option<Mouth<D>>) {
    let walls = complement(channels, mouth);
    let middle_of = |cell: [i32; D]| Vector::from(cell.map(|c| f64::from(c) + 0.5));
    // How far beyond the mouth a cell of the strip begins.
    let in_strip = |cell: [i32; D]| {
        let Mouth { plane, channel, .. } = mouth?;
        let (axis, middle) = (plane.side.axis, middle_of(cell));
        let is_across = |i: usize| channel.min()[i] < middle[i] && middle[i] < channel.max()[i];
        let beyond = (middle[axis] - plane.bound).abs() - 0.5;
        let is_strip = (0..D).filter(|i| *i != axis).all(is_across) && !plane.contains(&middle);
        is_strip.then_some(beyond)
    };
    let cells = (EDGE + 2).pow(D as u32);
    for number in 0..cells {
        let mut rest = number;
        let cell: [i32; D] = std::array::from_fn(|_| {
            let coordinate = rest % (EDGE + 2) - 1;
            rest /= EDGE + 2;
            coordinate
        });
        for axis in 0..D {
            // The side at the lower end along `axis`.
            let mut behind = cell;
            behind[axis] -= 1;
            let mut middle = middle_of(cell);
            middle[axis] = f64::from(cell[axis]);
            let is_free = |cell| grid(channels, cell) || in_strip(cell).is_some();
            let reach = mouth.map_or(0.0, |mouth| mouth.reach);
            // Free as a channel, or as a part of the strip of which the sides matter.
            let counts = |cell| grid(channels, cell) || in_strip(cell).is_some_and(|at| at < reach);
            let free = if is_free(cell) { cell } else { behind };
            let expected = is_free(cell) != is_free(behind) && counts(free);
            let covers = |wall: &&Wall<D>| {
                wall.from[axis] == wall.to[axis]
                    && (0..D).all(|i| wall.from[i] <= middle[i] && middle[i] <= wall.to[i])
            };
            let count = walls.as_slice().iter().filter(covers).count();
            assert_eq!(count, usize::from(expected), "{cell:?}, axis {axis}");
        }
    }
    for wall in walls.as_slice() {
        let flat = (0..D).filter(|axis| wall.from[*axis] == wall.to[*axis]).count();
        assert_eq!(flat, 1, "{wall:?} has an extent");
    }
}

/// What searching must find.
fn check_search<const D: usize>(walls: &Walls<D>, min: Vector<D>, max: Vector<D>, reach: f64) {
    let distance = |wall: &Wall<D>| {
        let (low, high) = wall.bounds();
        distance_squared_box_box((&low, &high), (&min, &max))
    };
    let mut found = Vec::new();
    let budget = Budget::default();
    let near = walls.near(&min, &max, reach, &budget, |index, wall| {
        assert_eq!(walls.as_slice()[index], *wall);
        found.push(index);
    });
    near.unwrap();
    found.sort_unstable();
    let near: Vec<_> = (0..walls.as_slice().len())
        .filter(|index| distance(&walls.as_slice()[*index]) <= reach * reach)
        .collect();
    assert_eq!(found, near);

    let mut nearest = f64::INFINITY;
    let visited = walls.nearest(&min, &max, &budget, |_, wall| {
        nearest = nearest.min(distance(wall).sqrt());
        nearest
    });
    visited.unwrap();
    let least = walls.as_slice().iter().map(distance).fold(f64::INFINITY, f64::min);
    assert_eq!(nearest, least.sqrt());
}

#[test]
fn box_and_polygon_make_the_same_walls() {
    let solid = space([1., 2.], [3., 5.]);
    let corners = [[1., 2.], [3., 2.], [3., 5.], [1., 5.]].map(Vector::from);
    let polygon = Polygon::new(corners.to_vec(), &Budget::default()).expect("a rectangle");
    let (mut boxed, mut outlined) = (Walls::default(), Walls::default());
    boxed.push_box(&solid);
    outlined.push_polygon(&polygon);
    let sorted = |walls: &Walls<2>| {
        let mut bounds: Vec<_> = walls
            .as_slice()
            .iter()
            .map(|w| w.bounds())
            .map(|(a, b)| [a[0], a[1], b[0], b[1]])
            .collect();
        bounds.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        bounds
    };
    assert_eq!(sorted(&boxed), sorted(&outlined));
    for walls in [boxed, outlined] {
        assert_eq!(
            walls.solid_around(&Vector::from([2.0, 3.0]), &Budget::default()).unwrap(),
            Some(0)
        );
        assert_eq!(
            walls.solid_around(&Vector::from([0.5, 3.0]), &Budget::default()).unwrap(),
            None
        );
    }
}

#[test]
fn solid_box_in_space_has_six_sides() {
    let mut walls = Walls::default();
    walls.push_box(&space([0., 0., 0.], [1., 2., 3.]));
    let area: f64 = walls
        .as_slice()
        .iter()
        .map(|wall| {
            let size = wall.to - wall.from;
            size[0] * size[1] + size[1] * size[2] + size[2] * size[0]
        })
        .sum();
    assert_eq!((walls.as_slice().len(), area), (6, 22.0));
    assert_eq!(
        walls.solid_around(&Vector::from([0.5, 1.0, 1.0]), &Budget::default()).unwrap(),
        Some(0)
    );
    assert_eq!(
        walls.solid_around(&Vector::from([0.5, 1.0, 4.0]), &Budget::default()).unwrap(),
        None
    );
}

proptest! {
    #[test]
    fn complement_is_the_boundary_of_the_grid(boxes in whole_boxes::<2>(9), reach in 0..4_u8) {
        check_grid(&boxes, None);
        check_grid(&boxes, out_of(boxes[0], UP, f64::from(reach)));
        check_grid(&boxes, out_of(boxes[0], (0, Sign::Negative), f64::from(reach)));
    }

    #[test]
    fn complement_of_many_is_the_boundary_of_the_grid(boxes in whole_boxes::<2>(120)) {
        check_grid(&boxes, None);
    }

    #[test]
    fn complement_does_not_depend_on_the_order(boxes in whole_boxes::<2>(9)) {
        let reversed: Vec<_> = boxes.iter().rev().copied().collect();
        let (a, b) = (complement(&boxes, None), complement(&reversed, None));
        prop_assert_eq!(a.as_slice(), b.as_slice());
    }

    #[test]
    fn search_finds_all_and_the_nearest(
        scene in scenes::<2>(60),
        at in proptest::array::uniform2(-30.0..30.0f64),
        size in proptest::array::uniform2(0.0..5.0f64),
        reach in 0.0..9.0f64,
    ) {
        let walls = complement(&scene.channels, None);
        check_search(&walls, at.into(), Vector::from(at) + Vector::from(size), reach);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn complement_is_the_boundary_of_the_grid_in_space(boxes in whole_boxes::<3>(7), reach in 0..4_u8) {
        check_grid(&boxes, None);
        check_grid(&boxes, out_of(boxes[0], (2, Sign::Positive), f64::from(reach)));
    }
}

/// Channels up and to the right by turns.
fn chain(count: usize) -> Vec<AxisBox<2>> {
    let corners = (0..count).map(|i| (5.0 * (i / 2) as f64, 5.0 * i.div_ceil(2) as f64));
    let channels = corners.enumerate().map(|(i, (x, z))| {
        let (right, up) = if i % 2 == 0 { (1.0, 6.0) } else { (6.0, 1.0) };
        space([x - 1.0, z - 1.0], [x + right, z + up])
    });
    channels.collect()
}

#[test]
fn search_looks_at_few_of_many_walls() {
    let walls = complement(&chain(4000), None);
    assert!(walls.as_slice().len() > 4000);
    for at in [0.0, 2500.0, 5000.0, 9999.0] {
        let at = Vector::from([at, at]);
        let (mut visits, mut nearest) = (0, f64::INFINITY);
        let visited = walls.nearest(&at, &at, &Budget::default(), |_, wall| {
            visits += 1;
            let (low, high) = wall.bounds();
            nearest = distance_squared_box_box((&low, &high), (&at, &at)).sqrt().min(nearest);
            nearest
        });
        visited.unwrap();
        assert!(visits < 40, "{visits} of {}", walls.as_slice().len());
    }
}

#[test]
fn work_of_the_complement_grows_as_n_log_n() {
    let check = |factor, channels: fn(usize) -> Vec<AxisBox<2>>| {
        work::check_n_log_n(factor, &[150, 1_000, 10_000, 100_000], |size| {
            let channels = channels(size);
            (channels.len(), work::looks(|| drop(complement(&channels, None))))
        });
    };
    check(4.5, chain);
    check(10.5, streets);
}

#[test]
fn memory_is_as_documented() {
    let (mut walls, mut made) = (Walls::default(), Complement::default());
    walls.set_complement(&chain(10_000), None, &mut made, &Budget::default()).unwrap();
    let Walls { walls: list, solids, tree } = &walls;
    let held = size_of_val(&**list) + size_of_val(&**solids) + tree.memory() + made.memory();
    assert!(held <= 320 * 10_000, "{held} bytes");
    assert!(held > 310 * 10_000, "{held} bytes");
}
