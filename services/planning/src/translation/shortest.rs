//! The shortest way out among sums.
//!
//! A* over the vertices of those sums that turned out to be in the way. A line is looked at only
//! when its turn comes; the sum that lies in its way is then known from there on, and every place
//! reached so far gets the lines that touch it. At any moment the known sums have a shortest way
//! that is no longer than the one sought, and the first line of it that has not been looked at is
//! in the queue. So the first way that is complete is the shortest; and where the queue is empty,
//! there is none.
//!
//! A taut way goes on from a place only within a wedge: from straight on to along the sum that it
//! turns about. Most known sums have nothing in it. Each place keeps a list of the others: they
//! alone can be in the way of its lines, the nearest of them of nearly all.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use super::blocks::NONE;
use super::sums::{Shift, SumPolygon, Sums};
use crate::budget::{Budget, Held, Spent};
use crate::geometry::distance::{cross, distance_point_segment};
use crate::geometry::orientation::Side;
use crate::geometry::{Direction, Vector, polygon};

/// Steps that a line takes which is put into the queue.
const STEPS_PER_LINE: u64 = 4;

/// Bytes that a place takes, a vertex of a known sum, and a line in the queue.
const BYTES_PER_PLACE: usize = 160;
const BYTES_PER_VERTEX: usize = 64;
const BYTES_PER_LINE: usize = 64;

/// Where a way out ends: at this displacement along an axis, or beyond.
#[derive(Debug, Clone, Copy)]
pub(super) struct Out {
    pub(super) exit: Direction,
    /// Along the exit, metres; greater than 0.
    pub(super) distance: f64,
}

impl Out {
    fn missing(&self, at: &Vector<2>) -> f64 {
        (self.distance - self.exit.coordinate(at)).max(0.0)
    }

    /// The place on the line of the goal beside `at`, exactly on it.
    fn beside(&self, at: &Vector<2>) -> Vector<2> {
        let mut to = *at;
        to[self.exit.axis] = self.exit.sign.factor() * self.distance;
        to
    }
}

/// A displacement that can be reached.
#[derive(Debug)]
struct Settled {
    at: Vector<2>,
    /// The side on which the sum is that the way touches here; `None` at the start.
    side: Option<Side>,
    /// The way arrives in this direction, a unit vector, on a line of this length, metres; zero if
    /// that is too short to tell.
    arriving: (Vector<2>, f64),
    /// What is on the right of one of these directions is aside: a way that goes on there would turn
    /// away from that sum, or into it. Zero where there is no telling.
    wedge: [Vector<2>; 2],
    length: f64,
    before: usize,
    /// The known sums that reach into what lies ahead; first what was in the way last.
    ahead: Vec<u32>,
}

impl Settled {
    /// `off` where sums are on the left, and the opposite where they are on the right; 0 at the start.
    fn turned(&self, off: f64) -> f64 {
        match self.side {
            Some(Side::Left) => off,
            Some(_) => -off,
            None => 0.0,
        }
    }
}

/// A vertex of known sums.
#[derive(Debug, Clone, Copy)]
struct SumCorner {
    /// The place there where sums are on the left of the way, and where they are on the right.
    places: [Option<u32>; 2],
    /// Whether it is known to be inside of a sum: no way leads there.
    is_buried: bool,
}

impl SumCorner {
    fn place(&self, side: Side) -> Option<u32> {
        self.places[usize::from(side != Side::Left)]
    }

    fn set_place(&mut self, side: Side, place: u32) {
        self.places[usize::from(side != Side::Left)] = Some(place);
    }
}

/// A sum that has been in the way.
#[derive(Debug)]
struct KnownSum {
    sum: usize,
    /// A circle around it.
    around: (Vector<2>, f64),
    /// The corner at each vertex, `NONE` where no line has led yet.
    corners: Vec<u32>,
    /// Where it meets the line of the goal.
    ends: Vec<Vector<2>>,
}

/// Where a line leads.
#[derive(Debug, Clone, Copy)]
enum LineEnd {
    /// To the goal.
    Goal,
    /// To a corner, a sum being on this side; along the side of the sum that follows.
    Vertex { corner: u32, side: Side, along: Vector<2> },
}

/// A line that may be part of the way.
#[derive(Debug, Clone, Copy)]
struct Line {
    /// The least length of a way along it.
    least: f64,
    /// The order in which lines were found.
    turn: u64,
    from: usize,
    /// The length to its beginning when it was found.
    length: f64,
    to: Vector<2>,
    target: LineEnd,
}

impl PartialEq for Line {
    fn eq(&self, other: &Self) -> bool {
        self.turn == other.turn
    }
}

impl Eq for Line {}

impl PartialOrd for Line {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Line {
    /// The greatest is looked at first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.total_cmp(&self.least).then(other.turn.cmp(&self.turn))
    }
}

struct WaySearch<'s, 'a, 'b> {
    sums: &'s mut Sums<'a>,
    out: Out,
    budget: &'b Budget<'b>,
    held: Held<'b>,
    places: Vec<Settled>,
    corners: Vec<SumCorner>,
    /// By the bits of the coordinates: sums share corners.
    corner_at: BTreeMap<(u64, u64), u32>,
    queue: BinaryHeap<Line>,
    turn: u64,
    known: Vec<KnownSum>,
    bytes: usize,
    /// Memory for lines that were found.
    found: Vec<(Vector<2>, LineEnd)>,
}

/// The shortest way from no displacement to the goal, both included; `None` where there is none.
pub(super) fn shortest(
    sums: &mut Sums<'_>,
    out: Out,
    budget: &Budget<'_>,
) -> Result<Option<Vec<Vector<2>>>, Spent> {
    let mut search = WaySearch {
        sums,
        out,
        budget,
        held: Held::new(budget, 0)?,
        places: Vec::new(),
        corners: Vec::new(),
        corner_at: BTreeMap::new(),
        queue: BinaryHeap::new(),
        turn: 0,
        known: Vec::new(),
        bytes: 0,
        found: Vec::new(),
    };
    let nowhere = Vector::zeros();
    let start = Settled {
        at: nowhere,
        side: None,
        arriving: (nowhere, 0.0),
        wedge: [nowhere; 2],
        length: 0.0,
        before: 0,
        ahead: Vec::new(),
    };
    search.places.push(start);
    search.expand(0)?;
    while let Some(line) = search.queue.pop() {
        budget.step(1)?;
        let Line { from, to, target, length, .. } = line;
        let begin = &search.places[from];
        if begin.length < length {
            continue;
        }
        let shift = Shift::new(&begin.at, &to);
        let length = length + shift.length();
        if search.is_beaten(target, length) || search.is_blocked(from, &shift)? {
            continue;
        }
        if let Some(sum) = search.sums.in_the_way(&shift, budget)? {
            search.learn(sum)?;
            continue;
        }
        match target {
            LineEnd::Goal => return Ok(Some(search.way(from, to))),
            LineEnd::Vertex { corner, side, along } => {
                search.reach((corner, side), (to, along), (from, length))?;
            }
        }
    }
    Ok(None)
}

impl WaySearch<'_, '_, '_> {
    fn is_beaten(&self, target: LineEnd, length: f64) -> bool {
        let LineEnd::Vertex { corner, side, .. } = target else { return false };
        let place = self.corners[corner as usize].place(side);
        place.is_some_and(|place| self.places[place as usize].length <= length)
    }

    /// Arrives at a corner from a place, by a way of this length.
    fn reach(
        &mut self,
        (corner, side): (u32, Side),
        (at, along): (Vector<2>, Vector<2>),
        (before, length): (usize, f64),
    ) -> Result<(), Spent> {
        let least = self.least();
        let towards = |line: Vector<2>| {
            let length = line.norm();
            if length > least { (line / length, length) } else { (Vector::zeros(), 0.0) }
        };
        let arriving = towards(at - self.places[before].at);
        // From straight on to along the side of that sum that follows.
        let turned = if side == Side::Left { 1.0 } else { -1.0 };
        let place = Settled {
            at,
            side: Some(side),
            arriving,
            wedge: [arriving.0 * turned, towards(along).0 * -turned],
            length,
            before,
            ahead: Vec::new(),
        };
        let index = match self.corners[corner as usize].place(side) {
            Some(index) => {
                self.places[index as usize] = place;
                index as usize
            }
            None => {
                self.take(BYTES_PER_PLACE)?;
                self.places.push(place);
                let index = self.places.len() - 1;
                self.corners[corner as usize].set_place(side, named(index));
                index
            }
        };
        self.expand(index)
    }

    fn take(&mut self, bytes: usize) -> Result<(), Spent> {
        self.bytes += bytes;
        self.held.resize(self.bytes)
    }

    /// Whether a known sum is in the way of a line from a place.
    fn is_blocked(&mut self, from: usize, shift: &Shift) -> Result<bool, Spent> {
        let ahead = &mut self.places[from].ahead;
        let found = ahead.iter().position(|known| {
            let KnownSum { sum, around, .. } = &self.known[*known as usize];
            shift.comes_near(around) && self.sums.polygon(*sum).is_entered_by(shift)
        });
        self.budget.step(1 + found.map_or(ahead.len(), |at| at + 1) as u64)?;
        if let Some(at) = found {
            // Most likely it is in the way of the next line as well.
            ahead[..=at].rotate_right(1);
        }
        Ok(found.is_some())
    }

    /// Remembers of a line's end if it is inside the sum that is in the way of the line, which is the
    /// first of those ahead.
    fn bury(&mut self, from: usize, target: LineEnd, to: &Vector<2>) {
        let LineEnd::Vertex { corner, .. } = target else { return };
        let Some(known) = self.places[from].ahead.first() else { return };
        let sum = self.known[*known as usize].sum;
        self.corners[corner as usize].is_buried = self.sums.polygon(sum).holds(to);
    }

    /// Puts all lines from a place into the queue.
    fn expand(&mut self, from: usize) -> Result<(), Spent> {
        let at = self.places[from].at;
        let goal = if self.out.missing(&at) > 0.0 { self.out.beside(&at) } else { at };
        self.found.clear();
        self.found.push((goal, LineEnd::Goal));
        self.budget.step(self.known.len() as u64 / 2)?;
        for known in 0..self.known.len() {
            if !self.is_aside(&self.places[from], &self.known[known].around) {
                self.look_at(from, known)?;
            }
        }
        self.push_found(from)
    }

    /// A sum is in the way.
    fn learn(&mut self, sum: usize) -> Result<(), Spent> {
        if !self.sums.learn(sum) {
            return Ok(());
        }
        let vertices = self.sums.polygon(sum).vertices();
        let exit = self.out.exit;
        let beyond = |vertex: &Vector<2>| exit.coordinate(vertex) - self.out.distance;
        let ends = polygon::edges(vertices).filter_map(|(a, b)| {
            let (before, after) = (beyond(&a), beyond(&b));
            let place = a + (b - a) * (before / (before - after));
            ((before < 0.0) != (after < 0.0)).then(|| self.out.beside(&place))
        });
        let ends = ends.collect();
        let corners = vec![NONE; vertices.len()];
        self.budget.step(STEPS_PER_LINE * corners.len() as u64)?;
        self.take(BYTES_PER_VERTEX * corners.len())?;
        let around = self.sums.polygon(sum).around();
        self.known.push(KnownSum { sum, around, corners, ends });
        self.budget.step(self.places.len() as u64 / 2)?;
        for from in 0..self.places.len() {
            if self.is_aside(&self.places[from], &around) {
                continue;
            }
            self.found.clear();
            self.look_at(from, self.known.len() - 1)?;
            self.push_found(from)?;
        }
        Ok(())
    }

    /// Finds the lines from a place to a known sum: those that touch it, and those to where it meets
    /// the line of the goal. None if the sum is aside, which its circle may not have told.
    fn look_at(&mut self, from: usize, known: usize) -> Result<(), Spent> {
        let polygon = self.sums.polygon(self.known[known].sum);
        self.budget.step(2)?;
        if self.has_aside(&self.places[from], polygon) {
            return Ok(());
        }
        let vertices = polygon.vertices();
        let count = vertices.len();
        self.budget.step(1 + count as u64 / 2)?;
        let place = &mut self.places[from];
        place.ahead.push(named(known));
        let at = place.at;
        let KnownSum { corners: names, ends, .. } = &mut self.known[known];
        polygon.touching(&at, self.sums.rounding(), |index, vertex, side| {
            let next = if side == Side::Left { index + 1 } else { index + count - 1 };
            let along = vertices[next % count] - vertex;
            if names[index] == NONE {
                names[index] = name_of(vertex, &mut self.corner_at, &mut self.corners);
            }
            let corner = names[index];
            if !self.corners[corner as usize].is_buried {
                self.found.push((*vertex, LineEnd::Vertex { corner, side, along }));
            }
        });
        self.found.extend(ends.iter().map(|end| (*end, LineEnd::Goal)));
        self.take(size_of::<u32>())
    }

    /// Puts those of the lines that were found from a place into the queue which may be part of a taut
    /// way, and of one that is shorter than those known.
    fn push_found(&mut self, from: usize) -> Result<(), Spent> {
        for index in 0..self.found.len() {
            let (to, target) = self.found[index];
            let place = &self.places[from];
            let shift = Shift::new(&place.at, &to);
            let length = place.length + shift.length();
            if !self.goes_on(place, &shift) || self.is_beaten(target, length) {
                continue;
            }
            if self.is_blocked(from, &shift)? {
                self.bury(from, target, &to);
                continue;
            }
            let left = match target {
                LineEnd::Goal => 0.0,
                LineEnd::Vertex { .. } => self.out.missing(&to),
            };
            let (least, turn) = (length + left, self.turn);
            let length = self.places[from].length;
            self.turn += 1;
            self.budget.step(STEPS_PER_LINE)?;
            self.take(BYTES_PER_LINE)?;
            self.queue.push(Line { least, turn, from, length, to, target });
        }
        Ok(())
    }

    /// Whether a taut way that arrives at a place can go on like this: straight on, or towards the
    /// side of the sum that it touches there.
    fn goes_on(&self, place: &Settled, shift: &Shift) -> bool {
        let (arriving, before) = &place.arriving;
        let (way, after, least) = (shift.along(), shift.length(), self.least());
        if *before == 0.0 || after <= least {
            return true;
        }
        // How far the way turns off from straight on.
        let off = place.turned(cross(arriving, way)) * (before / before.max(after));
        off >= -least && (off > least || arriving.dot(way) > 0.0)
    }

    /// Whether no way that goes on from a place leads to a sum: it would turn away from the sum that it
    /// touches there, or into it.
    fn has_aside(&self, place: &Settled, sum: &SumPolygon) -> bool {
        let beyond = -2.0 * self.least();
        place.wedge.iter().any(|side| sum.is_right_of((&place.at, side), beyond))
    }

    /// The same of a circle.
    fn is_aside(&self, place: &Settled, (center, radius): &(Vector<2>, f64)) -> bool {
        let to = center - place.at;
        let beyond = -(radius + 2.0 * self.least());
        place.wedge.iter().any(|side| cross(side, &to) < beyond)
    }

    /// Shorter lines have no direction, metres.
    fn least(&self) -> f64 {
        4.0 * self.sums.tolerance()
    }

    /// The way to a place and from there to the end, but for places where it goes straight on: the part
    /// would stop there.
    fn way(&self, from: usize, to: Vector<2>) -> Vec<Vector<2>> {
        let mut way = vec![to];
        let mut at = from;
        loop {
            let place = &self.places[at];
            let last = way[way.len() - 1];
            if place.side.is_none() {
                way.push(place.at);
                break;
            }
            let before = self.places[place.before].at;
            let bend = distance_point_segment(&place.at, (&before, &last));
            if bend > self.sums.rounding() {
                way.push(place.at);
            }
            at = place.before;
        }
        way.reverse();
        way
    }
}

/// The corner at a vertex, which sums may share.
fn name_of(
    vertex: &Vector<2>,
    known: &mut BTreeMap<(u64, u64), u32>,
    corners: &mut Vec<SumCorner>,
) -> u32 {
    // No negative zero.
    let key = ((vertex.x + 0.0).to_bits(), (vertex.y + 0.0).to_bits());
    *known.entry(key).or_insert_with(|| {
        corners.push(SumCorner { places: [None; 2], is_buried: false });
        named(corners.len() - 1)
    })
}

fn named(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(NONE)
}
