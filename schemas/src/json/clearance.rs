//! The clearance gaps of a scene in JSON, of which there are several forms.

use std::fmt;

use serde::de::value::{EnumAccessDeserializer, SeqAccessDeserializer};
use serde::de::{EnumAccess, Error, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::read::OR_OTHER;
use super::values::{Element, List, Numbers};
use crate::message::{Choice, ClearanceWish, Gap};

/// The word for the gap that leaves the greatest clearance.
pub(super) const SAFEST: &str = "safest";

/// Metres: one number for all axes, or a list with a number per axis.
#[derive(Clone, Copy)]
pub(super) enum GapJson {
    Uniform(f64),
    PerAxis(Numbers<1>),
}

impl Serialize for GapJson {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Uniform(gap) => gap.serialize(serializer),
            Self::PerAxis(gaps) => gaps.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for GapJson {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(GapVisitor)
    }
}

struct GapVisitor;

impl<'de> Visitor<'de> for GapVisitor {
    type Value = GapJson;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number or a list of 1 to 3 numbers")
    }

    fn visit_f64<E>(self, gap: f64) -> Result<GapJson, E> {
        Ok(GapJson::Uniform(gap))
    }

    fn visit_u64<E>(self, gap: u64) -> Result<GapJson, E> {
        Ok(GapJson::Uniform(gap as f64))
    }

    fn visit_i64<E>(self, gap: i64) -> Result<GapJson, E> {
        Ok(GapJson::Uniform(gap as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, entries: A) -> Result<GapJson, A::Error> {
        Numbers::deserialize(SeqAccessDeserializer::new(entries)).map(GapJson::PerAxis)
    }
}

impl From<&Gap> for GapJson {
    fn from(gap: &Gap) -> Self {
        match gap {
            Gap::Uniform(gap) => Self::Uniform(*gap),
            Gap::PerAxis(gaps) => Self::PerAxis(Numbers(*gaps)),
        }
    }
}

impl From<GapJson> for Gap {
    fn from(json: GapJson) -> Self {
        match json {
            GapJson::Uniform(gap) => Self::Uniform(gap),
            GapJson::PerAxis(gaps) => Self::PerAxis(gaps.0),
        }
    }
}

impl Element for Gap {
    type Json<'a> = GapJson;

    fn from_json<E: Error>(json: GapJson) -> Result<Self, E> {
        Ok(json.into())
    }
}

/// The clearance gaps to plan with: `"safest"`, or an object with one field.
pub(super) enum WishJson<'a> {
    Safest,
    Given(GivenWish<'a>),
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(transform = super::schema::allow_null_alternatives)
)]
#[serde(rename_all = "snake_case")]
pub(super) enum GivenWish<'a> {
    /// The same gap at every junction.
    Gap(GapJson),
    /// A gap per junction, in travel order; needs `in_order`.
    Gaps(List<'a, Gap>),
    /// An answer to each of these.
    Each(List<'a, Choice>),
    /// How many answers, without samples, from the shortest path to the safest.
    Curve(u64),
    /// `drive` only: the least free clearance, metres; the answer is the shortest motion that
    /// keeps it.
    AtLeast(f64),
}

impl GivenWish<'_> {
    const FIELDS: &'static [&'static str] = &["gap", "gaps", "each", "curve", "at_least"];
}

impl Serialize for WishJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Safest => serializer.serialize_str(SAFEST),
            Self::Given(wish) => wish.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for WishJson<'_> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_enum(OR_OTHER, GivenWish::FIELDS, WishVisitor)
    }
}

struct WishVisitor;

impl<'de> Visitor<'de> for WishVisitor {
    type Value = WishJson<'static>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(
            "\"safest\" or an object with one of `gap`, `gaps`, `each`, `curve`, `at_least`",
        )
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
        match text {
            SAFEST => Ok(WishJson::Safest),
            _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
        }
    }

    fn visit_enum<A: EnumAccess<'de>>(self, wish: A) -> Result<Self::Value, A::Error> {
        GivenWish::deserialize(EnumAccessDeserializer::new(wish)).map(WishJson::Given)
    }
}

impl<'a> From<&'a ClearanceWish> for WishJson<'a> {
    fn from(wish: &'a ClearanceWish) -> Self {
        Self::Given(match wish {
            ClearanceWish::Safest => return Self::Safest,
            ClearanceWish::Gap(gap) => GivenWish::Gap(gap.into()),
            ClearanceWish::Gaps(gaps) => GivenWish::Gaps(gaps.as_slice().into()),
            ClearanceWish::Each(choices) => GivenWish::Each(choices.as_slice().into()),
            ClearanceWish::Curve(points) => GivenWish::Curve(*points),
            ClearanceWish::AtLeast(clearance) => GivenWish::AtLeast(*clearance),
        })
    }
}

impl From<WishJson<'_>> for ClearanceWish {
    fn from(json: WishJson) -> Self {
        match json {
            WishJson::Safest => Self::Safest,
            WishJson::Given(GivenWish::Gap(gap)) => Self::Gap(gap.into()),
            WishJson::Given(GivenWish::Gaps(gaps)) => Self::Gaps(gaps.into()),
            WishJson::Given(GivenWish::Each(choices)) => Self::Each(choices.into()),
            WishJson::Given(GivenWish::Curve(points)) => Self::Curve(points),
            WishJson::Given(GivenWish::AtLeast(clearance)) => Self::AtLeast(clearance),
        }
    }
}

/// The gaps of one of several answers: a gap, `"safest"`, or an object with one field.
pub(super) enum ChoiceJson<'a> {
    Gap(GapJson),
    Safest,
    Given(GivenChoice<'a>),
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(transform = super::schema::allow_null_alternatives)
)]
#[serde(rename_all = "snake_case")]
pub(super) enum GivenChoice<'a> {
    /// The same gap at every junction.
    Gap(GapJson),
    /// A gap per junction, in travel order; needs `in_order`.
    Gaps(List<'a, Gap>),
    /// `drive` only: the least free clearance, metres.
    AtLeast(f64),
}

impl GivenChoice<'_> {
    const FIELDS: &'static [&'static str] = &["gap", "gaps", "at_least"];
}

impl Serialize for ChoiceJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Gap(gap) => gap.serialize(serializer),
            Self::Safest => serializer.serialize_str(SAFEST),
            Self::Given(choice) => choice.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for ChoiceJson<'_> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_enum(OR_OTHER, GivenChoice::FIELDS, ChoiceVisitor)
    }
}

struct ChoiceVisitor;

impl<'de> Visitor<'de> for ChoiceVisitor {
    type Value = ChoiceJson<'static>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(
            "a gap (a number or a list of 1 to 3 numbers), \"safest\", or an object with one of \
             `gap`, `gaps`, `at_least`",
        )
    }

    fn visit_f64<E: Error>(self, gap: f64) -> Result<Self::Value, E> {
        GapVisitor.visit_f64(gap).map(ChoiceJson::Gap)
    }

    fn visit_u64<E: Error>(self, gap: u64) -> Result<Self::Value, E> {
        GapVisitor.visit_u64(gap).map(ChoiceJson::Gap)
    }

    fn visit_i64<E: Error>(self, gap: i64) -> Result<Self::Value, E> {
        GapVisitor.visit_i64(gap).map(ChoiceJson::Gap)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
        match text {
            SAFEST => Ok(ChoiceJson::Safest),
            _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, entries: A) -> Result<Self::Value, A::Error> {
        GapVisitor.visit_seq(entries).map(ChoiceJson::Gap)
    }

    fn visit_enum<A: EnumAccess<'de>>(self, choice: A) -> Result<Self::Value, A::Error> {
        GivenChoice::deserialize(EnumAccessDeserializer::new(choice)).map(ChoiceJson::Given)
    }
}

impl<'a> From<&'a Choice> for ChoiceJson<'a> {
    fn from(choice: &'a Choice) -> Self {
        match choice {
            Choice::Safest => Self::Safest,
            Choice::Gap(gap) => Self::Gap(gap.into()),
            Choice::Gaps(gaps) => Self::Given(GivenChoice::Gaps(gaps.as_slice().into())),
            Choice::AtLeast(clearance) => Self::Given(GivenChoice::AtLeast(*clearance)),
        }
    }
}

impl Element for Choice {
    type Json<'a> = ChoiceJson<'a>;

    fn from_json<E: Error>(json: ChoiceJson) -> Result<Self, E> {
        Ok(match json {
            ChoiceJson::Safest => Self::Safest,
            ChoiceJson::Gap(gap) | ChoiceJson::Given(GivenChoice::Gap(gap)) => {
                Self::Gap(gap.into())
            }
            ChoiceJson::Given(GivenChoice::Gaps(gaps)) => Self::Gaps(gaps.into()),
            ChoiceJson::Given(GivenChoice::AtLeast(clearance)) => Self::AtLeast(clearance),
        })
    }
}
