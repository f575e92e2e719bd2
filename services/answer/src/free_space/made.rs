//! Channels made from solids.

use std::sync::Arc;

use planning::free_space::graph::Graph;
use planning::free_space::mouth_of;
use planning::free_space::solids::{Solids, UnionInCavity};
use planning::free_space::walls::Walls;
use planning::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector};
use planning::translation::{Demand, NoWay};

use crate::answers::Resources;
use crate::cache::Kind;
use crate::entries::Entry;
use crate::refuse::{self, Axes, Refused};

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

    /// The mouth of such a cavity, if the bounds are those of the solids; for a union of boxes in any
    /// case, as its channels go on beyond it.
    pub(super) fn mouth(&self, exit: Direction, is_union: bool) -> Option<HalfSpace> {
        match &self.bounds {
            Some(bounds) => is_union.then(|| mouth_of(bounds, exit)),
            None => self.solids.mouth(exit),
        }
    }

    /// Makes channels for the bounds of a union of boxes. Refuses it where it overlaps a solid, or
    /// reaches out of the bounds.
    pub(crate) fn make_for_union(
        &mut self,
        (boxes, around): (&[AxisBox<D>], AxisBox<D>),
        exit: Direction,
        axes: &Axes,
        resources: &mut Resources<'_>,
    ) -> Result<Made<D>, Refused> {
        let Self { solids, made, walls, bounds } = self;
        let Resources { budget, cache, .. } = resources;
        let no_way = |why: NoWay<D>| refuse::no_way(axes, String::new(), Demand::Part(1.0), why);
        let Some(bounds) = bounds.or_else(|| solids.bounds()) else {
            return Err(no_way(NoWay::Closed(None)));
        };
        let body = UnionInCavity { boxes, around, bounds, exit };
        if let Some((solid, axis, depth)) = solids.deepest_of(boxes, budget)? {
            let mut out = Vector::zeros();
            out[axis] = depth;
            return Err(no_way(NoWay::Overlap { solid, out: Some(out) }));
        }
        if let Some((axis, side, end)) = body.outside() {
            return Err(no_way(NoWay::OutOfBounds { axis, side, end }));
        }
        let Some(bounds) = body.room() else { return Err(no_way(NoWay::Closed(None))) };
        let content = cache.describe(Kind::UnionJunctions, D);
        content.word((exit.axis as u64) << 1 | u64::from(exit.sign == Sign::Positive));
        content.boxes(&[body.bounds]);
        content.word(boxes.len() as u64);
        content.boxes(boxes);
        content.boxes(solids.boxes());
        let graph = cache.get(budget, || {
            let mut graph = Graph::default();
            solids.channels_for_union(&body, budget, made)?;
            graph.build(made, budget)?;
            Ok::<_, Refused>(graph)
        })?;
        Ok(Made { graph, walls: walls.clone(), bounds, room: Vector::zeros() })
    }

    /// Makes channels: all maximal boxes within `bounds` that are larger than `room` (metres).
    pub(crate) fn make(
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
