//! Reading a scene within a request's budget.

use std::ops::Deref;

use planning::budget::Budget;
use schemas::convert;
use schemas::message::{Body, Choice, ClearanceWish, FreeSpace, SceneRequest, Solid};
use schemas::wire::RequestHeader;

use crate::refuse::Refused;

/// A request whose free space is at hand, its own or the one that it names.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) request: &'a SceneRequest,
    /// In place of the request's.
    pub(crate) free_space: &'a FreeSpace,
}

impl Deref for Scene<'_> {
    type Target = SceneRequest;

    fn deref(&self) -> &SceneRequest {
        self.request
    }
}

/// So many cells are read and checked in the time of a step.
pub(crate) const CELLS_PER_STEP: u64 = 4;

/// The most that a cell takes once it is read, bytes: solids with hardly a vertex, in lists that
/// grow.
const BYTES_PER_CELL: usize = 80;

/// Reads a scene in place of the one before.
pub(crate) fn read(
    header: &RequestHeader,
    cells: &[u64],
    scene: &mut SceneRequest,
    budget: &Budget<'_>,
) -> Result<(), Refused> {
    budget.step(cells.len() as u64 / CELLS_PER_STEP)?;
    let most = cells.len().saturating_mul(BYTES_PER_CELL);
    budget.hold(most)?;
    convert::read_scene(header, cells, scene)
        .map_err(|malformed| convert::unreadable(&malformed))?;
    budget.release(most);
    Ok(budget.hold(bytes(scene) + size_of_val(cells))?)
}

/// The memory that a scene holds, bytes.
pub(crate) fn bytes(scene: &SceneRequest) -> usize {
    let SceneRequest { free_space, body, exit, clearance, .. } = scene;
    let body = match body {
        Body::Polygon(vertices) => of(vertices),
        Body::Boxes(boxes) => of(boxes),
        Body::Box(_) | Body::Footprint(_) => 0,
    };
    let clearance = match clearance {
        ClearanceWish::Gaps(gaps) => of(gaps),
        ClearanceWish::Each(choices) => of(choices) + choices.iter().map(of_choice).sum::<usize>(),
        ClearanceWish::Gap(_)
        | ClearanceWish::Safest
        | ClearanceWish::Curve(_)
        | ClearanceWish::AtLeast(_) => 0,
    };
    of(exit) + body + clearance + free_space_bytes(free_space)
}

/// The memory that a free space holds, bytes.
pub(crate) fn free_space_bytes(free_space: &FreeSpace) -> usize {
    let channels = free_space.channels.as_ref().map_or(0, of);
    let solids = free_space.solids.as_ref();
    let outlines = |solids: &Vec<Solid>| solids.iter().map(of_solid).sum::<usize>();
    channels + solids.map_or(0, |solids| of(solids) + outlines(solids))
}

fn of<T>(list: &Vec<T>) -> usize {
    list.capacity() * size_of::<T>()
}

fn of_choice(choice: &Choice) -> usize {
    match choice {
        Choice::Gaps(gaps) => of(gaps),
        Choice::Gap(_) | Choice::Safest | Choice::AtLeast(_) => 0,
    }
}

fn of_solid(solid: &Solid) -> usize {
    match solid {
        Solid::Polygon(vertices) => of(vertices),
        Solid::Boxes(boxes) => of(boxes),
        Solid::Box(_) => 0,
    }
}
