//! How work and memory grow, and scenes made to be hard.

use super::*;
use crate::budget::Allowance;
use crate::free_space::solids::candidates::Candidates;
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

/// Work goes with the solids and the channels found between them.
#[track_caller]
fn check_work<const D: usize>(
    factor: f64,
    sizes: &[usize],
    body: f64,
    scene: impl Fn(usize) -> (Solids<D>, AxisBox<D>),
) {
    work::check_n_log_n(factor, sizes, |size| {
        let (mut solids, bounds) = scene(size);
        let (budget, body) = (Budget::default(), Vector::repeat(body));
        let mut found = Vec::new();
        let looks = work::looks(|| {
            solids.channels(&bounds, &body, &budget, &mut found).expect("no limit");
        });
        let steps = budget.drawn(Cap::ChannelSteps) as usize;
        (solids.boxes().len() + found.len(), steps + looks)
    });
}

fn between_blocks<const D: usize>(side: usize) -> (Solids<D>, AxisBox<D>) {
    let (blocks, bounds) = blocks(side);
    (with_boxes(&blocks), bounds)
}

#[test]
fn work_between_blocks_grows_as_n_log_n() {
    check_work::<2>(1.0, &[10, 32, 100, 316], 1.5, between_blocks);
}

#[test]
fn work_between_blocks_in_space_grows_as_n_log_n() {
    check_work::<3>(1.0, &[4, 7, 10, 16], 1.5, between_blocks);
}

/// A square at every step up to the right.
fn steps(count: usize) -> impl Iterator<Item = AxisBox<2>> {
    (0..count).map(|step| step as f64).map(|at| space([at, at], [at + 1.0, at + 1.0]))
}

#[test]
fn work_along_stairs_grows_as_n_log_n() {
    check_work(0.7, &[100, 1_000, 10_000, 100_000], 0.5, |count| {
        let end = count as f64 + 9.0;
        (with_boxes(&steps(count).collect::<Vec<_>>()), space([-9.0; 2], [end; 2]))
    });
}

/// A seventh of all sides lies on one line: looking among these takes the index over the
/// solids, another part of log n.
#[test]
fn work_in_a_comb_grows_hardly_more() {
    check_work(25.0, &[1_000, 10_000, 100_000], 1.5, |vertices| {
        let mut outline = Vec::new();
        for (tooth, low) in
            (0..vertices / 4).zip([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].iter().cycle())
        {
            let x = tooth as f64 * 4.0;
            outline.extend([[x, *low], [x + 2.0, *low], [x + 2.0, 20.0], [x + 4.0, 20.0]]);
        }
        let end = vertices as f64 / 4.0 * 4.0;
        outline.extend([[end, 0.0], [0.0, 0.0]]);
        let mut solids = Solids::default();
        solids.push_polygon(&polygon(&outline), &Budget::default()).expect("a solid");
        let bounds = solids.bounds().expect("a solid");
        (solids, bounds)
    });
}

#[track_caller]
fn check_memory<const D: usize>(boxes: &[AxisBox<D>], bounds: &AxisBox<D>) {
    let mut solids = with_boxes(boxes);
    find(&mut solids, bounds, [0.1; D]);
    let [without, with, channel] = solids.sweep.memory();
    let [candidate, node] = Candidates::<D>::memory();
    let count = boxes.len();
    assert!(without <= (40 + 48 * D) * count + 99 * D, "{without} bytes for {count}");
    assert!(with <= (56 + 67 * D) * count + 99 * D, "{with} bytes for {count}");
    assert!(candidate <= 8 * D + 4 && node <= 8 * D + 20 && channel <= 8 * D, "{node} bytes");
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
const LIMITS: Allowance =
    Allowance { pieces: 1 << 20, channels: 1 << 18, channel_steps: 1 << 26, ..Allowance::NONE };

/// Finds channels larger than 0.1 m within 9 m around all solids: how many, or why not.
fn count<const D: usize>(boxes: &[AxisBox<D>]) -> Result<usize, Spent> {
    let mut solids = with_boxes(boxes);
    let all = solids.bounds().expect("there are solids");
    let margin = Vector::repeat(9.0);
    let bounds = AxisBox::new(all.min() - margin, all.max() + margin).expect("a box");
    let mut channels = Vec::new();
    solids.channels(&bounds, &Vector::repeat(0.1), &Budget::new(LIMITS), &mut channels)?;
    Ok(channels.len())
}

#[track_caller]
fn check_count<const D: usize>(boxes: impl Iterator<Item = AxisBox<D>>, channels: usize) {
    assert_eq!(count(&boxes.collect::<Vec<_>>()), Ok(channels));
}

#[track_caller]
fn check_too_many<const D: usize>(boxes: impl Iterator<Item = AxisBox<D>>) {
    let error = Spent::Limit { cap: Cap::Channels, most: LIMITS.channels };
    assert_eq!(count(&boxes.collect::<Vec<_>>()), Err(error));
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
    check_count(steps(10_000), 20_002);
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
