//! JSON as a tree that keeps every field, also those of the same name.

use std::borrow::Cow;
use std::cell::Cell;
use std::fmt;

use serde::de::{IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// A value and all that is in it.
pub(super) enum Node<'t> {
    Null,
    Bool(bool),
    /// A number without sign, fraction and exponent.
    Whole(u64),
    /// A whole number less than 0.
    Negative(i64),
    Number(f64),
    Text(Cow<'t, str>),
    List(Vec<Node<'t>>),
    Object(Vec<(Cow<'t, str>, Node<'t>)>),
}

/// Why a text is not JSON: the path to the value in which that shows, and the message.
pub(super) struct NotJson {
    pub(super) path: String,
    pub(super) message: String,
}

/// The tree of a text that is one JSON value; `root` is what messages call it.
pub(super) fn parse<'t>(text: &'t str, root: &str) -> Result<Node<'t>, NotJson> {
    let root = || root.to_owned();
    if text.starts_with(BYTE_ORDER_MARK) {
        let message = "invalid JSON: the text begins with a byte order mark; save it without one";
        return Err(NotJson { path: root(), message: message.to_owned() });
    }
    let json = &mut serde_json::Deserializer::from_str(text);
    let tree = serde_path_to_error::deserialize(&mut *json).map_err(|error| {
        // Where the parser stops is mostly in the field that is wrong.
        let path = error.path().to_string();
        let fault = Located(error.inner());
        match path.trim_end_matches(['.', '?']) {
            "" => NotJson { path: root(), message: format!("invalid JSON {fault}") },
            path => {
                let path = Excerpt(path, 200).to_string();
                NotJson { message: format!("{path}: invalid JSON {fault}"), path }
            }
        }
    })?;
    json.end().map_err(|error| {
        let (line, column) = (error.line(), error.column());
        let message = format!(
            "invalid JSON at line {line}, column {column}: unexpected text after the {}",
            root()
        );
        NotJson { path: root(), message }
    })?;
    Ok(tree)
}

/// A parser's error, its place first.
struct Located<'a>(&'a serde_json::Error);

impl fmt::Display for Located<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (line, column) = (self.0.line(), self.0.column());
        let text = self.0.to_string();
        let place = format!(" at line {line} column {column}");
        let what = text.strip_suffix(&place).unwrap_or(&text);
        write!(f, "at line {line}, column {column}: {what}")
    }
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
    // The text's errors are reported by whoever reads all of it.
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
        Ok(Node::Negative(value))
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

/// A value as messages name it.
impl fmt::Display for Node<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => f.write_str("null"),
            Self::Bool(value) => write!(f, "{value}"),
            Self::Whole(value) => write!(f, "{value}"),
            Self::Negative(value) => write!(f, "{value}"),
            Self::Number(value) => write!(f, "{value:?}"),
            Self::Text(text) => write!(f, "the text \"{}\"", Excerpt(text, 60)),
            Self::List(list) if list.is_empty() => f.write_str("an empty list"),
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
