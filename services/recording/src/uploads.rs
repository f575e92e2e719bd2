//! Named free spaces, which requests refer to by name.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use schemas::codec;
use schemas::message::{Digest, Request, RequestContent};

/// The most memory that they take, bytes: those of the largest planners. The oldest are dropped.
const MOST_BYTES: usize = 256 << 20;

/// The requests that made named free spaces known, so that each file of a recording can have those
/// that its requests refer to.
#[derive(Debug, Clone, Default)]
pub struct Uploads {
    known: BTreeMap<Digest, Upload>,
    bytes: usize,
    /// Counts uploads.
    count: u64,
}

#[derive(Debug, Clone)]
struct Upload {
    request: Arc<Request>,
    bytes: usize,
    number: u64,
}

impl Uploads {
    /// Keeps the request if it makes a free space known.
    pub fn note(&mut self, request: &Request) {
        let Some((name, true)) = name(request) else { return };
        let bytes = codec::encode(request).len();
        let upload = Upload { request: Arc::new(request.clone()), bytes, number: self.count };
        self.count += 1;
        self.bytes += bytes;
        self.bytes -= self.known.insert(name, upload).map_or(0, |before| before.bytes);
        while self.bytes > MOST_BYTES {
            let oldest = self.known.iter().min_by_key(|(_, upload)| upload.number);
            let Some(oldest) = oldest.map(|(name, _)| *name) else { return };
            self.bytes -= self.known.remove(&oldest).map_or(0, |before| before.bytes);
        }
    }

    /// The upload that a file lacks in which the free spaces `there` are, and in which this request
    /// comes next.
    pub(crate) fn missing(
        &self,
        request: &Request,
        there: &mut BTreeSet<Digest>,
    ) -> Option<Arc<Request>> {
        let (name, is_upload) = name(request)?;
        if !there.insert(name) || is_upload {
            return None;
        }
        self.known.get(&name).map(|upload| Arc::clone(&upload.request))
    }
}

/// The name of its free space, if it has one, and whether it carries that as well.
fn name(request: &Request) -> Option<(Digest, bool)> {
    let RequestContent::Scene(scene) = &request.content else { return None };
    let space = &scene.free_space;
    Some((space.named?, space.channels.is_some() || space.solids.is_some()))
}
