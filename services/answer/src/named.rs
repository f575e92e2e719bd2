//! Free spaces that a request names.

use std::sync::Arc;

use planning::budget::Budget;
use schemas::message::{Digest, ErrorCode, FreeSpace, Refusal};

use crate::refuse::Refused;
use crate::scene;
use crate::store::Store;

/// So many bytes are digested in the time of a step.
const DIGESTED_PER_STEP: u64 = 16;

/// The free space that a request names, if it does: one that is known, or the one that it brings,
/// which is known from now on.
pub(crate) fn open(
    free_space: &mut FreeSpace,
    store: &Store,
    budget: &Budget<'_>,
) -> Result<Option<Arc<FreeSpace>>, Refused> {
    let Some(name) = free_space.named else { return Ok(None) };
    let FreeSpace { channels, in_order, solids, bounds, named: _ } = &*free_space;
    let is_alone = channels.is_none() && solids.is_none() && bounds.is_none() && !in_order;
    if is_alone {
        let known = store.lock().uploads.find(name).ok_or_else(|| unknown(name))?;
        // As if it had been sent.
        let bytes = scene::free_space_bytes(&known);
        budget.step((bytes / size_of::<u64>()) as u64 / scene::CELLS_PER_STEP)?;
        budget.hold(bytes)?;
        return Ok(Some(known));
    }
    budget.step(scene::free_space_bytes(free_space) as u64 / DIGESTED_PER_STEP)?;
    let has = free_space.digest();
    if has != name {
        return Err(other_name(name, has).into());
    }
    let known = Arc::new(std::mem::take(free_space));
    let mut kept = store.lock();
    let before = kept.uploads.bytes();
    kept.uploads.insert(name, Arc::clone(&known));
    let now = kept.uploads.bytes();
    kept.entries.count_elsewhere(before, now);
    Ok(Some(known))
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
