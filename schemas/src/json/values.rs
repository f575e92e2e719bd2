//! The values that scenes and replies share.

use std::borrow::Cow;
use std::fmt;

use serde::de::{Error, SeqAccess, Unexpected, Visitor};
use serde::ser::SerializeSeq;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::message::{AxisBox, Direction, Named, Vector};

/// A message that stands in lists, and its form in JSON.
pub(super) trait Element: Clone {
    type Json<'a>: Serialize + for<'de> Deserialize<'de> + From<&'a Self>
    where
        Self: 'a;

    fn from_json<E: Error>(json: Self::Json<'static>) -> Result<Self, E>;
}

/// A list of messages. They take their form in JSON one by one, as they are written
/// and read.
pub(super) struct List<'a, M: Clone>(pub(super) Cow<'a, [M]>);

impl<'a, M: Clone> From<&'a [M]> for List<'a, M> {
    fn from(list: &'a [M]) -> Self {
        Self(Cow::Borrowed(list))
    }
}

impl<M: Clone> From<List<'_, M>> for Vec<M> {
    fn from(list: List<M>) -> Self {
        list.0.into_owned()
    }
}

impl<M: Element> Serialize for List<'_, M> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.0.len()))?;
        self.0.iter().try_for_each(|entry| list.serialize_element(&M::Json::from(entry)))?;
        list.end()
    }
}

impl<'de, M: Element + 'static> Deserialize<'de> for List<'_, M> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ListVisitor<M>(std::marker::PhantomData<M>);

        impl<'de, M: Element + 'static> Visitor<'de> for ListVisitor<M> {
            type Value = Vec<M>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Vec<M>, A::Error> {
                // The tree that is read from knows how long its lists are.
                let mut list = Vec::with_capacity(entries.size_hint().unwrap_or(0));
                while let Some(Entry(entry)) = entries.next_element()? {
                    list.push(entry);
                }
                Ok(list)
            }
        }

        let visitor = ListVisitor(std::marker::PhantomData);
        deserializer.deserialize_seq(visitor).map(|list| Self(Cow::Owned(list)))
    }
}

struct Entry<M>(M);

impl<'de, M: Element + 'static> Deserialize<'de> for Entry<M> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        M::from_json(Deserialize::deserialize(deserializer)?).map(Self)
    }
}

/// One of a few values, each of which has a name.
#[derive(Clone, Copy)]
pub(super) struct Word<T>(pub(super) T);

impl<T: Named> Serialize for Word<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.word())
    }
}

impl<'de, T: Named> Deserialize<'de> for Word<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(WordVisitor(std::marker::PhantomData)).map(Self)
    }
}

struct WordVisitor<T>(std::marker::PhantomData<T>);

impl<T: Named> Visitor<'_> for WordVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        words::<T>(f)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<T, E> {
        T::from_word(text).ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
    }
}

fn words<T: Named>(f: &mut fmt::Formatter) -> fmt::Result {
    if T::VALUES.len() > 1 {
        f.write_str("one of ")?;
    }
    for (index, value) in T::VALUES.iter().enumerate() {
        write!(f, "{}\"{}\"", if index > 0 { ", " } else { "" }, value.word())?;
    }
    Ok(())
}

/// A word or a list of words.
pub(super) enum Words<'a, T: Clone> {
    One(Word<T>),
    Several(List<'a, T>),
}

impl<'a, T: Named> From<&'a [T]> for Words<'a, T> {
    fn from(words: &'a [T]) -> Self {
        match words {
            [word] => Self::One(Word(*word)),
            words => Self::Several(words.into()),
        }
    }
}

impl<T: Named> From<Words<'_, T>> for Vec<T> {
    fn from(words: Words<T>) -> Self {
        match words {
            Words::One(Word(word)) => vec![word],
            Words::Several(words) => words.into(),
        }
    }
}

impl<T: Named + Element> Serialize for Words<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::One(word) => word.serialize(serializer),
            Self::Several(words) => words.serialize(serializer),
        }
    }
}

impl<'de, T: Named + Element> Deserialize<'de> for Words<'_, T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WordsVisitor<T>(std::marker::PhantomData<T>);

        impl<'de, T: Named + Element> Visitor<'de> for WordsVisitor<T> {
            type Value = Words<'static, T>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                words::<T>(f)?;
                f.write_str(" or a list of these")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
                let word = T::from_word(text).map(|word| Words::One(Word(word)));
                word.ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, entries: A) -> Result<Self::Value, A::Error> {
                let entries = serde::de::value::SeqAccessDeserializer::new(entries);
                List::deserialize(entries).map(Words::Several)
            }
        }

        deserializer.deserialize_any(WordsVisitor(std::marker::PhantomData))
    }
}

impl Element for Direction {
    type Json<'a> = Word<Self>;

    fn from_json<E: Error>(json: Word<Self>) -> Result<Self, E> {
        Ok(json.0)
    }
}

impl From<&Direction> for Word<Direction> {
    fn from(direction: &Direction) -> Self {
        Self(*direction)
    }
}

/// A list of at least `LEAST` and at most 3 numbers.
#[derive(Clone, Copy)]
pub(super) struct Numbers<const LEAST: usize>(pub(super) Vector);

/// A point, or the edges of a box: (x, z) or (x, y) in two dimensions, (x, y, z) in three.
pub(super) type Point = Numbers<2>;

impl<const LEAST: usize> Serialize for Numbers<LEAST> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.as_slice().serialize(serializer)
    }
}

impl<'de, const LEAST: usize> Deserialize<'de> for Numbers<LEAST> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumbersVisitor::<LEAST>).map(Self)
    }
}

pub(super) struct NumbersVisitor<const LEAST: usize>;

impl<'de, const LEAST: usize> Visitor<'de> for NumbersVisitor<LEAST> {
    type Value = Vector;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let to = if LEAST + 1 == Vector::MOST { "or" } else { "to" };
        write!(f, "a list of {LEAST} {to} {} numbers", Vector::MOST)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Vector, A::Error> {
        let count = entries.size_hint().unwrap_or(0);
        if !(LEAST..=Vector::MOST).contains(&count) {
            return Err(A::Error::invalid_length(count, &self));
        }
        let mut values = [0.0; Vector::MOST];
        for value in &mut values[..count] {
            match entries.next_element()? {
                Some(entry) => *value = entry,
                None => return Err(A::Error::invalid_length(count, &self)),
            }
        }
        Vector::new(&values[..count]).ok_or_else(|| A::Error::invalid_length(count, &self))
    }
}

impl Element for Vector {
    type Json<'a> = Point;

    fn from_json<E: Error>(json: Point) -> Result<Self, E> {
        Ok(json.0)
    }
}

impl From<&Vector> for Point {
    fn from(vector: &Vector) -> Self {
        Self(*vector)
    }
}

/// A box with sides parallel to the axes, as it is written; `half_space` reads it.
#[derive(Serialize, Clone, Copy)]
pub(super) struct BoxJson {
    pub(super) min: Point,
    pub(super) max: Point,
}

impl From<&AxisBox> for BoxJson {
    fn from(&AxisBox { min, max }: &AxisBox) -> Self {
        Self { min: Numbers(min), max: Numbers(max) }
    }
}

impl From<BoxJson> for AxisBox {
    fn from(BoxJson { min, max }: BoxJson) -> Self {
        Self { min: min.0, max: max.0 }
    }
}

impl Element for AxisBox {
    type Json<'a> = BoxJson;

    fn from_json<E: Error>(json: BoxJson) -> Result<Self, E> {
        Ok(json.into())
    }
}
