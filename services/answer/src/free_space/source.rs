//! What a request says of its free space.

use std::sync::Arc;

use planning::budget::Budget;
use planning::free_space::graph::Graph;
use planning::free_space::solids::Solids;
use planning::free_space::walls::{Complement, Wall, Walls};
use planning::geometry::{AxisBox, Direction, HalfSpace, Vector};
use schemas::message::{self, Refusal, Solid};

use super::made::{Cut, Made};
use super::space::{Around, FreeSpace, Outlines, complement_of};
use super::take::{Pieces, Surfaces, TakeSolids, take_all};
use crate::answers::Resources;
use crate::cache::{Content, Kind};
use crate::check;
use crate::entries::Entry;
use crate::refuse::{Axes, FLOOR, Refused};
use crate::scene::Scene;

/// Memory for what a request says of its free space.
#[derive(Debug, Default)]
pub(crate) struct Buffers<const D: usize> {
    channels: Vec<AxisBox<D>>,
    solids: Solids<D>,
    made: Vec<AxisBox<D>>,
    outline: Vec<Vector<2>>,
}

impl<const D: usize> Buffers<D> {
    /// The channels that were read last.
    pub(crate) fn channels(&self) -> &[AxisBox<D>] {
        &self.channels
    }

    /// The memory that it holds.
    pub(crate) fn bytes(&self) -> usize {
        let channels = self.channels.capacity() + self.made.capacity();
        let outline = self.outline.capacity() * size_of::<Vector<2>>();
        channels * size_of::<AxisBox<D>>() + self.solids.bytes() + outline
    }
}

/// What a request says of its free space, read and checked.
#[derive(Debug)]
pub(crate) enum Source<'a, const D: usize> {
    /// Channels.
    Channels(FreeSpace<'a, D>),
    /// Solids to make channels from.
    Solids(Cut<'a, D>),
    /// Solids by their surfaces alone.
    Outlines(Outlines<D>),
}

impl<'a, const D: usize> Source<'a, D> {
    /// Where the solids end along an exit, if channels are made within their own bounds.
    pub(crate) fn mouth(&self, exit: Direction, is_union: bool) -> Option<HalfSpace> {
        match self {
            Self::Channels(_) | Self::Outlines(_) => None,
            Self::Solids(cut) => cut.mouth(exit, is_union),
        }
    }

    /// The solids by their surfaces, if channels are not given.
    pub(crate) fn outlines(&self) -> Option<Outlines<D>> {
        match self {
            Self::Channels(_) => None,
            Self::Solids(cut) => Some(Outlines { walls: cut.walls.clone(), bounds: cut.bounds }),
            Self::Outlines(outlines) => Some(outlines.clone()),
        }
    }

    /// Reads the scene's channels, solids and bounds. Unless the body can move in channels among the
    /// solids, as a box can in the plane and whatever there is in space, and the solids have no slanted
    /// sides, there is no use in making any.
    pub(crate) fn read(
        scene: Scene<'_>,
        axes: &Axes,
        has_channels: bool,
        buffers: &'a mut Buffers<D>,
        resources: &mut Resources<'_>,
    ) -> Result<Self, Refused>
    where
        for<'b> Surfaces<'b, D>: TakeSolids<D>,
        for<'b> Pieces<'b, D>: TakeSolids<D>,
    {
        let bounds = bounds(scene, axes)?;
        if scene.free_space.channels.is_some() {
            return given_channels(scene, axes, buffers, resources).map(Self::Channels);
        }
        let Buffers { solids, made, outline, .. } = buffers;
        let walls = surfaces(scene, axes, None, outline, resources)?;
        if !has_channels || !walls.as_slice().iter().all(Wall::is_axis_parallel) {
            return Ok(Self::Outlines(Outlines { walls, bounds }));
        }
        solids.clear();
        let budget = resources.budget;
        take_all(scene, axes, Pieces { solids, outline, budget }, budget)?;
        Ok(Self::Solids(Cut { solids, made, walls, bounds }))
    }

    /// The free space: as given, or as `make` makes it.
    pub(crate) fn open(
        &mut self,
        make: impl FnOnce(&mut Cut<'a, D>) -> Result<Made<D>, Refused>,
    ) -> Result<FreeSpace<'a, D>, Refused> {
        match self {
            Self::Channels(space) => Ok(space.clone()),
            Self::Outlines(outlines) => Ok(FreeSpace::Outlines(outlines.clone())),
            Self::Solids(cut) => make(cut).map(FreeSpace::Made),
        }
    }
}

/// The scene's channels, which it must have, and the walls around them.
pub(crate) fn given_channels<'a, const D: usize>(
    scene: Scene<'_>,
    axes: &Axes,
    buffers: &'a mut Buffers<D>,
    resources: &mut Resources<'_>,
) -> Result<FreeSpace<'a, D>, Refused>
where
    for<'b> Surfaces<'b, D>: TakeSolids<D>,
{
    bounds::<D>(scene, axes)?;
    let Buffers { channels, outline, .. } = buffers;
    let given = scene.free_space.channels.as_deref().unwrap_or_default();
    take_channels(given, axes, channels, resources.budget)?;
    // One channel has but one order.
    if scene.free_space.in_order || channels.len() == 1 {
        let around = around(scene, axes, outline, resources)?;
        return Ok(FreeSpace::InOrder(channels, around));
    }
    let Resources { budget, cache, .. } = resources;
    cache.describe(Kind::Junctions, D).boxes(channels);
    let graph = cache.get(budget, || {
        let mut graph = Graph::default();
        graph.build(channels, budget)?;
        Ok::<_, Refused>(graph)
    })?;
    let around = around(scene, axes, outline, resources)?;
    Ok(FreeSpace::Unordered(graph, around))
}

/// The walls of a floor: the surfaces of its solids and its bounds, or all that its channels leave.
pub(crate) fn floor_walls(
    scene: Scene<'_>,
    buffers: &mut Buffers<2>,
    complement: &mut Complement<2>,
    resources: &mut Resources<'_>,
) -> Result<Arc<Entry<Walls<2>>>, Refused> {
    let Buffers { channels, outline, .. } = buffers;
    let bounds = bounds(scene, &FLOOR)?;
    let Some(given) = &scene.free_space.channels else {
        if bounds.is_none() {
            let message = "free_space.bounds is missing; solids alone do not bound a floor";
            return Err(Refusal::invalid("free_space.bounds", message).into());
        }
        // What lies outside of them is wall.
        return surfaces(scene, &FLOOR, bounds, outline, resources);
    };
    take_channels(given, &FLOOR, channels, resources.budget)?;
    complement_of(channels, None, complement, resources)
}

/// The scene's bounds, checked, if it has any.
fn bounds<const D: usize>(scene: Scene<'_>, axes: &Axes) -> Result<Option<AxisBox<D>>, Refusal> {
    let bounds = scene.free_space.bounds.as_ref();
    bounds
        .map(|bounds| check::axis_box(|| "free_space.bounds".to_owned(), axes, bounds))
        .transpose()
}

fn take_channels<const D: usize>(
    given: &[message::AxisBox],
    axes: &Axes,
    channels: &mut Vec<AxisBox<D>>,
    budget: &Budget<'_>,
) -> Result<(), Refused> {
    channels.clear();
    budget.step(given.len() as u64)?;
    budget.hold(size_of::<AxisBox<D>>() * given.len())?;
    for (index, sides) in given.iter().enumerate() {
        let field = || format!("free_space.channels[{index}]");
        channels.push(check::axis_box(field, axes, sides)?);
    }
    Ok(())
}

/// The walls around given channels.
fn around<const D: usize>(
    scene: Scene<'_>,
    axes: &Axes,
    outline: &mut Vec<Vector<2>>,
    resources: &mut Resources<'_>,
) -> Result<Around<D>, Refused>
where
    for<'b> Surfaces<'b, D>: TakeSolids<D>,
{
    if scene.free_space.solids.as_ref().is_none_or(Vec::is_empty) {
        return Ok(Around::Complement(None));
    }
    surfaces(scene, axes, None, outline, resources).map(Around::Solids)
}

/// The surfaces of the scene's solids, and of what lies outside of `within`.
fn surfaces<const D: usize>(
    scene: Scene<'_>,
    axes: &Axes,
    within: Option<AxisBox<D>>,
    outline: &mut Vec<Vector<2>>,
    resources: &mut Resources<'_>,
) -> Result<Arc<Entry<Walls<D>>>, Refused>
where
    for<'b> Surfaces<'b, D>: TakeSolids<D>,
{
    let Resources { budget, cache, .. } = resources;
    let content = cache.describe(Kind::SolidsWalls, D);
    content.word(u64::from(within.is_some()));
    content.boxes(within.as_slice());
    describe::<D>(scene, content);
    cache.get(budget, || {
        let mut walls = Walls::default();
        take_all(scene, axes, Surfaces { walls: &mut walls, within, outline, budget }, budget)?;
        Ok(walls)
    })
}

fn describe<const D: usize>(scene: Scene<'_>, content: &mut Content) {
    // For boxes; polygons may take more.
    let solids = scene.free_space.solids.as_deref().unwrap_or_default();
    content.reserve((1 + 2 * D) * solids.len());
    for solid in solids {
        match solid {
            Solid::Box(sides) => {
                content.word(0);
                content.numbers(&sides.min.padded()[..D]);
                content.numbers(&sides.max.padded()[..D]);
            }
            Solid::Boxes(boxes) => {
                content.word(u64::MAX - boxes.len() as u64);
                for sides in boxes {
                    content.numbers(&sides.min.padded()[..D]);
                    content.numbers(&sides.max.padded()[..D]);
                }
            }
            Solid::Polygon(vertices) => {
                content.word(1 + vertices.len() as u64);
                vertices.iter().for_each(|vertex| content.numbers(&vertex.padded()[..D]));
            }
        }
    }
}
