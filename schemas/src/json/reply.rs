//! Replies as people read them.

use std::io;

use serde::Serialize;
use serde::ser::{SerializeSeq, Serializer};

use crate::message::{
    AxisBox, Curve, Direction, ErrorCode, Leg, Refusal, Reply, Sample, Trajectory, Vector,
};

/// Writes a reply as one JSON object, without a line end.
pub fn write_reply(reply: &Reply, writer: impl io::Write) -> io::Result<()> {
    Ok(serde_json::to_writer(writer, &ReplyView::from(reply))?)
}

/// A reply as one JSON object.
pub fn reply_to_json(reply: &Reply) -> String {
    serde_json::to_string(&ReplyView::from(reply)).expect("replies have text keys only")
}

#[derive(Serialize)]
struct ReplyView<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    trajectories: Option<Vec<AnswerView<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<RefusalView<'a>>,
}

impl<'a> From<&'a Reply> for ReplyView<'a> {
    fn from(reply: &'a Reply) -> Self {
        let answer = |answer: &'a Result<Trajectory, Refusal>| match answer {
            Ok(trajectory) => AnswerView::Trajectory(TrajectoryView::from(trajectory)),
            Err(refusal) => AnswerView::Refusal { error: RefusalView::from(refusal) },
        };
        let (trajectories, error) = match &reply.answers {
            Ok(answers) => (Some(answers.iter().map(answer).collect()), None),
            Err(refusal) => (None, Some(RefusalView::from(refusal))),
        };
        Self { id: reply.id, trajectories, error }
    }
}

#[derive(Serialize)]
#[serde(untagged)]
enum AnswerView<'a> {
    Trajectory(TrajectoryView<'a>),
    Refusal { error: RefusalView<'a> },
}

#[derive(Serialize)]
struct TrajectoryView<'a> {
    gap: GapsView<'a>,
    route: &'a [u64],
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    channels: &'a [AxisBox],
    #[serde(skip_serializing_if = "Option::is_none")]
    exit: Option<Direction>,
    length: f64,
    duration: f64,
    clearance: ClearanceView,
    legs: Vec<LegView>,
    samples: SamplesView<'a>,
}

impl<'a> From<&'a Trajectory> for TrajectoryView<'a> {
    fn from(trajectory: &'a Trajectory) -> Self {
        let clearance = trajectory.clearance;
        Self {
            gap: GapsView { gaps: &trajectory.gaps, each: trajectory.gaps_per_junction as usize },
            route: &trajectory.route,
            channels: &trajectory.channels,
            exit: trajectory.exit,
            length: trajectory.length,
            duration: trajectory.duration,
            clearance: ClearanceView {
                value: clearance.value,
                at: clearance.at,
                wall: clearance.wall,
            },
            legs: trajectory.legs.iter().map(LegView::from).collect(),
            samples: SamplesView {
                samples: &trajectory.samples,
                dimension: trajectory.dimension as usize,
            },
        }
    }
}

#[derive(Serialize)]
struct ClearanceView {
    value: f64,
    at: f64,
    wall: Vector,
}

/// Per junction a list with a number per axis; where there is one number per
/// junction, that number.
struct GapsView<'a> {
    gaps: &'a [f64],
    each: usize,
}

impl Serialize for GapsView<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.each <= 1 {
            return self.gaps.serialize(serializer);
        }
        serializer.collect_seq(self.gaps.chunks(self.each))
    }
}

struct SamplesView<'a> {
    samples: &'a [Sample],
    dimension: usize,
}

impl Serialize for SamplesView<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct SampleView<'a> {
            t: f64,
            position: &'a [f64],
            heading: f64,
            velocity: &'a [f64],
            yaw_rate: f64,
        }
        let dimension = self.dimension.min(3);
        let mut list = serializer.serialize_seq(Some(self.samples.len()))?;
        for sample in self.samples {
            list.serialize_element(&SampleView {
                t: sample.t,
                position: &sample.position[..dimension],
                heading: sample.heading,
                velocity: &sample.velocity[..dimension],
                yaw_rate: sample.yaw_rate,
            })?;
        }
        list.end()
    }
}

#[derive(Serialize)]
struct LegView {
    #[serde(flatten)]
    curve: CurveView,
    length: f64,
    clearance: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    rule: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    junction: Option<u64>,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum CurveView {
    Line {
        from: Vector,
        to: Vector,
        heading: f64,
        /// Given only for a line on which the body turns.
        #[serde(skip_serializing_if = "Option::is_none")]
        turned: Option<f64>,
    },
    Arc {
        center: Vector,
        radius: f64,
        start_angle: f64,
        sweep: f64,
    },
    Turn {
        position: Vector,
        from_heading: f64,
        to_heading: f64,
    },
}

impl From<&Leg> for LegView {
    fn from(leg: &Leg) -> Self {
        let curve = match leg.curve {
            Curve::Line { from, to, heading, turned } => {
                CurveView::Line { from, to, heading, turned: (turned != 0.0).then_some(turned) }
            }
            Curve::Arc { center, radius, start_angle, sweep } => {
                CurveView::Arc { center, radius, start_angle, sweep }
            }
            Curve::Turn { position, from_heading, to_heading, .. } => {
                CurveView::Turn { position, from_heading, to_heading }
            }
        };
        Self {
            curve,
            length: leg.length,
            clearance: leg.clearance,
            rule: leg.rule.map(|rule| format!("table {}, rule {}", rule.table, rule.number)),
            junction: leg.junction,
        }
    }
}

#[derive(Serialize)]
struct RefusalView<'a> {
    code: ErrorCode,
    message: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    field: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    junction: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    needs: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    has: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    least: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    most: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    heading: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    setting: Option<&'a str>,
}

impl<'a> From<&'a Refusal> for RefusalView<'a> {
    fn from(refusal: &'a Refusal) -> Self {
        Self {
            code: refusal.code,
            message: &refusal.message,
            field: refusal.field.as_deref(),
            junction: refusal.junction,
            axis: refusal.axis.and_then(|axis| ["x", "y", "z"].get(axis as usize).copied()),
            needs: refusal.needs,
            has: refusal.has,
            least: refusal.least,
            most: refusal.most,
            heading: refusal.heading,
            setting: refusal.setting.as_deref(),
        }
    }
}
