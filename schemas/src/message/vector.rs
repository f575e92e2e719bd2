//! One to three numbers, without allocation.

use std::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeSeq;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// One to three numbers: a point, a size, or a gap per axis. Metres, in the
/// scene's frame: (x, z) or (x, y) in two dimensions, (x, y, z) in three.
#[derive(Clone, Copy)]
pub struct Vector {
    values: [f64; 3],
    length: u8,
}

impl Vector {
    /// The most numbers that a vector can have.
    pub const MOST: usize = 3;

    /// The vector with these numbers, if there are 1 to 3.
    pub fn new(values: &[f64]) -> Option<Self> {
        if values.is_empty() || values.len() > Self::MOST {
            return None;
        }
        let mut vector = Self { values: [0.0; 3], length: values.len() as u8 };
        vector.values[..values.len()].copy_from_slice(values);
        Some(vector)
    }

    /// The numbers.
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.length as usize]
    }

    /// How many numbers there are.
    pub fn dimension(&self) -> usize {
        self.length as usize
    }

    /// The numbers, padded with zeros to three.
    pub fn padded(&self) -> [f64; 3] {
        self.values
    }
}

/// The origin in two dimensions.
impl Default for Vector {
    fn default() -> Self {
        Self::from([0.0; 2])
    }
}

impl<const N: usize> From<[f64; N]> for Vector {
    fn from(values: [f64; N]) -> Self {
        const { assert!(N >= 1 && N <= Self::MOST, "a vector holds one to three numbers") };
        let mut vector = Self { values: [0.0; 3], length: N as u8 };
        vector.values[..N].copy_from_slice(&values);
        vector
    }
}

impl PartialEq for Vector {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

impl fmt::Debug for Vector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_slice().fmt(f)
    }
}

impl Serialize for Vector {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut sequence = serializer.serialize_seq(Some(self.dimension()))?;
        for value in self.as_slice() {
            sequence.serialize_element(value)?;
        }
        sequence.end()
    }
}

impl<'de> Deserialize<'de> for Vector {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(VectorVisitor)
    }
}

struct VectorVisitor;

impl<'de> Visitor<'de> for VectorVisitor {
    type Value = Vector;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of 1 to 3 numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Vector, A::Error> {
        let (mut values, mut length) = ([0.0; Vector::MOST], 0);
        while let Some(value) = sequence.next_element()? {
            match values.get_mut(length) {
                Some(place) => *place = value,
                None => return Err(A::Error::invalid_length(length + 1, &self)),
            }
            length += 1;
        }
        Vector::new(&values[..length]).ok_or_else(|| A::Error::invalid_length(length, &self))
    }
}
