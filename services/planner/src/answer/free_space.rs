//! Where a body can move: channels as the request gives them or made from its solids,
//! in travel order or as a route finds them.

use planning::free_space::End;
use planning::free_space::graph::Graph;
use planning::free_space::route::{RouteError, Router, Traveller};
use planning::free_space::solids::{Caps, Solids};
use planning::geometry::{AxisBox, Vector};
use schemas::message::SceneRequest;
use schemas::message::{self, Refusal};

use super::refuse::{self, Axes};
use super::{Refused, check};

mod second_look;

use second_look::SecondLook;

/// What a request may ask for: 2^20 boxes of solids, 2^18 channels, a second or so.
const CAPS: Caps = Caps { pieces: 1 << 20, channels: 1 << 18, steps: 1 << 26 };

/// The most junctions of all channels.
const MOST_JUNCTIONS: usize = 1 << 22;

/// The most pairs of junctions that a route is sought through.
const MOST_STEPS: usize = 1 << 24;

/// Slanted edges of solids are followed to this part of the body's least extent.
const SLANT: f64 = 0.01;

/// The channels of a request, and the ones travelled. Reusable memory: where a request has the
/// free space of the last one, what was made from it is kept.
#[derive(Debug, Default)]
pub(super) struct FreeSpace<const D: usize> {
    source: Source,
    pub(super) solids: Solids<D>,
    bounds: Option<AxisBox<D>>,
    channels: Vec<AxisBox<D>>,
    /// What `channels` were made from last.
    made: Option<Made<D>>,
    graph: Graph<D>,
    router: Router<D>,
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

#[derive(Debug, PartialEq)]
struct Made<const D: usize> {
    solids: Vec<AxisBox<D>>,
    bounds: AxisBox<D>,
    room: Vector<D>,
}

impl<const D: usize> FreeSpace<D> {
    /// Reads channels and bounds; solids are pushed one by one after it.
    pub(super) fn read(&mut self, scene: &SceneRequest, axes: &Axes) -> Result<(), Refusal> {
        let given = &scene.free_space;
        self.solids.clear();
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
        self.made = None;
        self.channels.clear();
        for (index, sides) in channels.iter().enumerate() {
            let field = || format!("free_space.channels[{index}]");
            self.channels.push(check::axis_box(field, axes, sides)?);
        }
        // There is but one order of one channel.
        self.source = match given.in_order || channels.len() == 1 {
            true => Source::InOrder,
            false => Source::Unordered,
        };
        if self.source == Source::Unordered { self.connect() } else { Ok(()) }
    }

    /// The tolerance for slanted solids beside a body of this size; `None` where no channels
    /// are made from them.
    pub(super) fn slant(&self, size: &[f64]) -> Option<f64> {
        let least = size.iter().copied().fold(f64::INFINITY, f64::min);
        (self.source == Source::Solids).then_some(SLANT * least)
    }

    /// How finely and how many boxes solids may be cut into.
    pub(super) fn caps() -> Caps {
        CAPS
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
        &self.channels
    }

    /// Makes channels from the solids: all maximal boxes within `bounds` that are
    /// larger than `room` (metres).
    pub(super) fn make(&mut self, bounds: AxisBox<D>, room: Vector<D>) -> Result<(), Refusal> {
        self.second_look.prepare(bounds, room);
        let same = self.made.as_ref().is_some_and(|made| {
            made.bounds == bounds && made.room == room && made.solids == self.solids.boxes()
        });
        if same {
            return Ok(());
        }
        self.made = None;
        self.solids
            .channels(&bounds, &room, &CAPS, &mut self.channels)
            .map_err(|error| refuse::solids("free_space.solids", &error))?;
        self.connect()?;
        self.made = Some(Made { solids: self.solids.boxes().to_vec(), bounds, room });
        Ok(())
    }

    /// Finds the junctions of all channels.
    fn connect(&mut self) -> Result<(), Refusal> {
        if self.graph.channels() == self.channels {
            return Ok(());
        }
        self.graph
            .build(&self.channels, MOST_JUNCTIONS)
            .map_err(|error| refuse::solids("free_space.channels", &error))
    }

    /// Finds the channels to travel: the traveller's shortest route.
    pub(super) fn find(
        &mut self,
        axes: &Axes,
        field: impl Fn() -> String,
        traveller: impl FnOnce() -> Result<Traveller<D>, RouteError>,
        end: End<D>,
    ) -> Result<(), Refused> {
        let traveller = traveller().map_err(|error| refuse::route(axes, field(), error))?;
        self.router
            .find(&self.graph, &traveller, end, MOST_STEPS)
            .map_err(|error| self.refuse_route(axes, field(), error, &traveller, end))?;
        self.travelled.clear();
        self.travelled.extend(self.router.route().iter().map(|channel| self.channels[*channel]));
        Ok(())
    }

    /// The channels travelled, in travel order.
    pub(super) fn travelled(&self) -> &[AxisBox<D>] {
        match self.source {
            Source::InOrder => &self.channels,
            Source::Unordered | Source::Solids => &self.travelled,
        }
    }

    /// Their indices among all channels.
    pub(super) fn route(&self) -> impl ExactSizeIterator<Item = u64> {
        let in_order = !self.is_routed();
        let route = self.router.route();
        let length = if in_order { self.channels.len() } else { route.len() };
        (0..length).map(move |at| if in_order { at as u64 } else { route[at] as u64 })
    }

    /// The channels as the reply names them: those that were made.
    pub(super) fn named(&self) -> impl ExactSizeIterator<Item = message::AxisBox> {
        let named = if self.is_made() { &self.channels[..] } else { &[] };
        named.iter().map(|channel| message::AxisBox {
            min: message::Vector::new(channel.min().as_slice()).expect("two or three numbers"),
            max: message::Vector::new(channel.max().as_slice()).expect("two or three numbers"),
        })
    }
}
