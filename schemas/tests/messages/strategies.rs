//! Random messages.

use proptest::collection::vec;
use proptest::option::of;
use proptest::prelude::*;
use schemas::message::{
    Answer, AxisBox, Body, Choice, Clearance, ClearanceWish, Corners, Curve, Digest, Direction,
    ErrorCode, ExceededLimit, Exceeds, Footprint, Frames, FreeSpace, Gap, Goal, Leg, Limits,
    PathChoice, Pose, Refusal, ReplyPart, Report, RequestKey, Rule, Rung, Sample, SampleFrame,
    Sampling, SceneRequest, Solid, StartTurn, Task, Trajectory, Vector,
};

pub(crate) type Numbers = BoxedStrategy<f64>;

/// All that JSON can say.
pub(crate) fn finite() -> Numbers {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    let any = POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO;
    prop_oneof![any, -10.0..10.0, Just(1.0)].boxed()
}

/// All but NaN, which equals nothing.
pub(crate) fn numbers() -> Numbers {
    prop_oneof![9 => finite(), 1 => Just(f64::INFINITY), 1 => Just(f64::NEG_INFINITY)].boxed()
}

pub(crate) const TASKS: [Task; 3] = [Task::Disassemble, Task::Assemble, Task::Drive];

pub(crate) const RUNGS: [Rung; 5] =
    [Rung::Taut, Rung::Radius, Rung::Aligned, Rung::Reverse, Rung::Lattice];

pub(crate) const DIRECTIONS: [Direction; 6] = [
    Direction::PlusX,
    Direction::MinusX,
    Direction::PlusY,
    Direction::MinusY,
    Direction::PlusZ,
    Direction::MinusZ,
];

pub(crate) const ERRORS: [ErrorCode; 16] = [
    ErrorCode::InvalidScene,
    ErrorCode::UnsupportedVersion,
    ErrorCode::BodyOutsideFreeSpace,
    ErrorCode::GoalOutsideFreeSpace,
    ErrorCode::NoRoute,
    ErrorCode::JunctionTooSmall,
    ErrorCode::GapOutOfRange,
    ErrorCode::CornersTooClose,
    ErrorCode::TurnBlocked,
    ErrorCode::WallInTheWay,
    ErrorCode::TooManySamples,
    ErrorCode::DeadlineExceeded,
    ErrorCode::Overloaded,
    ErrorCode::Internal,
    ErrorCode::TooCostly,
    ErrorCode::UnknownFreeSpace,
];

fn one_of<T: Copy + std::fmt::Debug + 'static>(all: &'static [T]) -> BoxedStrategy<T> {
    proptest::sample::select(all).boxed()
}

fn vector(numbers: &Numbers, dimension: usize) -> BoxedStrategy<Vector> {
    vec(numbers.clone(), dimension).prop_map(|values| Vector::new(&values).unwrap()).boxed()
}

fn axis_box(numbers: &Numbers, dimension: usize) -> BoxedStrategy<AxisBox> {
    let corner = vector(numbers, dimension);
    (corner.clone(), corner).prop_map(|(min, max)| AxisBox { min, max }).boxed()
}

fn gap(numbers: &Numbers) -> BoxedStrategy<Gap> {
    let several = |dimension| vector(numbers, dimension).prop_map(Gap::PerAxis);
    prop_oneof![numbers.clone().prop_map(Gap::Uniform), several(1), several(2), several(3)].boxed()
}

fn wish(numbers: &Numbers) -> BoxedStrategy<ClearanceWish> {
    let gaps = vec(gap(numbers), 0..4);
    let choice = prop_oneof![
        gap(numbers).prop_map(Choice::Gap),
        gaps.clone().prop_map(Choice::Gaps),
        Just(Choice::Safest),
        numbers.clone().prop_map(Choice::AtLeast),
    ];
    prop_oneof![
        gap(numbers).prop_map(ClearanceWish::Gap),
        gaps.prop_map(ClearanceWish::Gaps),
        Just(ClearanceWish::Safest),
        vec(choice, 0..5).prop_map(ClearanceWish::Each),
        any::<u64>().prop_map(ClearanceWish::Curve),
        numbers.clone().prop_map(ClearanceWish::AtLeast),
    ]
    .boxed()
}

fn sampling(numbers: &Numbers) -> BoxedStrategy<Sampling> {
    prop_oneof![
        numbers.clone().prop_map(Sampling::Period),
        numbers.clone().prop_map(Sampling::Spacing),
        any::<u64>().prop_map(Sampling::Count),
    ]
    .boxed()
}

fn limits(numbers: &Numbers) -> BoxedStrategy<Limits> {
    let limit = || of(numbers.clone());
    (limit(), limit(), limit(), limit(), limit(), limit(), limit())
        .prop_map(
            |(
                speed,
                acceleration,
                yaw_rate,
                yaw_acceleration,
                lateral_acceleration,
                jerk,
                yaw_jerk,
            )| Limits {
                speed,
                acceleration,
                yaw_rate,
                yaw_acceleration,
                lateral_acceleration,
                jerk,
                yaw_jerk,
            },
        )
        .boxed()
}

/// A scene that all forms can say: its points agree in their dimension.
pub(crate) fn scene(numbers: Numbers) -> BoxedStrategy<SceneRequest> {
    (2..=3_usize).prop_flat_map(move |dimension| scene_of(&numbers, dimension)).boxed()
}

fn scene_of(numbers: &Numbers, dimension: usize) -> BoxedStrategy<SceneRequest> {
    let planar = dimension == 2;
    let (sides, corner) = (axis_box(numbers, dimension), vector(numbers, dimension));
    let polygon = vec(corner, 0..6);
    let boxes = vec(sides.clone(), 0..4);
    let solid = prop_oneof![
        polygon.clone().prop_map(Solid::Polygon),
        sides.clone().prop_map(Solid::Box),
        boxes.clone().prop_map(Solid::Boxes)
    ];
    let free_space =
        (of(vec(sides.clone(), 0..5)), any::<bool>(), of(vec(solid, 0..5)), of(sides.clone()));
    let free_space = (free_space, of(any::<[u8; 32]>().prop_map(Digest))).prop_map(
        |((channels, in_order, solids, bounds), named)| FreeSpace {
            channels,
            in_order,
            solids,
            bounds,
            named,
        },
    );
    let solid_body = prop_oneof![
        polygon.prop_map(Body::Polygon),
        sides.prop_map(Body::Box),
        boxes.prop_map(Body::Boxes)
    ];
    let footprint = (numbers.clone(), numbers.clone(), of(numbers.clone()));
    let footprint = footprint.prop_map(|(width, along, rear)| {
        Body::Footprint(match rear {
            None => Footprint::Centered { width, length: along },
            Some(rear) => Footprint::Offset { width, front: along, rear },
        })
    });
    let body = match planar {
        true => prop_oneof![solid_body, footprint].boxed(),
        false => solid_body.boxed(),
    };
    let position = vector(numbers, dimension);
    let pose = (position.clone(), numbers.clone())
        .prop_map(|(position, heading)| Pose { position, heading });
    // In space nothing turns.
    let start = pose.clone().prop_map(move |pose| match planar {
        true => pose,
        false => Pose { heading: 0.0, ..pose },
    });
    let goal = (position, of(numbers.clone())).prop_map(move |(position, heading)| Goal {
        position,
        heading: heading.filter(|_| planar),
    });
    let frame = of(one_of(&[SampleFrame::Fixed, SampleFrame::Base]));
    let frames = (pose.clone(), of(pose.clone()), of(pose), frame).prop_map(
        |(fixed, fixed_at_end, moving, samples)| Frames { fixed, fixed_at_end, moving, samples },
    );
    let what = (
        of(any::<u64>()),
        one_of(&TASKS),
        free_space,
        body,
        vec(one_of(&DIRECTIONS), 0..4),
        of(start),
    );
    let how = (
        of(goal),
        of(one_of(&[StartTurn::InPlace, StartTurn::WhileMoving])),
        wish(numbers),
        limits(numbers),
        of(sampling(numbers)),
        of(numbers.clone()),
    );
    let manner = (
        of(any::<bool>()),
        of(any::<bool>()),
        [of(numbers.clone()), of(numbers.clone()), of(numbers.clone())],
        of(Just(Report::Full)),
        of(frames),
        of(one_of(&[Corners::Sharp, Corners::Arc])),
        of(any::<bool>()),
        of(one_of(&[PathChoice::Rules, PathChoice::Shortest])),
    );
    (what, how, manner)
        .prop_map(
            |(
                (id, task, free_space, body, exit, start),
                (goal, start_turn, clearance, limits, sampling, deadline),
                (
                    reverse,
                    turn_in_place,
                    [min_turn_radius, turn_cost, stop_cost],
                    report,
                    frames,
                    corners,
                    stop_at_joints,
                    path,
                ),
            )| SceneRequest {
                id,
                task,
                free_space,
                body,
                exit,
                start,
                goal,
                start_turn,
                reverse,
                turn_in_place,
                min_turn_radius,
                turn_cost,
                stop_cost,
                report,
                clearance,
                limits,
                sampling,
                deadline,
                frames,
                corners,
                stop_at_joints,
                path,
            },
        )
        .boxed()
}

pub(crate) fn key() -> BoxedStrategy<RequestKey> {
    any::<(u64, u64)>().prop_map(|(client, sequence)| RequestKey { client, sequence }).boxed()
}

fn leg(numbers: &Numbers, dimension: usize) -> BoxedStrategy<Leg> {
    let (point, number) = (|| vector(numbers, dimension), || numbers.clone());
    let curve = prop_oneof![
        (point(), point(), number(), number())
            .prop_map(|(from, to, heading, turned)| Curve::Line { from, to, heading, turned }),
        (point(), number(), number(), number()).prop_map(|(center, radius, start_angle, sweep)| {
            Curve::Arc { center, radius, start_angle, sweep }
        }),
        (point(), number(), number(), number()).prop_map(
            |(position, from_heading, to_heading, sweep)| Curve::Turn {
                position,
                from_heading,
                to_heading,
                sweep
            }
        ),
        (point(), point(), [number(), number(), number(), number()]).prop_map(
            |(from, to, [from_heading, to_heading, first, last])| Curve::Clothoid {
                from,
                to,
                from_heading,
                to_heading,
                curvatures: [first, last],
                length: 0.0,
            }
        ),
    ];
    let rule = (1..=u16::MAX, any::<u16>()).prop_map(|(table, number)| Rule { table, number });
    let found = (any::<bool>(), of(one_of(&RUNGS)));
    (curve, number(), number(), of(0..u64::MAX), of(rule), found)
        .prop_map(|(mut curve, length, clearance, junction, rule, (backwards, rung))| {
            let reverse = backwards && !matches!(curve, Curve::Turn { .. });
            if let Curve::Clothoid { length: of_curve, .. } = &mut curve {
                *of_curve = length;
            }
            Leg { curve, length, clearance, junction, rule, reverse, rung }
        })
        .boxed()
}

fn sample(numbers: &Numbers) -> BoxedStrategy<Sample> {
    proptest::array::uniform9(numbers.clone())
        .prop_map(|[t, x, y, z, heading, u, v, w, yaw_rate]| Sample {
            t,
            position: [x, y, z],
            heading,
            velocity: [u, v, w],
            yaw_rate,
        })
        .boxed()
}

pub(crate) fn trajectory(numbers: Numbers) -> BoxedStrategy<Trajectory> {
    (2..=3_usize).prop_flat_map(move |dimension| trajectory_of(&numbers, dimension)).boxed()
}

fn trajectory_of(numbers: &Numbers, dimension: usize) -> BoxedStrategy<Trajectory> {
    let number = || numbers.clone();
    let scalars = (
        any::<u32>(),
        of(one_of(&DIRECTIONS)),
        [number(), number(), number(), number()],
        vector(numbers, dimension),
        (of(number()), any::<bool>(), of(number()), of((any::<u32>(), number())), of(any::<u64>())),
    );
    let lists = (
        vec(number(), 0..5),
        vec(any::<u64>(), 0..5),
        vec(axis_box(numbers, dimension), 0..3),
        vec(leg(numbers, dimension), 0..5),
        vec(sample(numbers), 0..5),
    );
    (scalars, lists)
        .prop_map(
            move |(
                (
                    gaps_per_junction,
                    exit,
                    [length, duration, value, at],
                    wall,
                    (bound, complete, free_clearance, exceeds, stops),
                ),
                (gaps, route, channels, legs, samples),
            )| Trajectory {
                dimension: dimension as u32,
                gaps_per_junction,
                exit,
                length,
                bound,
                complete,
                duration,
                clearance: Clearance { value, at, wall },
                free_clearance,
                gaps,
                route,
                channels,
                legs,
                samples,
                exceeds: exceeds.map(|(joints, jump)| Exceeds {
                    limit: ExceededLimit::YawAcceleration,
                    joints: joints.into(),
                    jump,
                }),
                stops,
            },
        )
        .boxed()
}

pub(crate) fn refusal(numbers: &Numbers) -> BoxedStrategy<Refusal> {
    let number = || of(numbers.clone());
    (
        (one_of(&ERRORS), ".{0,40}", of(".{0,20}"), of(".{0,20}")),
        (of(any::<u64>()), of(0..3_u32)),
        [number(), number(), number(), number(), number()],
    )
        .prop_map(|((code, message, field, setting), (junction, axis), numbers)| {
            let [needs, has, least, most, heading] = numbers;
            Refusal {
                code,
                message,
                field,
                junction,
                axis,
                needs,
                has,
                least,
                most,
                heading,
                setting,
            }
        })
        .boxed()
}

pub(crate) fn part(numbers: Numbers) -> BoxedStrategy<ReplyPart> {
    let content: BoxedStrategy<Answer> = prop_oneof![
        3 => trajectory(numbers.clone()).prop_map(Ok),
        1 => refusal(&numbers).prop_map(Err),
    ]
    .boxed();
    let head = (key(), of(any::<u64>()), any::<u64>(), any::<(u32, bool, u32, u32)>());
    (head, content)
        .prop_map(|((key, id, sent_ns, (part, last, answer, answers)), content)| ReplyPart {
            key,
            id,
            sent_ns,
            part,
            last,
            answer,
            answers,
            content,
        })
        .boxed()
}
