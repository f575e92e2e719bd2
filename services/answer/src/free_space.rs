//! Where a body can move: channels as the request gives them or made from its solids,
//! in travel order or as a route finds them; and the walls around.

use std::sync::Arc;

use planning::budget::{Budget, Spent};
use planning::free_space::graph::Graph;
use planning::free_space::solids::{Solids, SolidsError};
use planning::free_space::walls::{Complement, Walls};
use planning::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector};
use planning::route::{Judgement, Motion, RouteError, Router};
use schemas::message::{self, Refusal, SceneRequest, Solid, Task};

use super::cache::{Cache, Content, Kind};
use super::check;
use super::refuse::{self, Axes};

mod second_look;

use second_look::SecondLook;

/// Slanted edges of solids are followed to this part of the body's least extent.
const SLANT: f64 = 0.01;

/// The channels of a request, the ones travelled, and the walls. What takes long to make
/// belongs to the cache, and is held while the request lasts.
#[derive(Debug)]
pub(super) struct FreeSpace<const D: usize, M: Motion<D>> {
    source: Source,
    outline: Vec<Vector<2>>,
    solids: Solids<D>,
    bounds: Option<AxisBox<D>>,
    /// As the request has them.
    given: Vec<AxisBox<D>>,
    /// Those made from solids.
    made: Vec<AxisBox<D>>,
    /// All channels and their junctions, unless the channels are in order.
    graph: Option<Arc<Graph<D>>>,
    walls: Option<Arc<Walls<D>>>,
    /// Where the walls end, if they are the channels' complement.
    mouth: Option<HalfSpace>,
    complement: Complement<D>,
    router: Router<D, M>,
    travelled: Vec<AxisBox<D>>,
    /// Whether a refusal is to be as clear as can be; it takes time.
    pub(super) explains: bool,
    second_look: SecondLook<D>,
}

/// Where the channels come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Source {
    /// The request, in travel order.
    #[default]
    InOrder,
    /// The request, in any order.
    Unordered,
    /// The request's solids.
    Solids,
}

impl<const D: usize, M: Motion<D>> Default for FreeSpace<D, M> {
    fn default() -> Self {
        Self {
            source: Source::default(),
            outline: Vec::new(),
            solids: Solids::default(),
            bounds: None,
            given: Vec::new(),
            made: Vec::new(),
            graph: None,
            walls: None,
            mouth: None,
            complement: Complement::default(),
            router: Router::default(),
            travelled: Vec::new(),
            explains: true,
            second_look: SecondLook::default(),
        }
    }
}

impl<const D: usize, M: Motion<D>> FreeSpace<D, M> {
    /// Reads channels and bounds; solids are taken in after it.
    pub(super) fn read(
        &mut self,
        scene: &SceneRequest,
        axes: &Axes,
        budget: &Budget<'_>,
        cache: &mut Cache,
    ) -> Result<(), Refusal> {
        let given = &scene.free_space;
        self.given.clear();
        self.release();
        self.second_look.clear();
        self.explains = true;
        self.bounds = match &given.bounds {
            Some(bounds) => Some(check::axis_box(|| "free_space.bounds".to_owned(), axes, bounds)?),
            None => None,
        };
        let Some(channels) = &given.channels else {
            self.source = Source::Solids;
            return Ok(());
        };
        for (index, sides) in channels.iter().enumerate() {
            let field = || format!("free_space.channels[{index}]");
            self.given.push(check::axis_box(field, axes, sides)?);
        }
        // There is but one order of one channel.
        self.source = match given.in_order || channels.len() == 1 {
            true => Source::InOrder,
            false => Source::Unordered,
        };
        if self.source == Source::Unordered {
            cache.describe(Kind::Junctions, D).boxes(&self.given);
            let graph = cache.get(budget, |graph: &mut Graph<D>| {
                graph.build(&self.given, budget).map_err(refuse::spent)
            })?;
            self.graph = Some(graph);
        }
        Ok(())
    }

    /// Lets go of what belongs to the cache: the request has ended.
    pub(super) fn release(&mut self) {
        (self.graph, self.walls, self.mouth) = (None, None, None);
    }

    /// Whether the channels are made from the solids.
    pub(super) fn is_made(&self) -> bool {
        self.source == Source::Solids
    }

    /// Whether a route is to be found through the channels.
    pub(super) fn is_routed(&self) -> bool {
        self.source != Source::InOrder
    }

    /// The bounds that the request gives.
    pub(super) fn bounds(&self) -> Option<&AxisBox<D>> {
        self.bounds.as_ref()
    }

    /// All channels, as given or made.
    pub(super) fn channels(&self) -> &[AxisBox<D>] {
        self.graph.as_deref().map_or(&self.given, Graph::channels)
    }

    /// What clearance is measured against.
    pub(super) fn walls(&self) -> &Walls<D> {
        self.walls.as_deref().expect("found before the first path")
    }

    /// Where to look for the channels of a cavity: within the bounds that the request gives, or
    /// those of its solids.
    pub(super) fn cavity(&self, body: &AxisBox<D>, exit: Direction) -> Option<AxisBox<D>> {
        self.bounds.or_else(|| self.solids.cavity(body, exit))
    }

    /// Makes channels from the solids: all maximal boxes within `bounds` that are
    /// larger than `room` (metres).
    pub(super) fn make(
        &mut self,
        bounds: AxisBox<D>,
        room: Vector<D>,
        budget: &Budget<'_>,
        cache: &mut Cache,
    ) -> Result<(), Refusal> {
        let Self { solids, made, second_look, .. } = self;
        second_look.prepare(bounds, room);
        let content = cache.describe(Kind::SolidsJunctions, D);
        content.boxes(&[bounds]);
        content.numbers(room.as_slice());
        content.boxes(solids.boxes());
        let graph = cache.get(budget, |graph: &mut Graph<D>| {
            let made = solids
                .channels(&bounds, &room, budget, made)
                .and_then(|()| graph.build(made, budget));
            made.map_err(refuse::spent)
        })?;
        self.graph = Some(graph);
        Ok(())
    }

    /// Makes the channels' complement the walls, up to the mouth if there is one.
    pub(super) fn wall_in(
        &mut self,
        mouth: Option<HalfSpace>,
        budget: &Budget<'_>,
        cache: &mut Cache,
    ) -> Result<(), Refusal> {
        if self.walls.is_some() && self.mouth == mouth {
            return Ok(());
        }
        let channels = self.graph.as_deref().map_or(&self.given[..], Graph::channels);
        let complement = &mut self.complement;
        let content = cache.describe(Kind::ChannelsWalls, D);
        content.word(u64::from(mouth.is_some()));
        if let Some(HalfSpace { side, bound }) = mouth {
            content.word((side.axis as u64) << 1 | u64::from(side.sign == Sign::Positive));
            content.numbers(&[bound]);
        }
        content.boxes(channels);
        let walls = cache.get(budget, |walls: &mut Walls<D>| {
            walls.set_complement(channels, mouth, complement, budget).map_err(refuse::spent)
        })?;
        (self.walls, self.mouth) = (Some(walls), mouth);
        Ok(())
    }

    /// Finds the channels to travel: the shortest route that can be followed, as `judge`
    /// finds out, given its channels and the walls.
    pub(super) fn find<T>(
        &mut self,
        motion: &mut M,
        budget: &Budget<'_>,
        mut judge: impl FnMut(&[AxisBox<D>], &Walls<D>, f64) -> Result<Judgement<T>, Spent>,
    ) -> Result<T, RouteError> {
        let Self { graph, walls, router, travelled, .. } = self;
        let graph = graph.as_deref().expect("channels are in order, or connected");
        let no_walls = Walls::default();
        let known = walls.as_deref();
        let walls = known.unwrap_or(&no_walls);
        router.find_judged(graph, known, motion, budget, |route, length| {
            travelled.clear();
            travelled.extend(route.iter().map(|channel| graph.channels()[*channel]));
            judge(travelled, walls, length)
        })
    }

    /// The channels travelled, in travel order.
    pub(super) fn travelled(&self) -> &[AxisBox<D>] {
        match self.source {
            Source::InOrder => &self.given,
            Source::Unordered | Source::Solids => &self.travelled,
        }
    }

    /// Their indices among all channels.
    pub(super) fn route(&self) -> impl ExactSizeIterator<Item = u64> {
        let in_order = !self.is_routed();
        let route = self.router.route();
        let length = if in_order { self.given.len() } else { route.len() };
        (0..length).map(move |at| if in_order { at as u64 } else { route[at] as u64 })
    }

    /// The channels as the reply names them: those that were made.
    pub(super) fn named(&self) -> impl ExactSizeIterator<Item = message::AxisBox> {
        let named = if self.is_made() { self.channels() } else { &[] };
        named.iter().map(|channel| message::AxisBox {
            min: message::Vector::new(channel.min().as_slice()).expect("two or three numbers"),
            max: message::Vector::new(channel.max().as_slice()).expect("two or three numbers"),
        })
    }
}

impl<M: Motion<2>> FreeSpace<2, M> {
    /// Takes in the scene's solids, if it has any: as walls, and, where channels are to be made
    /// from them for a body of this size, cut into boxes.
    pub(super) fn take_in_solids(
        &mut self,
        scene: &SceneRequest,
        axes: &Axes,
        size: &[f64],
        budget: &Budget<'_>,
        cache: &mut Cache,
    ) -> Result<(), Refusal> {
        if !check::has_solids(scene) {
            return Ok(());
        }
        let is_made = self.is_made();
        let Self { outline, solids, .. } = self;
        // What is outside of a floor's bounds is wall.
        let around = self.bounds.filter(|_| is_made && scene.task == Task::Drive);
        let content = cache.describe(Kind::SolidsWalls, 2);
        content.word(u64::from(around.is_some()));
        content.boxes(around.as_slice());
        describe_solids::<2>(scene, content);
        let walls = cache.get(budget, |walls: &mut Walls<2>| {
            walls.clear();
            check::push_solids(scene, axes, walls, push_walls, |walls, field, points| {
                let solid = check::polygon(field, points, outline, budget)?;
                walls.push_polygon(&solid);
                *outline = solid.into_vertices();
                Ok(())
            })?;
            if let Some(bounds) = &around {
                walls.push_inside(bounds);
            }
            walls.index(budget).map_err(refuse::spent)
        })?;
        self.walls = Some(walls);
        if is_made {
            let tolerance = SLANT * size.iter().copied().fold(f64::INFINITY, f64::min);
            solids.clear();
            let push_box = |solids: &mut Solids<2>, solid: &_| {
                solids.push_box(*solid, budget).map_err(refuse::spent)
            };
            check::push_solids(scene, axes, solids, push_box, |solids, field, points| {
                let solid = check::polygon(field, points, outline, budget)?;
                let pushed = solids.push_polygon(&solid, tolerance, budget);
                *outline = solid.into_vertices();
                pushed.map_err(|error| match error {
                    SolidsError::Spent(error) => {
                        Refusal { field: Some(field()), ..refuse::spent(error) }
                    }
                    error => Refusal::invalid(field(), format!("{}: {error}", field())),
                })
            })?;
        }
        Ok(())
    }
}

impl<M: Motion<3>> FreeSpace<3, M> {
    /// Takes in the scene's solids, if it has any; as in two dimensions.
    pub(super) fn take_in_solids(
        &mut self,
        scene: &SceneRequest,
        axes: &Axes,
        budget: &Budget<'_>,
        cache: &mut Cache,
    ) -> Result<(), Refusal> {
        if !check::has_solids(scene) {
            return Ok(());
        }
        describe_solids::<3>(scene, cache.describe(Kind::SolidsWalls, 3));
        let walls = cache.get(budget, |walls: &mut Walls<3>| {
            walls.clear();
            check::push_solids(scene, axes, walls, push_walls, |_, field, _| {
                Err(check::flat(field()))
            })?;
            walls.index(budget).map_err(refuse::spent)
        })?;
        self.walls = Some(walls);
        if self.is_made() {
            let solids = &mut self.solids;
            solids.clear();
            let push_box = |solids: &mut Solids<3>, solid: &_| {
                solids.push_box(*solid, budget).map_err(refuse::spent)
            };
            check::push_solids(scene, axes, solids, push_box, |_, field, _| {
                Err(check::flat(field()))
            })?;
        }
        Ok(())
    }
}

fn push_walls<const D: usize>(walls: &mut Walls<D>, solid: &AxisBox<D>) -> Result<(), Refusal> {
    walls.push_box(solid);
    Ok(())
}

fn describe_solids<const D: usize>(scene: &SceneRequest, content: &mut Content) {
    for solid in scene.free_space.solids.iter().flatten() {
        match solid {
            Solid::Box(sides) => {
                content.word(0);
                content.numbers(&sides.min.padded()[..D]);
                content.numbers(&sides.max.padded()[..D]);
            }
            Solid::Polygon(vertices) => {
                content.word(1 + vertices.len() as u64);
                vertices.iter().for_each(|vertex| content.numbers(&vertex.padded()[..D]));
            }
        }
    }
}
