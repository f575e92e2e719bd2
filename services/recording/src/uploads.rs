//! Named free spaces, which requests refer to by name.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use schemas::codec;
use schemas::message::{Digest, FreeSpace, Request, RequestContent};

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

/// What a file lacks for a request.
pub(crate) enum Lack {
    Nothing,
    /// A free space that is known.
    Upload(Arc<Request>),
    /// A free space of which only the name is known.
    Unknown(Digest),
}

#[derive(Debug, Clone)]
struct Upload {
    request: Arc<Request>,
    bytes: usize,
    number: u64,
}

impl Uploads {
    /// Keeps the request if it makes a free space known, and says whether it does.
    pub fn note(&mut self, request: &Request) -> bool {
        let Some(space) = named(request).filter(|space| !space.is_name_only()) else {
            return false;
        };
        // A wrong name is refused.
        let Some(name) = space.named.filter(|name| *name == space.digest()) else { return false };
        let bytes = codec::encode(request).len();
        let upload = Upload { request: Arc::new(request.clone()), bytes, number: self.count };
        self.count += 1;
        self.bytes += bytes;
        self.bytes -= self.known.insert(name, upload).map_or(0, |before| before.bytes);
        while self.bytes > MOST_BYTES {
            let oldest = self.known.iter().min_by_key(|(_, upload)| upload.number);
            let Some(oldest) = oldest.map(|(name, _)| *name) else { break };
            self.bytes -= self.known.remove(&oldest).map_or(0, |before| before.bytes);
        }
        true
    }

    /// Notes this request, and says what the file lacks for it in which it comes next and in which
    /// the free spaces `there` are.
    pub(crate) fn lack(&mut self, request: &Request, there: &mut BTreeSet<Digest>) -> Lack {
        let Some(space) = named(request) else { return Lack::Nothing };
        let name = space.named.expect("it has a name");
        if self.note(request) {
            there.insert(name);
        }
        if !space.is_name_only() || there.contains(&name) {
            return Lack::Nothing;
        }
        match self.known.get(&name) {
            Some(upload) => {
                there.insert(name);
                Lack::Upload(Arc::clone(&upload.request))
            }
            None => Lack::Unknown(name),
        }
    }
}

/// Its free space, if that has a name.
fn named(request: &Request) -> Option<&FreeSpace> {
    match &request.content {
        RequestContent::Scene(scene) => Some(&scene.free_space).filter(|it| it.named.is_some()),
        RequestContent::Unreadable { .. } => None,
    }
}
