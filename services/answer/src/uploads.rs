//! Free spaces that were sent with a name, so that later requests need only the name.

use foldhash::fast::FixedState;
use hashlink::LinkedHashMap;
use planning::budget::Budget;
use schemas::message::{Digest, ErrorCode, FreeSpace, Refusal};

use crate::refuse::Refused;
use crate::scene;

/// So many bytes are digested in the time of a step.
const DIGESTED_PER_STEP: u64 = 16;

/// The free spaces used last, bounded in bytes.
///
/// A request that gives a name alone is answered as if it carried the free space itself, byte for
/// byte, unless the name is not known.
#[derive(Debug)]
pub(crate) struct Uploads {
    most_bytes: usize,
    bytes: usize,
    /// From the least to the most recently used.
    known: LinkedHashMap<Digest, FreeSpace, FixedState>,
    /// The one that the request at hand uses.
    lent: Option<Digest>,
}

impl Uploads {
    pub(crate) fn new(most_bytes: usize) -> Self {
        let known = LinkedHashMap::with_hasher(FixedState::default());
        Self { most_bytes, bytes: 0, known, lent: None }
    }

    /// The memory that they take, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }

    /// Looks up a name given alone, and checks one given with its free space.
    pub(crate) fn open(
        &mut self,
        free_space: &mut FreeSpace,
        budget: &Budget<'_>,
    ) -> Result<(), Refused> {
        let Some(name) = free_space.named else { return Ok(()) };
        let FreeSpace { channels, in_order, solids, bounds, named: _ } = &*free_space;
        let is_alone = channels.is_none() && solids.is_none() && bounds.is_none() && !in_order;
        if is_alone {
            let known = self.known.remove(&name).ok_or_else(|| unknown(name))?;
            *free_space = known;
            let bytes = scene::free_space_bytes(free_space);
            self.bytes -= bytes;
            self.lent = Some(name);
            // As if it had been sent.
            budget.step((bytes / size_of::<u64>()) as u64 / scene::CELLS_PER_STEP)?;
            return Ok(budget.hold(bytes)?);
        }
        budget.step(scene::free_space_bytes(free_space) as u64 / DIGESTED_PER_STEP)?;
        let has = free_space.digest();
        if has != name {
            return Err(other_name(name, has).into());
        }
        self.lent = Some(name);
        Ok(())
    }

    /// Takes back what the request used, and drops the least recently used ones until the bound
    /// holds.
    pub(crate) fn close(&mut self, free_space: &mut FreeSpace) {
        let Some(name) = self.lent.take() else { return };
        let free_space = std::mem::take(free_space);
        let bytes = scene::free_space_bytes(&free_space);
        if bytes <= self.most_bytes {
            if let Some(before) = self.known.insert(name, free_space) {
                self.bytes -= scene::free_space_bytes(&before);
            }
            self.bytes += bytes;
        }
        while self.bytes > self.most_bytes {
            let Some((_, oldest)) = self.known.pop_front() else { break };
            self.bytes -= scene::free_space_bytes(&oldest);
        }
    }
}

fn unknown(name: Digest) -> Refusal {
    let field = "free_space.named";
    let message = format!(
        "{field}: no free space is known as {name}; send it once, with its name beside its content"
    );
    let refusal = Refusal::new(ErrorCode::UnknownFreeSpace, message);
    Refusal { field: Some(field.to_owned()), ..refusal }
}

fn other_name(name: Digest, has: Digest) -> Refusal {
    let field = "free_space.named";
    let message = format!("{field} is {name}, but the free space beside it is {has}");
    Refusal::invalid(field, message)
}
