use super::*;
use crate::disassembly::{DisassemblyPath, Gap, disassemble};
use crate::free_space::random::{Scene, scenes};
use crate::free_space::walls::Complement;
use crate::free_space::{Chain, End};
use crate::geometry::{Direction, Sign};
use crate::section_4::{CHANNELS, FEMALE, MALE};
use proptest::prelude::*;

fn space<const D: usize>(min: [f64; D], max: [f64; D]) -> AxisBox<D> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

fn polygon(vertices: &[[f64; 2]]) -> Polygon {
    Polygon::new(vertices.iter().map(|v| Vector::from(*v)).collect(), &Budget::default())
        .expect("a polygon")
}

fn section_4() -> Scene<2> {
    Scene {
        channels: CHANNELS.map(|[min, max]| space(min, max)).to_vec(),
        body: space(MALE[0], MALE[1]),
        exit: Direction { axis: 1, sign: Sign::Positive },
    }
}

fn plan<const D: usize>(scene: &Scene<D>, gap: Gap<'_, D>) -> (Chain<D>, DisassemblyPath<D>) {
    let (mut chain, mut path) = (Chain::default(), DisassemblyPath::default());
    chain
        .build(&scene.channels, &scene.body.center(), End::Exit(scene.exit), &Budget::default())
        .expect("a chain");
    disassemble(&chain, &scene.body, gap, &mut path, &Budget::default()).expect("a path");
    (chain, path)
}

fn complement<const D: usize>(chain: &Chain<D>) -> Walls<D> {
    let mut walls = Walls::default();
    walls
        .set_complement(
            chain.channels(),
            chain.mouth_and_channel(0.0),
            &mut Complement::default(),
            &Budget::default(),
        )
        .unwrap();
    walls
}

fn solids(solids: &[Polygon]) -> Walls<2> {
    let mut walls = Walls::default();
    for solid in solids {
        walls.push_polygon(solid);
    }
    walls.index(&Budget::default()).unwrap();
    walls
}

fn measure<const D: usize>(
    body: &Body<'_, D>,
    walls: &Walls<D>,
    legs: &[Leg<D>],
) -> (Clearance<D>, Vec<Clearance<D>>) {
    let mut each = Vec::new();
    let whole = clearance_body_legs(body, walls, legs, &mut each, &Budget::default())
        .unwrap()
        .expect("there are walls");
    (whole, each)
}

fn leg<const D: usize>(from: [f64; D], to: [f64; D]) -> Leg<D> {
    let curve = Curve::Line { from: from.into(), to: to.into(), heading: 0.0, turned: 0.0 };
    Leg { curve, junction: None, rule: None, rung: None }
}

/// Section 4's clearances per leg, from docs/method.md 4, measured in four ways.
#[track_caller]
fn check_section_4(gap: Gap<'_, 2>, known: [f64; 3]) {
    let scene = section_4();
    let (chain, path) = plan(&scene, gap);
    let corners = polygon(&[[4.5, 1.01], [4.5, 4.], [6.99, 4.], [6.99, 1.01]]);
    let bodies = [
        Body::from_box(&scene.body),
        Body::from_polygon(&corners),
        Body { bounds: scene.body, outline: corners.vertices(), boxes: &[] },
    ];
    for walls in [complement(&chain), solids(&[polygon(&FEMALE)])] {
        for body in &bodies {
            let (whole, each) = measure(body, &walls, path.legs());
            for (found, known) in each.iter().zip(known) {
                assert!((found.value - known).abs() < 2e-15, "{} is not {known}", found.value);
            }
            // The assembled body is 0.01 from the floor and from the right wall.
            assert!((whole.value - 0.01).abs() < 2e-15);
            assert_eq!(whole.at, 0.0);
            let wall = whole.wall;
            assert!(wall[1] == 1.0 || wall[0] == 7.0, "{wall}");
        }
    }
}

#[test]
fn section_4_at_three_gaps() {
    check_section_4(Gap::Uniform(0.01), [0.01, 0.01384579467942845, 0.01]);
    check_section_4(Gap::Uniform(0.2), [0.01, 0.2517622086923952, 0.2]);
    check_section_4(Gap::Safest, [0.01, 0.255, 0.505]);
}

#[test]
fn place_is_arc_length_and_wall_point() {
    let mut walls = Walls::default();
    walls.push(Wall { from: [6.0, 2.0].into(), to: [6.0, 9.0].into() });
    let legs = [leg([0., 0.], [0., 3.]), leg([0., 3.], [8., 3.])];
    let body = Body::from_box(&space([0., -3.], [1., -2.]));
    let (whole, each) = measure(&body, &walls, &legs);
    // Below the wall's lower end, first reached with the right side.
    assert_eq!(whole, Clearance { value: 1.0, at: 3.0 + 5.0, wall: [6.0, 2.0].into() });
    let at_end = Clearance { value: 26.0_f64.sqrt(), at: 3.0, wall: [6.0, 2.0].into() };
    assert_eq!(each, [at_end, whole]);
}

#[test]
fn contact_is_found_where_it_begins() {
    let mut walls = Walls::default();
    walls.push_box(&space([4., 0., 0.], [5., 9., 9.]));
    let body = Body::from_box(&space([0., 1., 1.], [1., 2., 2.]));
    let (whole, _) = measure(&body, &walls, &[leg([0., 0., 0.], [9., 0., 0.])]);
    assert_eq!(whole, Clearance { value: 0.0, at: 3.0, wall: [4.0, 1.5, 1.5].into() });
}

#[test]
fn slanted_contact_is_found_where_it_begins() {
    let diamond = polygon(&[[6., 0.], [8., 2.], [6., 4.], [4., 2.]]);
    let triangle = polygon(&[[0., 1.], [2., 2.], [0., 3.]]);
    let (whole, _) =
        measure(&Body::from_polygon(&triangle), &solids(&[diamond]), &[leg([0., 0.], [9., 0.])]);
    assert_eq!(whole, Clearance { value: 0.0, at: 2.0, wall: [4.0, 2.0].into() });
}

#[track_caller]
fn check_starts_blocked(body: &Polygon, solid: &Polygon) {
    let walls = solids(std::slice::from_ref(solid));
    for to in [[0.0, 0.0], [0.125, 0.0], [20.0, 0.0]] {
        let (whole, _) = measure(&Body::from_polygon(body), &walls, &[leg([0., 0.], to)]);
        assert_eq!((whole.value, whole.at), (0.0, 0.0));
    }
}

#[test]
fn body_inside_a_solid_and_around_one_is_blocked() {
    let small = polygon(&[[4., 4.], [6., 4.], [5., 6.]]);
    let large = polygon(&[[0., 0.], [9., 0.], [9., 9.], [5., 10.], [0., 9.]]);
    check_starts_blocked(&small, &large);
    check_starts_blocked(&large, &small);
    let box_shaped = polygon(&[[0., 0.], [9., 0.], [9., 9.], [0., 9.]]);
    check_starts_blocked(&small, &box_shaped);
    check_starts_blocked(&box_shaped, &small);
}

#[test]
fn crossing_slabs_without_a_vertex_near_are_blocked() {
    let upright = polygon(&[[4., 0.], [5., 0.], [5., 9.], [4., 9.5]]);
    let flat = polygon(&[[0., 4.], [9., 4.], [9.5, 5.], [0., 5.]]);
    check_starts_blocked(&upright, &flat);
    check_starts_blocked(&flat, &upright);
}

#[test]
fn body_inside_a_solid_box_in_space_is_blocked() {
    let mut walls = Walls::default();
    walls.push_box(&space([0., 0., 0.], [9., 9., 9.]));
    let body = Body::from_box(&space([4., 4., 4.], [5., 5., 5.]));
    let (whole, _) = measure(&body, &walls, &[leg([0., 0., 0.], [1., 0., 0.])]);
    assert_eq!((whole.value, whole.at), (0.0, 0.0));
}

#[test]
fn cavity_of_a_solid_is_not_its_inside() {
    let scene = section_4();
    let (whole, _) = measure(
        &Body::from_box(&scene.body),
        &solids(&[polygon(&FEMALE)]),
        &[leg([0., 0.], [0., 0.])],
    );
    assert!(whole.value > 0.0099);
}

#[test]
fn nothing_to_measure_is_no_clearance() {
    let body = Body::from_box(&space([0., 0.], [1., 1.]));
    let mut each = Vec::new();
    let legs = [leg([0., 0.], [1., 0.])];
    assert_eq!(
        clearance_body_legs(&body, &Walls::default(), &legs, &mut each, &Budget::default())
            .unwrap(),
        None
    );
    assert_eq!(
        clearance_body_legs(
            &body,
            &solids(&[polygon(&FEMALE)]),
            &[],
            &mut each,
            &Budget::default()
        )
        .unwrap(),
        None
    );
}

/// Distance between a point and the closed region of a displaced outline.
fn outside(outline: &[Vector<2>], at: &Vector<2>, point: &Vector<2>) -> f64 {
    let point = point - at;
    if polygon::contains(polygon::edges(outline), &point) {
        return 0.0;
    }
    let to_edge = |(a, b): (_, _)| distance_segment_segment((&point, &point), (&a, &b)).distance;
    polygon::edges(outline).map(to_edge).fold(f64::INFINITY, f64::min)
}

/// Distance between the closed region of a displaced outline and all walls.
fn placed(outline: &[Vector<2>], walls: &Walls<2>, at: &Vector<2>) -> f64 {
    let ends = walls.as_slice().iter().map(|wall| outside(outline, at, &wall.from));
    let mut least = ends.fold(f64::INFINITY, f64::min);
    for (a, b) in polygon::edges(outline) {
        for wall in walls.as_slice() {
            let edge = (&(a + at), &(b + at));
            let found = distance_segment_segment(edge, (&wall.from, &wall.to));
            least = least.min(found.distance);
        }
    }
    least
}

/// The exact clearance against dense sampling of placements.
fn check_sampled(outline: &[Vector<2>], body: &Body<'_, 2>, walls: &Walls<2>, legs: &[Leg<2>]) {
    const STEPS: u32 = 400;
    let (_, each) = measure(body, walls, legs);
    let mut travelled = 0.0;
    for (leg, found) in legs.iter().zip(&each) {
        let Curve::Line { from, to, .. } = leg.curve else { panic!("a translation") };
        let least = (0..=STEPS)
            .map(|step| from + (to - from) * (f64::from(step) / f64::from(STEPS)))
            .map(|at| placed(outline, walls, &at))
            .fold(f64::INFINITY, f64::min);
        let bound = leg.curve.length() / f64::from(STEPS) / 2.0 + 1e-12;
        assert!(found.value <= least + 1e-12, "{} > {least}", found.value);
        assert!(least - bound <= found.value, "{} < {least} - {bound}", found.value);
        // It is so close where it says.
        let part = if leg.curve.length() > 0.0 {
            (found.at - travelled) / leg.curve.length()
        } else {
            0.0
        };
        let there = from + (to - from) * part;
        assert!((placed(outline, walls, &there) - found.value).abs() < 1e-9);
        let to_point = outside(outline, &there, &found.wall);
        assert!((to_point - found.value).abs() < 1e-9, "{to_point} is not {}", found.value);
        travelled += leg.curve.length();
    }
}

/// Star-shaped polygons about a centre.
fn stars(center: [f64; 2]) -> impl Strategy<Value = Polygon> {
    proptest::collection::vec(0.4..2.0f64, 3..9).prop_map(move |radii| {
        let turn = std::f64::consts::TAU / radii.len() as f64;
        let vertex = |(i, r): (usize, &f64)| {
            let angle = i as f64 * turn;
            [center[0] + r * libm::cos(angle), center[1] + r * libm::sin(angle)]
        };
        polygon(&radii.iter().enumerate().map(vertex).collect::<Vec<_>>())
    })
}

fn displacements() -> impl Strategy<Value = Vec<Leg<2>>> {
    proptest::collection::vec(proptest::array::uniform2(-3.0..9.0f64), 1..4).prop_map(|points| {
        let mut from = [0.0, 0.0];
        let legs = points.iter().map(|to| leg(std::mem::replace(&mut from, *to), *to));
        legs.collect()
    })
}

/// Corollary of lemma 1: never closer than at the start or than the gap.
fn check_corollary<const D: usize>(scene: &Scene<D>, fraction: f64) {
    let (chain, path) = plan(scene, Gap::Fraction(fraction));
    let walls = complement(&chain);
    let body = Body::from_box(&scene.body);
    let (whole, each) = measure(&body, &walls, path.legs());
    let channel = &scene.channels[0];
    let start = (scene.body.min() - channel.min()).inf(&(channel.max() - scene.body.max())).min();
    let gap = path.gaps().iter().map(|gap| gap.min()).fold(f64::INFINITY, f64::min);
    // The exit alone keeps what the start has beside it.
    let promised = start.min(gap);
    assert!(whole.value > promised - 1e-12, "{} is less than {promised}", whole.value);
    let least = each.iter().map(|leg| leg.value).fold(f64::INFINITY, f64::min);
    assert_eq!(whole.value, least);
}

fn rectangles(middle: [f64; 2]) -> impl Strategy<Value = AxisBox<2>> {
    let sizes = (0.1..1.0_f64, 0.1..1.0_f64, 0.1..1.0_f64, 0.1..1.0_f64);
    sizes.prop_map(move |(left, low, right, high)| {
        space([middle[0] - left, middle[1] - low], [middle[0] + right, middle[1] + high])
    })
}

proptest! {
    #[test]
    fn clearance_keeps_the_promise_of_lemma_1(scene in scenes::<2>(8), fraction in 0.01..1.0f64) {
        check_corollary(&scene, fraction);
    }

    #[test]
    fn clearance_keeps_the_promise_of_lemma_1_in_space(
        scene in scenes::<3>(8),
        fraction in 0.01..1.0f64,
    ) {
        check_corollary(&scene, fraction);
    }

    #[test]
    fn clearance_of_boxes_is_that_of_sampling(scene in scenes::<2>(6), fraction in 0.05..1.0f64) {
        let (chain, path) = plan(&scene, Gap::Fraction(fraction));
        let body = Body::from_box(&scene.body);
        check_sampled(&corners(body.bounds()), &body, &complement(&chain), path.legs());
    }

    #[test]
    fn rectangle_is_measured_like_a_box(scene in scenes::<2>(30), fraction in 0.05..1.0f64) {
        let (chain, path) = plan(&scene, Gap::Fraction(fraction));
        let walls = complement(&chain);
        let boxed = Body::from_box(&scene.body);
        let corners = corners(boxed.bounds());
        let rectangle = Polygon::new(corners.to_vec(), &Budget::default()).expect("a rectangle");
        let found = measure(&boxed, &walls, path.legs());
        prop_assert_eq!(&measure(&Body::from_polygon(&rectangle), &walls, path.legs()), &found);
        let general = Body { bounds: scene.body, outline: &corners, boxes: &[] };
        let other = measure(&general, &walls, path.legs());
        for (a, b) in found.1.iter().zip(&other.1) {
            prop_assert!((a.value - b.value).abs() < 1e-12);
            // Far from the origin of the leg the place may differ by rounding.
            prop_assert!((a.at - b.at).abs() < 1e-6, "{a:?} {b:?}");
        }
    }

    #[test]
    fn index_changes_nothing(scene in scenes::<3>(40), fraction in 0.05..1.0f64) {
        let (chain, path) = plan(&scene, Gap::Fraction(fraction));
        let walls = complement(&chain);
        let mut plain = Walls::default();
        for wall in walls.as_slice() {
            plain.push(*wall);
        }
        let body = Body::from_box(&scene.body);
        let (with, without) =
            (measure(&body, &walls, path.legs()), measure(&body, &plain, path.legs()));
        for (a, b) in with.1.iter().zip(&without.1) {
            prop_assert_eq!((a.value, a.wall), (b.value, b.wall));
            prop_assert_eq!(a.at, b.at);
        }
        prop_assert_eq!(with.0, without.0);
    }

    #[test]
    fn clearance_of_polygons_is_that_of_sampling(
        body in stars([0., 0.]),
        solid in stars([5., 1.]),
        other in stars([1., 6.]),
        legs in displacements(),
    ) {
        let walls = solids(&[solid, other]);
        check_sampled(body.vertices(), &Body::from_polygon(&body), &walls, &legs);
    }

    #[test]
    fn clearance_of_a_box_beside_polygons_is_that_of_sampling(
        solid in stars([5., 1.]),
        other in stars([1., 6.]),
        legs in displacements(),
    ) {
        let walls = solids(&[solid, other]);
        let body = Body::from_box(&space([-1.0, -0.5], [1.0, 0.5]));
        check_sampled(&corners(body.bounds()), &body, &walls, &legs);
    }

    /// The distance of a union is the least of those of its parts.
    #[test]
    fn clearance_of_a_union_is_the_least_of_its_boxes(
        first in rectangles([0., 0.]),
        second in rectangles([1., 1.]),
        box_of_walls in rectangles([5., 1.]),
        solid in stars([1., 6.]),
        legs in displacements(),
    ) {
        let mut walls = solids(&[solid]);
        walls.push_box(&box_of_walls);
        walls.push_more(&box_of_walls.translated(&Vector::from([1.0, 0.5])));
        let boxes = [first, second];
        let (whole, each) = measure(&Body::from_boxes(&boxes).expect("boxes"), &walls, &legs);
        let parts = boxes.map(|part| measure(&Body::from_box(&part), &walls, &legs));
        let least = |values: [f64; 2]| values[0].min(values[1]);
        let expected = least([0, 1].map(|part: usize| parts[part].0.value));
        prop_assert_eq!(whole.value, expected);
        for (leg, near) in each.iter().enumerate() {
            prop_assert_eq!(near.value, least([0, 1].map(|part: usize| parts[part].1[leg].value)));
        }
    }
}
