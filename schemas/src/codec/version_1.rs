//! Version 1 of recorded messages, readable for ever.
//!
//! What version 2 changed is frozen here: a refusal has no setting. Everything else is
//! shared with the current messages; whoever changes one of those copies its present form
//! into this file. `schemas/tests/pinned/version_1` and the recordings in `recordings/`
//! hold the bytes.

use serde::Deserialize;

use super::{DecodeError, decode};
use crate::message::{self, ErrorCode, Request, RequestContent, RequestKey, Trajectory};

/// See [`message::ReplyPart`].
#[derive(Deserialize)]
struct ReplyPart {
    key: RequestKey,
    id: Option<u64>,
    sent_ns: u64,
    part: u32,
    last: bool,
    answer: u32,
    answers: u32,
    content: Result<Trajectory, Refusal>,
}

/// See [`message::Refusal`].
#[derive(Deserialize)]
struct Refusal {
    code: ErrorCode,
    #[serde(deserialize_with = "message::text")]
    message: String,
    #[serde(deserialize_with = "message::optional_text")]
    field: Option<String>,
    junction: Option<u64>,
    axis: Option<u32>,
    needs: Option<f64>,
    has: Option<f64>,
    least: Option<f64>,
    most: Option<f64>,
    heading: Option<f64>,
}

/// Requests have the same bytes in version 2. Only the header kept with an unreadable one
/// carries the version of shared memory, which a planner would now refuse.
pub(super) fn request(bytes: &[u8]) -> Result<Request, DecodeError> {
    let mut request: Request = decode(bytes)?;
    if let RequestContent::Unreadable { header, .. } = &mut request.content
        && let Some(word) = header.first_mut()
    {
        let version = match *word as u32 {
            1 => 2,
            // Was refused, and still is to be.
            2 => 1,
            other => other,
        };
        *word = *word >> 32 << 32 | u64::from(version);
    }
    Ok(request)
}

pub(super) fn reply(bytes: &[u8]) -> Result<message::ReplyPart, DecodeError> {
    let ReplyPart { key, id, sent_ns, part, last, answer, answers, content } = decode(bytes)?;
    let content = content.map_err(Refusal::upgrade);
    Ok(message::ReplyPart { key, id, sent_ns, part, last, answer, answers, content })
}

impl Refusal {
    fn upgrade(self) -> message::Refusal {
        let Self { code, message, field, junction, axis, needs, has, least, most, heading } = self;
        let setting = None;
        message::Refusal {
            code,
            message,
            field,
            junction,
            axis,
            needs,
            has,
            least,
            most,
            heading,
            setting,
        }
    }
}
