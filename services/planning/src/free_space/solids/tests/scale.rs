//! How work and memory grow, and scenes made to be hard.

use super::*;
use crate::geometry::work;

/// Numbers in [0, 1), always the same.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / (1_u64 << 24) as f64
    }
}

/// Blocks of uneven size, apart from each other, in a square or cube.
fn blocks<const D: usize>(side: usize) -> (Vec<AxisBox<D>>, AxisBox<D>) {
    let mut next = numbers();
    let blocks = (0..side.pow(D as u32)).map(|index| {
        let corner: [f64; D] =
            std::array::from_fn(|axis| (index / side.pow(axis as u32) % side * 10) as f64);
        space(corner.map(|at| at + 1.0 + 2.0 * next()), corner.map(|at| at + 9.0 - 2.0 * next()))
    });
    (blocks.collect(), space([0.0; D], [side as f64 * 10.0; D]))
}

/// Work for `side^D` blocks goes with the channels found, all larger than 1.5 m.
#[track_caller]
fn check_work<const D: usize>(factor: f64, sides: &[usize]) {
    work::check_n_log_n(factor, sides, |side| {
        let (blocks, bounds) = blocks::<D>(side);
        let mut solids = with_boxes(&blocks);
        let mut found = 0;
        let looks = work::looks(|| found = find(&mut solids, &bounds, [1.5; D]).len());
        (blocks.len() + found, solids.sweep.steps + looks)
    });
}

#[test]
fn work_between_blocks_grows_as_n_log_n() {
    check_work::<2>(1.0, &[10, 32, 100, 316]);
}

#[test]
fn work_between_blocks_in_space_grows_as_n_log_n() {
    check_work::<3>(2.0, &[4, 7, 10, 16]);
}

#[track_caller]
fn check_memory<const D: usize>(boxes: &[AxisBox<D>], bounds: &AxisBox<D>) {
    let mut solids = with_boxes(boxes);
    find(&mut solids, bounds, [0.1; D]);
    let [without, with, candidate, channel] = solids.sweep.memory();
    let count = boxes.len();
    assert!(without <= (40 + 48 * D) * count + 99 * D, "{without} bytes for {count}");
    assert!(with <= (56 + 67 * D) * count + 99 * D, "{with} bytes for {count}");
    assert!(candidate <= 8 * D + 4 && channel <= 8 * D);
}

#[test]
fn memory_is_as_documented() {
    let (plane, bounds) = blocks::<2>(50);
    check_memory(&plane, &bounds);
    let (cubes, bounds) = blocks::<3>(9);
    check_memory(&cubes, &bounds);
    let posts = (0..999).map(|post| f64::from(2 * post));
    let row: Vec<_> = posts.map(|x| space([x, 0.], [x + 1., 9.])).collect();
    check_memory(&row, &space([-1., -1.], [2000., 20.]));
}

/// What the planner allows.
const CAPS: Caps = Caps { pieces: 1 << 20, channels: 1 << 18, steps: 1 << 26 };

/// Finds channels larger than 0.1 m within 9 m around all solids: how many, or why not.
fn count<const D: usize>(boxes: &[AxisBox<D>]) -> Result<usize, SolidsError> {
    let mut solids = with_boxes(boxes);
    let all = solids.bounds().expect("there are solids");
    let margin = Vector::repeat(9.0);
    let bounds = AxisBox::new(all.min() - margin, all.max() + margin).expect("a box");
    let mut channels = Vec::new();
    solids.channels(&bounds, &Vector::repeat(0.1), &CAPS, &mut channels)?;
    Ok(channels.len())
}

#[track_caller]
fn check_count<const D: usize>(boxes: impl Iterator<Item = AxisBox<D>>, channels: usize) {
    assert_eq!(count(&boxes.collect::<Vec<_>>()), Ok(channels));
}

#[track_caller]
fn check_too_many<const D: usize>(boxes: impl Iterator<Item = AxisBox<D>>) {
    let most = CAPS.channels;
    let error = SolidsError::TooManyChannels { has: most + 1, most };
    assert_eq!(count(&boxes.collect::<Vec<_>>()), Err(error));
}

#[track_caller]
fn check_too_intricate<const D: usize>(boxes: impl Iterator<Item = AxisBox<D>>) {
    match count(&boxes.collect::<Vec<_>>()) {
        Err(SolidsError::TooIntricate { has, most }) => {
            // What a single solid takes, it may take too much.
            assert!(most == CAPS.steps && has < most + (1 << 22), "{has} steps");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn checkerboard_is_free_on_every_other_field() {
    // 100 x 100 fields, every other one solid, and the four ways around all.
    let fields = (0..10_000).filter(|field| (field / 100 + field % 100) % 2 == 0);
    let at = |field: u32| [f64::from(field % 100), f64::from(field / 100)];
    check_count(fields.map(|field| space(at(field), at(field).map(|at| at + 1.0))), 5_000 + 4);
}

#[test]
fn stairs_have_a_channel_at_every_step_on_both_sides() {
    let steps = (0..3_000).map(f64::from);
    check_count(steps.map(|at| space([at, at], [at + 1.0, at + 1.0])), 6_002);
}

#[test]
fn solids_that_begin_together_have_channels_beside_and_behind() {
    let mut next = numbers();
    let posts = (0..3_000).map(|post| f64::from(2 * post));
    check_count(posts.map(|x| space([x, 0.0], [x + 1.0, 1.0 + 999.0 * next()])), 6_002);
}

#[test]
fn crossing_bars_are_refused_by_the_number_of_channels() {
    let bars = |count: u32| {
        let end = f64::from(2 * count + 4);
        (0..count).map(move |bar| match f64::from(bar / 2 * 4) {
            x if bar % 2 == 0 => space([x, 0.0], [x + 1.0, end]),
            y => space([0.0, y], [end, y + 1.0]),
        })
    };
    check_too_many(bars(3_000));
}

#[test]
fn stairs_that_face_stairs_are_refused_by_the_number_of_channels() {
    // Every step below to the left with every one above to the right.
    let steps = (0..1_200).map(f64::from).flat_map(|step| {
        let below = space([step, 0.0], [step + 1.0, 1_200.0 - step]);
        [below, space([2_400.0 + step, 2_399.5 - step], [2_401.0 + step, 2_400.0])]
    });
    check_too_many(steps);
}

#[test]
fn dust_in_space_is_refused_by_the_number_of_channels() {
    let mut next = numbers();
    let mut corner = || [next(), next(), next()].map(|part| 1_000.0 * part);
    check_too_many((0..2_000).map(|_| corner()).map(|at| space(at, at.map(|at| at + 0.01))));
}

#[test]
fn long_stairs_are_refused_by_the_work() {
    let steps = (0..60_000).map(f64::from);
    check_too_intricate(steps.map(|at| space([at, at], [at + 1.0, at + 1.0])));
}
