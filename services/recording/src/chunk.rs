//! The inside of a file: its records as fields, its chunks as messages.

use std::collections::BTreeMap;

use mcap::records::op;
use schemas::{codec, topic};

use crate::read::{Damage, Message, ReadError, Record};
use crate::{Summary, Topic};

/// Opcode and length before every record.
pub(crate) const RECORD_HEAD: usize = 1 + 8;

/// Takes fields off the front of a record. Lengths are checked against what is there
/// before anything is reserved for them.
pub(crate) struct Fields<'a>(pub(crate) &'a [u8]);

impl<'a> Fields<'a> {
    pub(crate) fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn u8(&mut self) -> Option<u8> {
        self.array().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn block(&mut self) -> Option<&'a [u8]> {
        let count = self.u32()?;
        self.bytes(count as usize)
    }

    pub(crate) fn text(&mut self) -> Option<&'a str> {
        std::str::from_utf8(self.block()?).ok()
    }

    /// Opcode and body of the next record.
    pub(crate) fn record(&mut self) -> Option<(u8, &'a [u8])> {
        let opcode = self.u8()?;
        let length = usize::try_from(self.u64()?).ok()?;
        Some((opcode, self.bytes(length)?))
    }
}

impl Summary {
    /// The summary in the body of a metadata record, if that is one.
    pub(crate) fn parse(body: &[u8]) -> Option<Self> {
        let mut fields = Fields(body);
        if fields.text()? != crate::SUMMARY_NAME {
            return None;
        }
        let mut pairs = Fields(fields.block()?);
        let mut summary = Self::default();
        while !pairs.0.is_empty() {
            let (name, value) = (pairs.text()?, pairs.text()?);
            let field = match name {
                "recorded" => &mut summary.recorded,
                "lost" => &mut summary.lost,
                "gaps" => &mut summary.gaps,
                _ => continue,
            };
            *field = value.parse().ok()?;
        }
        Some(summary)
    }
}

/// The records in the body of a chunk, once their checksum is verified, and where they
/// begin in it.
pub(crate) fn verify(body: &[u8]) -> Result<(usize, &[u8]), Damage> {
    let mut fields = Fields(body);
    let broken = || Damage::Broken { what: "a chunk's header" };
    let _times = fields.bytes(16).ok_or_else(broken)?;
    let uncompressed = fields.u64().ok_or_else(broken)?;
    let saved = fields.u32().ok_or_else(broken)?;
    let compression = fields.text().ok_or_else(broken)?;
    let compressed = fields.u64().ok_or_else(broken)?;
    if !compression.is_empty() {
        return Err(Damage::Compressed { method: compression.to_owned() });
    }
    let given = fields.0.len() as u64;
    if compressed != given || uncompressed != given {
        return Err(Damage::ChunkLength { claimed: compressed, given });
    }
    // MCAP lets 0 stand for "none": nothing would vouch for the messages.
    let calculated = crc32fast::hash(fields.0);
    if saved != calculated {
        return Err(Damage::Checksum { of: "a chunk", saved, calculated });
    }
    Ok((body.len() - fields.0.len(), fields.0))
}

/// What the channels of a file hold.
#[derive(Default)]
pub(crate) struct Channels {
    schemas: BTreeMap<u16, Schema>,
    /// `None`: not one of ours.
    topics: BTreeMap<u16, Option<Topic>>,
}

#[derive(PartialEq)]
struct Schema {
    name: String,
    encoding: String,
    data: Vec<u8>,
}

/// The records of a verified chunk, one after the other.
#[derive(Default)]
pub(crate) struct Records {
    /// All of them.
    pub(crate) bytes: Vec<u8>,
    /// Where the next begins.
    at: usize,
    /// Where in the file `bytes` begin.
    offset: u64,
}

/// One step through the records of a chunk.
pub(crate) enum Step {
    /// A message.
    Record(Box<Record>),
    /// A message of a channel that is not ours.
    Skipped,
    /// A channel or a schema, or nothing of interest.
    Other,
}

impl Records {
    /// Goes on with another chunk's.
    pub(crate) fn fill(&mut self, records: &[u8], offset: u64) {
        self.bytes.clear();
        self.bytes.extend_from_slice(records);
        (self.at, self.offset) = (0, offset);
    }

    /// The next record. Records can be read on after an error, too.
    pub(crate) fn next(&mut self, channels: &mut Channels) -> Option<Result<Step, ReadError>> {
        let mut fields = Fields(&self.bytes[self.at..]);
        if fields.0.is_empty() {
            return None;
        }
        let offset = self.offset + self.at as u64;
        let Some((opcode, body)) = fields.record() else {
            self.at = self.bytes.len();
            let damage = Damage::Broken { what: "the last record of a chunk" };
            return Some(Err(ReadError::Damaged { offset, damage }));
        };
        self.at = self.bytes.len() - fields.0.len();
        let broken = |what| ReadError::Damaged { offset, damage: Damage::Broken { what } };
        Some(match opcode {
            op::SCHEMA => channels
                .add_schema(Fields(body))
                .unwrap_or(Err(Damage::Broken { what: "a schema" }))
                .map(|()| Step::Other)
                .map_err(|damage| ReadError::Damaged { offset, damage }),
            op::CHANNEL => channels
                .add_channel(Fields(body), offset)
                .unwrap_or_else(|| Err(broken("a channel")))
                .map(|()| Step::Other),
            op::MESSAGE => {
                channels.message(Fields(body), offset).unwrap_or_else(|| Err(broken("a message")))
            }
            _ => Ok(Step::Other),
        })
    }
}

impl Channels {
    fn add_schema(&mut self, mut fields: Fields) -> Option<Result<(), Damage>> {
        let id = fields.u16()?;
        let schema = Schema {
            name: fields.text()?.to_owned(),
            encoding: fields.text()?.to_owned(),
            data: fields.block()?.to_owned(),
        };
        let known = self.schemas.entry(id).or_insert_with(|| Schema {
            name: schema.name.clone(),
            encoding: schema.encoding.clone(),
            data: schema.data.clone(),
        });
        Some(if *known == schema { Ok(()) } else { Err(Damage::Redefined { what: "schema", id }) })
    }

    fn add_channel(&mut self, mut fields: Fields, offset: u64) -> Option<Result<(), ReadError>> {
        let (id, schema) = (fields.u16()?, fields.u16()?);
        let (name, encoding) = (fields.text()?, fields.text()?);
        let topic = Topic::ALL.into_iter().find(|topic| topic.name() == name);
        if let Some(topic) = topic
            && let Err(error) = self.check_layout(topic, schema, encoding, offset)
        {
            return Some(Err(error));
        }
        let known = *self.topics.entry(id).or_insert(topic);
        Some(if known == topic {
            Ok(())
        } else {
            let damage = Damage::Redefined { what: "channel", id };
            Err(ReadError::Damaged { offset, damage })
        })
    }

    /// Checks that a channel of ours holds what this crate writes.
    fn check_layout(
        &self,
        topic: Topic,
        schema: u16,
        encoding: &str,
        offset: u64,
    ) -> Result<(), ReadError> {
        let check = |what, found: &str, expected: &str| {
            if found == expected {
                return Ok(());
            }
            let (found, expected) = (brief(found), brief(expected));
            Err(ReadError::Layout { offset, topic: topic.name(), what, found, expected })
        };
        check("message encoding", encoding, topic::ENCODING)?;
        let Some(schema) = self.schemas.get(&schema) else {
            return check("schema", "none", topic.schema_name());
        };
        check("schema name", &schema.name, topic.schema_name())?;
        check("schema encoding", &schema.encoding, topic::ENCODING)?;
        check("schema", &String::from_utf8_lossy(&schema.data), topic.schema())
    }

    fn message(&self, mut fields: Fields, offset: u64) -> Option<Result<Step, ReadError>> {
        let (channel, sequence) = (fields.u16()?, fields.u32()?);
        let (log_ns, publish_ns) = (fields.u64()?, fields.u64()?);
        let topic = match self.topics.get(&channel) {
            Some(Some(topic)) => *topic,
            Some(None) => return Some(Ok(Step::Skipped)),
            None => {
                let damage = Damage::UnknownChannel { channel };
                return Some(Err(ReadError::Damaged { offset, damage }));
            }
        };
        let message = match topic {
            Topic::Request => codec::decode(fields.0).map(Message::Request),
            Topic::Reply => codec::decode(fields.0).map(Message::Reply),
        };
        Some(match message {
            Ok(message) => {
                Ok(Step::Record(Box::new(Record { message, log_ns, publish_ns, sequence })))
            }
            Err(source) => {
                let topic = topic.name();
                Err(ReadError::Message { offset, topic, sequence, source })
            }
        })
    }
}

/// The beginning of a text, for messages to people.
fn brief(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    let end = line.floor_char_boundary(80);
    if end < text.trim_end().len() { format!("{}...", &line[..end]) } else { line.to_owned() }
}

/// Finds messages missing by their sequence numbers.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Gaps {
    next: u32,
    pub(crate) lost: u64,
    pub(crate) gaps: u64,
}

impl Gaps {
    /// How many messages are missing before the one with this number. Numbers wrap
    /// around; one that goes back begins a new count and says nothing of losses.
    pub(crate) fn before(&mut self, sequence: u32) -> u64 {
        let ahead = sequence.wrapping_sub(self.next);
        self.next = sequence.wrapping_add(1);
        let lost = if ahead <= u32::MAX / 2 { u64::from(ahead) } else { 0 };
        self.lost += lost;
        self.gaps += u64::from(lost > 0);
        lost
    }
}
