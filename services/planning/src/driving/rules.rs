//! Table 2, corrected: where the robot arrives at the guiding circle, and where it leaves it.
//!
//! In print six rows of the table and the last line of equation 5.5 are wrong
//! (`docs/errata.md`). Paths take their tangents from one formula for all cases
//! (`tangent.rs`). The rules name its turns and are the independent construction that it is
//! tested against.

use crate::geometry::Sign::{self, Negative, Positive};
use crate::geometry::{AxisBox, Direction, Vector};
use crate::motion::Rule;

/// One row of Table 2, corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TurnRule {
    /// Its number in the table, from 1.
    pub number: u8,
    /// Condition "J_n against M": the direction in which the robot enters the junction.
    pub approach: Direction,
    /// Condition "J_n against J_(n-1)": the direction in which it leaves.
    pub leave: Direction,
    /// The sense of the turn; positive turns left.
    pub turn: Sign,
    /// p_n, the corner of the corridor inside the turn, as a vertex of the junction: whether it
    /// has the greatest (positive) or the least x, and y.
    pub corner: [Sign; 2],
    /// Signs of x and y in equation 5.5. Rules 1 to 4 have the cosine of the arriving angle in
    /// x and the sine in y, rules 5 to 8 the reverse.
    pub signs: [Sign; 2],
}

const RIGHT: Direction = Direction { axis: 0, sign: Positive };
const LEFT: Direction = Direction { axis: 0, sign: Negative };
const UP: Direction = Direction { axis: 1, sign: Positive };
const DOWN: Direction = Direction { axis: 1, sign: Negative };

const fn rule(
    number: u8,
    approach: Direction,
    leave: Direction,
    turn: Sign,
    corner: [Sign; 2],
    signs: [Sign; 2],
) -> TurnRule {
    TurnRule { number, approach, leave, turn, corner, signs }
}

/// Table 2, corrected.
#[rustfmt::skip]
pub const TABLE_2: [TurnRule; 8] = [
    //      approach  leave  turn      corner p_n            (m_a)_x   (m_a)_y
    rule(1, UP,       RIGHT, Negative, [Positive, Negative], [Negative, Positive]),
    rule(2, DOWN,     RIGHT, Positive, [Positive, Positive], [Negative, Negative]),
    rule(3, UP,       LEFT,  Positive, [Negative, Negative], [Positive, Positive]),
    rule(4, DOWN,     LEFT,  Negative, [Negative, Positive], [Positive, Negative]),
    rule(5, RIGHT,    UP,    Positive, [Negative, Positive], [Positive, Negative]),
    rule(6, LEFT,     UP,    Negative, [Positive, Positive], [Negative, Negative]),
    rule(7, RIGHT,    DOWN,  Negative, [Negative, Negative], [Positive, Positive]),
    rule(8, LEFT,     DOWN,  Positive, [Positive, Negative], [Negative, Positive]),
];

impl TurnRule {
    /// The rule for these directions; `None` unless they have different axes, x and y.
    pub fn of(approach: Direction, leave: Direction) -> Option<&'static Self> {
        TABLE_2.iter().find(|rule| rule.approach == approach && rule.leave == leave)
    }

    /// Table and number, as legs name it.
    pub fn name(&self) -> Rule {
        Rule { table: 2, number: self.number }
    }

    /// The vertex p_n of a junction, metres.
    pub fn corner_of(&self, junction: &AxisBox<2>) -> Vector<2> {
        let pick = |axis: usize| match self.corner[axis] {
            Negative => junction.min()[axis],
            Positive => junction.max()[axis],
        };
        Vector::<2>::new(pick(0), pick(1))
    }

    /// The arriving angle Theta_a, radians: (5.2), (5.6), (5.7) with the signs that the arc
    /// cosines lose. `from` is m_0 (or the last leaving point), `corner` is p_n; NaN if `from`
    /// is closer to it than `radius`.
    pub fn arriving_angle(&self, from: &Vector<2>, corner: &Vector<2>, radius: f64) -> f64 {
        let to_corner = corner - from;
        let distance = libm::hypot(to_corner.x, to_corner.y);
        libm::acos(radius / distance)
            - libm::atan2(self.approach.coordinate(&to_corner), self.leave.coordinate(&to_corner))
    }

    /// The leaving angle Theta_l, radians: (5.3) for every kind of next corner. `to` is the next
    /// corner or the goal; `reach` is how far it lies across the tangent, metres: the sum of both
    /// radii if the next turn is to the other side, this radius less the next one if it is to the
    /// same side, this radius before the goal.
    pub fn leaving_angle(&self, corner: &Vector<2>, to: &Vector<2>, reach: f64) -> f64 {
        let onward = to - corner;
        let distance = libm::hypot(onward.x, onward.y);
        libm::acos(reach / distance)
            - libm::atan2(self.leave.coordinate(&onward), self.approach.coordinate(&onward))
    }

    /// The arriving point m_a, metres: (5.4), (5.5).
    pub fn arriving_point(&self, corner: &Vector<2>, radius: f64, angle: f64) -> Vector<2> {
        let [x, y] = self.signs.map(Sign::factor);
        let (sin, cos) = libm::sincos(angle);
        let (along_x, along_y) = if self.number <= 4 { (cos, sin) } else { (sin, cos) };
        corner + Vector::<2>::new(x * along_x, y * along_y) * radius
    }

    /// The leaving point m_l, metres, for which the paper has no equation: the arriving point
    /// with sine and cosine exchanged.
    pub fn leaving_point(&self, corner: &Vector<2>, radius: f64, angle: f64) -> Vector<2> {
        self.arriving_point(corner, radius, std::f64::consts::FRAC_PI_2 - angle)
    }
}
