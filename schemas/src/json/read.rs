//! Values from trees.

use serde::Deserialize;
use serde::de::value::BorrowedStrDeserializer;
use serde::de::{DeserializeSeed, Deserializer, EnumAccess, Error, MapAccess, SeqAccess};
use serde::de::{VariantAccess, Visitor};
use serde::forward_to_deserialize_any;

use super::fault::{Fault, Names};
use super::tree::Node;

/// Asks [`Deserializer::deserialize_enum`] to take values other than objects, too: the
/// visitor is shown what is there. Without this an enumeration is always an object.
pub(super) const OR_OTHER: &str = "";

pub(super) fn read<'n, T: Deserialize<'n>>(node: &'n Node<'n>) -> Result<T, Fault> {
    T::deserialize(node)
}

macro_rules! only {
    ($method:ident, $pattern:pat, $expected:expr) => {
        fn $method<V: Visitor<'n>>(self, visitor: V) -> Result<V::Value, Fault> {
            match self {
                $pattern => self.deserialize_any(visitor),
                _ => Err(Fault::expected($expected).found(self)),
            }
        }
    };
}

impl<'n> Deserializer<'n> for &'n Node<'n> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'n>>(self, visitor: V) -> Result<V::Value, Fault> {
        let value = match self {
            Node::Null => visitor.visit_unit(),
            Node::Bool(value) => visitor.visit_bool(*value),
            Node::Whole(value) => visitor.visit_u64(*value),
            Node::Negative(value) => visitor.visit_i64(*value),
            Node::Number(value) => visitor.visit_f64(*value),
            Node::Text(text) => visitor.visit_borrowed_str(text),
            Node::List(list) => visitor.visit_seq(Entries { list, next: 0 }),
            Node::Object(fields) => visitor.visit_map(Fields { fields, current: None }),
        };
        value.map_err(|fault| fault.found(self))
    }

    only!(deserialize_f64, Node::Whole(_) | Node::Negative(_) | Node::Number(_), "a number");
    only!(deserialize_u64, Node::Whole(_), format_args!("a whole number from 0 to {}", u64::MAX));
    only!(deserialize_bool, Node::Bool(_), "true or false");
    only!(deserialize_str, Node::Text(_), "a text");
    only!(deserialize_string, Node::Text(_), "a text");
    only!(deserialize_seq, Node::List(_), "a list");

    fn deserialize_option<V: Visitor<'n>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self {
            Node::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_struct<V: Visitor<'n>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self {
            Node::Object(_) => self.deserialize_any(visitor),
            _ => Err(Fault::expected(format_args!("an object with {}", Names(fields))).found(self)),
        }
    }

    /// An object with exactly one field, which says which variant it is.
    fn deserialize_enum<V: Visitor<'n>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let Node::Object(fields) = self else {
            if name == OR_OTHER {
                return self.deserialize_any(visitor);
            }
            let expected = format_args!("an object with one of {}", Names(variants));
            return Err(Fault::expected(expected).found(self));
        };
        let mut seen: Vec<&str> = Vec::with_capacity(variants.len());
        for (name, _) in fields {
            if !variants.contains(&&**name) {
                return Err(Fault::unknown(variants).in_field(name));
            }
            if seen.contains(&&**name) {
                return Err(Fault::repeated().in_field(name));
            }
            seen.push(name);
        }
        let mut given = fields.iter().filter(|(_, value)| !matches!(value, Node::Null));
        match (given.next(), given.next()) {
            (Some((name, value)), None) => {
                visitor.visit_enum(Only { name, value }).map_err(|fault| fault.found(self))
            }
            (None, _) => Err(Fault::not_one_of(variants, "none")),
            (Some((first, _)), Some((second, _))) => {
                Err(Fault::not_one_of(variants, format_args!("`{first}` and `{second}`")))
            }
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'n>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    forward_to_deserialize_any! {
        <W: Visitor<'n>>
        i8 i16 i32 i64 i128 u8 u16 u32 u128 f32 char bytes byte_buf unit unit_struct
        tuple tuple_struct map identifier ignored_any
    }
}

struct Entries<'n> {
    list: &'n [Node<'n>],
    next: usize,
}

impl<'n> SeqAccess<'n> for Entries<'n> {
    type Error = Fault;

    fn next_element_seed<S: DeserializeSeed<'n>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Fault> {
        let index = self.next;
        let Some(entry) = self.list.get(index) else { return Ok(None) };
        self.next += 1;
        seed.deserialize(entry).map(Some).map_err(|fault| fault.in_entry(index))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.list.len() - self.next)
    }
}

struct Fields<'n> {
    fields: &'n [(std::borrow::Cow<'n, str>, Node<'n>)],
    current: Option<(&'n str, &'n Node<'n>)>,
}

impl<'n> MapAccess<'n> for Fields<'n> {
    type Error = Fault;

    fn next_key_seed<S: DeserializeSeed<'n>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Fault> {
        let Some(((name, value), rest)) = self.fields.split_first() else { return Ok(None) };
        self.fields = rest;
        self.current = Some((name, value));
        seed.deserialize(BorrowedStrDeserializer::new(name)).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'n>>(&mut self, seed: S) -> Result<S::Value, Fault> {
        let (name, value) = self.current.take().expect("serde asks for a field's name first");
        seed.deserialize(value).map_err(|fault| match value {
            // `null` is the same as a field left out.
            Node::Null if fault.is_here() => Fault::missing().in_field(name),
            _ => fault.in_field(name),
        })
    }
}

/// The only field of an object.
struct Only<'n> {
    name: &'n str,
    value: &'n Node<'n>,
}

impl<'n> EnumAccess<'n> for Only<'n> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'n>>(self, seed: S) -> Result<(S::Value, Self), Fault> {
        Ok((seed.deserialize(BorrowedStrDeserializer::new(self.name))?, self))
    }
}

impl<'n> VariantAccess<'n> for Only<'n> {
    type Error = Fault;

    fn newtype_variant_seed<S: DeserializeSeed<'n>>(self, seed: S) -> Result<S::Value, Fault> {
        seed.deserialize(self.value).map_err(|fault| fault.in_field(self.name))
    }

    fn unit_variant(self) -> Result<(), Fault> {
        Err(Fault::custom("is not an object").in_field(self.name))
    }

    fn tuple_variant<V: Visitor<'n>>(self, _: usize, visitor: V) -> Result<V::Value, Fault> {
        self.value.deserialize_seq(visitor).map_err(|fault| fault.in_field(self.name))
    }

    fn struct_variant<V: Visitor<'n>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let value = self.value.deserialize_struct("", fields, visitor);
        value.map_err(|fault| fault.in_field(self.name))
    }
}
