//! The shortest path through the shrunk junctions (docs/method.md 3) as an independent
//! measure of the rules: a convex problem, solved one way-point at a time.

use super::*;

/// The point of `space` nearest in sum to its two neighbours (the second one
/// counted along `exit` only, when there is none after).
fn best_between(
    space: [Vector<2>; 2],
    before: &Vector<2>,
    after: Option<&Vector<2>>,
    exit: Direction,
) -> Vector<2> {
    let cost = |x: f64, z: f64| {
        let here = Vector::from([x, z]);
        let onwards = match after {
            Some(after) => (after - here).norm(),
            None => -exit.coordinate(&here),
        };
        (here - before).norm() + onwards
    };
    let [min, max] = space;
    let z_at = |x: f64| least(min[1], max[1], &|z| cost(x, z));
    let x = least(min[0], max[0], &|x| cost(x, z_at(x)));
    Vector::from([x, z_at(x)])
}

/// Where a convex function is least between two bounds, by trisection.
fn least(mut low: f64, mut high: f64, function: &dyn Fn(f64) -> f64) -> f64 {
    for _ in 0..70 {
        let third = (high - low) / 3.0;
        if function(low + third) <= function(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    (low + high) / 2.0
}

/// Length of the shortest path that keeps `gap` in every junction and leaves by
/// a pure exit motion.
pub(super) fn optimum(scene: &Scene<2>, chain: &Chain<2>, path: &DisassemblyPath<2>) -> f64 {
    let spaces: Vec<[Vector<2>; 2]> = chain
        .junctions()
        .iter()
        .zip(path.gaps())
        .map(|(junction, gap)| {
            let space = &junction.space;
            [space.min() + gap - scene.body.min(), space.max() - gap - scene.body.max()]
        })
        .collect();
    let mut points: Vec<Vector<2>> = spaces.iter().map(|[min, max]| (min + max) / 2.0).collect();
    for _ in 0..40 {
        for index in 0..points.len() {
            let before = index.checked_sub(1).map_or(Vector::zeros(), |before| points[before]);
            points[index] = best_between(spaces[index], &before, points.get(index + 1), scene.exit);
        }
    }
    let end = way_points(path)[path.legs().len()];
    let mut from = Vector::zeros();
    let mut length = 0.0;
    for point in &points {
        length += (point - from).norm();
        from = *point;
    }
    length + scene.exit.coordinate(&end) - scene.exit.coordinate(&from)
}

#[test]
fn section_4_is_optimal_as_the_gap_closes() {
    let scene = section_4();
    let (chain, path) = plan(&scene, Gap::Uniform(1e-12)).expect("a path");
    assert!((path.length() - 6.899154287904625).abs() < 1e-11);
    assert!((path.length() - optimum(&scene, &chain, &path)).abs() < 1e-7);
}

#[test]
fn rules_are_optimal_in_section_4() {
    for gap in [0.01, 0.1, 0.2] {
        let scene = section_4();
        let (chain, path) = plan(&scene, Gap::Uniform(gap)).expect("a path");
        assert!((path.length() - optimum(&scene, &chain, &path)).abs() < 1e-7);
    }
}

/// Whether no way-point wants to move back into its junction: the condition for
/// the corners of a convex problem's feasible set to be its solution. That the
/// polyline turns in every corner's own sense is necessary but not sufficient:
/// a body that starts closer to a wall than the gap can be drawn along the side
/// of its first junction.
fn is_held_by_its_corners(chain: &Chain<2>, path: &DisassemblyPath<2>) -> bool {
    let points = way_points(path);
    chain.junctions().iter().zip(points.windows(3)).all(|(junction, p)| {
        let pull = (p[2] - p[1]).normalize() - (p[1] - p[0]).normalize();
        junction.approach.coordinate(&pull) <= 0.0 && junction.leaving.coordinate(&pull) >= 0.0
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn no_rule_path_is_shorter_than_the_optimum(
        scene in scenes::<2>(5),
        fraction in 0.01..0.9f64,
    ) {
        let (chain, path) = plan(&scene, Gap::Fraction(fraction)).expect("a path");
        let optimum = optimum(&scene, &chain, &path);
        prop_assert!(path.length() > optimum - 1e-6, "{} < {optimum}", path.length());
        if is_held_by_its_corners(&chain, &path) {
            prop_assert!(path.length() < optimum + 1e-3, "{} > {optimum}", path.length());
        }
    }
}
