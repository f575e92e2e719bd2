//! Types that people write in more than one way. In recordings they are plain enums.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::message::{Choice, Gap, Vector};

/// The recorded form of [`Gap`].
#[derive(Serialize, Deserialize)]
enum RecordedGap {
    Uniform(f64),
    PerAxis(Vector),
}

/// The recorded form of [`Choice`]; in JSON also its form as an object.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum RecordedChoice {
    Gap(Gap),
    Gaps(Vec<Gap>),
    Safest,
}

impl From<RecordedChoice> for Choice {
    fn from(choice: RecordedChoice) -> Self {
        match choice {
            RecordedChoice::Gap(gap) => Self::Gap(gap),
            RecordedChoice::Gaps(gaps) => Self::Gaps(gaps),
            RecordedChoice::Safest => Self::Safest,
        }
    }
}

impl Serialize for Gap {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match (self, serializer.is_human_readable()) {
            (Self::Uniform(gap), true) => gap.serialize(serializer),
            (Self::PerAxis(gaps), true) => gaps.serialize(serializer),
            (Self::Uniform(gap), false) => RecordedGap::Uniform(*gap).serialize(serializer),
            (Self::PerAxis(gaps), false) => RecordedGap::PerAxis(*gaps).serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Gap {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return deserializer.deserialize_any(GapVisitor);
        }
        Ok(match RecordedGap::deserialize(deserializer)? {
            RecordedGap::Uniform(gap) => Self::Uniform(gap),
            RecordedGap::PerAxis(gaps) => Self::PerAxis(gaps),
        })
    }
}

struct GapVisitor;

impl<'de> Visitor<'de> for GapVisitor {
    type Value = Gap;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number or a list of 1 to 3 numbers")
    }

    fn visit_f64<E: Error>(self, gap: f64) -> Result<Gap, E> {
        Ok(Gap::Uniform(gap))
    }

    fn visit_i64<E: Error>(self, gap: i64) -> Result<Gap, E> {
        Ok(Gap::Uniform(gap as f64))
    }

    fn visit_u64<E: Error>(self, gap: u64) -> Result<Gap, E> {
        Ok(Gap::Uniform(gap as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<Gap, A::Error> {
        Vector::deserialize(SeqAccessDeserializer::new(sequence)).map(Gap::PerAxis)
    }
}

impl Serialize for Choice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Gap(gap) if serializer.is_human_readable() => gap.serialize(serializer),
            Self::Gap(gap) => RecordedChoice::Gap(*gap).serialize(serializer),
            Self::Gaps(gaps) => RecordedChoice::Gaps(gaps.clone()).serialize(serializer),
            Self::Safest => RecordedChoice::Safest.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Choice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            deserializer.deserialize_any(ChoiceVisitor)
        } else {
            RecordedChoice::deserialize(deserializer).map(Self::from)
        }
    }
}

struct ChoiceVisitor;

impl<'de> Visitor<'de> for ChoiceVisitor {
    type Value = Choice;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a gap (a number, or a list of 1 to 3), \"safest\", or {\"gaps\": [..]}")
    }

    fn visit_f64<E: Error>(self, gap: f64) -> Result<Choice, E> {
        GapVisitor.visit_f64(gap).map(Choice::Gap)
    }

    fn visit_i64<E: Error>(self, gap: i64) -> Result<Choice, E> {
        GapVisitor.visit_i64(gap).map(Choice::Gap)
    }

    fn visit_u64<E: Error>(self, gap: u64) -> Result<Choice, E> {
        GapVisitor.visit_u64(gap).map(Choice::Gap)
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<Choice, E> {
        match word {
            "safest" => Ok(Choice::Safest),
            _ => Err(E::unknown_variant(word, &["safest"])),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<Choice, A::Error> {
        GapVisitor.visit_seq(sequence).map(Choice::Gap)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Choice, A::Error> {
        RecordedChoice::deserialize(MapAccessDeserializer::new(map)).map(Choice::from)
    }
}

/// For serde's `with`: in JSON one value stands for a list of one.
pub(crate) mod one_or_many {
    use super::*;

    pub(crate) fn serialize<S: Serializer, T: Serialize>(
        list: &Vec<T>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        match list.as_slice() {
            [] if serializer.is_human_readable() => serializer.serialize_none(),
            [one] if serializer.is_human_readable() => one.serialize(serializer),
            _ => list.serialize(serializer),
        }
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
        deserializer: D,
    ) -> Result<Vec<T>, D::Error> {
        if deserializer.is_human_readable() {
            deserializer.deserialize_any(OneOrMany(std::marker::PhantomData))
        } else {
            Vec::deserialize(deserializer)
        }
    }

    struct OneOrMany<T>(std::marker::PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for OneOrMany<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("one of \"+x\" \"-x\" \"+y\" \"-y\" \"+z\" \"-z\", or a list of them")
        }

        fn visit_unit<E: Error>(self) -> Result<Vec<T>, E> {
            Ok(Vec::new())
        }

        fn visit_str<E: Error>(self, word: &str) -> Result<Vec<T>, E> {
            T::deserialize(serde::de::value::StrDeserializer::new(word)).map(|one| vec![one])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<Vec<T>, A::Error> {
            Vec::deserialize(SeqAccessDeserializer::new(sequence))
        }
    }
}
