//! Whole requests: a scene, and who asks.

use super::{Malformed, read_scene};
use crate::message::{ErrorCode, Refusal, Request, RequestContent, RequestKey, SceneRequest};
use crate::wire::{RequestHeader, VERSION};

/// A request as a message; memory that can't be read as a scene is kept as it came.
pub fn read_request(header: &RequestHeader, cells: &[u64]) -> Request {
    let mut scene = SceneRequest::empty();
    let readable = header.version == VERSION && read_scene(header, cells, &mut scene).is_ok();
    Request {
        key: RequestKey { client: header.client, sequence: header.sequence },
        sent_ns: header.sent_ns,
        content: match readable {
            true => RequestContent::Scene(scene),
            false => RequestContent::Unreadable {
                header: bytemuck::cast_slice(bytemuck::bytes_of(header)).to_vec(),
                cells: cells.to_vec(),
            },
        },
    }
}

/// Refuses a request of another version.
pub fn check_version(header: &RequestHeader) -> Result<(), Refusal> {
    if header.version == VERSION {
        return Ok(());
    }
    let (has, needs) = (f64::from(header.version), f64::from(VERSION));
    let message = format!("the request has message version {has}, this planner needs {needs}");
    let refusal = Refusal::new(ErrorCode::UnsupportedVersion, message);
    Err(Refusal { needs: Some(needs), has: Some(has), ..refusal })
}

/// The refusal for memory that can't be read as a scene.
pub fn unreadable(malformed: &Malformed) -> Refusal {
    Refusal::invalid("request", format!("the request can't be read: {malformed}"))
}

/// The header that [`RequestContent::Unreadable`] keeps; zero where words are missing.
pub fn header_of(words: &[u64]) -> RequestHeader {
    let mut header = RequestHeader::default();
    let target: &mut [u64] = bytemuck::cast_slice_mut(bytemuck::bytes_of_mut(&mut header));
    let length = words.len().min(target.len());
    target[..length].copy_from_slice(&words[..length]);
    header
}
