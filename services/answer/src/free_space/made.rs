//! Channels made from solids.

use std::sync::Arc;

use planning::free_space::graph::Graph;
use planning::free_space::solids::Solids;
use planning::free_space::walls::Walls;
use planning::geometry::{AxisBox, Direction, HalfSpace, Vector};

use crate::answers::Resources;
use crate::cache::Kind;
use crate::entries::Entry;
use crate::refuse::Refused;

/// Solids, cut into boxes.
#[derive(Debug)]
pub(crate) struct Cut<'a, const D: usize> {
    pub(super) solids: &'a mut Solids<D>,
    /// Memory for channels.
    pub(super) made: &'a mut Vec<AxisBox<D>>,
    /// Their surfaces.
    pub(super) walls: Arc<Entry<Walls<D>>>,
    /// As the request gives them.
    pub(super) bounds: Option<AxisBox<D>>,
}

/// All channels of some size between solids.
#[derive(Debug, Clone)]
pub(crate) struct Made<const D: usize> {
    graph: Arc<Entry<Graph<D>>>,
    walls: Arc<Entry<Walls<D>>>,
    /// Within these bounds.
    pub(super) bounds: AxisBox<D>,
    /// Larger than this on every axis, metres.
    pub(super) room: Vector<D>,
}

impl<const D: usize> Made<D> {
    /// The channels, and which of them meet.
    pub(super) fn graph(&self) -> &Arc<Entry<Graph<D>>> {
        &self.graph
    }

    /// The surfaces of the solids.
    pub(super) fn walls(&self) -> &Arc<Entry<Walls<D>>> {
        &self.walls
    }

    pub(crate) fn bounds(&self) -> &AxisBox<D> {
        &self.bounds
    }
}

impl<const D: usize> Cut<'_, D> {
    /// Where to look for the channels of a cavity: within the bounds that the request gives, or
    /// those of its solids.
    pub(crate) fn cavity(&self, body: &AxisBox<D>, exit: Direction) -> Option<AxisBox<D>> {
        self.bounds.or_else(|| self.solids.cavity(body, exit))
    }

    /// The mouth of such a cavity, if the bounds are those of the solids.
    pub(super) fn mouth(&self, exit: Direction) -> Option<HalfSpace> {
        if self.bounds.is_some() { None } else { self.solids.mouth(exit) }
    }

    /// Makes channels: all maximal boxes within `bounds` that are larger than `room` (metres).
    pub(super) fn make(
        &mut self,
        bounds: AxisBox<D>,
        room: Vector<D>,
        resources: &mut Resources<'_>,
    ) -> Result<Made<D>, Refused> {
        let Self { solids, made, walls, .. } = self;
        let Resources { budget, cache, .. } = resources;
        let content = cache.describe(Kind::SolidsJunctions, D);
        content.boxes(&[bounds]);
        content.numbers(room.as_slice());
        content.boxes(solids.boxes());
        let graph = cache.get(budget, || {
            let mut graph = Graph::default();
            solids.channels(&bounds, &room, budget, made)?;
            graph.build(made, budget)?;
            Ok::<_, Refused>(graph)
        })?;
        Ok(Made { graph, walls: walls.clone(), bounds, room })
    }
}
