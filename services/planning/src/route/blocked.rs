//! Why there is no route between solids: the narrowest passage on the widest way, or a wall.

use super::Traveller;
use super::widest::{Change, Lack, Space, Unknown, WidestWay, extent, is_of_the_search};
use crate::budget::{Budget, Held, Spent};
use crate::free_space::End;
use crate::geometry::box_tree::BoxTree;
use crate::geometry::{AxisBox, Direction, Sign, Vector};

/// A box, metres; may be flat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region<const D: usize> {
    /// The corner with the least coordinates.
    pub min: Vector<D>,
    /// The corner with the greatest coordinates.
    pub max: Vector<D>,
}

/// A free place that is too narrow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage<const D: usize> {
    /// Where it is.
    pub place: Region<D>,
    /// The axis along which it is too narrow.
    pub axis: usize,
    /// Its extent along the axis must exceed this, metres.
    pub needs: f64,
    /// Its extent along the axis, metres.
    pub has: f64,
}

impl<const D: usize> Passage<D> {
    /// Whether the traveller does not fit in. If it just fits, it cannot move.
    fn is_too_narrow(&self) -> bool {
        self.has < self.needs
    }
}

/// What blocks a traveller between solids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Blocked<const D: usize> {
    /// The start is in a solid or outside the bounds.
    StartTaken(Region<D>),
    /// The goal is in a solid or outside the bounds.
    GoalTaken(Region<D>),
    /// There is no room at the start: this is the widest place there.
    NarrowStart(Passage<D>),
    /// There is no room at the goal: this is the widest place there.
    NarrowGoal(Passage<D>),
    /// There is no room anywhere: this is the widest place.
    NoRoom(Passage<D>),
    /// The narrowest place on the widest way.
    Narrow {
        /// Where it is narrowest.
        passage: Passage<D>,
        /// The junction of free boxes there, counted from 0 in travel order.
        junction: usize,
        /// How many other places on that way are too narrow, none by more.
        others: usize,
    },
    /// No way leads from start to end, however narrow: walls are in between. This is the thickest
    /// wall on the way where the thickest is thinnest.
    Wall {
        /// The part of the wall between the free boxes on both sides of it.
        place: Region<D>,
        /// The axis along which it would be passed.
        axis: usize,
        /// Its thickness along that axis, metres; 0 if free boxes just meet at an edge.
        thickness: f64,
        /// What an opening through it must exceed along every axis, metres.
        needs: Vector<D>,
        /// The missing junction of free boxes, counted from 0 in travel order.
        junction: usize,
        /// How many other places on that way are too narrow or walls.
        others: usize,
    },
}

/// Finds out what blocks a traveller that has no route through the channels larger than
/// `room`. `boxes` are all maximal free boxes within `bounds`, whatever their size, from
/// [`Solids::channels`](crate::free_space::solids::Solids::channels) for a body of no size.
/// `None` if only a gap or a turn is in the way, or if it would take more than about
/// [`Cap::RouteSteps`](crate::budget::Cap::RouteSteps) pairs of boxes to tell.
///
/// A body passes from one maximal box to the next if it fits into their common part, so the
/// widest way over these boxes is the widest of all: no body larger than it along every axis
/// passes.
pub fn blocked<const D: usize>(
    boxes: &[AxisBox<D>],
    bounds: &AxisBox<D>,
    room: &Vector<D>,
    traveller: &Traveller<D>,
    budget: &Budget<'_>,
) -> Result<Option<Blocked<D>>, Spent> {
    let count = boxes.len();
    budget.step(STEPS_PER_BOX * count as u64)?;
    let per_box = size_of::<AxisBox<D>>() + size_of::<usize>();
    let _held = Held::new(budget, count * per_box + BoxTree::<D>::bytes_for(count))?;
    let found = on_the_way(boxes.to_vec(), bounds, room, traveller, budget)?;
    Ok(found.or_else(|| {
        let all = (0..count).collect::<Vec<_>>();
        no_room(boxes, &all, room).map(Blocked::NoRoom)
    }))
}

/// Every box is copied, and checked for the start, the goal and room.
const STEPS_PER_BOX: u64 = 4;

fn on_the_way<const D: usize>(
    mut boxes: Vec<AxisBox<D>>,
    bounds: &AxisBox<D>,
    room: &Vector<D>,
    traveller: &Traveller<D>,
    budget: &Budget<'_>,
) -> Result<Option<Blocked<D>>, Spent> {
    let (inner, end) = (boxes.len(), traveller.end);
    if let End::Exit(exit) = end {
        open_mouth(&mut boxes, bounds, exit, traveller.needs_along(exit.axis).1);
    }
    let around = |min: &Vector<D>, max: &Vector<D>| -> Vec<usize> {
        (0..inner).filter(|index| boxes[*index].holds(min) && boxes[*index].holds(max)).collect()
    };
    let starts = around(&traveller.least, &traveller.greatest);
    if starts.is_empty() {
        let Traveller { least, greatest, .. } = *traveller;
        return Ok(Some(Blocked::StartTaken(Region { min: least, max: greatest })));
    }
    if let Some(passage) = no_room(&boxes, &starts, room).filter(Passage::is_too_narrow) {
        return Ok(Some(Blocked::NarrowStart(passage)));
    }
    let goals = match end {
        End::Exit(_) => Vec::new(),
        End::Goal(goal) => around(&goal, &goal),
    };
    if let End::Goal(goal) = end {
        if goals.is_empty() {
            return Ok(Some(Blocked::GoalTaken(Region { min: goal, max: goal })));
        }
        if let Some(passage) = no_room(&boxes, &goals, room).filter(Passage::is_too_narrow) {
            return Ok(Some(Blocked::NarrowGoal(passage)));
        }
    }
    let is_end = |index: usize| match end {
        End::Exit(exit) => reach(&boxes[index], exit) > reach(bounds, exit),
        End::Goal(_) => goals.binary_search(&index).is_ok(),
    };
    let mut tree = BoxTree::default();
    tree.build(boxes.len(), |index| (boxes[index].min(), boxes[index].max()), budget)?;
    let space = Space { channels: &boxes, tree: &tree, traveller, room: Some(*room) };
    let way = match space.widest_way(&starts, is_end, budget) {
        Ok(way) => way,
        Err(Unknown::Spent(spent)) if !is_of_the_search(&spent) => return Err(spent),
        Err(_) => return Ok(None),
    };
    let scene = Surroundings { space, bounds, budget };
    match way.junction {
        Some(junction) => scene.at_junction(&way, junction),
        None => Ok(scene.in_one_box(&way)),
    }
}

/// Lengthens all boxes that reach the side of the bounds towards the exit, beyond which
/// everything is free, and adds the free box beyond it.
fn open_mouth<const D: usize>(
    boxes: &mut Vec<AxisBox<D>>,
    bounds: &AxisBox<D>,
    exit: Direction,
    length: f64,
) {
    let (side, mouth) = (2.0 * length, reach(bounds, exit));
    let outwards = |min: &Vector<D>, max: &Vector<D>| {
        let (mut min, mut max) = (*min, *max);
        match exit.sign {
            Sign::Positive => max[exit.axis] += side,
            Sign::Negative => min[exit.axis] -= side,
        }
        AxisBox::new(min, max).ok()
    };
    for free in boxes.iter_mut().filter(|free| reach(free, exit) >= mouth) {
        *free = outwards(&free.min(), &free.max()).unwrap_or(*free);
    }
    let (mut min, mut max) = (bounds.min(), bounds.max());
    match exit.sign {
        Sign::Positive => min[exit.axis] = max[exit.axis],
        Sign::Negative => max[exit.axis] = min[exit.axis],
    }
    boxes.extend(outwards(&min, &max));
}

/// The greatest coordinate along a direction, metres.
fn reach<const D: usize>(sides: &AxisBox<D>, towards: Direction) -> f64 {
    towards.coordinate(&sides.min()).max(towards.coordinate(&sides.max()))
}

/// The widest of these boxes; `None` if one of them has room.
fn no_room<const D: usize>(
    boxes: &[AxisBox<D>],
    around: &[usize],
    room: &Vector<D>,
) -> Option<Passage<D>> {
    let mut widest: Option<(f64, Passage<D>)> = None;
    for index in around {
        let (free, size) = (&boxes[*index], boxes[*index].size());
        let lack = |axis: &usize| room[*axis] - size[*axis];
        // The first of equals.
        let worst = (0..D).max_by(|a, b| lack(a).total_cmp(&lack(b)).then(b.cmp(a)));
        let axis = worst.unwrap_or(0);
        if lack(&axis) < 0.0 {
            return None;
        }
        if widest.is_none_or(|(least, _)| lack(&axis) < least) {
            let place = Region { min: free.min(), max: free.max() };
            let passage = Passage { place, axis, needs: room[axis], has: size[axis] };
            widest = Some((lack(&axis), passage));
        }
    }
    widest.map(|(_, passage)| passage)
}

struct Surroundings<'a, const D: usize> {
    space: Space<'a, D>,
    bounds: &'a AxisBox<D>,
    budget: &'a Budget<'a>,
}

impl<const D: usize> Surroundings<'_, D> {
    fn at_junction(&self, way: &WidestWay, junction: usize) -> Result<Option<Blocked<D>>, Spent> {
        let boxes = self.space.channels;
        let (one, other) = (&boxes[way.route[junction]], &boxes[way.route[junction + 1]]);
        let (axis, others) = (way.lack.axis, self.other_places(way));
        let has = extent(one, other, axis);
        Ok(match way.lack.change {
            Change::Nothing | Change::Gap => None,
            Change::Junction => {
                let place = self.trimmed(self.passage(way, junction, axis), axis, &way.lack)?;
                let needs = self.space.traveller.needs_along(axis).0;
                let passage = Passage { place, axis, needs, has };
                Some(Blocked::Narrow { passage, junction, others })
            }
            Change::Wall => {
                let place = self.between(one, other);
                let needs = Vector::from_fn(|axis, _| self.space.traveller.needs_along(axis).0);
                let thickness = (-has).max(0.0);
                Some(Blocked::Wall { place, axis, thickness, needs, junction, others })
            }
        })
    }

    /// For a box that holds start and end, and that the body just fills.
    fn in_one_box(&self, way: &WidestWay) -> Option<Blocked<D>> {
        let [index] = way.route[..] else { return None };
        let (free, room) = (&self.space.channels[index], self.space.room?);
        let lack = self.space.lack_of(free);
        if lack.change != Change::Junction {
            return None;
        }
        let (axis, place) = (lack.axis, Region { min: free.min(), max: free.max() });
        let (place, needs, has) = (self.within(&place), room[axis], free.size()[axis]);
        let passage = Passage { place, axis, needs, has };
        Some(Blocked::Narrow { passage, junction: 0, others: 0 })
    }

    /// Where a junction is narrow. Usually one of its two boxes is as narrow: a doorway that
    /// reaches far into the rooms on both sides. Then it is the part of that box between them.
    fn passage(&self, way: &WidestWay, junction: usize, axis: usize) -> Region<D> {
        let boxes = self.space.channels;
        let at = |place: usize| &boxes[way.route[place]];
        let has = extent(at(junction), at(junction + 1), axis);
        let narrow = |place: &usize| at(*place).size()[axis] <= has;
        let Some(place) = [junction, junction + 1].into_iter().find(narrow) else {
            return self.between(at(junction), at(junction + 1));
        };
        let narrow = at(place);
        let mut part = Region { min: narrow.min(), max: narrow.max() };
        let neighbour = |index: usize| way.route.get(index).map(|at| &boxes[*at]);
        let before = place.checked_sub(1).and_then(neighbour);
        let (Some(before), Some(after)) = (before, neighbour(place + 1)) else {
            return self.within(&part);
        };
        let (before, after) = ((before.min(), before.max()), (after.min(), after.max()));
        for other in (0..D).filter(|other| *other != axis) {
            let (low, high) = if before.1[other] <= after.0[other] {
                (before.1[other], after.0[other])
            } else if after.1[other] <= before.0[other] {
                (after.1[other], before.0[other])
            } else {
                continue;
            };
            part.min[other] = part.min[other].max(low);
            part.max[other] = part.max[other].min(high);
        }
        self.within(&part)
    }

    /// Without the ends that also lie in wider boxes, as the way may have led along the narrow
    /// box through rooms beside it. An axis along which nothing would be left stays whole.
    fn trimmed(&self, place: Region<D>, axis: usize, worst: &Lack) -> Result<Region<D>, Spent> {
        let boxes = self.space.channels;
        let has = place.max[axis] - place.min[axis];
        let is_wider = |free: &AxisBox<D>| {
            let lack = |axis| self.space.lack_along(axis, free.size()[axis]).metres;
            free.size()[axis] > has && (0..D).all(|axis| lack(axis) < worst.metres)
        };
        let mut rest = place;
        self.space.tree.visit(&place.min, &place.max, 0.0, self.budget, |index| {
            let (min, max) = (boxes[index].min(), boxes[index].max());
            let covers = |axis: usize| min[axis] <= place.min[axis] && place.max[axis] <= max[axis];
            let mut uncovered = (0..D).filter(|axis| !covers(*axis));
            if let (Some(along), None) = (uncovered.next(), uncovered.next())
                && along != axis
                && is_wider(&boxes[index])
            {
                if min[along] <= place.min[along] {
                    rest.min[along] = rest.min[along].max(max[along]);
                } else if place.max[along] <= max[along] {
                    rest.max[along] = rest.max[along].min(min[along]);
                }
            }
            0.0
        })?;
        for along in 0..D {
            if rest.min[along] >= rest.max[along] {
                (rest.min[along], rest.max[along]) = (place.min[along], place.max[along]);
            }
        }
        Ok(rest)
    }

    /// How many places on the way, besides the worst, are too narrow or walls. A doorway is one
    /// place with two consecutive junctions.
    fn other_places(&self, way: &WidestWay) -> usize {
        let boxes = self.space.channels;
        let (mut count, mut last) = (0_usize, None);
        for (at, pair) in way.route.windows(2).enumerate() {
            let [first, second] = *pair else { continue };
            let lack = self.space.lack(&boxes[first], &boxes[second]);
            let place = match lack.change {
                Change::Nothing => continue,
                Change::Gap | Change::Junction => self.passage(way, at, lack.axis),
                Change::Wall => self.between(&boxes[first], &boxes[second]),
            };
            if last.replace(place) != Some(place) {
                count += 1;
            }
        }
        count.saturating_sub(1)
    }

    /// The common part of two boxes; along axes on which they are apart, the part between.
    fn between(&self, one: &AxisBox<D>, other: &AxisBox<D>) -> Region<D> {
        let (a, b) = (one.min().sup(&other.min()), one.max().inf(&other.max()));
        self.within(&Region { min: a.inf(&b), max: a.sup(&b) })
    }

    fn within(&self, place: &Region<D>) -> Region<D> {
        let (min, max) = (self.bounds.min(), self.bounds.max());
        Region { min: place.min.sup(&min).inf(&max), max: place.max.inf(&max).sup(&min) }
    }
}
