//! The worked corridors with replies put together from their table of points.

use schemas::message::{
    AxisBox, Body, Choice, Clearance, ClearanceWish, Curve, Footprint, FreeSpace, Gap, Goal, Leg,
    Pose, Reply, RequestKey, Rule, SceneRequest, Task, Trajectory, Vector,
};

/// Gap, total length, and per corner: rule, corner, arriving and leaving point.
type Worked<const N: usize> = (f64, f64, [(u16, [f64; 2], [f64; 2], [f64; 2]); N]);

/// Corridor A: gap, total length, then per corner rule, corner, arriving and leaving point.
const Z: [Worked<3>; 4] = [
    (
        0.2,
        29.365950690995216,
        [
            (
                1,
                [3.0, 8.0],
                [2.309643264610417, 8.11579109595404],
                [2.824510569952008, 8.677645526762651],
            ),
            (
                5,
                [9.0, 11.0],
                [9.175489430047993, 10.322354473237349],
                [9.628992660793624, 10.692805871365099],
            ),
            (
                1,
                [13.0, 16.0],
                [12.371007339206376, 16.3071941286349],
                [12.859600684264933, 16.685775496894664],
            ),
        ],
    ),
    (
        0.6,
        30.660774468510798,
        [
            (
                1,
                [3.0, 8.0],
                [1.9062123189163245, 8.116741203992403],
                [2.857939267479191, 9.090788131708285],
            ),
            (
                5,
                [9.0, 11.0],
                [9.14206073252081, 9.909211868291715],
                [10.042762244693181, 10.649790204245456],
            ),
            (
                1,
                [13.0, 16.0],
                [11.957237755306819, 16.350209795754544],
                [12.835064040224754, 17.08756431036193],
            ),
        ],
    ),
    (
        1.0,
        32.20812160545722,
        [
            (1, [3.0, 8.0], [1.501578354169773, 8.068793686537601], [3.0, 9.5]),
            (5, [9.0, 11.0], [9.0, 9.5], [10.473814801736411, 10.720948158610872]),
            (
                1,
                [13.0, 16.0],
                [11.526185198263589, 16.27905184138913],
                [12.852190105992493, 17.492699646691687],
            ),
        ],
    ),
    (
        0.9296875,
        31.917340963672473,
        [
            (
                1,
                [3.0, 8.0],
                [1.5725985784823937, 8.080817878626991],
                [2.966685795293655, 9.42929930785019],
            ),
            (
                5,
                [9.0, 11.0],
                [9.033314204706345, 9.57070069214981],
                [10.397732435633847, 10.699416590555423],
            ),
            (
                1,
                [13.0, 16.0],
                [11.602267564366153, 16.300583409444577],
                [12.846119541462805, 17.421382127415647],
            ),
        ],
    ),
];

/// Corridor B: gap, total length, then per corner rule, corner, arriving and leaving point.
const SERPENTINE: [Worked<5>; 4] = [
    (
        0.2,
        38.135038804008026,
        [
            (1, [3.0, 10.5], [2.304674051981499, 10.58075782322582], [3.0, 11.2]),
            (7, [4.5, 10.5], [4.5, 11.2], [5.157490502700863, 10.740221228991459]),
            (2, [8.0, 5.0], [7.342509497299137, 4.759778771008542], [8.0, 4.3]),
            (5, [10.0, 5.0], [10.0, 4.3], [10.658844448506265, 4.76351745799642]),
            (
                1,
                [14.0, 12.0],
                [13.341155551493735, 12.23648254200358],
                [13.81565734967167, 12.675290890853658],
            ),
        ],
    ),
    (
        0.6,
        40.67957598076666,
        [
            (1, [3.0, 10.5], [1.9028328307338045, 10.578893616246205], [3.0, 11.6]),
            (7, [4.5, 10.5], [4.5, 11.6], [5.5728820024002435, 10.742743092436518]),
            (2, [8.0, 5.0], [6.9271179975997565, 4.757256907563481], [8.0, 3.9]),
            (5, [10.0, 5.0], [10.0, 3.9], [11.067744859128757, 4.7355743662121395]),
            (
                1,
                [14.0, 12.0],
                [12.932255140871243, 12.26442563378786],
                [13.772244858316503, 13.076163368377093],
            ),
        ],
    ),
    (
        1.0,
        43.45206861336774,
        [
            (1, [3.0, 10.5], [1.500575708822633, 10.541554723284488], [3.0, 12.0]),
            (7, [4.5, 10.5], [4.5, 12.0], [5.994125346447286, 10.632625220466455]),
            (2, [8.0, 5.0], [6.505874653552714, 4.867374779533545], [8.0, 3.5]),
            (5, [10.0, 5.0], [10.0, 3.5], [11.485766232650043, 4.793847867057118]),
            (
                1,
                [14.0, 12.0],
                [12.514233767349957, 12.206152132942881],
                [13.775716346311775, 13.483137499589388],
            ),
        ],
    ),
    (
        0.9296875,
        42.947830256018776,
        [
            (1, [3.0, 10.5], [1.5712120381965093, 10.55070806505554], [3.0, 11.9296875]),
            (7, [4.5, 10.5], [4.5, 11.9296875], [5.920620890515014, 10.660756440270918]),
            (2, [8.0, 5.0], [6.579379109484986, 4.8392435597290815], [8.0, 3.5703125]),
            (5, [10.0, 5.0], [10.0, 3.5703125], [11.412194173339987, 4.7770337145646495]),
            (
                1,
                [14.0, 12.0],
                [12.587805826660013, 12.22296628543535],
                [13.771642362055545, 13.411332397718086],
            ),
        ],
    ),
];
/// Corridor A: three corners, S-turns.
pub(super) fn z() -> (SceneRequest, Reply) {
    let channels = [
        ([0.0, 0.0], [3.0, 11.0]),
        ([0.0, 8.0], [13.0, 11.0]),
        ([9.0, 8.0], [13.0, 20.0]),
        ([9.0, 16.0], [22.0, 20.0]),
    ];
    corridor(&channels, [1.2, 1.5], [20.5, 18.25], &Z)
}

/// Corridor B: five corners, two U-turns.
pub(super) fn serpentine() -> (SceneRequest, Reply) {
    let channels = [
        ([0.0, 0.0], [3.0, 14.0]),
        ([0.0, 10.5], [8.0, 14.0]),
        ([4.5, 2.0], [8.0, 14.0]),
        ([4.5, 2.0], [14.0, 5.0]),
        ([10.0, 2.0], [14.0, 16.0]),
        ([10.0, 12.0], [22.0, 16.0]),
    ];
    corridor(&channels, [1.25, 1.5], [20.5, 14.5], &SERPENTINE)
}

fn corridor<const N: usize>(
    channels: &[([f64; 2], [f64; 2])],
    start: [f64; 2],
    goal: [f64; 2],
    worked: &[Worked<N>],
) -> (SceneRequest, Reply) {
    let boxes =
        channels.iter().map(|(min, max)| AxisBox { min: (*min).into(), max: (*max).into() });
    let choices = worked.iter().map(|(gap, ..)| match *gap {
        0.9296875 => Choice::Safest,
        gap => Choice::Gap(Gap::Uniform(gap)),
    });
    let heading = std::f64::consts::FRAC_PI_2;
    let scene = SceneRequest {
        id: Some(N as u64),
        task: Task::Drive,
        free_space: FreeSpace {
            channels: Some(boxes.collect()),
            in_order: true,
            ..FreeSpace::default()
        },
        body: Body::Footprint(Footprint::Centered { width: 1.0, length: 1.5 }),
        start: Some(Pose { position: start.into(), heading }),
        goal: Some(Goal { position: goal.into(), heading: None }),
        clearance: ClearanceWish::Each(choices.collect()),
        ..SceneRequest::empty()
    };
    let answers = worked.iter().map(|worked| Ok(trajectory(start, goal, heading, worked)));
    let key = RequestKey::default();
    (scene, Reply { key, id: Some(N as u64), answers: Ok(answers.collect()) })
}

fn trajectory<const N: usize>(
    start: [f64; 2],
    goal: [f64; 2],
    heading: f64,
    (gap, total, corners): &Worked<N>,
) -> Trajectory {
    let radius = 0.5 + gap;
    let angle = |from: [f64; 2], to: [f64; 2]| libm::atan2(to[1] - from[1], to[0] - from[0]);
    let wrap = |angle: f64| angle - std::f64::consts::TAU * (angle / std::f64::consts::TAU).round();
    let leg = |curve, length| Leg::new(curve, length, *gap);
    let line = |from: [f64; 2], to: [f64; 2]| {
        let (length, heading) = (libm::hypot(to[0] - from[0], to[1] - from[1]), angle(from, to));
        leg(Curve::Line { from: from.into(), to: to.into(), heading, turned: 0.0 }, length)
    };
    let to_heading = angle(start, corners[0].2);
    let sweep = wrap(to_heading - heading);
    let position = Vector::from(start);
    let mut legs =
        vec![leg(Curve::Turn { position, from_heading: heading, to_heading, sweep }, 0.0)];
    let mut at = start;
    for (number, corner, arriving, leaving) in corners {
        legs.push(line(at, *arriving));
        let start_angle = angle(*corner, *arriving);
        let sweep = wrap(angle(*corner, *leaving) - start_angle);
        let curve = Curve::Arc { center: (*corner).into(), radius, start_angle, sweep };
        let rule = Some(Rule { table: 2, number: *number });
        legs.push(Leg { rule, ..leg(curve, radius * sweep.abs()) });
        at = *leaving;
    }
    legs.push(line(at, goal));

    // At the first corner: the corner itself, or with a large gap the outer wall x = 0, which
    // the robot's outer corner passes when it is level with it (docs/method.md 6.2).
    let (before, corner) = (legs[1].length, corners[0].1);
    let outer = libm::hypot(1.0 + gap, 0.75);
    let clearance = if *gap <= corner[0] - outer {
        let wall = corner.into();
        Clearance { value: *gap, at: before + legs[2].length / 2.0, wall }
    } else {
        let Curve::Arc { start_angle, .. } = legs[2].curve else { unreachable!() };
        let level = std::f64::consts::PI - libm::atan2(0.75, 1.0 + gap);
        let at = before + radius * (start_angle - level);
        Clearance { value: corner[0] - outer, at, wall: [0.0, corner[1]].into() }
    };
    Trajectory {
        dimension: 2,
        gaps_per_junction: 1,
        length: *total,
        duration: total + 4.0,
        clearance,
        gaps: vec![*gap; N],
        route: (0..=N as u64).collect(),
        legs,
        ..Trajectory::default()
    }
}
