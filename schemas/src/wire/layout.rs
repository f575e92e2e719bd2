//! The layout as data: its text, and the hash that the type names on the bus carry.
//!
//! Offsets, types and counts are taken from the `repr(C)` structures themselves; the
//! tables add names for codes and bits, and explanations. The hash covers everything a
//! peer depends on and leaves the explanations out: correcting one disconnects nobody.

mod table;
#[cfg(test)]
mod tests;

use std::fmt::Write;

/// Everything that lies in shared memory.
struct Layout<'a> {
    version: u32,
    sections: &'a [Section<'a>],
}

/// A structure or a payload.
enum Section<'a> {
    Structure(Structure<'a>),
    Payload(Payload<'a>),
}

/// A `repr(C)` structure without padding.
struct Structure<'a> {
    name: &'a str,
    note: &'a str,
    /// Bytes.
    size: usize,
    fields: &'a [Field<'a>],
}

/// A field of a structure.
#[derive(Clone, Copy)]
struct Field<'a> {
    name: &'a str,
    kind: Kind,
    /// Bytes from the structure's start.
    offset: usize,
    /// More than 1 for an array.
    count: usize,
    words: Words<'a>,
    note: &'a str,
}

/// Cells that follow each other.
struct Payload<'a> {
    name: &'a str,
    note: &'a str,
    items: &'a [Item<'a>],
}

/// A number, or a list of `count` entries.
#[derive(Clone, Copy)]
struct Item<'a> {
    name: &'a str,
    /// Where the number of entries stands; empty for exactly one.
    count: &'a str,
    form: &'a str,
    /// The condition under which it is present; empty for always.
    when: &'a str,
    words: Words<'a>,
    note: &'a str,
}

/// What a number stands for.
#[derive(Clone, Copy)]
enum Words<'a> {
    /// Itself.
    None,
    /// The entry of this index.
    Codes(&'a [&'a str]),
    /// Each entry whose mask is set.
    Bits(&'a [(&'a str, u64)]),
}

/// The type of a number.
#[derive(Clone, Copy)]
enum Kind {
    U8,
    U16,
    U32,
    U64,
    F64,
}

impl Kind {
    const fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::U16 => "u16",
            Self::U32 => "u32",
            Self::U64 => "u64",
            Self::F64 => "f64",
        }
    }

    const fn size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 => 4,
            Self::U64 | Self::F64 => 8,
        }
    }
}

/// A number or an array of numbers.
trait Numbers {
    const KIND: Kind;
    const COUNT: usize;
}

macro_rules! numbers {
    ($($type:ident $kind:ident),*) => {
        $(impl Numbers for $type {
            const KIND: Kind = Kind::$kind;
            const COUNT: usize = 1;
        })*
    };
}

numbers!(u8 U8, u16 U16, u32 U32, u64 U64, f64 F64);

impl<T: Numbers, const N: usize> Numbers for [T; N] {
    const KIND: Kind = T::KIND;
    const COUNT: usize = N * T::COUNT;
}

/// Takes a field's type from an accessor that is never called.
const fn field<'a, S, T: Numbers>(
    name: &'a str,
    offset: usize,
    _accessor: fn(&S) -> &T,
    words: Words<'a>,
    note: &'a str,
) -> Field<'a> {
    Field { name, kind: T::KIND, offset, count: T::COUNT, words, note }
}

impl Structure<'_> {
    /// Whether the fields fill the structure: none left out, no padding.
    const fn is_complete(&self) -> bool {
        let (mut index, mut end) = (0, 0);
        while index < self.fields.len() {
            let field = &self.fields[index];
            if field.offset != end {
                return false;
            }
            end += field.kind.size() * field.count;
            index += 1;
        }
        end == self.size
    }
}

/// FNV-1a, 64 bits.
struct Fnv(u64);

impl Fnv {
    const fn byte(self, byte: u8) -> Self {
        Self((self.0 ^ byte as u64).wrapping_mul(0x0000_0100_0000_01b3))
    }

    const fn number(mut self, number: u64) -> Self {
        let bytes = number.to_le_bytes();
        let mut index = 0;
        while index < bytes.len() {
            self = self.byte(bytes[index]);
            index += 1;
        }
        self
    }

    /// The length keeps neighbouring texts apart.
    const fn text(mut self, text: &str) -> Self {
        let bytes = text.as_bytes();
        self = self.number(bytes.len() as u64);
        let mut index = 0;
        while index < bytes.len() {
            self = self.byte(bytes[index]);
            index += 1;
        }
        self
    }

    const fn words(mut self, words: Words) -> Self {
        let mut index = 0;
        match words {
            Words::None => self.byte(0),
            Words::Codes(names) => {
                self = self.byte(1).number(names.len() as u64);
                while index < names.len() {
                    self = self.text(names[index]);
                    index += 1;
                }
                self
            }
            Words::Bits(bits) => {
                self = self.byte(2).number(bits.len() as u64);
                while index < bits.len() {
                    self = self.text(bits[index].0).number(bits[index].1);
                    index += 1;
                }
                self
            }
        }
    }
}

impl Layout<'_> {
    /// Over versions, names, types, offsets, counts, codes and bits.
    const fn hash(&self) -> u64 {
        let mut hash = Fnv(0xcbf2_9ce4_8422_2325).number(self.version as u64);
        let mut section = 0;
        while section < self.sections.len() {
            let mut index = 0;
            match &self.sections[section] {
                Section::Structure(Structure { name, note: _, size, fields }) => {
                    hash = hash.byte(0).text(name).number(*size as u64);
                    hash = hash.number(fields.len() as u64);
                    while index < fields.len() {
                        let Field { name, kind, offset, count, words, note: _ } = fields[index];
                        hash = hash.text(name).text(kind.name());
                        hash = hash.number(offset as u64).number(count as u64).words(words);
                        index += 1;
                    }
                }
                Section::Payload(Payload { name, note: _, items }) => {
                    hash = hash.byte(1).text(name).number(items.len() as u64);
                    while index < items.len() {
                        let Item { name, count, form, when, words, note: _ } = items[index];
                        hash = hash.text(name).text(count).text(form).text(when).words(words);
                        index += 1;
                    }
                }
            }
            section += 1;
        }
        hash.0
    }

    fn text(&self) -> String {
        let mut text = format!(
            "Clearway shared-memory layout, version {}, hash {:016x}\n{}",
            self.version,
            self.hash(),
            table::PREAMBLE,
        );
        for section in self.sections {
            text.push('\n');
            match section {
                Section::Structure(structure) => structure.describe(&mut text),
                Section::Payload(payload) => payload.describe(&mut text),
            }
        }
        text
    }
}

impl Structure<'_> {
    fn describe(&self, text: &mut String) {
        let _ = writeln!(text, "{}, {} bytes: {}", self.name, self.size, self.note);
        for field in self.fields {
            let kind = match field.count {
                1 => field.kind.name().to_owned(),
                count => format!("{}[{count}]", field.kind.name()),
            };
            let left = format!("{:>5}  {kind:<8}{}", field.offset, field.name);
            describe_line(text, &left, "", field.words, field.note);
        }
    }
}

impl Payload<'_> {
    fn describe(&self, text: &mut String) {
        let _ = writeln!(text, "{}: {}", self.name, self.note);
        for item in self.items {
            let form = match item.count {
                "" => item.form.to_owned(),
                count => format!("{count} x {}", item.form),
            };
            let left = format!("  {:<16}{form}", item.name);
            describe_line(text, &left, item.when, item.words, item.note);
        }
    }
}

/// Appends a line, wrapped where its explanation is long.
fn describe_line(text: &mut String, left: &str, when: &str, words: Words, note: &str) {
    const COLUMN: usize = 37;
    const WIDTH: usize = 92;
    let mut right = String::new();
    if !when.is_empty() {
        let _ = write!(right, "if {when}; ");
    }
    match words {
        Words::None => {}
        Words::Codes(names) => {
            let codes = names.iter().enumerate().map(|(code, name)| format!("{code}\u{a0}{name}"));
            right += &(codes.collect::<Vec<_>>().join(", ") + "; ");
        }
        Words::Bits(bits) => {
            let bits =
                bits.iter().map(|(name, mask)| format!("{}\u{a0}{name}", mask.trailing_zeros()));
            right += &("bits: ".to_owned() + &bits.collect::<Vec<_>>().join(", ") + "; ");
        }
    }
    right += note;
    let mut line = format!("{left:<COLUMN$}");
    for word in right.trim_end_matches([';', ' ']).split(' ') {
        // A code stays with its name.
        let word = word.replace('\u{a0}', " ");
        if line.len() + 1 + word.len() > WIDTH {
            text.push_str(line.trim_end());
            line = format!("\n{:COLUMN$}", "");
        }
        line.push(' ');
        line.push_str(&word);
    }
    text.push_str(line.trim_end());
    text.push('\n');
}

/// Identifies the layout of this version; see the module's description.
pub const fn hash() -> u64 {
    table::LAYOUT.hash()
}

/// The layout in words, as in `schemas/src/wire/layout.txt`.
pub fn text() -> String {
    table::LAYOUT.text()
}
