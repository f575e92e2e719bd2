use super::*;
use crate::free_space::random::scenes;
use crate::geometry::work;
use proptest::prelude::*;

fn space<const D: usize>(min: [f64; D], max: [f64; D]) -> AxisBox<D> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

/// About `count` corridors four crossings long, laid like bricks, both ways: each
/// meets four others.
pub(crate) fn streets(count: usize) -> Vec<AxisBox<2>> {
    let lines = count.isqrt();
    let at = |line: usize| line as f64 * 10.0;
    let mut channels = Vec::new();
    for line in 0..lines {
        for begin in (0..lines).step_by(4) {
            let (begin, end) = (at(begin + line % 4), at(begin + line % 4 + 3));
            let across = [at(line) - 1.0, at(line) + 1.0];
            channels.push(space([begin - 1.0, across[0]], [end + 1.0, across[1]]));
            channels.push(space([across[0], begin - 1.0], [across[1], end + 1.0]));
        }
    }
    channels
}

fn build<const D: usize>(channels: &[AxisBox<D>]) -> Graph<D> {
    let mut graph = Graph::default();
    graph.build(channels, &Budget::default()).expect("few enough");
    graph
}

/// Neighbours are all channels with a common interior, in ascending order.
fn check<const D: usize>(channels: &[AxisBox<D>]) {
    let graph = build(channels);
    let mut junctions = 0;
    for (index, channel) in channels.iter().enumerate() {
        let meets =
            |other: &usize| *other != index && channel.intersection(&channels[*other]).is_some();
        let expected: Vec<_> = (0..channels.len()).filter(meets).collect();
        assert_eq!(graph.neighbours(index).collect::<Vec<_>>(), expected);
        junctions += expected.len();
    }
    assert_eq!(graph.junctions(), junctions / 2);
}

#[test]
fn equal_and_touching_channels_are_told_apart() {
    let one = space([0., 0.], [2., 2.]);
    check(&[one, space([2., 0.], [4., 2.]), one, space([2., 2.], [3., 3.]), one]);
}

#[test]
fn streets_meet_where_they_cross() {
    check(&streets(400));
}

proptest! {
    #[test]
    fn neighbours_are_those_that_meet(scene in scenes::<3>(60)) {
        check(&scene.channels);
    }
}

#[test]
fn work_grows_as_n_log_n() {
    work::check_n_log_n(5.0, &[100, 1_000, 10_000, 100_000], |size| {
        let channels = streets(size);
        (channels.len(), work::looks(|| drop(build(&channels))))
    });
}

#[test]
fn memory_is_as_documented() {
    let graph = build(&streets(10_000));
    let (channels, junctions) = (graph.channels().len(), graph.junctions());
    let held = size_of_val(&*graph.channels)
        + graph.tree.memory()
        + size_of_val(&*graph.begins)
        + size_of_val(&*graph.neighbours)
        + size_of_val(&*graph.pairs);
    let documented = (20 + 35 * 2) * channels + 16 * junctions;
    assert!(held <= documented, "{held} bytes, not {documented}");
    assert!(held * 20 > documented * 19, "{held} bytes, far from {documented}");
}
