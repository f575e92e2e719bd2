//! What the channels of a file are, and its records as messages.

use std::collections::BTreeMap;
use std::sync::Arc;

use mcap::records::op;
use schemas::{codec, topic};

use crate::error::{Damage, ReadError};
use crate::fields::Fields;
use crate::format::{Topic, VERSION_KEY};
use crate::record::{Aside, Foreign, Message, Record};

/// What the channels of a file hold.
#[derive(Default)]
pub(crate) struct Channels {
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, Channel>,
    /// Whether messages of others are kept.
    pub(crate) keeps_foreign: bool,
}

struct Channel {
    topic: String,
    /// Which of ours, and the version of its messages.
    ours: Option<(Topic, u32)>,
    is_status: bool,
    /// The version of the requests that made free spaces known, if it has those.
    uploads: Option<u32>,
    /// If it is none of ours.
    foreign: Option<Arc<Foreign>>,
    messages: u64,
}

/// What a record means.
pub(crate) enum Step {
    /// A message.
    Record(Box<Record>),
    /// What is not numbered.
    Aside(Aside),
    /// A message of a channel that is not ours.
    Skipped,
    /// A channel or a schema, or nothing of interest.
    Other,
}

#[derive(PartialEq)]
struct Schema {
    name: String,
    encoding: String,
    data: Vec<u8>,
}

impl Channels {
    /// Takes in a record that begins at byte `offset`.
    pub(crate) fn take(&mut self, opcode: u8, body: &[u8], offset: u64) -> Result<Step, ReadError> {
        let damaged = |damage| ReadError::Damaged { offset, damage };
        let broken = |what| damaged(Damage::Broken { what });
        match opcode {
            op::SCHEMA => match self.add_schema(Fields(body)) {
                None => Err(broken("a schema")),
                Some(Err(damage)) => Err(damaged(damage)),
                Some(Ok(())) => Ok(Step::Other),
            },
            op::CHANNEL => self
                .add_channel(Fields(body), offset)
                .unwrap_or_else(|| Err(broken("a channel")))
                .map(|()| Step::Other),
            op::MESSAGE => {
                self.message(Fields(body), offset).unwrap_or_else(|| Err(broken("a message")))
            }
            _ => Ok(Step::Other),
        }
    }

    /// Whether a channel is one of ours.
    pub(crate) fn has_ours(&self) -> bool {
        self.channels.values().any(|channel| channel.ours.is_some() || channel.is_status)
    }

    /// Channels of others and their messages so far.
    pub(crate) fn others(&self) -> impl Iterator<Item = (&str, u64)> {
        let others = self.channels.values().filter(|channel| channel.foreign.is_some());
        others.map(|channel| (&*channel.topic, channel.messages))
    }

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
        let metadata = fields.map()?;
        let version = metadata.get(VERSION_KEY).map(String::as_str);
        let ours = match Topic::ALL.into_iter().find(|topic| topic.name() == name) {
            None => None,
            Some(topic) => match self.identify(topic, schema, encoding, version, offset) {
                Ok(version) => Some((topic, version)),
                Err(error) => return Some(Err(error)),
            },
        };
        let is_status = name == topic::STATUS && encoding == "json";
        let uploads = match name {
            topic::FREE_SPACE => {
                match self.identify(Topic::Request, schema, encoding, version, offset) {
                    Ok(version) => Some(version),
                    Err(error) => return Some(Err(error)),
                }
            }
            _ => None,
        };
        let is_foreign = ours.is_none() && !is_status && uploads.is_none();
        let foreign = is_foreign.then(|| {
            let of = |schema: &Schema| {
                (schema.name.clone(), schema.encoding.clone(), schema.data.clone())
            };
            let (topic, encoding) = (name.to_owned(), encoding.to_owned());
            let schema = self.schemas.get(&schema).map(of);
            Arc::new(Foreign { topic, encoding, metadata: metadata.clone(), schema })
        });
        let topic = name.to_owned();
        let new = || Channel { topic, ours, is_status, uploads, foreign, messages: 0 };
        let known = self.channels.entry(id).or_insert_with(new);
        Some(if (known.ours, &*known.topic) == (ours, name) {
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

    fn message(&mut self, mut fields: Fields, offset: u64) -> Option<Result<Step, ReadError>> {
        let (channel, sequence) = (fields.u16()?, fields.u32()?);
        let (log_ns, publish_ns) = (fields.u64()?, fields.u64()?);
        let Some(channel) = self.channels.get_mut(&channel) else {
            let damage = Damage::UnknownChannel { channel };
            return Some(Err(ReadError::Damaged { offset, damage }));
        };
        channel.messages += 1;
        if let Some(version) = channel.uploads {
            return Some(match codec::decode_request(version, fields.0) {
                Ok(request) => {
                    let request = Box::new(request);
                    Ok(Step::Aside(Aside::FreeSpace { request, log_ns }))
                }
                Err(source) => {
                    let topic = topic::FREE_SPACE;
                    Err(ReadError::Message { offset, topic, sequence, source })
                }
            });
        }
        let Some((topic, version)) = channel.ours else {
            let json = std::str::from_utf8(fields.0).ok().filter(|_| channel.is_status);
            return Some(Ok(match (json, &channel.foreign) {
                (Some(json), _) => Step::Aside(Aside::Status { json: json.to_owned(), log_ns }),
                (None, Some(channel)) if self.keeps_foreign => {
                    let (channel, message) = (Arc::clone(channel), fields.0.to_owned());
                    Step::Aside(Aside::Foreign { channel, message, sequence, log_ns, publish_ns })
                }
                (None, _) => Step::Skipped,
            }));
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
