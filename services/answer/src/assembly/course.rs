//! The way of a body through the channels it travels.

use planning::budget::{Budget, Spent};
use planning::clearance::Clearance;
use planning::clearance::translating::{Body, clearance_body_legs};
use planning::disassembly::{DisassemblyError, DisassemblyPath, Gap, disassemble, shortest_way};
use planning::free_space::walls::Walls;
use planning::free_space::{Chain, ChainError, End, Mouth};
use planning::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector};
use planning::motion::{Curve, Leg};
use planning::trajectory::{CornerShape, round_corners};

/// The channels travelled, the path through them, and how close it comes to the walls.
#[derive(Debug, Default)]
pub(super) struct Course<const D: usize> {
    /// The indices of the channels travelled, in travel order.
    pub(super) route: Vec<usize>,
    /// Memory for these channels, where the route was found.
    travelled: Vec<AxisBox<D>>,
    chain: Chain<D>,
    /// The way out that the chain is for, if it is of all channels in order.
    all_to: Option<Direction>,
    pub(super) path: DisassemblyPath<D>,
    /// What no way through the same channels at the same gap is shorter than, metres, where it was
    /// looked for.
    pub(super) bound: Option<f64>,
    /// Of the legs, and of the whole motion; none where there are no walls.
    pub(super) clearances: Vec<Clearance<D>>,
    pub(super) clearance: Option<Clearance<D>>,
    /// Memory for legs whose corners are rounded.
    rounded: Vec<Leg<D>>,
}

impl<const D: usize> Course<D> {
    /// Begins a request.
    pub(super) fn forget(&mut self) {
        self.all_to = None;
    }

    /// The memory that it holds, bytes.
    pub(super) fn bytes(&self) -> usize {
        let route = self.route.capacity() * size_of::<usize>();
        let travelled = self.travelled.capacity() * size_of::<AxisBox<D>>();
        let clearances = self.clearances.capacity() * size_of::<Clearance<D>>();
        let rounded = self.rounded.capacity() * size_of::<Leg<D>>();
        route + travelled + clearances + rounded + self.chain.bytes() + self.path.bytes()
    }

    /// The cells that its gaps and its route take in a reply.
    pub(super) fn cells(&self) -> usize {
        D * self.path.gaps().len() + self.route.len()
    }

    /// Travels all channels, which are in order.
    pub(super) fn follow_all(
        &mut self,
        channels: &[AxisBox<D>],
        body: &Body<'_, D>,
        exit: Direction,
        budget: &Budget<'_>,
    ) -> Result<(), ChainError> {
        if self.all_to == Some(exit) {
            return Ok(());
        }
        self.all_to = None;
        self.chain.build(channels, &body.bounds().center(), End::Exit(exit), budget)?;
        self.route.clear();
        self.route.extend(0..channels.len());
        self.all_to = Some(exit);
        Ok(())
    }

    /// Travels along a route that was found.
    pub(super) fn follow(
        &mut self,
        channels: &[AxisBox<D>],
        route: &[usize],
        body: &Body<'_, D>,
        exit: Direction,
        budget: &Budget<'_>,
    ) -> Result<(), ChainError> {
        self.all_to = None;
        self.route.clear();
        self.route.extend_from_slice(route);
        self.travelled.clear();
        self.travelled.extend(route.iter().map(|channel| channels[*channel]));
        self.chain.build(&self.travelled, &body.bounds().center(), End::Exit(exit), budget)
    }

    /// Takes a way that leads through no channels.
    pub(super) fn take(&mut self, way: &[Vector<D>]) {
        self.all_to = None;
        self.bound = None;
        self.route.clear();
        self.path.set_way(way);
    }

    /// Puts the mouth into the last channel.
    pub(super) fn set_mouth(&mut self, mouth: HalfSpace) {
        self.chain.set_mouth(mouth);
    }

    /// Where the last channel is left, by a body that goes on beyond by `reach`, metres.
    pub(super) fn mouth(&self, reach: f64) -> Option<Mouth<D>> {
        self.chain.mouth_and_channel(reach)
    }

    /// Finds the path by the rules of Table 1.
    pub(super) fn disassemble(
        &mut self,
        body: &AxisBox<D>,
        gap: Gap<'_, D>,
        budget: &Budget<'_>,
    ) -> Result<(), DisassemblyError> {
        self.bound = None;
        disassemble(&self.chain, body, gap, &mut self.path, budget)
    }

    /// Looks for the shortest way at the gap of the path, and takes it if so wanted.
    pub(super) fn shorten(
        &mut self,
        body: &AxisBox<D>,
        goal: Option<&Vector<D>>,
        takes: bool,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let way = shortest_way(&self.chain, body, goal, &self.path, budget)?;
        self.bound = Some(way.bound);
        if takes {
            self.path.set_legs(&way.legs);
        }
        Ok(())
    }

    /// How far a body at this displacement is beyond the mouth with its last side, metres; or how
    /// far it is short of it.
    pub(super) fn beyond_the_mouth(&self, body: &Body<'_, D>, at: &Vector<D>) -> Result<f64, f64> {
        let Some(HalfSpace { side, bound }) = self.chain.mouth() else { return Ok(0.0) };
        let body = body.bounds().translated(at);
        let beyond = match side.sign {
            Sign::Negative => body.min()[side.axis] - bound,
            Sign::Positive => bound - body.max()[side.axis],
        };
        if beyond < 0.0 { Err(-beyond) } else { Ok(beyond) }
    }

    /// Goes on from the mouth to a place beyond it, `axis` being the exit's.
    pub(super) fn go_on(&mut self, to: Vector<D>, axis: usize) {
        self.path.go_on(to, axis);
    }

    /// Whether the body stays free on the last leg, beyond the mouth.
    pub(super) fn is_free_outside(
        &self,
        body: &Body<'_, D>,
        walls: &Walls<D>,
        budget: &Budget<'_>,
    ) -> Result<bool, Spent> {
        let (Some(near), Some(Curve::Line { from, to, .. })) =
            (self.clearances.last(), self.path.legs().last().map(|leg| leg.curve))
        else {
            return Ok(true);
        };
        if near.value > 0.0 {
            return Ok(true);
        }
        // It touches a wall: what it passes over is looked at as boxes.
        for part in body.boxes() {
            let (from, to) = (part.translated(&from), part.translated(&to));
            let swept = AxisBox::new(from.min().inf(&to.min()), from.max().sup(&to.max()));
            if let Ok(swept) = swept
                && !walls.is_free(&swept, budget)?
            {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Measures how close the path comes to the walls; `None` if there are none.
    pub(super) fn measure(
        &mut self,
        body: &Body<'_, D>,
        walls: &Walls<D>,
        budget: &Budget<'_>,
    ) -> Result<Option<Clearance<D>>, Spent> {
        let Self { path, clearances, clearance, .. } = self;
        *clearance = clearance_body_legs(body, walls, path.legs(), clearances, budget)?;
        Ok(*clearance)
    }

    /// Passes corners along curves of a shape; in the plane only.
    pub(super) fn round(
        &mut self,
        (body, shape): (&Body<'_, D>, CornerShape),
        walls: &Walls<D>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let Self { path, clearances, clearance, rounded, .. } = self;
        *clearance =
            round_corners((body, shape), walls, path.legs(), (rounded, clearances), budget)?;
        path.set_legs(rounded);
        Ok(())
    }

    /// Whether a clearance of 0 is no more than contact, because the body stays where no solid
    /// is: in the channels (lemma 1 of docs/method.md), given or made from the solids, and, at the
    /// end, beyond the mouth.
    pub(super) fn is_contact(
        &self,
        body: &Body<'_, D>,
        solids: &Walls<D>,
        is_made: bool,
        budget: &Budget<'_>,
    ) -> Result<bool, Spent> {
        let Some(Curve::Line { to, .. }) = self.path.legs().last().map(|leg| leg.curve) else {
            return Ok(false);
        };
        // Channels made from the solids are free of them.
        if !is_made {
            for channel in self.chain.channels() {
                if !solids.is_free(channel, budget)? {
                    return Ok(false);
                }
            }
        }
        for part in body.boxes() {
            if !solids.is_free(&part.translated(&to), budget)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The least clearance of all, and that of the legs after the first, which begins where the
    /// body is; `None` where there are no walls.
    pub(super) fn room(&self) -> Option<(f64, f64)> {
        let whole = self.clearance?.value;
        let later = self.clearances.get(1..).unwrap_or_default().iter();
        let later = later.map(|near| near.value).reduce(f64::min);
        Some((whole, later.unwrap_or(whole)))
    }

    /// Whether it has more room than another, or the same but for `same` metres, and is shorter.
    pub(super) fn is_safer_than(&self, other: &Self, same: f64) -> bool {
        // Without walls there is room without end.
        let room = |course: &Self| course.room().unwrap_or((f64::INFINITY, f64::INFINITY));
        let ((whole, later), (other_whole, other_later)) = (room(self), room(other));
        let differs = |a: f64, b: f64| a != b && (a - b).abs() > same;
        if differs(whole, other_whole) {
            whole > other_whole
        } else if differs(later, other_later) {
            later > other_later
        } else {
            self.path.length() < other.path.length()
        }
    }

    /// Turns the path round. What was measured on the way out is exact in every number.
    pub(super) fn reverse(&mut self) {
        self.path.reverse();
        self.clearances.reverse();
        if let Some(near) = &mut self.clearance {
            near.at = self.path.length() - near.at;
        }
    }
}
