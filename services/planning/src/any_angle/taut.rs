//! The shortest path of a disc: straight lines and arcs about the corners of a floor.
//!
//! A search in the manner of Polyanya (Cui, Harabor, Grastien, "Compromise-free Pathfinding on a
//! Navigation Mesh", 2017), from points to circles: what a node is rooted at is a guiding circle
//! run around in one sense, and the next line is a common tangent of two of them
//! (`docs/method.md`, section 5).
//!
//! Which corners a line from a circle can lead to: those that are seen, as points, from its
//! centre. For if a tangent keeps its distance from all walls, then so does the strip between it
//! and the line of centres, which therefore crosses no wall. What is seen is found junction by
//! junction with exact predicates; each tangent and arc is then checked against all walls near it.

use std::collections::BinaryHeap;

use super::arc_memo::{ArcMemos, KnownArcs};
use super::disc::{Disc, FreeArc, turned};
use super::queue::Queued;
use super::sight::Sight;
use crate::budget::{Budget, Cap, Held, Spent};
use crate::driving::tangent::{Circle, Tangent, tangent};
use crate::free_space::floor::{Floor, NONE, Reflex};
use crate::geometry::{Vector, rotated, unit};
use path::{STRAIGHT, at_rest, contact_normal, is_behind};

mod path;
mod reach;

pub(super) use path::{TautPath, TautTurn, TurnRadii};

/// Steps of the budget that looking through a junction takes.
const STEPS_PER_SIGHT: u64 = 15;

/// After so many turns pockets are looked for: most searches end before.
const TURNS_BEFORE_POCKETS: u32 = 24;

/// So many junctions in a row may be looked through without a look at how far they are.
const MOST_UNMEASURED: u32 = 8;

/// Where the next line leaves from.
#[derive(Debug, Clone, Copy)]
struct TurnRoot {
    /// The vertex that the path turns about; `NONE` at the start.
    vertex: u32,
    circle: Circle,
    /// The line that leads there; at the start it has no length.
    arrival: Tangent,
    /// The length of the path at the end of that line, metres.
    length: f64,
    /// How far the circle can be run around, radians, and the direction there.
    most_sweep: f64,
    last_direction: Vector<2>,
    /// The angle run around the circle before, radians.
    sweep_before: f64,
    before: u32,
    /// Another root with the same vertex and sense.
    same: u32,
    /// From the end of the line that leads there to the goal, metres.
    to_goal: f64,
}

/// What is next.
#[derive(Debug, Clone, Copy)]
enum Step {
    /// A look through a junction.
    Look(Sight),
    /// An index of a line to a circle.
    Turn(u32),
    /// An index of a line to the goal.
    Finish(u32),
}

/// A line to the circle about a vertex, after this sweep about the root, and where the arc ends
/// that it leads to.
#[derive(Debug, Clone, Copy)]
struct TurnStep {
    vertex: u32,
    circle: Circle,
    line: Tangent,
    sweep: f64,
    end: Vector<2>,
}

/// A search in memory that is used again.
#[derive(Debug, Default)]
pub(super) struct TautSearch {
    /// Indices of steps, by the least length of a path that goes on from there.
    heap: BinaryHeap<Queued>,
    /// Each with its root.
    steps: Vec<(u32, Step)>,
    turns: Vec<TurnStep>,
    /// Lines to the goal, each after a sweep about its root.
    finishes: Vec<(Tangent, f64)>,
    roots: Vec<TurnRoot>,
    /// For each vertex and sense, the last root there.
    last_root: Vec<u32>,
    /// Vertices with roots, to be reset.
    touched: Vec<u32>,
    goal_faces: Vec<u32>,
    /// Faces at the start and at the goal.
    end_faces: Vec<u32>,
    /// How far beyond the gates of pockets there may be something to turn about, metres; `None`
    /// where pockets are not looked for.
    beyond_gates: Option<f64>,
    arcs: ArcMemos,
    own_arcs: OwnArcs,
    /// After how many turns pockets are looked for, if not after the usual number.
    #[cfg(test)]
    pub(super) turns_before_pockets: Option<u32>,
}

/// Free arcs about corners with radii of their own, for one search.
#[derive(Debug, Default)]
struct OwnArcs {
    /// Vertex, index of the first, and count.
    at: Vec<(u32, [u32; 2])>,
    arcs: Vec<FreeArc>,
}

impl TautSearch {
    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.heap.capacity() * size_of::<Queued>()
            + self.steps.capacity() * size_of::<(u32, Step)>()
            + self.turns.capacity() * size_of::<TurnStep>()
            + self.finishes.capacity() * size_of::<(Tangent, f64)>()
            + self.roots.capacity() * size_of::<TurnRoot>()
            + self.arcs.bytes()
            + (self.last_root.capacity() + self.touched.capacity() + self.end_faces.capacity())
                * size_of::<u32>()
    }

    /// The shortest path of a disc from its start to its goal that turns about corners with these
    /// radii; `None` if there is none.
    pub(super) fn find(
        &mut self,
        floor: &Floor,
        disc: &Disc<'_>,
        radii: TurnRadii<'_>,
        budget: &Budget<'_>,
    ) -> Result<Option<TautPath>, Spent> {
        self.clear(floor);
        let is_even = disc.is_even() && radii.least <= disc.radius;
        self.arcs.begin(floor.vertex_count(), is_even.then_some(disc.radius));
        let mut run = Run { search: self, floor, disc, radii, budget };
        if disc.start == disc.goal {
            return Ok(Some(TautPath { turns: Vec::new(), last: at_rest(disc.goal), length: 0.0 }));
        }
        let found = run.run()?;
        Ok(found.map(|(root, line, sweep)| self.path(root, line, sweep)))
    }

    /// To be called before a search on another floor.
    pub(super) fn forget(&mut self) {
        self.arcs.forget();
    }

    fn clear(&mut self, floor: &Floor) {
        self.heap.clear();
        self.roots.clear();
        self.steps.clear();
        self.turns.clear();
        self.finishes.clear();
        self.beyond_gates = None;
        self.own_arcs.at.clear();
        self.own_arcs.arcs.clear();
        for vertex in self.touched.drain(..) {
            self.last_root[2 * vertex as usize] = NONE;
            self.last_root[2 * vertex as usize + 1] = NONE;
        }
        if self.last_root.len() < 2 * floor.vertex_count() {
            self.last_root.resize(2 * floor.vertex_count(), NONE);
        }
    }

    fn path(&self, root: u32, last: Tangent, sweep: f64) -> TautPath {
        let mut turns = Vec::new();
        let (mut at, mut sweep) = (root, sweep);
        let mut length = last.length;
        while let Some(root) = self.roots.get(at as usize)
            && root.vertex != NONE
        {
            length += root.arrival.length + root.circle.signed_radius.abs() * sweep;
            turns.push(TautTurn {
                vertex: root.vertex,
                circle: root.circle,
                arrival: root.arrival,
                sweep,
            });
            (at, sweep) = (root.before, root.sweep_before);
        }
        turns.reverse();
        TautPath { turns, last, length }
    }
}

struct Run<'a> {
    search: &'a mut TautSearch,
    floor: &'a Floor,
    disc: &'a Disc<'a>,
    radii: TurnRadii<'a>,
    budget: &'a Budget<'a>,
}

impl Run<'_> {
    fn run(&mut self) -> Result<Option<(u32, Tangent, f64)>, Spent> {
        let Self { floor, disc, budget, .. } = *self;
        let mut held = Held::new(budget, 0)?;
        self.search.goal_faces = floor.faces_around(&disc.goal, budget)?;
        let faces = floor.faces_around(&disc.start, budget)?;
        let search = &mut *self.search;
        search.end_faces.clear();
        search.end_faces.extend(search.goal_faces.iter().chain(&faces));
        self.search.roots.push(TurnRoot {
            vertex: NONE,
            circle: Circle { center: disc.start, signed_radius: 0.0 },
            arrival: at_rest(disc.start),
            length: 0.0,
            most_sweep: 0.0,
            last_direction: Vector::zeros(),
            sweep_before: 0.0,
            before: NONE,
            same: NONE,
            to_goal: (disc.goal - disc.start).norm(),
        });
        for index in faces {
            let face = floor.face(index);
            for vertex in face.vertices {
                self.offer_turns(0, vertex)?;
            }
            if self.search.goal_faces.contains(&index) {
                self.offer_goal(0);
            }
            for sight in Sight::from_face(floor, &disc.start, face, index) {
                self.offer_sight(0, sight);
            }
        }
        while let Some(next) = self.search.heap.pop() {
            budget.step(STEPS_PER_SIGHT)?;
            let (root, step) = self.search.steps[next.index];
            match step {
                Step::Look(sight) => self.look(root, sight)?,
                Step::Turn(index) => {
                    let next = self.search.turns[index as usize];
                    self.turn(root, &next)?;
                }
                Step::Finish(index) => {
                    let (line, sweep) = self.search.finishes[index as usize];
                    if disc.is_clear((&line.from, &line.to), budget)? {
                        return Ok(Some((root, line, sweep)));
                    }
                }
            }
            held.resize(
                self.search.steps.len() * size_of::<(u32, Step)>()
                    + self.search.turns.len() * size_of::<TurnStep>()
                    + self.search.roots.len() * size_of::<TurnRoot>(),
            )?;
        }
        Ok(None)
    }

    /// Looks through a junction: on to the next ones, and to the vertex beyond.
    fn look(&mut self, root: u32, sight: Sight) -> Result<(), Spent> {
        let Self { floor, budget, .. } = *self;
        let mut sight = sight;
        let mut unmeasured = 0;
        loop {
            let center = self.search.roots[root as usize].circle.center;
            let face = floor.face(sight.face);
            if sight.narrow == NONE
                && self.search.goal_faces.contains(&sight.face)
                && sight.shows(floor, &center, &self.disc.goal)
            {
                self.offer_goal(root);
            }
            let (further, sees_apex) = sight.further(floor, &center);
            if sees_apex && self.is_within_reach(&sight, &floor.vertex(sight.apex(face))) {
                self.offer_turns(root, sight.apex(face))?;
            }
            let further = self.note_gates(further);
            // Through the only junction seen, without a look at how far it is.
            if let [Some(only), None] | [None, Some(only)] = further
                && unmeasured < MOST_UNMEASURED
                && sight.narrow == NONE
                && only.gate == NONE
            {
                let mut next = only;
                self.note_narrow(root, &mut next);
                if next.narrow == NONE {
                    unmeasured += 1;
                    budget.step(STEPS_PER_SIGHT)?;
                    sight = next;
                    continue;
                }
            }
            unmeasured = 0;
            // On through the nearer junction, without a detour through the heap.
            let offered = further.map(|sight| {
                let mut sight = sight?;
                Some((self.least(root, &mut sight)?, sight))
            });
            let (next, other) = match offered {
                [Some(right), Some(left)] if right.0 <= left.0 => (right, Some(left)),
                [Some(right), Some(left)] => (left, Some(right)),
                [Some(only), None] | [None, Some(only)] => (only, None),
                [None, None] => return Ok(()),
            };
            if let Some((least, sight)) = other {
                self.push(least, root, Step::Look(sight));
            }
            if self.search.heap.peek().is_some_and(|top| top.least < next.0) {
                self.push(next.0, root, Step::Look(next.1));
                return Ok(());
            }
            budget.step(STEPS_PER_SIGHT)?;
            sight = next.1;
        }
    }

    /// Takes up a line to a circle, unless a wall is in the way or the circle has been reached
    /// by a way that is as good.
    fn turn(&mut self, from: u32, next: &TurnStep) -> Result<(), Spent> {
        let Self { floor, disc, budget, .. } = *self;
        let TurnStep { vertex, circle, line, sweep, end } = *next;
        let length = self.length_to(from, &line, sweep);
        let sense = circle.signed_radius.signum();
        let radius = circle.signed_radius.abs();
        let slot = slot(vertex, sense);
        if self.is_beaten(slot, &line.direction, length, sense) {
            return Ok(());
        }
        let Some(corner) = floor.corner(vertex) else { return Ok(()) };
        let normal = contact_normal(&line.direction, sense);
        if !disc.is_clear((&line.from, &line.to), budget)? {
            return Ok(());
        }
        let mut most_sweep = turned(&normal, &end, sense).max(0.0);
        // From where another way joins the circle, that one is shorter.
        let mut other = self.search.last_root[slot];
        while let Some(known) = self.search.roots.get(other as usize) {
            let angle = turned(&line.direction, &known.arrival.direction, sense);
            if angle > 0.0 && length + radius * angle >= known.length {
                most_sweep = most_sweep.min(angle);
            }
            other = known.same;
        }
        let search = &mut *self.search;
        let index = search.roots.len() as u32;
        search.roots.push(TurnRoot {
            vertex,
            circle,
            arrival: line,
            length,
            most_sweep,
            last_direction: rotated(&line.direction, &unit(sense * most_sweep)),
            sweep_before: sweep,
            before: from,
            same: search.last_root[slot],
            to_goal: (disc.goal - line.to).norm(),
        });
        if search.last_root[slot ^ 1] == NONE && search.last_root[slot] == NONE {
            search.touched.push(vertex);
        }
        search.last_root[slot] = index;
        let before_pockets = TURNS_BEFORE_POCKETS;
        #[cfg(test)]
        let before_pockets = search.turns_before_pockets.unwrap_or(before_pockets);
        if index == before_pockets {
            self.find_pockets()?;
        }
        self.look_around(index, corner, budget)
    }

    /// Looks in all directions of a corner's free sector.
    fn look_around(
        &mut self,
        root: u32,
        corner: &Reflex,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let floor = self.floor;
        let TurnRoot { vertex, circle, .. } = self.search.roots[root as usize];
        let mut index = corner.first;
        loop {
            budget.step(STEPS_PER_SIGHT)?;
            let face = floor.face(index);
            let Some(at) = face.index_of(vertex) else { return Ok(()) };
            let gate = self.gate_of(index)?;
            let [right, left] = [1, 2].map(|turn| face.vertices[(at + turn) % 3]);
            if index == corner.first && self.is_near_gate(gate, &floor.vertex(right)) {
                self.offer_turns(root, right)?;
            }
            if self.is_near_gate(gate, &floor.vertex(left)) {
                self.offer_turns(root, left)?;
            }
            if self.search.goal_faces.contains(&index) {
                self.offer_goal(root);
            }
            for sight in Sight::from_face(floor, &circle.center, face, index) {
                let [beyond, _] = self.note_gates([Some(Sight { gate, ..sight }), None]);
                self.offer_sight(root, beyond.unwrap_or(sight));
            }
            match face.beyond((at + 2) % 3) {
                Some(next) if next != corner.first => index = next,
                _ => return Ok(()),
            }
        }
    }

    /// Whether a way that is as good as this one leads to the same circle.
    fn is_beaten(&self, slot: usize, arrival: &Vector<2>, length: f64, sense: f64) -> bool {
        let mut other = self.search.last_root[slot];
        while let Some(known) = self.search.roots.get(other as usize) {
            other = known.same;
            let before = &known.arrival.direction;
            if known.length > length + self.disc.rounding || is_behind(before, arrival, sense) {
                continue;
            }
            let angle = turned(before, arrival, sense);
            let over = known.circle.signed_radius.abs() * angle.max(0.0);
            if angle >= -STRAIGHT
                && angle <= known.most_sweep + STRAIGHT
                && known.length + over <= length + self.disc.rounding
            {
                return true;
            }
        }
        false
    }

    /// Offers the lines to the circle about a vertex, run around in either sense.
    fn offer_turns(&mut self, root: u32, vertex: u32) -> Result<(), Spent> {
        let floor = self.floor;
        let Some(corner) = floor.corner(vertex) else { return Ok(()) };
        let center = floor.vertex(vertex);
        let least = self.disc.radius_at(&center).max(self.radii.least);
        let own = self.radii.own_at(vertex).map(|own| own.max(least));
        let radius = own.unwrap_or(least);
        let place = match own {
            Some(_) => self.own_arcs_of(vertex, corner, (&center, radius))?,
            None => self.arcs_of(vertex, corner, (&center, radius))?,
        };
        if place.1 == 0 {
            return Ok(());
        }
        for sense in [1.0, -1.0] {
            let circle = Circle { center, signed_radius: sense * radius };
            let from = &self.search.roots[root as usize].circle;
            let Some(line) = tangent(from, &circle) else { continue };
            let normal = contact_normal(&line.direction, sense);
            let arcs = match own {
                Some(_) => &self.search.own_arcs.arcs[place.0 as usize..][..place.1 as usize],
                None => self.search.arcs.front().slice(place),
            };
            let Some(arc) = arcs.iter().find(|arc| arc.holds(&normal, STRAIGHT)) else { continue };
            let end = arc.ends[usize::from(sense > 0.0)];
            let Some(sweep) = self.sweep_to(root, &line) else { continue };
            let length = self.length_to(root, &line, sweep);
            if self.is_beaten(slot(vertex, sense), &line.direction, length, sense) {
                continue;
            }
            let least = length + (self.disc.goal - line.to).norm();
            let index = self.search.turns.len() as u32;
            self.search.turns.push(TurnStep { vertex, circle, line, sweep, end });
            self.push(least, root, Step::Turn(index));
        }
        Ok(())
    }

    /// The free arcs about a vertex: where they begin, and how many there are.
    fn arcs_of(
        &mut self,
        vertex: u32,
        corner: &Reflex,
        circle: (&Vector<2>, f64),
    ) -> Result<(u32, u32), Spent> {
        let Self { disc, budget, .. } = *self;
        let memo = self.search.arcs.front();
        match memo.look_up(vertex) {
            KnownArcs::Known(first, count, steps) => {
                budget.step(steps)?;
                Ok((first, count))
            }
            KnownArcs::Unknown => {
                let first = memo.arcs().len();
                let before = budget.drawn(Cap::Steps);
                disc.free_arcs(circle, &corner.normals, memo.arcs(), budget)?;
                Ok(memo.note(vertex, first, budget.drawn(Cap::Steps) - before))
            }
        }
    }

    /// The same about a vertex with a radius of its own.
    fn own_arcs_of(
        &mut self,
        vertex: u32,
        corner: &Reflex,
        circle: (&Vector<2>, f64),
    ) -> Result<(u32, u32), Spent> {
        let Self { disc, budget, .. } = *self;
        let OwnArcs { at, arcs } = &mut self.search.own_arcs;
        budget.step(at.len() as u64)?;
        if let Some((_, [first, count])) = at.iter().find(|(known, _)| *known == vertex) {
            return Ok((*first, *count));
        }
        let first = arcs.len() as u32;
        disc.free_arcs(circle, &corner.normals, arcs, budget)?;
        let count = arcs.len() as u32 - first;
        at.push((vertex, [first, count]));
        Ok((first, count))
    }

    fn offer_goal(&mut self, root: u32) {
        let goal = Circle { center: self.disc.goal, signed_radius: 0.0 };
        let line = tangent(&self.search.roots[root as usize].circle, &goal);
        if let Some(line) = line
            && let Some(sweep) = self.sweep_to(root, &line)
        {
            let least = self.length_to(root, &line, sweep);
            let index = self.search.finishes.len() as u32;
            self.search.finishes.push((line, sweep));
            self.push(least, root, Step::Finish(index));
        }
    }

    fn offer_sight(&mut self, root: u32, sight: Sight) {
        let mut sight = sight;
        if let Some(least) = self.least(root, &mut sight) {
            self.push(least, root, Step::Look(sight));
        }
    }

    fn push(&mut self, least: f64, root: u32, step: Step) {
        let index = self.search.steps.len();
        self.search.steps.push((root, step));
        self.search.heap.push(Queued { least, index });
    }

    /// The sweep about a root before a line; `None` if it can't be left in that direction.
    fn sweep_to(&self, index: u32, line: &Tangent) -> Option<f64> {
        let root = &self.search.roots[index as usize];
        if root.vertex == NONE {
            return Some(0.0);
        }
        let sense = root.circle.signed_radius.signum();
        if is_behind(&root.arrival.direction, &line.direction, sense) {
            return None;
        }
        let sweep = turned(&root.arrival.direction, &line.direction, sense);
        (sweep >= -STRAIGHT && sweep <= root.most_sweep + STRAIGHT).then_some(sweep.max(0.0))
    }

    /// The length of the path to the end of a line that leaves a root after a sweep, metres.
    fn length_to(&self, index: u32, line: &Tangent, sweep: f64) -> f64 {
        let root = &self.search.roots[index as usize];
        root.length + root.circle.signed_radius.abs() * sweep + line.length
    }
}

fn slot(vertex: u32, sense: f64) -> usize {
    2 * vertex as usize + usize::from(sense < 0.0)
}
