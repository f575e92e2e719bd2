//! Numbers for plots, as JSON with a schema.

use schemas::message::{Curve, Leg, Sample, Task, Trajectory};
use serde_json::{Value, json};

use crate::Shown;
use crate::topics::{Kind, ViewMessage};

/// Numbers of the request and its answers.
pub(crate) fn request(shown: &Shown) -> ViewMessage {
    let refused = |refusal: &schemas::message::Refusal| refusal.code.name();
    let answer = |answer: &schemas::message::Answer| match answer {
        Err(refusal) => json!({ "outcome": refused(refusal) }),
        Ok(motion) => json!({
            "outcome": "planned",
            "length": motion.length,
            "duration": motion.duration,
            "clearance": motion.clearance.value,
            "free_clearance": motion.free_clearance,
            "bound": motion.bound,
        }),
    };
    let outcome = match &shown.reply.answers {
        Err(refusal) => refused(refusal),
        Ok(answers) => match answers.iter().find_map(|answer| answer.as_ref().err()) {
            Some(refusal) => refused(refusal),
            None => "planned",
        },
    };
    let answers = shown.reply.answers.iter().flatten().map(answer).collect::<Vec<_>>();
    let message = json!({
        "request": shown.index,
        "id": shown.scene.id,
        "task": shown.scene.task.name(),
        "outcome": outcome,
        "planning_time": shown.planning_time,
        "answers": answers,
    });
    message_of("/viewing/request".to_owned(), Kind::Request, shown.begin_ns, &message)
}

pub(crate) fn request_schema() -> Value {
    let motion = json!({
        "type": "object",
        "properties": {
            "outcome": { "type": "string", "description": "planned, or the code of a refusal" },
            "length": number("metres"),
            "duration": number("seconds"),
            "clearance": number("the least distance to the walls, metres; null if there are none"),
            "free_clearance": number("metres"),
            "bound": number("no motion is shorter, metres"),
        },
        "required": ["outcome"],
    });
    json!({
        "title": "clearway.Answers",
        "type": "object",
        "properties": {
            "request": { "type": "integer", "description": "counts the recording's requests, from 0" },
            "id": { "type": ["integer", "null"], "description": "of the scene" },
            "task": { "enum": Task::NAMES },
            "outcome": { "type": "string", "description": "planned, or the code of the first refusal" },
            "planning_time": number("from sending the request to sending the end of its reply, seconds"),
            "answers": { "type": "array", "items": motion },
        },
        "required": ["request", "task", "outcome", "answers"],
    })
}

/// Numbers of each sample.
pub(crate) fn motion(shown: &Shown, answer: usize, motion: &Trajectory) -> Vec<ViewMessage> {
    let clearances = clearances(motion);
    let messages = motion.samples.iter().enumerate().map(|(index, sample)| {
        let Sample { t, position: _, heading, velocity: [x, y, z], yaw_rate } = *sample;
        let message = json!({
            "request": shown.index,
            "t": t,
            "speed": libm::sqrt(x * x + y * y + z * z),
            "heading": heading,
            "yaw_rate": yaw_rate,
            "clearance": clearances.as_ref().map(|all| all[index]),
        });
        let at = shown.after(t);
        message_of(format!("/viewing/{answer}/motion"), Kind::Motion, at, &message)
    });
    messages.collect()
}

pub(crate) fn motion_schema() -> Value {
    json!({
        "title": "clearway.Motion",
        "type": "object",
        "properties": {
            "request": { "type": "integer", "description": "counts the recording's requests, from 0" },
            "t": number("seconds since the motion began"),
            "speed": number("metres a second"),
            "heading": number("radians, counter-clockwise from +x"),
            "yaw_rate": number("radians a second"),
            "clearance": number("the least distance to the walls on the leg of this sample, metres"),
        },
        "required": ["request", "t", "speed", "heading", "yaw_rate"],
    })
}

fn number(description: &str) -> Value {
    json!({ "type": ["number", "null"], "description": description })
}

fn message_of(topic: String, kind: Kind, log_ns: u64, message: &Value) -> ViewMessage {
    ViewMessage { topic, kind, log_ns, bytes: message.to_string().into_bytes() }
}

/// The clearance of the leg on which each sample is. The last state of every leg is a sample;
/// `None` where one is not to be found among them.
fn clearances(motion: &Trajectory) -> Option<Vec<f64>> {
    let mut clearances = Vec::with_capacity(motion.samples.len());
    let last = motion.legs.len().checked_sub(1)?;
    let mut leg = 0;
    for sample in &motion.samples {
        let mut least = motion.legs[leg].clearance;
        while leg < last && is_at_end(&motion.legs[leg], sample) {
            leg += 1;
            least = least.min(motion.legs[leg].clearance);
        }
        clearances.push(least);
    }
    let end = motion.samples.last()?;
    (leg == last && is_at_end(&motion.legs[last], end)).then_some(clearances)
}

/// Whether a sample is the last of the leg, up to rounding.
fn is_at_end(leg: &Leg, sample: &Sample) -> bool {
    const ROUNDING: f64 = 1e-9;
    let end = match &leg.curve {
        Curve::Line { to, .. } | Curve::Clothoid { to, .. } => to.padded(),
        Curve::Arc { center, radius, start_angle, sweep } => {
            let angle = start_angle + sweep;
            let [x, y, z] = center.padded();
            [x + radius * libm::cos(angle), y + radius * libm::sin(angle), z]
        }
        Curve::Turn { to_heading, .. } => {
            let off = libm::remainder(sample.heading - to_heading, std::f64::consts::TAU);
            return off.abs() <= ROUNDING;
        }
    };
    let size = end.iter().fold(1.0_f64, |most, value| most.max(value.abs()));
    end.iter().zip(sample.position).all(|(end, at)| (end - at).abs() <= ROUNDING * size)
}
