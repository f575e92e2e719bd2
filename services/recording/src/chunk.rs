//! The inside of a chunk: its records as messages.

use std::collections::BTreeMap;

use mcap::records::op;
use schemas::{codec, topic};

use crate::error::{Damage, ReadError};
use crate::fields::Fields;
use crate::format::{Topic, VERSION_KEY};
use crate::record::{Message, Record};

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
    // In MCAP 0 means "none"; nothing would vouch for the messages.
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
    topics: BTreeMap<u16, Option<(Topic, u32)>>,
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
        let version = fields.value_of(VERSION_KEY)?;
        let topic = match Topic::ALL.into_iter().find(|topic| topic.name() == name) {
            None => None,
            Some(topic) => match self.identify(topic, schema, encoding, version, offset) {
                Ok(version) => Some((topic, version)),
                Err(error) => return Some(Err(error)),
            },
        };
        let known = *self.topics.entry(id).or_insert(topic);
        Some(if known == topic {
            Ok(())
        } else {
            let damage = Damage::Redefined { what: "channel", id };
            Err(ReadError::Damaged { offset, damage })
        })
    }

    /// The version of the messages of a channel of ours: what it says there, and 1 where it
    /// says nothing. The schema's text is for people and not looked at.
    fn identify(
        &self,
        topic: Topic,
        schema: u16,
        encoding: &str,
        version: Option<&str>,
        offset: u64,
    ) -> Result<u32, ReadError> {
        let check = |what, found: &str, expected: &str| {
            if found == expected {
                return Ok(());
            }
            let (found, expected) = (brief(found), expected.to_owned());
            Err(ReadError::Channel { offset, topic: topic.name(), what, found, expected })
        };
        check("message encoding", encoding, topic::ENCODING)?;
        let Some(schema) = self.schemas.get(&schema) else {
            check("schema", "none", topic.schema_name())?;
            return Ok(1);
        };
        check("schema name", &schema.name, topic.schema_name())?;
        check("schema encoding", &schema.encoding, topic::ENCODING)?;
        let text = version.unwrap_or("1");
        match text.parse() {
            Ok(version) if (1..=codec::VERSION).contains(&version) => Ok(version),
            Ok(found) => {
                let (topic, schema, newest) = (topic.name(), topic.schema_name(), codec::VERSION);
                Err(ReadError::Version { offset, topic, schema, found, newest })
            }
            Err(_) => check(VERSION_KEY, text, "a number").map(|()| 1),
        }
    }

    fn message(&self, mut fields: Fields, offset: u64) -> Option<Result<Step, ReadError>> {
        let (channel, sequence) = (fields.u16()?, fields.u32()?);
        let (log_ns, publish_ns) = (fields.u64()?, fields.u64()?);
        let (topic, version) = match self.topics.get(&channel) {
            Some(Some(topic)) => *topic,
            Some(None) => return Some(Ok(Step::Skipped)),
            None => {
                let damage = Damage::UnknownChannel { channel };
                return Some(Err(ReadError::Damaged { offset, damage }));
            }
        };
        let message = match topic {
            Topic::Request => codec::decode_request(version, fields.0).map(Message::Request),
            Topic::Reply => codec::decode_reply(version, fields.0).map(Message::Reply),
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
