//! The tables of the current version.

use std::mem::offset_of;

use super::Words::{Bits, Codes};
use super::{Field, Item, Layout, Payload, Section, Structure, Words, field};
use crate::message::{
    Axis, Corners, CurveKind, Direction, ErrorCode, ExceededLimit, PathChoice, Report, Rung,
    SampleFrame, StartTurn, Task,
};
use crate::wire::{
    Leg, ReplyHeader, RequestHeader, Sample, TapHeader, VERSION, given, present, reported, switch,
};

pub(super) const PREAMBLE: &str = "\
Generated from the structures in schemas/src/wire.rs and their tables.

Little-endian 64-bit machines. Structures are laid out as in C, without padding; columns:
offset in bytes, type, field. Payloads are cells of 8 bytes, items in the order given here.
What a bit or a count declares absent is not read. D is the header's dimension.
";

const GIVEN: [(&str, u64); 33] = [
    ("id", given::ID),
    ("channels", given::CHANNELS),
    ("in_order", given::IN_ORDER),
    ("solids", given::SOLIDS),
    ("bounds", given::BOUNDS),
    ("start", given::START),
    ("goal", given::GOAL),
    ("goal heading", given::GOAL_HEADING),
    ("start_turn", given::START_TURN),
    ("sampling", given::SAMPLING),
    ("deadline", given::DEADLINE),
    ("speed", given::LIMITS),
    ("acceleration", given::LIMITS << 1),
    ("yaw_rate", given::LIMITS << 2),
    ("yaw_acceleration", given::LIMITS << 3),
    ("lateral_acceleration", given::LIMITS << 4),
    ("reverse", given::REVERSE),
    ("turn_in_place", given::TURN_IN_PLACE),
    ("min_turn_radius", given::MIN_TURN_RADIUS),
    ("turn_cost", given::TURN_COST),
    ("stop_cost", given::STOP_COST),
    ("report", given::REPORT),
    ("rear", given::REAR),
    ("named", given::NAMED),
    ("frames", given::FRAMES),
    ("fixed_at_end", given::FIXED_AT_END),
    ("moving", given::MOVING),
    ("sample_frame", given::SAMPLE_FRAME),
    ("corners", given::CORNERS),
    ("stop_at_joints", given::STOP_AT_JOINTS),
    ("jerk", given::JERK),
    ("yaw_jerk", given::YAW_JERK),
    ("path", given::PATH),
];

const SWITCHES: [(&str, u64); 3] = [
    ("reverse", switch::REVERSE as u64),
    ("turn_in_place", switch::TURN_IN_PLACE as u64),
    ("stop_at_joints", switch::STOP_AT_JOINTS as u64),
];

const REPORTED: [(&str, u64); 6] = [
    ("id", reported::ID as u64),
    ("bound", reported::BOUND as u64),
    ("free_clearance", reported::FREE_CLEARANCE as u64),
    ("incomplete", reported::INCOMPLETE as u64),
    ("exceeds", reported::EXCEEDS as u64),
    ("stops", reported::STOPS as u64),
];

const PRESENT: [(&str, u64); 9] = [
    ("junction", present::JUNCTION),
    ("axis", present::AXIS),
    ("needs", present::NUMBERS),
    ("has", present::NUMBERS << 1),
    ("least", present::NUMBERS << 2),
    ("most", present::NUMBERS << 3),
    ("heading", present::NUMBERS << 4),
    ("field", present::FIELD),
    ("setting", present::SETTING),
];

/// The codes of a leg's rung, of which 0 is none.
const RUNGS: [&str; 1 + Rung::NAMES.len()] = {
    let mut names = ["none"; 1 + Rung::NAMES.len()];
    let mut index = 0;
    while index < Rung::NAMES.len() {
        names[1 + index] = Rung::NAMES[index];
        index += 1;
    }
    names
};

macro_rules! words {
    () => {
        Words::None
    };
    ($words:expr) => {
        $words
    };
}

/// A structure by its own fields: `name: "note"` or `name (words): "note"`.
macro_rules! structure {
    ($type:ident: $about:literal $($name:ident $(($words:expr))?: $note:literal)*) => {
        const {
            const FIELDS: &[Field] = &[$(field(
                stringify!($name),
                offset_of!($type, $name),
                |structure: &$type| &structure.$name,
                words!($($words)?),
                $note,
            )),*];
            let (name, note, size) = (stringify!($type), $about, size_of::<$type>());
            let structure = Structure { name, note, size, fields: FIELDS };
            assert!(structure.is_complete(), "a field is missing or out of order");
            Section::Structure(structure)
        }
    };
}

/// A payload: `name: form, "note"`, with `[count]`, `(words)` and `if "condition"`.
macro_rules! payload {
    (
        $payload:literal: $about:literal
        $($name:literal $([$count:literal])? $(($words:expr))? $(if $when:literal)?:
            $form:literal, $note:literal)*
    ) => {
        Section::Payload(Payload {
            name: $payload,
            note: $about,
            items: &[$(Item {
                name: $name,
                count: concat!($($count)?),
                form: $form,
                when: concat!($($when)?),
                words: words!($($words)?),
                note: $note,
            }),*],
        })
    };
}

pub(super) const LAYOUT: Layout = Layout { version: VERSION, sections: SECTIONS };

const SECTIONS: &[Section] = &[
    structure!(RequestHeader: "the user header of a request"
        version: "2"
        dimension: "2 or 3; 2 with a footprint"
        client: "the client's nonce"
        sequence: "counts the client's requests"
        sent_ns: "nanoseconds since the Unix epoch"
        given (Bits(&GIVEN)): "optional fields that are present"
        id: "echoed in the reply"
        task (Codes(Task::NAMES)): ""
        start_turn (Codes(StartTurn::NAMES)): ""
        sampling_kind (Codes(&["period", "spacing", "count"])): ""
        body_kind (Codes(&["polygon", "box", "footprint", "boxes"])): ""
        wish_kind (Codes(&["one choice", "each", "curve"])): ""
        exits: "entries in the payload"
        wake: "1: the client sleeps and must be woken"
        path (Codes(PathChoice::NAMES)): ""
        sampling: "f64 bits in s or m, or the count"
        limits: "speed, acceleration, yaw_rate, yaw_acceleration, lateral_acceleration; SI units"
        deadline: "s from arrival"
        start: "x, y (m), heading (rad); if D is 3: x, y, z"
        goal: "x, y (m), heading (rad); if D is 3: x, y, z"
        bounds: "D of the least corner, then D of the greatest; m"
        curve: "points"
        choices: "entries in the payload: 1 for one choice, 0 for a curve"
        body_points: "points in the payload: vertices, 2 for each box, 1 for a footprint"
        channels: "entries in the payload"
        solids: "entries in the payload"
        switches (Bits(&SWITCHES)): "values of these fields"
        report (Codes(Report::NAMES)): ""
        min_turn_radius: "m"
        turn_cost: "m per rad"
        stop_cost: "m per stop"
        rear: "m; with it the footprint in the payload is width, front"
        named: "SHA-256 of the free space"
        frames: "the fixed part, the fixed part at the end, the moving part: each D f64 (m), zeros, \
            heading (rad) last"
        sample_frame (Codes(SampleFrame::NAMES)): ""
        corners (Codes(Corners::NAMES)): ""
        jerks: "jerk (m/s3), yaw jerk (rad/s3)"),
    payload!("Request": "the payload of a request"
        "exit" ["exits"] (Codes(Direction::NAMES)): "u64", ""
        "choice" ["choices"]: "Choice", ""
        "body" ["body_points"]: "D f64", "m; each box: least, then greatest corner; \
            footprint: width, length, or width, front if rear is given"
        "channel" ["channels"]: "2 D f64", "m; least, then greatest corner"
        "solid" ["solids"]: "Solid", ""),
    payload!("Choice": "a clearance"
        "kind" (Codes(&["gap", "gaps", "safest", "at_least"])): "u64", ""
        "gap" if "kind is 0": "Gap", ""
        "junctions" if "kind is 1": "u64", "a count"
        "gaps" ["junctions"] if "kind is 1": "Gap", ""
        "least" if "kind is 3": "f64", "free clearance, m"),
    payload!("Gap": "one gap, m"
        "axes" : "u64", "0: the same on every axis; 1 to 3: one number per axis"
        "gap" ["axes (0: 1)"]: "f64", ""),
    payload!("Solid": "m"
        "kind" (Codes(&["polygon", "box", "boxes"])): "u64", ""
        "vertices" if "kind is 0": "u64", "a count"
        "vertex" ["vertices"] if "kind is 0": "D f64", ""
        "corners" if "kind is 1": "2 D f64", "least, then greatest"
        "boxes" if "kind is 2": "u64", "a count"
        "box" ["boxes"] if "kind is 2": "2 D f64", "least, then greatest corner"),
    structure!(ReplyHeader: "the user header of a part of a reply"
        version: "2"
        dimension: "2 or 3"
        client: "the request's"
        sequence: "the request's"
        sent_ns: "nanoseconds since the Unix epoch"
        id: "the request's"
        given (Bits(&REPORTED)): "optional fields that are present; incomplete: the search ended \
            early"
        last: "1: no part follows"
        part: "from 0"
        kind (Codes(&["trajectory", "refusal"])): ""
        answer: "the answer this part belongs to, from 0"
        answers: "0: the whole request is refused"
        exit: "0 not named, otherwise 1 + code of the direction"
        gaps_per_junction: ""
        length: "m"
        duration: "s"
        clearance: "least distance to the walls, m"
        clearance_at: "arc length where that is, m"
        wall: "the wall point there, m"
        gaps: "entries in the payload"
        route: "entries in the payload"
        channels: "entries in the payload"
        legs: "entries in the payload"
        samples: "entries in the payload"
        refusal: "cells of the payload, if kind is 1"
        bound: "m"
        free_clearance: "m"
        exceeds (Codes(ExceededLimit::NAMES)): ""
        exceeds_joints: "a count"
        exceeds_jump: "rad/s"
        stops: "a count"),
    payload!("Trajectory": "the payload if kind is 0; lists continue in the answer's next part"
        "gap" ["gaps"]: "f64", "m"
        "channel index" ["route"]: "u64", ""
        "channel" ["channels"]: "2 D f64", "m; least, then greatest corner"
        "leg" ["legs"]: "Leg", ""
        "sample" ["samples"]: "Sample", ""),
    payload!("Refusal": "the payload if kind is 1"
        "code" (Codes(ErrorCode::NAMES)): "u64", ""
        "present" (Bits(&PRESENT)): "u64", "optional fields that are present"
        "junction": "u64", ""
        "axis" (Codes(Axis::NAMES)): "u64", ""
        "needs": "f64", ""
        "has": "f64", ""
        "least": "f64", ""
        "most": "f64", ""
        "heading": "f64", "rad"
        "message_bytes": "u64", ""
        "field_bytes": "u64", ""
        "setting_bytes": "u64", ""
        "message": "UTF-8", "filled up with zeros to whole cells"
        "field": "UTF-8", "likewise"
        "setting": "UTF-8", "likewise"),
    structure!(Leg: "a piece of a path"
        kind (Codes(CurveKind::NAMES)): ""
        rung (Codes(&RUNGS)): ""
        reverse: "1: driven backwards, otherwise 0"
        table: "of the rule; 0 for none"
        number: "of the rule in its table"
        junction: "all bits set for none"
        length: "m"
        clearance: "m"
        point: "line, clothoid: from, arc: centre, turn: position; m"
        to: "line, clothoid; m"
        radius: "arc; m. Clothoid: curvature at its start; rad/m"
        start: "arc: start angle, turn, clothoid: heading before; rad"
        heading: "line: at its end, turn, clothoid: after; rad"
        sweep: "signed; line: turned on the way; rad. Clothoid: curvature at its end; rad/m"),
    structure!(Sample: "a state of the motion"
        t: "s"
        position: "m"
        heading: "rad"
        velocity: "m/s"
        yaw_rate: "rad/s"),
    structure!(TapHeader: "the user header of a message on the tap; its payload is the \
        message's user header, then the message's payload"
        sequence: "number of the bus message; heartbeat: of the next one"
        time_ns: "nanoseconds since the Unix epoch"
        kind (Codes(&["request", "reply part", "heartbeat"])): "heartbeat: without \
            payload, or with a request that makes a free space known which the next one names"
        piece: "long messages are cut into pieces of one sequence number; bit 0: last piece, \
            above it the piece's number from 0"),
];
