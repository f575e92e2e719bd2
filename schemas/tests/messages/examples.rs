//! One message of each kind, the same for ever.

use schemas::convert::{CellWriter, Certificate, PartSink, TrajectoryWriter, write_refusal};
use schemas::json;
use schemas::message::{
    Answer, AxisBox, Clearance, Curve, Direction, ErrorCode, Leg, Refusal, ReplyPart, RequestKey,
    Rule, Rung, Sample, SceneRequest, Trajectory,
};
use schemas::wire::{self, ReplyHeader, reported};

pub(crate) const KEY: RequestKey = RequestKey { client: 0x0123_4567_89ab_cdef, sequence: 3 };
pub(crate) const SENT_NS: u64 = 1_700_000_000_123_456_789;

/// Section 4 of the paper.
pub(crate) const SECTION_4: &str = r#"{
    "id": 7, "task": "disassemble",
    "free_space": { "channels": [ {"min": [4, 1], "max": [7, 6]}, {"min": [1, 2], "max": [7, 6]},
        {"min": [1, 2], "max": [5, 7]} ], "in_order": true },
    "body": { "polygon": [[4.5, 1.01], [4.5, 4], [6.99, 4], [6.99, 1.01]] },
    "clearance": { "gap": 0.2 },
    "limits": { "speed": 1.0, "acceleration": 0.5 },
    "sampling": { "period": 0.02 }
}"#;

/// By name: every form of every field is in one of them.
pub(crate) const SCENES: [(&str, &str); 10] = [
    ("section-4", SECTION_4),
    (
        "assemble-from-solids",
        r#"{ "task": "assemble",
        "free_space": { "solids": [ {"polygon": [[0, 0], [8, 0], [8, 7]]},
            {"box": {"min": [0, 0], "max": [1, 7]}} ], "bounds": {"min": [0, 0], "max": [8, 7]} },
        "body": { "box": {"min": [4, 1], "max": [5, 2]} }, "exit": ["+z", "-x"],
        "clearance": { "each": [0.01, [0.1, 0.2], "safest", {"gaps": [[0.1, 0.2], 0.3]}] },
        "sampling": { "count": 100 }, "deadline": 0.25 }"#,
    ),
    (
        "three-dimensions",
        r#"{ "id": 18446744073709551615, "task": "disassemble",
        "free_space": { "channels": [ {"min": [0, 0, 0], "max": [3, 3, 2]},
            {"min": [0, 0, 1], "max": [9, 3, 2]} ] },
        "body": { "box": {"min": [1, 1, 0.5], "max": [2, 2, 0.9]} }, "exit": "-y",
        "clearance": { "gaps": [[0.1, 0.2, 0.3]] }, "sampling": { "spacing": 0.1 } }"#,
    ),
    (
        "drive",
        r#"{ "id": 1, "task": "drive",
        "free_space": { "channels": [ {"min": [0, 0], "max": [3, 20]},
            {"min": [0, 17], "max": [20, 20]} ], "in_order": true },
        "body": { "footprint": {"width": 1.0, "length": 1.5} },
        "start": {"position": [1.5, 2], "heading": 1.5707963267948966},
        "goal": {"position": [18, 18.5], "heading": -0.25}, "start_turn": "while_moving",
        "clearance": { "gaps": [0.2] },
        "limits": { "speed": 2, "acceleration": 1, "yaw_rate": 0.5, "yaw_acceleration": 0.75,
            "lateral_acceleration": 0.25 } }"#,
    ),
    (
        "drive-safest",
        r#"{ "task": "drive", "free_space": { "channels": [] },
        "body": { "footprint": {"width": 1, "length": 2} },
        "start": {"position": [1, 2], "heading": 0}, "goal": {"position": [3, 4]},
        "start_turn": "in_place", "clearance": "safest" }"#,
    ),
    (
        "curve",
        r#"{ "task": "disassemble", "free_space": { "solids": [] },
        "body": { "polygon": [[0, 0], [1, 0], [0, 1]] }, "exit": ["+x", "+y", "-z"],
        "clearance": { "curve": 9 } }"#,
    ),
    (
        "drive-anywhere",
        r#"{ "id": 2, "task": "drive", "free_space": { "solids": [
            {"polygon": [[2, 2], [5, 3], [4, 6]]} ], "bounds": {"min": [0, 0], "max": [9, 8]} },
        "body": { "footprint": {"width": 0.6, "front": 0.9, "rear": 0.25} },
        "start": {"position": [1, 2], "heading": 0}, "goal": {"position": [8, 7], "heading": 1.5},
        "reverse": true, "turn_in_place": false, "min_turn_radius": 0.75, "turn_cost": 0.5,
        "stop_cost": 0.125, "report": "full",
        "clearance": { "each": [0.1, {"at_least": 0.05}, "safest"] } }"#,
    ),
    (
        "drive-named",
        r#"{ "task": "drive", "free_space": { "named":
            "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f" },
        "body": { "footprint": {"width": 1, "length": 2} },
        "start": {"position": [1, 2], "heading": 0}, "goal": {"position": [3, 4]},
        "reverse": false, "turn_in_place": true, "clearance": { "at_least": 0.25 } }"#,
    ),
    (
        "assemble-in-frames",
        r#"{ "task": "assemble", "free_space": { "channels": [
            {"half_spaces": [{"axis": "x", "at_least": 0}, {"axis": "x", "at_most": 3},
                {"axis": "z", "at_least": 0}, {"axis": "z", "at_most": 4}]} ] },
        "body": { "box": {"min": [1, 1], "max": [2, 2]} },
        "start": {"position": [13, 3]}, "goal": {"position": [12, -6]},
        "clearance": "safest", "limits": { "jerk": 2, "yaw_jerk": 3 },
        "frames": { "fixed": {"position": [12, -6], "heading": 0.5},
            "fixed_at_end": {"position": [14, 1], "heading": 0},
            "moving": {"position": [12, -5], "heading": -1}, "samples": "base" },
        "corners": "arc", "stop_at_joints": true }"#,
    ),
    (
        "unions-of-boxes",
        r#"{ "task": "disassemble",
        "free_space": { "solids": [ {"boxes": [ {"min": [0, 0, 0], "max": [9, 9, 1]},
            {"min": [0, 0, 1], "max": [1, 9, 5]} ]}, {"box": {"min": [7, 0, 1], "max": [9, 9, 5]}} ] },
        "body": { "boxes": [ {"min": [2, 2, 1], "max": [3, 3, 4]},
            {"min": [3, 2, 3], "max": [5, 3, 4]} ] },
        "clearance": { "gap": 0.25 }, "path": "shortest", "report": "full" }"#,
    ),
];

/// How many of [`SCENES`] recordings of version 2 can say.
pub(crate) const SCENES_OF_VERSION_2: usize = 8;

/// How many of [`SCENES`] version 1 can say.
pub(crate) const OLD_SCENES: usize = 6;

pub(crate) fn scene(text: &str) -> SceneRequest {
    json::read_scene(text).unwrap()
}

/// By name: a trajectory of assembly in two and in three dimensions, of driving, and
/// refusals with and without everything; what version 1 does not have is last.
pub(crate) fn parts() -> [(&'static str, ReplyPart); 7] {
    [
        ("assembly-2d", of_answer(Ok(assembly()))),
        ("assembly-3d", of_answer(Ok(assembly_3d()))),
        ("driving", of_answer(Ok(driving()))),
        ("refusal", of_answer(Err(refusal()))),
        ("refusal-of-a-field", ReplyPart { id: None, answers: 0, ..of_answer(Err(invalid())) }),
        ("refusal-too-costly", of_answer(Err(too_costly()))),
        ("driving-anywhere", of_answer(Ok(anywhere()))),
    ]
}

/// How many of [`parts`] version 1 can say.
pub(crate) const OLD_PARTS: usize = 5;

pub(crate) fn of_answer(content: Answer) -> ReplyPart {
    let (id, sent_ns) = (Some(7), SENT_NS);
    ReplyPart { key: KEY, id, sent_ns, part: 0, last: true, answer: 0, answers: 1, content }
}

fn line(from: [f64; 2], to: [f64; 2], length: f64, junction: Option<u64>) -> Leg {
    Leg {
        curve: Curve::Line { from: from.into(), to: to.into(), heading: 0.0, turned: 0.0 },
        length,
        clearance: 0.01,
        junction,
        rule: junction.map(|_| Rule { table: 1, number: 1 }),
        reverse: false,
        rung: None,
    }
}

pub(crate) fn assembly() -> Trajectory {
    let sample = |t, x, z| Sample {
        t,
        position: [x, z, 0.0],
        velocity: [0.5, -0.5, 0.0],
        ..Sample::default()
    };
    Trajectory {
        dimension: 2,
        gaps_per_junction: 2,
        exit: None,
        length: 3.5,
        bound: None,
        complete: true,
        duration: 6.25,
        clearance: Clearance { value: 0.01, at: 0.0, wall: [6.99, 1.0].into() },
        free_clearance: None,
        gaps: vec![0.2, 0.2, 0.1, 0.3],
        route: vec![0, 1, 2],
        channels: Vec::new(),
        legs: vec![
            line([0.0, 0.0], [0.0, 1.5], 1.5, Some(0)),
            line([0.0, 1.5], [-2.0, 1.5], 2.0, None),
        ],
        exceeds: None,
        stops: None,
        samples: vec![sample(0.0, 0.0, 0.0), sample(6.25, -2.0, 1.5)],
    }
}

pub(crate) fn assembly_3d() -> Trajectory {
    let curve = Curve::Line {
        from: [0.0, 0.0, 0.0].into(),
        to: [1.0, 2.0, 2.0].into(),
        heading: 0.0,
        turned: 0.0,
    };
    Trajectory {
        dimension: 3,
        gaps_per_junction: 3,
        exit: Some(Direction::PlusX),
        length: 3.0,
        bound: None,
        complete: true,
        duration: 4.0,
        clearance: Clearance { value: 0.5, at: 1.0, wall: [1.0, 2.0, 3.0].into() },
        free_clearance: None,
        gaps: vec![0.1, 0.2, 0.3],
        route: vec![1, 0],
        channels: vec![AxisBox { min: [0.0, 1.0, 2.0].into(), max: [3.0, 4.0, 5.0].into() }],
        legs: vec![Leg {
            curve,
            length: 3.0,
            clearance: 0.5,
            junction: Some(0),
            rule: None,
            reverse: false,
            rung: None,
        }],
        exceeds: None,
        stops: None,
        samples: vec![Sample {
            t: 4.0,
            position: [1.0, 2.0, 2.0],
            velocity: [0.0, 0.25, 0.5],
            ..Sample::default()
        }],
    }
}

pub(crate) fn driving() -> Trajectory {
    let leg = |curve, length, clearance, junction| Leg {
        curve,
        length,
        clearance,
        junction,
        rule: Some(Rule { table: 2, number: 4 }),
        reverse: false,
        rung: None,
    };
    let turn =
        Curve::Turn { position: [1.5, 2.0].into(), from_heading: 0.0, to_heading: 1.5, sweep: 1.5 };
    let line = Curve::Line {
        from: [1.5, 2.0].into(),
        to: [1.5, 17.0].into(),
        heading: 1.5,
        turned: -0.25,
    };
    let arc = Curve::Arc { center: [3.0, 17.0].into(), radius: 1.5, start_angle: 3.0, sweep: -1.5 };
    Trajectory {
        dimension: 2,
        gaps_per_junction: 1,
        exit: None,
        length: 17.25,
        bound: None,
        complete: true,
        duration: 20.0,
        clearance: Clearance { value: 0.2, at: 16.0, wall: [3.0, 17.0].into() },
        free_clearance: None,
        gaps: vec![0.2, 0.3],
        route: vec![0, 1],
        channels: vec![AxisBox { min: [0.0, 1.0].into(), max: [3.0, 4.0].into() }],
        legs: vec![
            leg(turn, 0.0, 1.0, None),
            leg(line, 15.0, 0.75, Some(0)),
            leg(arc, 2.25, 0.2, Some(0)),
        ],
        exceeds: None,
        stops: None,
        samples: vec![Sample {
            t: 0.5,
            position: [1.5, 2.0, 0.0],
            heading: 0.25,
            velocity: [0.0, 0.0, 0.0],
            yaw_rate: 0.5,
        }],
    }
}

/// [`driving`], with all that a trajectory in any free space has.
pub(crate) fn anywhere() -> Trajectory {
    let mut trajectory = driving();
    let rungs = [Some(Rung::Aligned), Some(Rung::Taut), Some(Rung::Reverse)];
    for (leg, rung) in trajectory.legs.iter_mut().zip(rungs) {
        (leg.rung, leg.rule, leg.junction) = (rung, None, None);
    }
    trajectory.legs[2].reverse = true;
    Trajectory {
        bound: Some(17.125),
        complete: false,
        free_clearance: Some(0.25),
        route: Vec::new(),
        channels: Vec::new(),
        ..trajectory
    }
}

pub(crate) fn refusal() -> Refusal {
    let message = "junction 1 is 2.40 m wide, the body needs more than 2.49 m";
    Refusal {
        junction: Some(1),
        needs: Some(2.49),
        has: Some(2.4),
        ..Refusal::new(ErrorCode::JunctionTooSmall, message)
    }
}

pub(crate) fn invalid() -> Refusal {
    Refusal {
        axis: Some(2),
        least: Some(0.0),
        most: Some(0.5),
        heading: Some(-0.5),
        ..Refusal::invalid("clearance.gap[1]", "clearance.gap[1] must be positive — but is −1")
    }
}

pub(crate) fn too_costly() -> Refusal {
    let message = "the route takes more than 16777216 steps (caps.route_steps)";
    Refusal {
        has: Some(16_777_216.0),
        setting: Some("caps.route_steps".to_owned()),
        ..Refusal::new(ErrorCode::TooCostly, message)
    }
}

/// Keeps parts as they would lie in shared memory.
#[derive(Default)]
pub(crate) struct Parts(pub(crate) Vec<(ReplyHeader, Vec<u64>)>);

impl PartSink for Parts {
    type Error = std::convert::Infallible;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Self::Error> {
        let mut payload = vec![u64::MAX; cells];
        let mut writer = CellWriter::new(&mut payload);
        fill(&mut writer);
        assert_eq!(writer.filled(), cells, "cells that nobody wrote");
        self.0.push((*header, payload));
        Ok(())
    }
}

/// Writes the parts of one answer; `part` gives what stands beside it.
pub(crate) fn write(part: &ReplyPart, sink: &mut Parts) {
    let mut header = ReplyHeader {
        version: wire::VERSION,
        dimension: 2,
        client: part.key.client,
        sequence: part.key.sequence,
        sent_ns: part.sent_ns,
        id: part.id.unwrap_or(0),
        given: if part.id.is_some() { reported::ID } else { 0 },
        part: part.part,
        answer: part.answer,
        answers: part.answers,
        ..ReplyHeader::default()
    };
    match &part.content {
        Err(refusal) => write_refusal(refusal, &mut header, part.last, sink).unwrap(),
        Ok(trajectory) => {
            header.dimension = trajectory.dimension;
            header.gaps_per_junction = trajectory.gaps_per_junction;
            header.exit = ReplyHeader::exit_code(trajectory.exit);
            (header.length, header.duration) = (trajectory.length, trajectory.duration);
            header.clearance = trajectory.clearance.value;
            header.clearance_at = trajectory.clearance.at;
            header.wall = trajectory.clearance.wall.padded();
            header.set_certificate(Certificate {
                bound: trajectory.bound,
                free_clearance: trajectory.free_clearance,
                complete: trajectory.complete,
            });
            header.set_exceeds(trajectory.exceeds);
            header.set_stops(trajectory.stops);
            let writer = TrajectoryWriter {
                gaps: trajectory.gaps.iter().copied(),
                route: trajectory.route.iter().copied(),
                channels: trajectory.channels.iter().copied(),
                legs: trajectory.legs.iter().map(leg),
                samples: trajectory.samples.iter().copied(),
            };
            writer.write(&mut header, part.last, sink).unwrap();
        }
    }
}

fn leg(leg: &Leg) -> wire::Leg {
    let rule = leg.rule.unwrap_or(Rule { table: 0, number: 0 });
    let cells = wire::Leg {
        table: rule.table,
        number: rule.number,
        junction: leg.junction.unwrap_or(u64::MAX),
        length: leg.length,
        clearance: leg.clearance,
        reverse: leg.reverse.into(),
        rung: wire::Leg::rung_code(leg.rung),
        ..wire::Leg::default()
    };
    match leg.curve {
        Curve::Line { from, to, heading, turned } => wire::Leg {
            kind: 0,
            point: from.padded(),
            to: to.padded(),
            heading,
            sweep: turned,
            ..cells
        },
        Curve::Arc { center, radius, start_angle, sweep } => wire::Leg {
            kind: 1,
            point: center.padded(),
            radius,
            start: start_angle,
            sweep,
            ..cells
        },
        Curve::Clothoid { from, to, from_heading, to_heading, curvatures, length: _ } => {
            wire::Leg {
                kind: 3,
                point: from.padded(),
                to: to.padded(),
                start: from_heading,
                heading: to_heading,
                radius: curvatures[0],
                sweep: curvatures[1],
                ..cells
            }
        }
        Curve::Turn { position, from_heading, to_heading, sweep } => wire::Leg {
            kind: 2,
            point: position.padded(),
            start: from_heading,
            heading: to_heading,
            sweep,
            ..cells
        },
    }
}
