//! The reply in JSON.

use std::borrow::Cow;
use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Error, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::trajectory::TrajectoryJson;
use super::values::{Element, List, Word};
use crate::message::{Answer, Axis, ErrorCode, Refusal, Reply, RequestKey};

/// A reply to a scene request: an answer for each clearance asked for, or the error
/// because of which the whole request is refused. Lengths are in metres, angles in radians,
/// times in seconds, in the frame of the scene.
#[derive(Serialize, Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(transform = super::schema::require_one)
)]
#[serde(deny_unknown_fields)]
pub(super) struct ReplyJson<'a> {
    /// That of the request.
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u64>,
    /// An answer for each clearance asked for, in the order of the request.
    #[serde(skip_serializing_if = "Option::is_none")]
    trajectories: Option<List<'a, Answer>>,
    /// Why the whole request is refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<RefusalJson<'a>>,
}

impl<'a> From<&'a Reply> for ReplyJson<'a> {
    fn from(Reply { key: _, id, answers }: &'a Reply) -> Self {
        let (trajectories, error) = match answers {
            Ok(answers) => (Some(answers.as_slice().into()), None),
            Err(refusal) => (None, Some(refusal.into())),
        };
        Self { id: *id, trajectories, error }
    }
}

impl ReplyJson<'_> {
    pub(super) fn into_message<E: Error>(self) -> Result<Reply, E> {
        let Self { id, trajectories, error } = self;
        let answers = match (trajectories, error) {
            (Some(answers), None) => Ok(answers.into()),
            (None, Some(refusal)) => Err(refusal.into_message()),
            (Some(_), Some(_)) => return Err(one_of("both")),
            (None, None) => return Err(one_of("neither")),
        };
        Ok(Reply { key: RequestKey::default(), id, answers })
    }
}

fn one_of<E: Error>(found: &str) -> E {
    E::custom(format_args!("must have either `trajectories` or `error`, but has {found}"))
}

/// A trajectory, or why this one is refused.
#[derive(Serialize)]
#[serde(untagged)]
pub(super) enum AnswerJson<'a> {
    Planned(TrajectoryJson<'a>),
    Refused(RefusedJson<'a>),
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct RefusedJson<'a> {
    /// Why there is no trajectory for this clearance.
    error: RefusalJson<'a>,
}

impl<'de> Deserialize<'de> for AnswerJson<'_> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnswerVisitor)
    }
}

struct AnswerVisitor;

impl<'de> Visitor<'de> for AnswerVisitor {
    type Value = AnswerJson<'static>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a trajectory or an object with `error`")
    }

    /// The first field tells: the forms have none in common.
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let first = map.next_key::<Cow<str>>()?;
        let refused = first.as_deref() == Some("error");
        let fields = MapAccessDeserializer::new(FromFirst { first, map });
        if refused {
            RefusedJson::deserialize(fields).map(AnswerJson::Refused)
        } else {
            TrajectoryJson::deserialize(fields).map(AnswerJson::Planned)
        }
    }
}

/// Fields of which the first name is already read.
struct FromFirst<'de, A> {
    first: Option<Cow<'de, str>>,
    map: A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for FromFirst<'de, A> {
    type Error = A::Error;

    fn next_key_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, A::Error> {
        match self.first.take() {
            Some(first) => seed.deserialize(first.into_deserializer()).map(Some),
            None => self.map.next_key_seed(seed),
        }
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
}

impl<'a> From<&'a Answer> for AnswerJson<'a> {
    fn from(answer: &'a Answer) -> Self {
        match answer {
            Ok(trajectory) => Self::Planned(trajectory.into()),
            Err(refusal) => Self::Refused(RefusedJson { error: refusal.into() }),
        }
    }
}

impl Element for Answer {
    type Json<'a> = AnswerJson<'a>;

    fn from_json<E: Error>(json: AnswerJson) -> Result<Self, E> {
        match json {
            AnswerJson::Planned(trajectory) => trajectory.into_message().map(Ok),
            AnswerJson::Refused(RefusedJson { error }) => Ok(Err(error.into_message())),
        }
    }
}

/// Why there is no trajectory, and what would have to change.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "error"))]
#[serde(deny_unknown_fields)]
pub(super) struct RefusalJson<'a> {
    /// What kind of error.
    code: Word<ErrorCode>,
    /// For people; its wording may change.
    message: Cow<'a, str>,
    /// The field of the request that is at fault, as a path such as
    /// `free_space.channels[3].min[1]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    field: Option<Cow<'a, str>>,
    /// The junction of two channels, counted from 0 in travel order.
    #[serde(skip_serializing_if = "Option::is_none")]
    junction: Option<u64>,
    /// The axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<Word<Axis>>,
    /// What is needed; metres unless the code says otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    needs: Option<f64>,
    /// What there is; in the unit of `needs`.
    #[serde(skip_serializing_if = "Option::is_none")]
    has: Option<f64>,
    /// The lower bound, itself excluded; in the unit of `needs`.
    #[serde(skip_serializing_if = "Option::is_none")]
    least: Option<f64>,
    /// The upper bound; in the unit of `needs`.
    #[serde(skip_serializing_if = "Option::is_none")]
    most: Option<f64>,
    /// A heading that would be free, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    heading: Option<f64>,
    /// The setting of the planner's configuration whose limit was met, such as
    /// `caps.route_steps`.
    #[serde(skip_serializing_if = "Option::is_none")]
    setting: Option<Cow<'a, str>>,
}

impl<'a> From<&'a Refusal> for RefusalJson<'a> {
    fn from(refusal: &'a Refusal) -> Self {
        let Refusal {
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
        } = refusal;
        Self {
            code: Word(*code),
            message: message.into(),
            field: field.as_deref().map(Cow::Borrowed),
            junction: *junction,
            axis: axis.and_then(|axis| Axis::ALL.get(axis as usize).copied()).map(Word),
            needs: *needs,
            has: *has,
            least: *least,
            most: *most,
            heading: *heading,
            setting: setting.as_deref().map(Cow::Borrowed),
        }
    }
}

impl RefusalJson<'_> {
    /// Not `From`: that would be one way too many for `?` to turn an error into a refusal.
    fn into_message(self) -> Refusal {
        let Self {
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
        } = self;
        Refusal {
            code: code.0,
            message: message.into_owned(),
            field: field.map(Cow::into_owned),
            junction,
            axis: axis.map(|Word(axis)| axis as u32),
            needs,
            has,
            least,
            most,
            heading,
            setting: setting.map(Cow::into_owned),
        }
    }
}
