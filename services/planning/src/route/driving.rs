//! The mover of a robot: it turns about corners on guiding circles.

use super::label::{Label, NONE};
use super::mover::{Mover, SearchStep};
use super::{SAME_LENGTH, Search, Traveller};
use crate::budget::{Budget, Spent};
use crate::driving::rules::TurnRule;
use crate::driving::tangent::{Circle, Tangent, tangent};
use crate::free_space::walls::Walls;
use crate::free_space::{End, Junction};
use crate::geometry::box_tree::distance_squared_box_box;
use crate::geometry::distance::distance_segment_segment;
use crate::geometry::{AxisBox, Sign, Vector, unrotated};
use cone::Cone;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

mod cone;

/// Steps of the budget that a line takes against one wall.
const STEPS_PER_WALL: u64 = 3;

/// A robot whose path is taut about the guiding circles (equation 5.1) of its corners.
///
/// The taut path through a chain turns about some corners and passes the others at a
/// distance, in a straight line from one circle to a later one. So the search opens two
/// labels at a junction: one that turns there, and one that passes, with the circle that the
/// line leaves and the cone of directions in which it passes all junctions so far. Of the
/// ways that turn about a corner the shortest is best whatever follows; of those that pass,
/// one is useless if another leaves the same circle with a cone that contains its own.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotMover {
    traveller: Traveller<2>,
    goal: Vector<2>,
    radius: f64,
    half_width: f64,
    /// Straight lines between circles that are ruled out.
    blocked: Vec<[Circle; 2]>,
}

/// How a junction is passed.
#[derive(Debug, Clone, Copy)]
pub enum Passing {
    /// On its corner's guiding circle.
    Turning {
        /// The circle.
        circle: Circle,
        /// Direction of the line that arrives there (unit vector).
        arrival: Vector<2>,
        /// The label of the circle that the line leaves; `NONE` for the start.
        root: u32,
    },
    /// Straight on, at a distance from its corner.
    Straight {
        /// The label of the circle that the line leaves; `NONE` for the start.
        root: u32,
        /// The directions of lines that pass every junction since.
        cone: Cone,
    },
}

/// The circle, or the start, that a straight line leaves.
#[derive(Debug, Clone, Copy)]
struct Root {
    /// Its label; `NONE` for the start.
    index: u32,
    circle: Circle,
    /// Direction in which the path arrives; `None` at the start.
    arrival: Option<Vector<2>>,
    /// Length of the path until there, metres.
    length: f64,
    /// Directions in which it can be left.
    cone: Cone,
}

impl Root {
    /// Where the path arrives.
    fn begin(&self) -> Vector<2> {
        let Circle { center, signed_radius } = self.circle;
        let normal = |arrival: Vector<2>| Vector::<2>::new(-arrival.y, arrival.x);
        self.arrival.map_or(center, |arrival| center - normal(arrival) * signed_radius)
    }

    /// Length of the path to the end of a line that leaves it, metres.
    fn length_with(&self, line: &Tangent) -> f64 {
        let Some(arrival) = &self.arrival else { return line.length };
        let swept = angle(arrival, &line.direction, sense(&self.circle)).max(0.0);
        self.length + self.circle.signed_radius.abs() * swept + line.length
    }

    /// The directions of lines that lead through a junction and stay outside the guiding circle
    /// of its corner.
    fn cone_through(&self, junction: &AxisBox<2>, circle: &Circle) -> Option<Cone> {
        let past = tangent(&self.circle, circle)?.direction;
        let past = self.cone.common(&Cone::half(&past, sense(circle).opposite()))?;
        let (min, max) = (junction.min(), junction.max());
        let corners = [min, Vector::<2>::new(max.x, min.y), max, Vector::<2>::new(min.x, max.y)];
        let lines = corners.map(|corner| tangent(&self.circle, &point(corner)));
        let directions = lines.iter().flatten().map(|line| &line.direction);
        if distance_to(junction, &self.circle.center) > self.circle.signed_radius.abs() {
            return Cone::around(directions).common(&past);
        }
        // If the start lies in the junction, or the arc leads into it or begins there. Only if
        // all of it lies ahead can no line leave the arc too early to lead into it.
        let Some(arrival) = &self.arrival else { return Some(past) };
        let turn = sense(&self.circle);
        let angles = directions.map(|direction| (angle(arrival, direction, turn), direction));
        match angles.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((angle, first)) if angle > 0.0 => Cone::half(first, turn).common(&past),
            _ => Some(past),
        }
    }
}

impl RobotMover {
    /// A robot of this width whose centre goes from `position` to `goal` through junctions
    /// larger than `needs` along every axis, and that keeps this gap from corners; all in
    /// metres.
    pub fn new(
        position: Vector<2>,
        goal: Vector<2>,
        needs: Vector<2>,
        (width, gap): (f64, f64),
    ) -> Self {
        let end = End::Goal(goal);
        let (least, greatest) = (position, position);
        let traveller = Traveller { least, greatest, needs, gap: Vector::zeros(), end };
        // (5.1)
        let (half_width, radius) = (width / 2.0, width / 2.0 + gap);
        Self { traveller, goal, radius, half_width, blocked: Vec::new() }
    }

    /// The guiding circle of the corner of a junction (equation 5.1).
    fn guiding_circle(&self, junction: &Junction<2>) -> Option<Circle> {
        let rule = TurnRule::of(junction.approach, junction.leaving)?;
        let signed_radius = rule.turn.factor() * self.radius;
        Some(Circle { center: rule.corner_of(&junction.space), signed_radius })
    }

    /// The root of the line that the way to a label (`NONE` for the start) is on; `None` if a
    /// better way there has been found.
    fn root(&self, labels: &[Label<Passing>], from: u32) -> Option<Root> {
        let (index, passed) = match labels.get(from as usize).map(|label| &label.state) {
            Some(Passing::Straight { root, cone }) => (*root, Some(*cone)),
            _ => (from, None),
        };
        if labels.get(index as usize).is_some_and(|label| label.beaten) {
            return None;
        }
        let root = self.root_of(labels, index);
        Some(Root { cone: passed.unwrap_or(root.cone), ..root })
    }

    /// The circle of a turning label; otherwise the start.
    fn root_of(&self, labels: &[Label<Passing>], index: u32) -> Root {
        match labels.get(index as usize).map(|label| (label.length, &label.state)) {
            Some((length, Passing::Turning { circle, arrival, .. })) => Root {
                index,
                circle: *circle,
                arrival: Some(*arrival),
                length,
                cone: Cone::half(arrival, sense(circle)),
            },
            _ => Root {
                index: NONE,
                circle: point(self.traveller.least),
                arrival: None,
                length: 0.0,
                cone: Cone::ALL,
            },
        }
    }

    /// The line from a root to a circle, if the cone holds it and no wall blocks it.
    fn line(
        &self,
        search: &Search<'_, 2>,
        root: &Root,
        circle: &Circle,
    ) -> Result<Option<Tangent>, Spent> {
        let Some(line) = tangent(&root.circle, circle) else { return Ok(None) };
        let blocked = || !self.blocked.is_empty() && self.blocked.contains(&[root.circle, *circle]);
        let passes = root.cone.holds(&line.direction) && !blocked();
        let is_free = passes
            && match search.walls {
                Some(walls) => self.is_clear(walls, &line, search.budget)?,
                None => true,
            };
        Ok(is_free.then_some(line))
    }

    /// Whether the robot's sides touch no wall along a line.
    fn is_clear(
        &self,
        walls: &Walls<2>,
        line: &Tangent,
        budget: &Budget<'_>,
    ) -> Result<bool, Spent> {
        let (from, to) = (&line.from, &line.to);
        let (mut clear, mut near) = (true, 0);
        walls.near(&from.inf(to), &from.sup(to), self.half_width, budget, |_, wall| {
            near += 1;
            let closest = || distance_segment_segment((from, to), (&wall.from, &wall.to));
            clear = clear && closest().distance > self.half_width;
        })?;
        budget.step(STEPS_PER_WALL * near)?;
        Ok(clear)
    }

    /// Whether two roots are the same circle, reached alike.
    fn is_same(&self, labels: &[Label<Passing>], one: u32, other: u32) -> bool {
        one == other || {
            let [one, other] = [one, other].map(|index| self.root_of(labels, index));
            one.circle == other.circle
                && one.arrival == other.arrival
                && (one.length - other.length).abs() <= SAME_LENGTH
        }
    }

    /// Whether one way that turns about a corner makes another useless. Both arrive at the same
    /// circle; the one goes on (or back) along it to where the other arrives.
    fn beats(
        &self,
        (one, arrival): (f64, &Vector<2>),
        (other, later): (f64, &Vector<2>),
        circle: &Circle,
    ) -> bool {
        // The angle rarely decides.
        let most = self.radius * PI;
        one + most <= other
            || one - most <= other
                && one + self.radius * angle(arrival, later, sense(circle)) <= other
    }
}

fn point(center: Vector<2>) -> Circle {
    Circle { center, signed_radius: 0.0 }
}

/// The sense in which a circle is run around.
fn sense(circle: &Circle) -> Sign {
    Sign::of(circle.signed_radius)
}

/// The angle from one direction to another in the sense of a turn, radians in [-pi, pi].
fn angle(from: &Vector<2>, to: &Vector<2>, turn: Sign) -> f64 {
    let turned = unrotated(to, from);
    libm::atan2(turn.factor() * turned.y, turned.x)
}

/// The distance of a box from a point, metres; 0 if it holds the point.
fn distance_to(space: &AxisBox<2>, point: &Vector<2>) -> f64 {
    let ends = (&space.min(), &space.max());
    distance_squared_box_box(ends, (point, point)).sqrt()
}

impl Mover<2> for RobotMover {
    type State = Passing;

    fn traveller(&self) -> &Traveller<2> {
        &self.traveller
    }

    /// Straight lines between the points where the bisector of each corner meets its guiding
    /// circle: the middle of the arc of a quarter turn.
    fn outline(&self) -> Option<f64> {
        Some(self.radius * FRAC_1_SQRT_2)
    }

    fn enter(
        &self,
        search: &Search<'_, 2>,
        labels: &[Label<Passing>],
        from: u32,
        junction: &Junction<2>,
    ) -> Result<[Option<SearchStep<Passing>>; 2], Spent> {
        let (Some(circle), Some(root)) = (self.guiding_circle(junction), self.root(labels, from))
        else {
            return Ok([None; 2]);
        };
        let (space, index) = (&junction.space, root.index);
        let turning = self.line(search, &root, &circle)?.map(|line| {
            let length = root.length_with(&line);
            let state = Passing::Turning { circle, arrival: line.direction, root: index };
            SearchStep { state, length, estimate: length + (self.goal - line.to).norm() }
        });
        let straight = root.cone_through(space, &circle).map(|cone| {
            let (state, begin) = (Passing::Straight { root: index, cone }, root.begin());
            let over = distance_to(space, &begin) + distance_to(space, &self.goal);
            let estimate = root.length + over.max((self.goal - begin).norm());
            SearchStep { state, length: root.length, estimate }
        });
        Ok([turning, straight])
    }

    fn finish(
        &self,
        search: &Search<'_, 2>,
        labels: &[Label<Passing>],
        from: u32,
    ) -> Result<Option<f64>, Spent> {
        if from == NONE && self.goal == self.traveller.least {
            return Ok(Some(0.0));
        }
        let Some(root) = self.root(labels, from) else { return Ok(None) };
        let line = self.line(search, &root, &point(self.goal))?;
        Ok(line.map(|line| root.length_with(&line)))
    }

    fn compare(
        &self,
        labels: &mut [Label<Passing>],
        new: &Label<Passing>,
        looks: &mut usize,
    ) -> bool {
        let mut at = new.next;
        while let Some(known) = labels.get(at as usize).copied() {
            let index = at as usize;
            at = known.next;
            *looks += 1;
            if known.beaten || known.directions != new.directions {
                continue;
            }
            match (&known.state, &new.state) {
                (
                    Passing::Turning { circle, arrival: one, .. },
                    Passing::Turning { arrival: other, .. },
                ) => {
                    if self.beats((known.length, one), (new.length, other), circle) {
                        return false;
                    }
                    labels[index].beaten =
                        self.beats((new.length, other), (known.length, one), circle);
                }
                (
                    Passing::Straight { root: one, cone: around },
                    Passing::Straight { root: other, cone: within },
                ) if self.is_same(labels, *one, *other) => {
                    if around.contains(within) {
                        return false;
                    }
                    labels[index].beaten = within.contains(around);
                }
                _ => {}
            }
        }
        true
    }

    fn avoid(&mut self, labels: &[Label<Passing>], last: u32, junction: Option<usize>) -> bool {
        let Some(Root { index: mut from, .. }) = self.root(labels, last) else { return false };
        let mut line = [point(self.traveller.least), point(self.goal)];
        // The line that leads to the corner of the junction, or passes it at a distance.
        let passed = junction.map_or(usize::MAX, |junction| junction + 1);
        while let Some(label) = labels.get(from as usize)
            && let Passing::Turning { circle, root, .. } = &label.state
        {
            if (label.junctions as usize) < passed {
                line[0] = *circle;
                break;
            }
            (from, line[1]) = (*root, *circle);
        }
        self.blocked.push(line);
        true
    }
}
