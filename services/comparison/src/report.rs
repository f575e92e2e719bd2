//! What `replay check` and `replay diff` print as JSON. Fields are in alphabetical order, within
//! structures and in the text.

use serde::Serialize;

use schemas::message::RequestKey;

use crate::check::{Case, Checked, Counts};
use crate::compare::{AnswerComparison, Comparison, Difference, FieldPath, Outcome, Verdict};
use crate::diff::{Compared, Pair};
use crate::motion::{Change, Deviation, MotionChange};

/// What `replay check --format json` prints: how recorded replies compare with those planned now.
/// Lengths are in metres, angles in radians, times in seconds. Infinite numbers are `null`.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub struct CheckReport {
    /// The recordings, in the order in which they were given.
    pub files: Vec<FileReport>,
}

/// A recording.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "json-schema", schemars(rename = "file"))]
pub struct FileReport {
    /// The answers that are not equal bit for bit, but those that are not compared.
    pub answers: Vec<AnswerReport>,
    /// Whether its end is missing.
    pub cut: bool,
    /// Replies that differ beyond tolerance.
    pub different: u64,
    /// The first difference of each of these.
    pub differences: Vec<RequestDifference>,
    /// Replies that are equal, or within tolerance.
    pub equal: u64,
    /// Those of the equal ones that are within tolerance, but not equal bit for bit.
    pub equal_within: u64,
    /// Why it could not be read to its end.
    pub error: Option<String>,
    /// Requests without whole replies, and replies without requests.
    pub incomplete: Vec<String>,
    /// Messages that its recorder missed.
    pub lost: u64,
    /// Replies that depend on load and are not compared.
    pub not_repeatable: u64,
    /// Where it is.
    pub path: String,
    /// Requests in it.
    pub requests: u64,
    /// Equal replies with differently worded messages.
    pub reworded: u64,
    /// Bytes of messages that no checksum covers.
    pub unchecked_bytes: u64,
}

/// What `replay diff --format json` prints: how the replies of the recording `b` compare with
/// those of `a`. Lengths are in metres, angles in radians, times in seconds. Infinite numbers are
/// `null`.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub struct DiffReport {
    /// The recording that counts as right.
    pub a: String,
    /// The answers that are not equal bit for bit, but those that are not compared.
    pub answers: Vec<AnswerReport>,
    /// The recording compared with it.
    pub b: String,
    /// Replies that differ beyond tolerance.
    pub different: u64,
    /// The first difference of each of these.
    pub differences: Vec<PairDifference>,
    /// Replies that are equal, or within tolerance.
    pub equal: u64,
    /// Those of the equal ones that are within tolerance, but not equal bit for bit.
    pub equal_within: u64,
    /// Replies that depend on load and are not compared.
    pub not_repeatable: u64,
    /// The keys of requests that only `a` has.
    pub only_in_a: Vec<String>,
    /// The keys of requests that only `b` has.
    pub only_in_b: Vec<String>,
    /// Equal replies with differently worded messages.
    pub reworded: u64,
}

/// Where a reply first differs.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "json-schema", schemars(rename = "difference"))]
pub struct DifferenceReport {
    /// The answer, from 0; `null` for the reply as a whole.
    pub answer: Option<usize>,
    /// How far apart the numbers are, if they are numbers.
    pub distance: Option<f64>,
    /// The field.
    pub field: String,
    /// The place in the list.
    pub index: Option<usize>,
    /// The list of the trajectory that the field is in: `sample`, `leg`, `gap`, `route`, `channel`.
    pub list: Option<String>,
    /// What there is now, numbers with 17 digits.
    pub planned: String,
    /// What was recorded, numbers with 17 digits.
    pub recorded: String,
}

/// Where the reply to a request first differs.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "json-schema", schemars(rename = "request_difference"))]
pub struct RequestDifference {
    /// Where.
    #[serde(flatten)]
    pub difference: DifferenceReport,
    /// The request's key.
    pub key: String,
    /// The request, from 0, in the order of the file.
    pub request: u64,
}

/// Where the replies of a pair first differ.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "json-schema", schemars(rename = "pair_difference"))]
pub struct PairDifference {
    /// Where.
    #[serde(flatten)]
    pub difference: DifferenceReport,
    /// The request's key in each recording.
    pub keys: [String; 2],
    /// The pair, from 0.
    pub pair: usize,
}

/// How an answer compares.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "json-schema", schemars(rename = "answer"))]
pub struct AnswerReport {
    /// The answer, from 0; `null` for the refusal of a request as a whole.
    pub answer: Option<usize>,
    /// How far along the recorded path the first difference is.
    pub arc_length: Option<f64>,
    /// The first difference beyond tolerance or, if there is none, the first.
    pub first: Option<DifferenceReport>,
    /// The scene's id.
    pub id: Option<u64>,
    /// The request's key.
    pub key: String,
    /// How far the motions are apart, if both are there.
    pub motion: Option<MotionReport>,
    /// `diff` only: the request's key in `b`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_key: Option<String>,
    /// `diff` only: the request, from 0, in the order of `b`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_request: Option<u64>,
    /// The request, from 0, in the order of the file.
    pub request: u64,
    /// `within`: different, within tolerance; `moved`: beyond it; `appeared`: there was no motion
    /// and there is one now; `vanished`: the reverse.
    pub verdict: &'static str,
}

/// How far a motion is from the recorded one: samples one by one in their order, as far as both
/// go.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "json-schema", schemars(rename = "motion"))]
pub struct MotionReport {
    /// Least distance to the walls.
    pub clearance: ChangeReport,
    /// Duration.
    pub duration: ChangeReport,
    /// Largest angle between headings; `null` if all are equal.
    pub heading: Option<DeviationReport>,
    /// How many legs, before and after.
    pub legs: [usize; 2],
    /// Arc length.
    pub length: ChangeReport,
    /// Largest distance between reference points; `null` if all are equal.
    pub position: Option<DeviationReport>,
    /// The channels travelled, before and after; `null` if they are the same.
    pub route: Option<[Vec<u64>; 2]>,
    /// How many samples, before and after.
    pub samples: [usize; 2],
    /// Largest distance between velocities, m/s; `null` if all are equal.
    pub speed: Option<DeviationReport>,
    /// Largest difference of times; `null` if all are equal.
    pub time: Option<DeviationReport>,
}

/// A number before and after.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "json-schema", schemars(rename = "change"))]
pub struct ChangeReport {
    /// By how much it has grown.
    pub change: Option<f64>,
    /// Now.
    pub planned: Option<f64>,
    /// As recorded.
    pub recorded: Option<f64>,
}

/// The largest deviation, and where it is.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "json-schema", schemars(rename = "deviation"))]
pub struct DeviationReport {
    /// How far along the recorded path, metres.
    pub arc_length: f64,
    /// How far apart; `null` where something is not a number.
    pub distance: Option<f64>,
    /// The sample, from 0.
    pub sample: usize,
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

impl From<&Difference> for DifferenceReport {
    fn from(difference: &Difference) -> Self {
        let Difference { path, recorded, planned, distance } = difference;
        let FieldPath { answer, item, field } = path;
        Self {
            answer: *answer,
            distance: distance.and_then(finite),
            field: field.clone(),
            index: item.map(|(_, index)| index),
            list: item.map(|(list, _)| list.to_owned()),
            planned: planned.clone(),
            recorded: recorded.clone(),
        }
    }
}

impl From<Change> for ChangeReport {
    fn from(change: Change) -> Self {
        let Change { recorded, planned } = change;
        let by = finite(change.by());
        Self { change: by, planned: finite(planned), recorded: finite(recorded) }
    }
}

impl From<Deviation> for DeviationReport {
    fn from(Deviation { distance, sample, arc_length }: Deviation) -> Self {
        Self { arc_length, distance: finite(distance), sample }
    }
}

impl From<&MotionChange> for MotionReport {
    fn from(motion: &MotionChange) -> Self {
        let MotionChange {
            position,
            heading,
            time,
            speed,
            length,
            duration,
            clearance,
            route,
            legs,
            samples,
        } = motion;
        Self {
            clearance: (*clearance).into(),
            duration: (*duration).into(),
            heading: heading.map(Into::into),
            legs: *legs,
            length: (*length).into(),
            position: position.map(Into::into),
            route: route.clone(),
            samples: *samples,
            speed: speed.map(Into::into),
            time: time.map(Into::into),
        }
    }
}

/// The answers of a reply that are not equal, or not compared.
fn answers(
    comparison: &Comparison,
    request: u64,
    key: RequestKey,
    id: Option<u64>,
) -> impl Iterator<Item = AnswerReport> {
    let listed = |answer: &&AnswerComparison| {
        !matches!(answer.verdict, Verdict::Equal | Verdict::NotRepeatable)
    };
    comparison.answers.iter().filter(listed).map(move |comparison| {
        let AnswerComparison { answer, verdict, first, arc_length, motion } = comparison;
        AnswerReport {
            answer: *answer,
            arc_length: *arc_length,
            first: first.as_deref().map(Into::into),
            id,
            key: key.to_string(),
            motion: motion.as_deref().map(Into::into),
            other_key: None,
            other_request: None,
            request,
            verdict: verdict.name(),
        }
    })
}

impl From<&[Checked]> for CheckReport {
    fn from(checked: &[Checked]) -> Self {
        Self { files: checked.iter().map(Into::into).collect() }
    }
}

impl From<&Checked> for FileReport {
    fn from(file: &Checked) -> Self {
        let Checked { path, more: _, contents, cases } = file;
        let Counts { equal, reworded, within, different, not_repeatable } = file.counts();
        let differences = file.differences().map(|(case, difference)| RequestDifference {
            difference: difference.into(),
            key: case.key.to_string(),
            request: case.index,
        });
        let answers = cases
            .iter()
            .flat_map(|case: &Case| answers(&case.comparison, case.index, case.key, case.id));
        Self {
            answers: answers.collect(),
            cut: contents.error.as_ref().is_some_and(|error| error.is_cut()),
            different,
            differences: differences.collect(),
            equal,
            equal_within: within,
            error: contents.error.as_ref().map(ToString::to_string),
            incomplete: contents.incomplete().collect(),
            lost: contents.lost(),
            not_repeatable,
            path: path.to_string_lossy().into_owned(),
            requests: contents.requests,
            reworded,
            unchecked_bytes: contents.coverage.bytes - contents.coverage.checked,
        }
    }
}

impl DiffReport {
    /// The report on the recordings with these names.
    pub fn new(compared: &Compared, [a, b]: [String; 2]) -> Self {
        let Counts { equal, reworded, within, different, not_repeatable } = compared.counts();
        let differences = compared.pairs.iter().enumerate().filter_map(|(index, pair)| {
            let Outcome::Different(difference) = &pair.comparison.outcome else { return None };
            let keys = pair.keys.map(|key| key.to_string());
            Some(PairDifference { difference: (&**difference).into(), keys, pair: index })
        });
        let answers = compared.pairs.iter().flat_map(|pair: &Pair| {
            let [request, other] = pair.indices;
            answers(&pair.comparison, request, pair.keys[0], pair.id).map(move |answer| {
                let other_key = Some(pair.keys[1].to_string());
                AnswerReport { other_key, other_request: Some(other), ..answer }
            })
        });
        let [only_in_a, only_in_b] =
            compared.alone.each_ref().map(|keys| keys.iter().map(ToString::to_string).collect());
        Self {
            a,
            answers: answers.collect(),
            b,
            different,
            differences: differences.collect(),
            equal,
            equal_within: within,
            not_repeatable,
            only_in_a,
            only_in_b,
            reworded,
        }
    }
}

/// The JSON Schemas of the reports (draft 2020-12), as the texts of their files.
#[cfg(feature = "json-schema")]
pub mod schema {
    use schemas::json::schema::describe;

    /// Of what `replay check` prints.
    pub fn check() -> String {
        describe::<super::CheckReport>("urn:clearway:schema:check", "Clearway replay check")
    }

    /// Of what `replay diff` prints.
    pub fn diff() -> String {
        describe::<super::DiffReport>("urn:clearway:schema:diff", "Clearway replay diff")
    }
}
