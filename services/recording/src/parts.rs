//! The parts of a damaged file that something vouches for.
//!
//! A file of a recorder is found again by its marks, which nothing inside a message can imitate. In
//! other files a chunk counts where the index, or the records before it, say that one begins;
//! everything else could be a chunk inside a message.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek};

use mcap::MAGIC;
use mcap::records::op;

use crate::chunk::{Chunk, Records};
use crate::error::{Damage, ReadError};
use crate::fields::{Fields, RECORD_HEAD};
use crate::format::MOST_RECORD_BYTES;
use crate::mark::{self, Mark};
use crate::source::Source;

/// A part of a file whose messages can be had.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Where its record begins: a chunk, or a message outside of one.
    pub(crate) offset: u64,
    /// The numbers of its messages, where a mark tells them.
    pub(crate) sequences: Option<(u64, u64)>,
    /// Whether its checksum is right.
    pub(crate) is_checked: bool,
}

/// A part of a file that is not used.
#[derive(Debug, Clone, PartialEq)]
pub struct Dropped {
    /// Where it begins.
    pub offset: u64,
    /// What is wrong with it.
    pub damage: Damage,
}

/// What was found.
#[derive(Debug, Default)]
pub(crate) struct Parts {
    /// In the order in which they were written.
    pub(crate) parts: Vec<Part>,
    pub(crate) dropped: Vec<Dropped>,
    /// The first and the last mark.
    pub(crate) marks: Option<(Mark, Mark)>,
    /// Schemas and channels from the index.
    pub(crate) definitions: Vec<(u8, Vec<u8>)>,
}

/// Finds the parts of a file. With `unverified`, also those that can only be guessed.
pub(crate) fn find<R: Read + Seek>(
    source: &mut Source<R>,
    unverified: bool,
) -> Result<Parts, ReadError> {
    let mut search = Search { source, found: Parts::default(), records: Records::default() };
    let index = search.index()?;
    match search.marks()? {
        Some(marks) => search.between_marks(&marks)?,
        None => search.along(&index, unverified)?,
    }
    search.found.dropped.sort_by_key(|dropped| dropped.offset);
    Ok(search.found)
}

/// Bytes of a mark's record.
const MARK_RECORD: u64 = (RECORD_HEAD + mark::BYTES) as u64;

struct Search<'a, R> {
    source: &'a mut Source<R>,
    found: Parts,
    records: Records,
}

/// Chunks of the index: where they begin, and their lengths.
type Index = Vec<(u64, u64)>;

impl<R: Read + Seek> Search<'_, R> {
    fn drop(&mut self, offset: u64, damage: Damage) {
        self.found.dropped.push(Dropped { offset, damage });
    }

    /// All marks of the recording, by where they are; none if it has no marks.
    fn marks(&mut self) -> Result<Option<Vec<(u64, Mark)>>, ReadError> {
        // The random number is anywhere but in the first bytes.
        let any = Mark::beginning(0);
        let mut all = Vec::new();
        let mut at = 0;
        while let Some(place) = self.source.find(&any[..17], at)? {
            at = place + 1;
            let body = self.source.get(place + RECORD_HEAD as u64, mark::BYTES)?;
            if let Some(Some(Ok(mark))) = body.map(|body| Mark::parse(mark::OPCODE, body)) {
                all.push((place, mark));
            }
        }
        // Marks inside messages are not where they say that they were written.
        let in_place = |(place, mark): &&(u64, Mark)| *place == mark.offset;
        let mut ids: Vec<_> = all.iter().filter(in_place).map(|(_, mark)| mark.id).collect();
        if ids.is_empty() {
            ids = all.iter().map(|(_, mark)| mark.id).collect();
        }
        ids.sort_unstable();
        ids.dedup();
        match ids[..] {
            [] => Ok(None),
            [id] => {
                all.retain(|(_, mark)| mark.id == id);
                Ok(Some(all))
            }
            [one, other, ..] => {
                let damage = Damage::Stranger { found: other, expected: one };
                Err(ReadError::Damaged { offset: 0, damage })
            }
        }
    }

    /// The chunks behind marks.
    fn between_marks(&mut self, marks: &[(u64, Mark)]) -> Result<(), ReadError> {
        // Where each part's chunk would be; no mark where that is damaged.
        let mut numbered: BTreeMap<u64, (u64, Option<Mark>)> = BTreeMap::new();
        let mut newest = 0;
        // Those that are where they were written are right; others may be copies.
        let in_place = |(place, mark): &&(u64, Mark)| *place == mark.offset;
        let moved = |entry: &&(u64, Mark)| !in_place(entry);
        for (place, mark) in marks.iter().filter(in_place).chain(marks.iter().filter(moved)) {
            let (found, expected) = (mark.number, newest);
            let is_twice = numbered.contains_key(&found);
            if is_twice || found < expected {
                self.drop(*place, Damage::Order { found, expected });
            }
            if !is_twice {
                let offset = place + MARK_RECORD;
                numbered.insert(found, (offset, Some(*mark)));
                newest = newest.max(found + 1);
            }
        }
        self.behind_damaged_marks(&mut numbered)?;
        let mut expected = 0;
        let mut parts = numbered.into_iter().peekable();
        while let Some((found, (offset, mark))) = parts.next() {
            if found != expected {
                self.drop(offset - MARK_RECORD, Damage::Order { found, expected });
            }
            expected = found + 1;
            let next = parts.peek().and_then(|(_, (_, next))| *next);
            if let Some(mark) = mark {
                let first = self.found.marks.map_or(mark, |(first, _)| first);
                self.found.marks = Some((first, mark));
            }
            let damage = match self.source.get(offset, 1)? {
                None => continue,
                Some([op::CHUNK]) => match self.chunk(offset)? {
                    Ok(true) => None,
                    Ok(false) => Some(Damage::NoChecksum),
                    Err(damage) => Some(damage),
                },
                // A chunk whose very first byte is damaged shows by what comes next.
                Some(_) => match mark.zip(next) {
                    Some((mark, next)) if next.recorded > mark.recorded => {
                        Some(Damage::Broken { what: "a chunk" })
                    }
                    _ => continue,
                },
            };
            let end = next.map_or(u64::MAX, |next| next.sequence);
            let sequences = mark.map(|mark| (mark.sequence, end));
            let part = Part { offset, sequences, is_checked: damage.is_none() };
            self.found.parts.push(part);
            if let Some(damage) = damage {
                self.drop(offset, damage);
            }
        }
        Ok(())
    }

    /// Adds the chunks whose mark is damaged: those to which whole records lead from the part
    /// before.
    fn behind_damaged_marks(
        &mut self,
        numbered: &mut BTreeMap<u64, (u64, Option<Mark>)>,
    ) -> Result<(), ReadError> {
        let mut before: Vec<_> =
            numbered.iter().map(|(number, (offset, _))| (*number + 1, *offset)).collect();
        before.push((0, MAGIC.len() as u64));
        let mut known: BTreeSet<u64> = before.iter().map(|(_, offset)| *offset).collect();
        while let Some((number, mut at)) = before.pop() {
            if numbered.contains_key(&number) {
                continue;
            }
            while let Some((opcode, length)) = self.source.head(at)?
                && matches!(opcode, op::HEADER | op::METADATA | op::CHUNK | op::MESSAGE_INDEX)
            {
                at += RECORD_HEAD as u64 + length;
            }
            let offset = at + MARK_RECORD;
            if !known.contains(&offset)
                && let Some([op::CHUNK]) = self.source.get(offset, 1)?
                && let Ok(true) = self.chunk(offset)?
            {
                numbered.insert(number, (offset, None));
                known.insert(offset);
                before.push((number + 1, offset));
            }
        }
        Ok(())
    }

    /// Whether the chunk at `offset` is whole, and has a checksum.
    fn chunk(&mut self, offset: u64) -> Result<Result<bool, Damage>, ReadError> {
        let Some(body) = self.source.body(offset, MOST_RECORD_BYTES)? else {
            return Ok(Err(Damage::BeyondEnd));
        };
        let chunk = match Chunk::parse(body) {
            Ok(chunk) => chunk,
            Err(damage) => return Ok(Err(damage)),
        };
        Ok(self.records.fill(&chunk, 0).map(|()| chunk.has_checksum()))
    }

    /// The chunks that the index names, if a checksum vouches for it.
    fn index(&mut self) -> Result<Index, ReadError> {
        const FOOTER: u64 = 20;
        let end = (FOOTER as usize + RECORD_HEAD + MAGIC.len()) as u64;
        let mut index = Index::new();
        let Some(at) = self.source.length.checked_sub(end) else { return Ok(index) };
        let Some(footer) = self.source.get(at, end as usize)?.map(<[u8]>::to_vec) else {
            return Ok(index);
        };
        let mut fields = Fields(&footer);
        let head = (fields.u8(), fields.u64());
        let numbers = (fields.u64(), fields.u64(), fields.u32());
        let (Some(begin), Some(_), Some(saved)) = numbers else { return Ok(index) };
        let is_footer = head == (Some(op::FOOTER), Some(FOOTER)) && fields.0 == MAGIC;
        if !is_footer || begin == 0 || begin > at || at - begin > MOST_RECORD_BYTES as u64 {
            return Ok(index);
        }
        // It covers the index and the footer up to itself.
        let covered = (at - begin) as usize + RECORD_HEAD + 16;
        let Some(bytes) = self.source.get(begin, covered)? else { return Ok(index) };
        if saved == 0 || crc32fast::hash(bytes) != saved {
            return Ok(index);
        }
        let mut records = Fields(&bytes[..(at - begin) as usize]);
        while let Some((opcode, body)) = records.record() {
            let mut fields = Fields(body);
            match opcode {
                op::CHUNK_INDEX => {
                    let _times = fields.bytes(16);
                    index.extend(fields.u64().zip(fields.u64()));
                }
                op::SCHEMA | op::CHANNEL => {
                    self.found.definitions.push((opcode, body.to_vec()));
                }
                _ => {}
            }
        }
        index.sort_unstable();
        Ok(index)
    }

    /// The chunks of a file without marks: those of the index, or those that one record after the
    /// other leads to.
    fn along(&mut self, index: &Index, unverified: bool) -> Result<(), ReadError> {
        for (offset, length) in index {
            let is_there = self.source.head(*offset)?.is_some_and(|(opcode, bytes)| {
                opcode == op::CHUNK && bytes.checked_add(RECORD_HEAD as u64) == Some(*length)
            });
            let outcome = match is_there {
                true => self.chunk(*offset)?,
                false => Err(Damage::Broken { what: "a chunk" }),
            };
            self.judge(*offset, outcome);
        }
        if !index.is_empty() {
            return Ok(());
        }
        let mut at = MAGIC.len() as u64;
        while at < self.source.length {
            let Some((opcode, length)) = self.source.head(at)?.filter(|(opcode, _)| {
                (op::HEADER..=op::DATA_END).contains(opcode) || *opcode >= 0x80
            }) else {
                self.drop(at, Damage::Lost { bytes: self.source.length - at });
                return if unverified { self.search(at) } else { Ok(()) };
            };
            match opcode {
                op::CHUNK => {
                    let outcome = self.chunk(at)?;
                    self.judge(at, outcome);
                }
                op::MESSAGE => {
                    let part = Part { offset: at, sequences: None, is_checked: false };
                    self.found.parts.push(part);
                    self.drop(at, Damage::Unchecked { what: "a message outside of a chunk" });
                }
                op::SCHEMA | op::CHANNEL => {
                    let body = self.source.body(at, MOST_RECORD_BYTES)?.map(<[u8]>::to_vec);
                    self.found.definitions.extend(body.map(|body| (opcode, body)));
                }
                op::DATA_END => return Ok(()),
                _ => {}
            }
            at += RECORD_HEAD as u64 + length;
        }
        Ok(())
    }

    fn judge(&mut self, offset: u64, outcome: Result<bool, Damage>) {
        let is_checked = matches!(outcome, Ok(true));
        match outcome {
            Ok(true) => {}
            Ok(false) => self.drop(offset, Damage::Unchecked { what: "a chunk" }),
            Err(damage) => self.drop(offset, damage),
        }
        self.found.parts.push(Part { offset, sequences: None, is_checked });
    }

    /// Anything from `at` on that is a chunk with the right checksum. It may be inside a message.
    fn search(&mut self, mut at: u64) -> Result<(), ReadError> {
        // Bytes of what only looks like chunks: bounded, else time would not be.
        let mut patience = self.source.length.saturating_mul(2);
        while let Some(place) = self.source.find(&[op::CHUNK], at)? {
            at = place + 1;
            let Some((_, length)) =
                self.source.head(place)?.filter(|(_, bytes)| *bytes <= patience)
            else {
                continue;
            };
            let Some(begin) = self.source.get(place + RECORD_HEAD as u64, 32)? else { continue };
            let name = u32::from_le_bytes(begin[28..].try_into().expect("4 bytes"));
            if name > 4 {
                continue;
            }
            if let Ok(true) = self.chunk(place)? {
                let part = Part { offset: place, sequences: None, is_checked: false };
                self.found.parts.push(part);
                at = place + RECORD_HEAD as u64 + length;
            } else {
                patience -= length;
            }
        }
        Ok(())
    }
}
