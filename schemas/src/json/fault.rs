//! What is wrong with a value, and where it is.

use std::fmt;

use serde::de::{self, Expected, Unexpected};

use super::tree::{Excerpt, Node};

/// What is wrong, and the path to it. It gathers its path on the way out, so that
/// reading what is right costs nothing.
#[derive(Debug)]
pub(super) struct Fault(Box<Inner>);

#[derive(Debug)]
struct Inner {
    /// The innermost first.
    path: Vec<Step>,
    what: String,
    /// Whether the value that was found is still to be added.
    open: bool,
}

#[derive(Debug)]
enum Step {
    Field(String),
    Entry(usize),
}

impl Fault {
    fn new(what: String) -> Self {
        Self(Box::new(Inner { path: Vec::new(), what, open: false }))
    }

    pub(super) fn expected(what: impl fmt::Display) -> Self {
        let mut fault = Self::new(format!("must be {what}"));
        fault.0.open = true;
        fault
    }

    pub(super) fn missing() -> Self {
        Self::new("is missing".to_owned())
    }

    pub(super) fn unknown(expected: &'static [&'static str]) -> Self {
        let expected = OneOf(expected);
        Self::new(format!("is not a known field; expected {expected}"))
    }

    pub(super) fn repeated() -> Self {
        Self::new("is given twice".to_owned())
    }

    pub(super) fn not_one_of(expected: &'static [&'static str], found: impl fmt::Display) -> Self {
        let expected = Names(expected);
        Self::new(format!("must have exactly one of {expected}, but has {found}"))
    }

    /// Adds the value that was found, if it is not there yet.
    pub(super) fn found(mut self, node: &Node) -> Self {
        if self.0.open {
            self.0.what += &format!(", not {node}");
            self.0.open = false;
        }
        self
    }

    pub(super) fn in_field(mut self, name: &str) -> Self {
        self.0.path.push(Step::Field(name.to_owned()));
        self
    }

    pub(super) fn in_entry(mut self, index: usize) -> Self {
        self.0.path.push(Step::Entry(index));
        self
    }

    /// Whether the fault is that of the value itself, not of one inside it.
    pub(super) fn is_here(&self) -> bool {
        self.0.path.is_empty()
    }

    /// The path, where `root` is what is read, and the whole message.
    pub(super) fn tell(&self, root: &str) -> (String, String) {
        let path = Path { root, steps: &self.0.path }.to_string();
        let message = format!("{path} {}", self.0.what);
        (path, message)
    }
}

struct Path<'a> {
    root: &'a str,
    steps: &'a [Step],
}

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut outer = self.steps.iter().rev();
        match outer.next() {
            Some(Step::Field(name)) if !name.is_empty() => write!(f, "{}", Excerpt(name, 60))?,
            Some(step) => write!(f, "{}{step}", self.root)?,
            None => f.write_str(self.root)?,
        }
        outer.try_for_each(|step| write!(f, "{step}"))
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Field(name) if name.is_empty() => f.write_str(".\"\""),
            Self::Field(name) => write!(f, ".{}", Excerpt(name, 60)),
            Self::Entry(index) => write!(f, "[{index}]"),
        }
    }
}

/// Names as they are listed in messages.
pub(super) struct Names(pub(super) &'static [&'static str]);

impl fmt::Display for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, name) in self.0.iter().enumerate() {
            write!(f, "{}`{name}`", if index > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}

/// Names of which one is expected.
pub(super) struct OneOf(pub(super) &'static [&'static str]);

impl fmt::Display for OneOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let one_of = if self.0.len() > 1 { "one of " } else { "" };
        write!(f, "{one_of}{}", Names(self.0))
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.tell("the value").1)
    }
}

impl std::error::Error for Fault {}

impl de::Error for Fault {
    fn custom<T: fmt::Display>(what: T) -> Self {
        Self::new(what.to_string())
    }

    fn invalid_type(_: Unexpected, expected: &dyn Expected) -> Self {
        Self::expected(expected)
    }

    fn invalid_value(_: Unexpected, expected: &dyn Expected) -> Self {
        Self::expected(expected)
    }

    fn invalid_length(_: usize, expected: &dyn Expected) -> Self {
        Self::expected(expected)
    }

    fn unknown_field(name: &str, expected: &'static [&'static str]) -> Self {
        Self::unknown(expected).in_field(name)
    }

    fn missing_field(name: &'static str) -> Self {
        Self::missing().in_field(name)
    }

    fn duplicate_field(name: &'static str) -> Self {
        Self::repeated().in_field(name)
    }
}
