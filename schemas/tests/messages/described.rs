//! The codec's bytes, read by the words of `codec/request.txt` and `codec/reply.txt`
//! alone, and written by another program of the same encoding.

use proptest::prelude::*;
use schemas::codec;
use schemas::message::{
    AxisBox, Body, Choice, Clearance, ClearanceWish, Corners, Curve, Digest, ErrorCode,
    ExceededLimit, Exceeds, Footprint, Frames, FreeSpace, Gap, Goal, Leg, Limits, PathChoice, Pose,
    Refusal, ReplyPart, Report, Request, RequestContent, RequestKey, Rule, Sample, SampleFrame,
    Sampling, SceneRequest, Solid, StartTurn, Trajectory, Vector,
};

use super::strategies::{
    DIRECTIONS, ERRORS, RUNGS, TASKS, finite, key, numbers, part, refusal, scene,
};

/// Bytes from the front.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (taken, rest) = self.0.split_first_chunk().expect("bytes are left");
        self.0 = rest;
        *taken
    }

    fn bool(&mut self) -> bool {
        match self.take() {
            [0] => false,
            [1] => true,
            [byte] => panic!("{byte} is no bool"),
        }
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take())
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    fn option<T>(&mut self, read: fn(&mut Self) -> T) -> Option<T> {
        self.bool().then(|| read(self))
    }

    fn list<T>(&mut self, read: fn(&mut Self) -> T) -> Vec<T> {
        (0..self.u64()).map(|_| read(self)).collect()
    }

    fn text(&mut self) -> String {
        let bytes = self.u64() as usize;
        let (text, rest) = self.0.split_at(bytes);
        self.0 = rest;
        String::from_utf8(text.to_vec()).unwrap()
    }

    fn vector(&mut self) -> Vector {
        Vector::new(&self.list(Self::f64)).expect("1 to 3 numbers")
    }

    fn one_of<T: Copy>(&mut self, variants: &[T]) -> T {
        variants[self.u32() as usize]
    }
}

fn read_key(from: &mut Bytes) -> RequestKey {
    RequestKey { client: from.u64(), sequence: from.u64() }
}

fn read_request(from: &mut Bytes) -> Request {
    Request {
        key: read_key(from),
        sent_ns: from.u64(),
        content: match from.u32() {
            0 => RequestContent::Scene(read_scene(from)),
            1 => RequestContent::Unreadable {
                header: from.list(Bytes::u64),
                cells: from.list(Bytes::u64),
            },
            other => panic!("{other}"),
        },
    }
}

fn read_pose(from: &mut Bytes) -> Pose {
    Pose { position: from.vector(), heading: from.f64() }
}

fn read_scene(from: &mut Bytes) -> SceneRequest {
    let id = from.option(Bytes::u64);
    let task = from.one_of(&TASKS);
    let channels = from.option(|from| from.list(read_box));
    let in_order = from.bool();
    let solids = from.option(|from| {
        from.list(|from| match from.u32() {
            0 => Solid::Polygon(from.list(Bytes::vector)),
            1 => Solid::Box(read_box(from)),
            2 => Solid::Boxes(from.list(read_box)),
            other => panic!("{other}"),
        })
    });
    let bounds = from.option(read_box);
    let named = from.option(|from| Digest(from.take()));
    SceneRequest {
        id,
        task,
        free_space: FreeSpace { channels, in_order, solids, bounds, named },
        body: match from.u32() {
            0 => Body::Polygon(from.list(Bytes::vector)),
            1 => Body::Box(read_box(from)),
            2 => Body::Footprint(read_footprint(from)),
            3 => Body::Boxes(from.list(read_box)),
            other => panic!("{other}"),
        },
        exit: from.list(|from| from.one_of(&DIRECTIONS)),
        start: from.option(read_pose),
        goal: from
            .option(|from| Goal { position: from.vector(), heading: from.option(Bytes::f64) }),
        start_turn: from.option(|from| from.one_of(&[StartTurn::InPlace, StartTurn::WhileMoving])),
        reverse: from.option(Bytes::bool),
        turn_in_place: from.option(Bytes::bool),
        min_turn_radius: from.option(Bytes::f64),
        turn_cost: from.option(Bytes::f64),
        stop_cost: from.option(Bytes::f64),
        report: from.option(|from| from.one_of(&[Report::Full])),
        clearance: match from.u32() {
            0 => ClearanceWish::Gap(read_gap(from)),
            1 => ClearanceWish::Gaps(from.list(read_gap)),
            2 => ClearanceWish::Safest,
            3 => ClearanceWish::Each(from.list(|from| match from.u32() {
                0 => Choice::Gap(read_gap(from)),
                1 => Choice::Gaps(from.list(read_gap)),
                2 => Choice::Safest,
                3 => Choice::AtLeast(from.f64()),
                other => panic!("{other}"),
            })),
            4 => ClearanceWish::Curve(from.u64()),
            5 => ClearanceWish::AtLeast(from.f64()),
            other => panic!("{other}"),
        },
        limits: Limits {
            speed: from.option(Bytes::f64),
            acceleration: from.option(Bytes::f64),
            yaw_rate: from.option(Bytes::f64),
            yaw_acceleration: from.option(Bytes::f64),
            lateral_acceleration: from.option(Bytes::f64),
            jerk: from.option(Bytes::f64),
            yaw_jerk: from.option(Bytes::f64),
        },
        sampling: from.option(|from| match from.u32() {
            0 => Sampling::Period(from.f64()),
            1 => Sampling::Spacing(from.f64()),
            2 => Sampling::Count(from.u64()),
            other => panic!("{other}"),
        }),
        deadline: from.option(Bytes::f64),
        frames: from.option(|from| Frames {
            fixed: read_pose(from),
            fixed_at_end: from.option(read_pose),
            moving: from.option(read_pose),
            samples: from.option(|from| from.one_of(&[SampleFrame::Fixed, SampleFrame::Base])),
        }),
        corners: from.option(|from| from.one_of(&[Corners::Sharp, Corners::Arc])),
        stop_at_joints: from.option(Bytes::bool),
        path: from.option(|from| from.one_of(&[PathChoice::Rules, PathChoice::Shortest])),
    }
}

fn read_box(from: &mut Bytes) -> AxisBox {
    AxisBox { min: from.vector(), max: from.vector() }
}

fn read_footprint(from: &mut Bytes) -> Footprint {
    match from.u32() {
        0 => Footprint::Centered { width: from.f64(), length: from.f64() },
        1 => Footprint::Offset { width: from.f64(), front: from.f64(), rear: from.f64() },
        other => panic!("{other}"),
    }
}

fn read_gap(from: &mut Bytes) -> Gap {
    match from.u32() {
        0 => Gap::Uniform(from.f64()),
        1 => Gap::PerAxis(from.vector()),
        other => panic!("{other}"),
    }
}

fn read_part(from: &mut Bytes) -> ReplyPart {
    ReplyPart {
        key: read_key(from),
        id: from.option(Bytes::u64),
        sent_ns: from.u64(),
        part: from.u32(),
        last: from.bool(),
        answer: from.u32(),
        answers: from.u32(),
        content: match from.u32() {
            0 => Ok(read_trajectory(from)),
            1 => Err(read_refusal(from)),
            other => panic!("{other}"),
        },
    }
}

fn read_trajectory(from: &mut Bytes) -> Trajectory {
    Trajectory {
        dimension: from.u32(),
        gaps_per_junction: from.u32(),
        exit: from.option(|from| from.one_of(&DIRECTIONS)),
        length: from.f64(),
        bound: from.option(Bytes::f64),
        complete: from.bool(),
        duration: from.f64(),
        clearance: Clearance { value: from.f64(), at: from.f64(), wall: from.vector() },
        free_clearance: from.option(Bytes::f64),
        gaps: from.list(Bytes::f64),
        route: from.list(Bytes::u64),
        channels: from.list(read_box),
        legs: from.list(read_leg),
        samples: from.list(|from| Sample {
            t: from.f64(),
            position: [from.f64(), from.f64(), from.f64()],
            heading: from.f64(),
            velocity: [from.f64(), from.f64(), from.f64()],
            yaw_rate: from.f64(),
        }),
        exceeds: from.option(|from| Exceeds {
            limit: from.one_of(&[ExceededLimit::YawAcceleration]),
            joints: from.u64(),
            jump: from.f64(),
        }),
        stops: from.option(Bytes::u64),
    }
}

fn read_leg(from: &mut Bytes) -> Leg {
    Leg {
        curve: match from.u32() {
            0 => Curve::Line {
                from: from.vector(),
                to: from.vector(),
                heading: from.f64(),
                turned: from.f64(),
            },
            1 => Curve::Arc {
                center: from.vector(),
                radius: from.f64(),
                start_angle: from.f64(),
                sweep: from.f64(),
            },
            2 => Curve::Turn {
                position: from.vector(),
                from_heading: from.f64(),
                to_heading: from.f64(),
                sweep: from.f64(),
            },
            3 => Curve::Clothoid {
                from: from.vector(),
                to: from.vector(),
                from_heading: from.f64(),
                to_heading: from.f64(),
                curvatures: [from.f64(), from.f64()],
                length: from.f64(),
            },
            other => panic!("{other}"),
        },
        length: from.f64(),
        clearance: from.f64(),
        junction: from.option(Bytes::u64),
        rule: from.option(|from| Rule { table: from.u16(), number: from.u16() }),
        reverse: from.bool(),
        rung: from.option(|from| from.one_of(&RUNGS)),
    }
}

fn read_refusal(from: &mut Bytes) -> Refusal {
    Refusal {
        code: from.one_of(&ERRORS),
        message: from.text(),
        field: from.option(Bytes::text),
        junction: from.option(Bytes::u64),
        axis: from.option(Bytes::u32),
        needs: from.option(Bytes::f64),
        has: from.option(Bytes::f64),
        least: from.option(Bytes::f64),
        most: from.option(Bytes::f64),
        heading: from.option(Bytes::f64),
        setting: from.option(Bytes::text),
    }
}

#[track_caller]
fn check_described<T>(message: &T, read: fn(&mut Bytes) -> T)
where
    T: serde::Serialize + PartialEq + std::fmt::Debug,
{
    let bytes = codec::encode(message);
    let mut left = Bytes(&bytes);
    assert_eq!(&read(&mut left), message);
    assert_eq!(left.0.len(), 0, "bytes that nothing describes");
}

proptest! {
    #[test]
    fn requests_are_as_described(key in key(), sent_ns: u64, scene in scene(numbers())) {
        let content = RequestContent::Scene(scene);
        check_described(&Request { key, sent_ns, content }, read_request);
    }

    #[test]
    fn unreadable_requests_are_as_described(key in key(), header: Vec<u64>, cells: Vec<u64>) {
        let content = RequestContent::Unreadable { header, cells };
        check_described(&Request { key, sent_ns: 0, content }, read_request);
    }

    #[test]
    fn reply_parts_are_as_described(part in part(numbers())) {
        check_described(&part, read_part);
    }
}

#[test]
fn error_codes_are_described_by_number() {
    for text in [codec::REPLY_SCHEMA.to_owned(), schemas::wire::layout_text()] {
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        for (number, code) in ERRORS.iter().enumerate() {
            let described = format!("{number} {code}");
            assert!(words.contains(&described), "{described}");
        }
    }
    assert_eq!(ERRORS[0], ErrorCode::InvalidScene);
}

/// The same shapes for `wincode`, which shares no code with ours.
mod other {
    use wincode::{SchemaRead, SchemaWrite};

    #[derive(SchemaWrite, SchemaRead, PartialEq, Debug)]
    #[repr(C)]
    pub(super) struct Sample {
        pub(super) t: f64,
        pub(super) position: [f64; 3],
        pub(super) heading: f64,
        pub(super) velocity: [f64; 3],
        pub(super) yaw_rate: f64,
    }

    #[derive(SchemaWrite, SchemaRead, PartialEq, Debug)]
    pub(super) struct Refusal {
        pub(super) code: Code,
        pub(super) message: String,
        pub(super) field: Option<String>,
        pub(super) junction: Option<u64>,
        pub(super) axis: Option<u32>,
        pub(super) needs: Option<f64>,
        pub(super) has: Option<f64>,
        pub(super) least: Option<f64>,
        pub(super) most: Option<f64>,
        pub(super) heading: Option<f64>,
        pub(super) setting: Option<String>,
    }

    #[derive(SchemaWrite, SchemaRead, PartialEq, Debug, Clone, Copy)]
    pub(super) enum Code {
        InvalidScene,
        UnsupportedVersion,
        BodyOutsideFreeSpace,
        GoalOutsideFreeSpace,
        NoRoute,
        JunctionTooSmall,
        GapOutOfRange,
        CornersTooClose,
        TurnBlocked,
        WallInTheWay,
        TooManySamples,
        DeadlineExceeded,
        Overloaded,
        Internal,
        TooCostly,
        UnknownFreeSpace,
    }

    pub(super) const CODES: [Code; 16] = [
        Code::InvalidScene,
        Code::UnsupportedVersion,
        Code::BodyOutsideFreeSpace,
        Code::GoalOutsideFreeSpace,
        Code::NoRoute,
        Code::JunctionTooSmall,
        Code::GapOutOfRange,
        Code::CornersTooClose,
        Code::TurnBlocked,
        Code::WallInTheWay,
        Code::TooManySamples,
        Code::DeadlineExceeded,
        Code::Overloaded,
        Code::Internal,
        Code::TooCostly,
        Code::UnknownFreeSpace,
    ];
}

proptest! {
    #[test]
    fn samples_are_the_same_to_another_codec(
        rows in proptest::collection::vec(proptest::array::uniform9(finite()), 0..20),
    ) {
        let ours: Vec<_> = rows.iter().map(|&[t, x, y, z, heading, u, v, w, yaw_rate]| Sample {
            t, position: [x, y, z], heading, velocity: [u, v, w], yaw_rate,
        }).collect();
        let theirs: Vec<_> = ours.iter().map(|&Sample { t, position, heading, velocity, yaw_rate }| {
            other::Sample { t, position, heading, velocity, yaw_rate }
        }).collect();
        let bytes = codec::encode(&ours);
        prop_assert_eq!(&bytes, &wincode::serialize(&theirs).unwrap());
        prop_assert_eq!(theirs, wincode::deserialize_exact::<Vec<other::Sample>>(&bytes).unwrap());
        prop_assert_eq!(ours, codec::decode::<Vec<Sample>>(&bytes).unwrap());
    }

    #[test]
    fn refusals_are_the_same_to_another_codec(ours in refusal(&finite())) {
        let Refusal {
            code, message, field, junction, axis, needs, has, least, most, heading, setting,
        } = ours.clone();
        let code = other::CODES[ERRORS.iter().position(|error| *error == code).unwrap()];
        let theirs = other::Refusal {
            code, message, field, junction, axis, needs, has, least, most, heading, setting,
        };
        let bytes = codec::encode(&ours);
        prop_assert_eq!(&bytes, &wincode::serialize(&theirs).unwrap());
        prop_assert_eq!(theirs, wincode::deserialize_exact::<other::Refusal>(&bytes).unwrap());
        prop_assert_eq!(ours, codec::decode::<Refusal>(&bytes).unwrap());
    }
}
