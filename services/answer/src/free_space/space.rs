//! Channels, which of them meet, and the walls around.

use std::sync::Arc;

use planning::free_space::Mouth;
use planning::free_space::graph::Graph;
use planning::free_space::walls::{Complement, Walls};
use planning::geometry::AxisBox;

use crate::answers::Resources;
use crate::cache::Kind;
use crate::entries::Entry;
use crate::refuse::Refused;

use super::made::Made;

/// Solids by their surfaces.
#[derive(Debug, Clone)]
pub(crate) struct Outlines<const D: usize> {
    pub(super) walls: Arc<Entry<Walls<D>>>,
    /// As the request gives them.
    pub(super) bounds: Option<AxisBox<D>>,
}

impl<const D: usize> Outlines<D> {
    pub(crate) fn walls(&self) -> &Walls<D> {
        &self.walls
    }

    /// Within what a body is to stay until it is out: the bounds that the request gives, or those
    /// of the solids.
    pub(crate) fn bounds(&self) -> Option<AxisBox<D>> {
        self.bounds.or_else(|| self.walls.bounds())
    }
}

/// Where a body can move. What took long to make belongs to the cache, and is held while the
/// request lasts.
#[derive(Debug, Clone)]
pub(crate) enum FreeSpace<'a, const D: usize> {
    /// The request's channels, in travel order.
    InOrder(&'a [AxisBox<D>], Around<D>),
    /// The request's channels in any order, and which of them meet.
    Unordered(Arc<Entry<Graph<D>>>, Around<D>),
    /// Channels made from the request's solids, and which of them meet.
    Made(Made<D>),
    /// Without channels: what the request's solids leave.
    Outlines(Outlines<D>),
}

/// What clearance is measured against where the request gives channels.
#[derive(Debug, Clone)]
pub(crate) enum Around<const D: usize> {
    /// The surfaces of the request's solids.
    Solids(Arc<Entry<Walls<D>>>),
    /// All that the channels leave, up to a mouth. It is found when it is asked for; the last
    /// is remembered.
    Complement(Option<(Option<Mouth<D>>, Arc<Entry<Walls<D>>>)>),
}

impl<const D: usize> FreeSpace<'_, D> {
    /// All channels.
    pub(crate) fn channels(&self) -> &[AxisBox<D>] {
        match self {
            Self::InOrder(channels, _) => channels,
            Self::Unordered(graph, _) => graph.channels(),
            Self::Made(made) => made.graph().channels(),
            Self::Outlines(_) => &[],
        }
    }

    /// Which channels meet, unless their order is given.
    pub(crate) fn graph(&self) -> Option<&Arc<Entry<Graph<D>>>> {
        match self {
            Self::InOrder(..) | Self::Outlines(_) => None,
            Self::Unordered(graph, _) => Some(graph),
            Self::Made(made) => Some(made.graph()),
        }
    }

    /// Whether the walls are solids, so that one of them may stand in a channel.
    pub(crate) fn has_solids(&self) -> bool {
        match self {
            Self::InOrder(_, around) | Self::Unordered(_, around) => {
                matches!(around, Around::Solids(_))
            }
            Self::Made(_) | Self::Outlines(_) => true,
        }
    }

    /// The walls, which end at the mouth (if there is one) unless they are solids.
    pub(crate) fn walls(
        &mut self,
        mouth: Option<Mouth<D>>,
        complement: &mut Complement<D>,
        resources: &mut Resources<'_>,
    ) -> Result<&Arc<Entry<Walls<D>>>, Refused> {
        let (channels, around) = match self {
            Self::InOrder(channels, around) => (*channels, around),
            Self::Unordered(graph, around) => (graph.channels(), around),
            Self::Made(made) => return Ok(made.walls()),
            Self::Outlines(outlines) => return Ok(&outlines.walls),
        };
        let last = match around {
            Around::Solids(walls) => return Ok(walls),
            Around::Complement(last) => last,
        };
        let known = last.take().filter(|(up_to, _)| *up_to == mouth);
        let known = match known {
            Some(known) => known,
            None => (mouth, complement_of(channels, mouth, complement, resources)?),
        };
        Ok(&last.insert(known).1)
    }

    /// The channels that were made from solids.
    pub(crate) fn made(&self) -> &[AxisBox<D>] {
        match self {
            Self::InOrder(..) | Self::Unordered(..) | Self::Outlines(_) => &[],
            Self::Made(made) => made.graph().channels(),
        }
    }
}

/// All that channels leave, up to a mouth.
pub(super) fn complement_of<const D: usize>(
    channels: &[AxisBox<D>],
    mouth: Option<Mouth<D>>,
    complement: &mut Complement<D>,
    resources: &mut Resources<'_>,
) -> Result<Arc<Entry<Walls<D>>>, Refused> {
    let Resources { budget, cache, .. } = resources;
    let content = cache.describe(Kind::ChannelsWalls, D);
    content.mouth(mouth);
    content.boxes(channels);
    cache.get(budget, || {
        let mut walls = Walls::default();
        walls.set_complement(channels, mouth, complement, budget)?;
        Ok(walls)
    })
}
