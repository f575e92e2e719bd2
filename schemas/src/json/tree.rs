//! JSON as a tree that keeps what is written: every field, also a second of the same name.

use std::borrow::Cow;
use std::cell::Cell;
use std::fmt;

use serde::de::{IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::message::Refusal;

/// A value and all that is in it.
pub(super) enum Node<'t> {
    Null,
    Bool(bool),
    /// A number without sign, fraction and exponent.
    Whole(u64),
    Number(f64),
    Text(Cow<'t, str>),
    List(Vec<Node<'t>>),
    Object(Vec<(Cow<'t, str>, Node<'t>)>),
}

/// The tree of a text that is one JSON value.
pub(super) fn parse(text: &str) -> Result<Node<'_>, Refusal> {
    if text.starts_with(BYTE_ORDER_MARK) {
        let message = "the text begins with a byte order mark, which JSON does not have";
        return Err(Refusal::invalid("scene", message));
    }
    let json = &mut serde_json::Deserializer::from_str(text);
    let tree = serde_path_to_error::deserialize(&mut *json).map_err(|error| {
        // Where the parser stopped is mostly in the field that is wrong.
        let path = error.path().to_string();
        let field = match path.trim_end_matches(['.', '?']) {
            "" => "scene".to_owned(),
            path => Excerpt(path, 200).to_string(),
        };
        let message = format!("{field}: no JSON can be read here: {}", error.inner());
        Refusal::invalid(field, message)
    })?;
    json.end().map_err(|error| {
        Refusal::invalid("scene", format!("something follows the scene's JSON: {error}"))
    })?;
    Ok(tree)
}

const BYTE_ORDER_MARK: char = '\u{feff}';

/// The `id` of a scene, however broken what follows it is.
pub(super) fn find_id(text: &str) -> Option<u64> {
    struct IdVisitor<'a>(&'a Cell<Option<u64>>);

    impl<'de> Visitor<'de> for IdVisitor<'_> {
        type Value = ();

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a scene")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
            while let Some(name) = map.next_key::<Cow<str>>()? {
                if name == "id" {
                    self.0.set(map.next_value()?);
                    return Ok(());
                }
                map.next_value::<IgnoredAny>()?;
            }
            Ok(())
        }
    }

    let id = Cell::new(None);
    let text = text.trim_start_matches(BYTE_ORDER_MARK);
    // What is wrong with the text is said elsewhere.
    let _ = serde_json::Deserializer::from_str(text).deserialize_map(IdVisitor(&id));
    id.get()
}

impl<'de> Deserialize<'de> for Node<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NodeVisitor)
    }
}

struct NodeVisitor;

impl<'de> Visitor<'de> for NodeVisitor {
    type Value = Node<'de>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<Node<'de>, E> {
        Ok(Node::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Node<'de>, E> {
        Ok(Node::Bool(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Node<'de>, E> {
        Ok(Node::Whole(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Node<'de>, E> {
        Ok(Node::Number(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Node<'de>, E> {
        Ok(Node::Number(value))
    }

    fn visit_borrowed_str<E>(self, text: &'de str) -> Result<Node<'de>, E> {
        Ok(Node::Text(Cow::Borrowed(text)))
    }

    fn visit_str<E>(self, text: &str) -> Result<Node<'de>, E> {
        Ok(Node::Text(Cow::Owned(text.to_owned())))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Node<'de>, A::Error> {
        let mut list = Vec::new();
        while let Some(entry) = sequence.next_element()? {
            list.push(entry);
        }
        Ok(Node::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Node<'de>, A::Error> {
        let mut fields = Vec::new();
        while let Some(field) = map.next_entry()? {
            fields.push(field);
        }
        Ok(Node::Object(fields))
    }
}

/// What stands there, for messages.
impl fmt::Display for Node<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => f.write_str("null"),
            Self::Bool(value) => write!(f, "{value}"),
            Self::Whole(value) => write!(f, "{value}"),
            Self::Number(value) => write!(f, "{value:?}"),
            Self::Text(text) => write!(f, "the text \"{}\"", Excerpt(text, 60)),
            Self::List(list) => write!(f, "a list of {}", list.len()),
            Self::Object(_) => f.write_str("an object"),
        }
    }
}

/// The beginning of a text that can be of any length: so many bytes, control characters escaped.
pub(super) struct Excerpt<'a>(pub(super) &'a str, pub(super) usize);

impl fmt::Display for Excerpt<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(text, most) = *self;
        let shown = &text[..text.floor_char_boundary(most)];
        write!(f, "{}", shown.escape_debug())?;
        if shown.len() < text.len() { f.write_str("…") } else { Ok(()) }
    }
}
