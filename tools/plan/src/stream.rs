//! Scenes from a stream: JSON objects one after another, each on one line or spread over
//! several.
//!
//! Each is returned as soon as its last byte has been read. After invalid JSON, reading goes
//! on at the next line that is not indented and doesn't begin with a closing bracket: in JSON
//! Lines that is the next line, in pretty-printed JSON the next object.

use std::cell::Cell;
use std::fmt;
use std::io::{self, BufRead, Read};
use std::ops::RangeInclusive;

use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};

/// Bytes of the longest scene that is read; bounds the memory.
pub(crate) const MOST_BYTES: usize = 256 << 20;

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The text of one scene.
#[derive(Debug, PartialEq)]
pub(crate) struct SceneText {
    /// The line of the stream where it begins, from 1.
    pub(crate) line: u64,
    pub(crate) text: String,
    /// Why the text is not JSON, if it isn't; it then ends where this was found.
    pub(crate) fault: Option<Fault>,
}

/// What is wrong, and where in the stream.
#[derive(Debug, PartialEq)]
pub(crate) struct Fault {
    line: u64,
    column: u64,
    what: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, column, what } = self;
        write!(f, "invalid JSON at line {line}, column {column}: {what}")
    }
}

/// The scenes of a stream.
pub(crate) struct Scenes<R> {
    input: Input<R>,
    most: usize,
    /// The text before was not JSON: what continues it is skipped.
    broken: bool,
    skipped: Option<RangeInclusive<u64>>,
}

impl<R: BufRead> Scenes<R> {
    /// The scenes in `reader`, each of at most `most` bytes.
    pub(crate) fn new(reader: R, most: usize) -> Self {
        let position = Position { line: 1, column: 1 };
        let input = Input { reader, again: Vec::new(), at: 0, position };
        Self { input, most, broken: false, skipped: None }
    }

    /// The lines that the last call of [`Scenes::next`] skipped, if any: they continue a text
    /// that was not JSON.
    pub(crate) fn skipped(&mut self) -> Option<RangeInclusive<u64>> {
        self.skipped.take()
    }

    /// The next scene, or `None` at the end of the stream.
    pub(crate) fn next(&mut self) -> io::Result<Option<SceneText>> {
        if std::mem::take(&mut self.broken) {
            self.skip()?;
        }
        while let Some(b' ' | b'\t' | b'\r' | b'\n') = self.input.peek()? {
            self.input.bump();
        }
        match self.input.peek()? {
            None => Ok(None),
            Some(b'{' | b'[') => self.value().map(Some),
            Some(_) => self.line().map(Some),
        }
    }

    /// An object or a list.
    fn value(&mut self) -> io::Result<SceneText> {
        let start = self.input.position;
        let failed = Cell::new(false);
        let check = Check { failed: &failed };
        let (input, most) = (&mut self.input, self.most);
        let mut tape = Tape { input, text: Vec::new(), most, ended: &failed };
        let read = check.deserialize(&mut serde_json::Deserializer::from_reader(&mut tape));
        let mut text = tape.text;
        let fault = match read {
            Ok(()) => None,
            Err(_) if text.len() > self.most => {
                let what = format!("longer than {} bytes, the most for one scene", self.most);
                self.broken = true;
                Some(Fault { line: start.line, column: start.column, what })
            }
            Err(error) if error.is_io() => return Err(error.into()),
            Err(error) => {
                self.broken = true;
                if let Some(next) = next_start(&text) {
                    let line = start.line + line_ends(&text[..next]);
                    self.input.read_again(&text[next..], Position { line, column: 1 });
                    self.broken = false;
                    text.truncate(next);
                }
                Some(start.fault(&error))
            }
        };
        Ok(SceneText { line: start.line, text: into_text(text), fault })
    }

    /// A line that begins with neither.
    fn line(&mut self) -> io::Result<SceneText> {
        let start = self.input.position;
        let mut text = Vec::new();
        while let Some(byte) = self.input.peek()?
            && byte != b'\n'
            && text.len() < self.most
        {
            text.push(byte);
            self.input.bump();
        }
        let check = Check { failed: &Cell::new(false) };
        let mut json = serde_json::Deserializer::from_slice(&text);
        let fault = match check.deserialize(&mut json).and_then(|()| json.end()) {
            Err(error) if !text.starts_with(BYTE_ORDER_MARK) => Some(start.fault(&error)),
            _ => None,
        };
        self.broken = fault.is_some();
        Ok(SceneText { line: start.line, text: into_text(text), fault })
    }

    /// Skips the rest of the line and the lines that continue what was broken.
    fn skip(&mut self) -> io::Result<()> {
        let at_start = self.input.position.column == 1;
        let mut whole = at_start;
        loop {
            if whole && !self.input.peek()?.is_some_and(continues) {
                return Ok(());
            }
            let line = self.input.position.line;
            let mut blank = true;
            while let Some(byte) = self.input.peek()? {
                self.input.bump();
                if byte == b'\n' {
                    break;
                }
                blank &= byte.is_ascii_whitespace();
            }
            if whole && !blank {
                let first = self.skipped.as_ref().map_or(line, |lines| *lines.start());
                self.skipped = Some(first..=line);
            }
            if self.input.peek()?.is_none() {
                return Ok(());
            }
            whole = true;
        }
    }
}

/// Whether a line that begins so continues the text before it.
fn continues(first: u8) -> bool {
    matches!(first, b' ' | b'\t' | b'\r' | b'\n' | b'}' | b']')
}

/// Where in a text that is not JSON the next one may begin: a line after the first.
fn next_start(text: &[u8]) -> Option<usize> {
    let ends = text.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
    let mut starts = ends.map(|(end, _)| end + 1);
    starts.find(|start| text.get(*start).is_some_and(|first| !continues(*first)))
}

fn line_ends(text: &[u8]) -> u64 {
    text.iter().filter(|byte| **byte == b'\n').count() as u64
}

fn into_text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes)
        .unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned())
}

/// A place in the stream; both count from 1, columns in bytes.
#[derive(Debug, Clone, Copy)]
struct Position {
    line: u64,
    column: u64,
}

impl Position {
    /// What is wrong with the JSON that begins here.
    fn fault(self, error: &serde_json::Error) -> Fault {
        let (line, column) = (error.line().max(1) as u64, error.column().max(1) as u64);
        let what = error.to_string();
        let position = format!(" at line {} column {}", error.line(), error.column());
        let what = what.strip_suffix(&position).unwrap_or(&what).to_owned();
        match line {
            1 => Fault { line: self.line, column: self.column + column - 1, what },
            _ => Fault { line: self.line + line - 1, column, what },
        }
    }
}

/// A reader that knows its position and can read some of it again.
struct Input<R> {
    reader: R,
    /// Read again from `at` before more is read.
    again: Vec<u8>,
    at: usize,
    /// Of the next byte.
    position: Position,
}

impl<R: BufRead> Input<R> {
    /// The next byte, which stays.
    fn peek(&mut self) -> io::Result<Option<u8>> {
        match self.again.get(self.at) {
            Some(byte) => Ok(Some(*byte)),
            None => Ok(self.reader.fill_buf()?.first().copied()),
        }
    }

    /// Passes the byte that [`Input::peek`] returned.
    fn bump(&mut self) {
        let byte = match self.again.get(self.at) {
            Some(byte) => {
                self.at += 1;
                Some(*byte)
            }
            None => {
                let byte = self.reader.fill_buf().ok().and_then(|bytes| bytes.first().copied());
                self.reader.consume(usize::from(byte.is_some()));
                byte
            }
        };
        match byte {
            Some(b'\n') => {
                self.position = Position { line: self.position.line + 1, column: 1 };
            }
            Some(_) => self.position.column += 1,
            None => {}
        }
    }

    /// Reads `bytes`, the first of which is at `position`, once more.
    fn read_again(&mut self, bytes: &[u8], position: Position) {
        let rest = self.again.split_off(self.at.min(self.again.len()));
        self.again = [bytes, &rest].concat();
        self.at = 0;
        self.position = position;
    }
}

/// Keeps what is read: at most one byte more than `most`, and nothing once it has `ended`.
struct Tape<'a, R> {
    input: &'a mut Input<R>,
    text: Vec<u8>,
    most: usize,
    ended: &'a Cell<bool>,
}

impl<R: BufRead> Read for Tape<'_, R> {
    /// One byte at a time: nothing is read that is not needed.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.ended.get() {
            return Ok(0);
        }
        let (Some(first), Some(byte)) = (buffer.first_mut(), self.input.peek()?) else {
            return Ok(0);
        };
        self.input.bump();
        self.text.push(byte);
        if self.text.len() > self.most {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        *first = byte;
        Ok(1)
    }
}

/// Reads JSON without keeping it; unlike `IgnoredAny` it checks every digit and byte.
///
/// The flag is set at the first error: serde_json then reads on to the end of each list and
/// object, for which nobody should have to wait.
#[derive(Clone, Copy)]
struct Check<'a> {
    failed: &'a Cell<bool>,
}

impl<'de> DeserializeSeed<'de> for Check<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Check<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let failed = |_: &A::Error| self.failed.set(true);
        while list.next_element_seed(self).inspect_err(failed)?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let failed = |_: &A::Error| self.failed.set(true);
        while map.next_entry_seed(self, self).inspect_err(failed)?.is_some() {}
        Ok(())
    }
}

#[cfg(test)]
mod tests;
