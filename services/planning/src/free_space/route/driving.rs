//! A robot that turns about corners on guiding circles.

use super::Search;
use super::label::{Label, NONE};
use super::traveller::{Motion, Step, Traveller};
use crate::driving::rules::TurnRule;
use crate::driving::tangent::{Circle, Tangent, tangent};
use crate::free_space::{Corner, End};
use crate::geometry::box_tree::distance_squared_box_box;
use crate::geometry::{AxisBox, Sign, Vector, unrotated};
use cone::Cone;
use std::f64::consts::PI;

mod cone;

/// A robot whose path is drawn taut about the guiding circles (equation 5.1) of the
/// corners it passes.
///
/// The taut path through a chain turns about some of its corners and passes the others
/// at a distance, in a straight line from one circle to a later one. So the search opens
/// two labels at a junction: one that turns there, and one that passes, which keeps the
/// circle that the line leaves and the [`Cone`] of directions in which it passes all
/// junctions so far. Of the ways that turn about a corner the shortest is the best
/// whatever follows; of those that pass, one is useless beside another with the same
/// circle and a cone around its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Driving {
    traveller: Traveller<2>,
    goal: Vector<2>,
    radius: f64,
    /// Straight lines from one circle to another that are not to be followed.
    blocked: Vec<[Circle; 2]>,
}

/// How a junction is passed.
#[derive(Debug, Clone, Copy)]
pub enum Passage {
    /// On its corner's guiding circle.
    Turning {
        /// The circle.
        circle: Circle,
        /// Direction of the line that arrives there (unit vector).
        arrival: Vector<2>,
        /// The label of the circle that the line leaves; `NONE`: the start.
        root: u32,
    },
    /// Straight on, its corner at a distance.
    Straight {
        /// The same.
        root: u32,
        /// Directions of lines that pass every junction since.
        cone: Cone,
    },
}

/// What a straight line leaves.
struct Root<'a> {
    label: Option<&'a Label<Passage>>,
    circle: Circle,
    cone: Cone,
}

impl Driving {
    /// A robot whose centre is at `position` and is to come to `goal`, that passes
    /// junctions larger than `needs` on every axis (metres), and turns about corners on
    /// guiding circles with this radius.
    pub fn new(position: Vector<2>, goal: Vector<2>, needs: Vector<2>, radius: f64) -> Self {
        let end = End::Goal(goal);
        let (least, greatest, gap) = (position, position, Vector::zeros());
        let traveller = Traveller { least, greatest, needs, gap, end };
        Self { traveller, goal, radius, blocked: Vec::new() }
    }

    /// The circle of a label that turns; the start where there is none.
    fn circle(&self, label: Option<&Label<Passage>>) -> Circle {
        match label.map(|label| &label.state) {
            Some(Passage::Turning { circle, .. }) => *circle,
            _ => point(self.traveller.least),
        }
    }

    /// The line that the way to a label is on, or leaves its circle on, and the label of
    /// the circle.
    fn root<'a>(&self, labels: &'a [Label<Passage>], from: u32) -> (u32, Root<'a>) {
        let (index, cone) = match labels.get(from as usize).map(|label| &label.state) {
            None => (NONE, Cone::ALL),
            Some(Passage::Straight { root, cone }) => (*root, *cone),
            Some(Passage::Turning { circle, arrival, .. }) => {
                (from, Cone::half(arrival, sense(circle)))
            }
        };
        let label = labels.get(index as usize);
        (index, Root { label, circle: self.circle(label), cone })
    }

    /// The line from a root to a circle, if the cone holds it and it is not blocked.
    fn line(&self, root: &Root<'_>, circle: &Circle) -> Option<Tangent> {
        let line = tangent(&root.circle, circle)?;
        let open = self.blocked.is_empty() || !self.blocked.contains(&[root.circle, *circle]);
        (root.cone.holds(&line.direction) && open).then_some(line)
    }

    /// The directions of lines from a root that lead through a junction and pass its corner
    /// at more than the guiding circle's radius.
    fn cone_through(root: &Root<'_>, junction: &AxisBox<2>, circle: &Circle) -> Option<Cone> {
        let past = tangent(&root.circle, circle)?.direction;
        let past = root.cone.common(&Cone::half(&past, sense(circle).opposite()))?;
        let (min, max) = (junction.min(), junction.max());
        let corners = [min, Vector::<2>::new(max.x, min.y), max, Vector::<2>::new(min.x, max.y)];
        let lines = corners.map(|corner| tangent(&root.circle, &point(corner)));
        let directions = lines.iter().flatten().map(|line| &line.direction);
        if distance_to(junction, &root.circle.center) > root.circle.signed_radius.abs() {
            return Cone::around(directions).common(&past);
        }
        let Some(Passage::Turning { arrival, .. }) = root.label.map(|label| &label.state) else {
            // The start lies in the junction.
            return Some(past);
        };
        // The arc about the root's corner may lead into the junction itself, or begin there;
        // only where all of it lies ahead can the line not leave the arc before it can lead
        // into it.
        let turn = sense(&root.circle);
        let angles = directions.map(|direction| (angle(arrival, direction, turn), direction));
        let first = angles.min_by(|a, b| a.0.total_cmp(&b.0));
        match first {
            Some((angle, direction)) if angle > 0.0 => Cone::half(direction, turn).common(&past),
            _ => Some(past),
        }
    }

    /// Length of the path that leaves a root along a line, metres.
    fn length(&self, root: &Root<'_>, line: &Tangent) -> f64 {
        let Some(label) = root.label else { return line.length };
        let Passage::Turning { circle, arrival, .. } = &label.state else { return f64::NAN };
        let arc = self.radius * angle(arrival, &line.direction, sense(circle)).max(0.0);
        label.length + arc + line.length
    }

    /// Whether a way that turns about a corner is no longer than another: both arrive on
    /// the same circle, and one goes on (or back) along it to where the other arrives.
    fn beats(
        &self,
        (one, arrival): (f64, &Vector<2>),
        (other, later): (f64, &Vector<2>),
        circle: &Circle,
    ) -> bool {
        // Seldom is it so close that the angle decides.
        let most = self.radius * PI;
        one + most <= other
            || one - most <= other
                && one + self.radius * angle(arrival, later, sense(circle)) <= other
    }
}

fn point(center: Vector<2>) -> Circle {
    Circle { center, signed_radius: 0.0 }
}

/// Which way a circle is run around.
fn sense(circle: &Circle) -> Sign {
    Sign::of(circle.signed_radius)
}

/// The angle from one direction to another in the sense of a turn, in [-pi, pi].
fn angle(from: &Vector<2>, to: &Vector<2>, turn: Sign) -> f64 {
    let turned = unrotated(to, from);
    libm::atan2(turn.factor() * turned.y, turned.x)
}

/// How far a box is from a point; 0 if it holds it.
fn distance_to(space: &AxisBox<2>, point: &Vector<2>) -> f64 {
    let ends = (&space.min(), &space.max());
    distance_squared_box_box(ends, (point, point)).sqrt()
}

impl Motion<2> for Driving {
    type State = Passage;

    fn traveller(&self) -> &Traveller<2> {
        &self.traveller
    }

    fn enter(
        &self,
        _: &Search<'_, 2>,
        labels: &[Label<Passage>],
        from: u32,
        corner: &Corner<2>,
    ) -> [Option<Step<Passage>>; 2] {
        let Some(rule) = TurnRule::of(corner.approach, corner.leaving) else { return [None; 2] };
        let (index, root) = self.root(labels, from);
        if root.label.is_some_and(|label| label.beaten) {
            return [None; 2];
        }
        let center = rule.corner_of(&corner.junction);
        let circle = Circle { center, signed_radius: rule.turn.factor() * self.radius };

        let turning = self.line(&root, &circle).map(|line| {
            let length = self.length(&root, &line);
            let state = Passage::Turning { circle, arrival: line.direction, root: index };
            Step { state, length, estimate: length + (self.goal - line.to).norm() }
        });
        let cone = Self::cone_through(&root, &corner.junction, &circle);
        let straight = cone.map(|cone| {
            let state = Passage::Straight { root: index, cone };
            let (length, begin) = match root.label {
                None => (0.0, root.circle.center),
                // Where the path arrives on the circle.
                Some(label) => (label.length, self.arrival_point(label)),
            };
            let [to, from] = [&begin, &self.goal].map(|end| distance_to(&corner.junction, end));
            let estimate = length + (self.goal - begin).norm().max(to + from);
            Step { state, length, estimate }
        });
        [turning, straight]
    }

    fn finish(&self, _: &Search<'_, 2>, labels: &[Label<Passage>], from: u32) -> Option<f64> {
        if from == NONE && self.goal == self.traveller.least {
            return Some(0.0);
        }
        let (_, root) = self.root(labels, from);
        self.line(&root, &point(self.goal)).map(|line| self.length(&root, &line))
    }

    fn compare(&self, labels: &mut [Label<Passage>], new: &Label<Passage>) -> bool {
        let mut at = new.next;
        while let Some(known) = labels.get_mut(at as usize) {
            at = known.next;
            if known.beaten || known.way != new.way {
                continue;
            }
            match (&known.state, &new.state) {
                (
                    Passage::Turning { circle, arrival: one, .. },
                    Passage::Turning { arrival: other, .. },
                ) => {
                    if self.beats((known.length, one), (new.length, other), circle) {
                        return false;
                    }
                    known.beaten = self.beats((new.length, other), (known.length, one), circle);
                }
                (
                    Passage::Straight { root: one, cone: around },
                    Passage::Straight { root: other, cone: within },
                ) if one == other => {
                    if around.contains(within) {
                        return false;
                    }
                    known.beaten = within.contains(around);
                }
                _ => {}
            }
        }
        true
    }

    fn avoid(&mut self, labels: &[Label<Passage>], last: u32, junction: Option<usize>) -> bool {
        let mut to = point(self.goal);
        let (_, mut root) = self.root(labels, last);
        // The line that leads to the junction's corner, or passes it at a distance.
        let passed = junction.map_or(usize::MAX, |junction| junction + 1);
        while let Some(label) = root.label
            && label.junctions as usize >= passed
            && let Passage::Turning { circle, root: before, .. } = &label.state
        {
            to = *circle;
            let label = labels.get(*before as usize);
            root = Root { label, circle: self.circle(label), cone: Cone::ALL };
        }
        self.blocked.push([root.circle, to]);
        true
    }
}

impl Driving {
    /// Where the path arrives on the circle that a label turns about.
    fn arrival_point(&self, label: &Label<Passage>) -> Vector<2> {
        match &label.state {
            Passage::Turning { circle, arrival, .. } => {
                let normal = Vector::<2>::new(-arrival.y, arrival.x);
                circle.center - normal * circle.signed_radius
            }
            Passage::Straight { .. } => self.traveller.least,
        }
    }
}
