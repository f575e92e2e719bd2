//! Exact clearance of the rectangular robot over lines, arcs and turns in place; over clothoids it is
//! certified from below ([`super::clothoid`]).
//!
//! While body and wall are apart, the least distance between them is between a corner of
//! one and an edge or corner of the other, and each of these pairs moves on a line or on
//! a circle about the guiding circle's centre: finitely many candidates in closed form.
//! The exception is a robot that turns while moving, which takes a bounded search
//! ([`TURNING_WHILE_MOVING_BOUND`]).

use thiserror::Error;

use crate::budget::{Budget, Spent};
use crate::clearance::Clearance;
use crate::clearance::clothoid::PlacedClothoid;
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::Vector;
use crate::geometry::number::Number;
use crate::motion::{Curve, Leg};

pub use free::{FREE_TURNING_WHILE_MOVING_BOUND, binding_tolerance, free_clearance};

use segment::Rectangle;

mod along_wall;
mod free;
mod moving;
mod segment;
mod slide;
mod swing;

/// Distances that differ by less than this count as equal, metres: the first place within
/// this of the least distance is reported.
pub const TIE: f64 = 1e-12;

/// The greatest error of the clearance over a line on which the body also turns, metres.
/// Every other clearance is exact to rounding.
pub const TURNING_WHILE_MOVING_BOUND: f64 = 1e-9;

/// Steps of the budget that the motion along one curve takes against one wall.
const STEPS_PER_WALL: u64 = 5;

/// The rectangle that a mobile robot covers. Poses are those of its reference point, which
/// lies midway between its sides and anywhere from its front to its rear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    width: f64,
    front: f64,
    rear: f64,
}

/// Why numbers are no [`Footprint`].
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum FootprintError {
    /// A side is not positive and finite.
    #[error(
        "width {} m and length {} m must be finite and greater than 0",
        Number(*width), Number(*length)
    )]
    Sides {
        /// Extent across the heading, metres.
        width: f64,
        /// Extent along the heading, metres.
        length: f64,
    },
    /// The width is not positive and finite, or the reference point is not within the
    /// rectangle.
    #[error(
        "width {} m must be greater than 0; front {} m and rear {} m must not be \
         negative, nor both 0; all must be finite",
        Number(*width), Number(*front), Number(*rear)
    )]
    Reach {
        /// Extent across the heading, metres.
        width: f64,
        /// From the reference point to the front edge, metres.
        front: f64,
        /// From the reference point to the rear edge, metres.
        rear: f64,
    },
}

impl FootprintError {
    /// The least of the numbers given, metres.
    pub fn least(&self) -> f64 {
        match *self {
            Self::Sides { width, length } => width.min(length),
            Self::Reach { width, front, rear } => width.min(front).min(rear),
        }
    }
}

impl Footprint {
    /// The rectangle of extent `width` across the heading (the paper's w) and `length` along
    /// it (the paper's h), metres, with the reference point in its middle; both must be
    /// positive and finite.
    pub fn new(width: f64, length: f64) -> Result<Self, FootprintError> {
        let positive = |side: f64| side > 0.0 && side.is_finite();
        if positive(width) && positive(length) {
            Ok(Self { width, front: length / 2.0, rear: length / 2.0 })
        } else {
            Err(FootprintError::Sides { width, length })
        }
    }

    /// The rectangle of extent `width` across the heading that reaches `front` ahead of the
    /// reference point and `rear` behind it, metres. The width must be positive, the others
    /// must not be negative, nor both 0.
    ///
    /// ```
    /// use planning::clearance::rectangle::Footprint;
    ///
    /// // A car's reference point is the middle of its rear axle.
    /// let car = Footprint::offset(1.8, 3.6, 1.0)?;
    /// assert_eq!((car.length(), car.front(), car.rear()), (4.6, 3.6, 1.0));
    /// assert_eq!(Footprint::offset(1.0, 0.75, 0.75), Footprint::new(1.0, 1.5));
    /// assert!(Footprint::offset(1.0, 2.0, -0.5).is_err());
    /// # Ok::<(), planning::clearance::rectangle::FootprintError>(())
    /// ```
    pub fn offset(width: f64, front: f64, rear: f64) -> Result<Self, FootprintError> {
        let length = front + rear;
        let reaches = front >= 0.0 && rear >= 0.0 && length > 0.0 && length.is_finite();
        if reaches && width > 0.0 && width.is_finite() {
            Ok(Self { width, front, rear })
        } else {
            Err(FootprintError::Reach { width, front, rear })
        }
    }

    /// Extent across the heading, metres.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// From the reference point to the front edge, metres.
    pub fn front(&self) -> f64 {
        self.front
    }

    /// From the reference point to the rear edge, metres.
    pub fn rear(&self) -> f64 {
        self.rear
    }

    /// Extent along the heading, metres.
    pub fn length(&self) -> f64 {
        self.front + self.rear
    }

    /// Radius of the turning circle: from the reference point to the farthest corner, metres.
    pub fn swing_radius(&self) -> f64 {
        let (along, across) = (self.front.max(self.rear), self.width / 2.0);
        (along * along + across * across).sqrt()
    }

    /// The rectangle in the frame of the reference point, the x axis along the heading.
    fn rectangle(&self) -> Rectangle {
        Rectangle {
            center: Vector::<2>::new((self.front - self.rear) / 2.0, 0.0),
            half: Vector::<2>::new(self.length() / 2.0, self.width / 2.0),
        }
    }
}

/// The least distance over a motion so far, and where it is met first. Infinite without walls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Met {
    /// The least distance, metres.
    pub(crate) value: f64,
    /// Where it is met: as a part of the leg, or as arc length from the start of the motion.
    pub(crate) along: f64,
    /// The wall point.
    pub(crate) wall: Vector<2>,
    /// Distance at `along`; within [`TIE`] of `value`.
    there: f64,
}

impl Met {
    pub(crate) const NOTHING: Self = Self {
        value: f64::INFINITY,
        along: 0.0,
        wall: Vector::<2>::new(0.0, 0.0),
        there: f64::INFINITY,
    };

    /// Whether a distance can change the result.
    fn wants(&self, value: f64) -> bool {
        value <= self.value + TIE
    }

    /// Takes into account a distance that occurs.
    pub(crate) fn offer(&mut self, value: f64, along: f64, wall: Vector<2>) {
        if !self.wants(value) {
            return;
        }
        self.value = self.value.min(value);
        if self.there > self.value + TIE || along < self.along {
            (self.there, self.along, self.wall) = (value, along, wall);
        }
    }

    pub(crate) fn clearance(&self) -> Option<Clearance<2>> {
        self.value.is_finite().then_some(Clearance {
            value: self.value,
            at: self.along,
            wall: self.wall,
        })
    }
}

/// Distance of the body at rest to the walls; `None` without walls. Heading in radians
/// counter-clockwise from +x.
pub fn clearance_rectangle_pose(
    footprint: &Footprint,
    position: &Vector<2>,
    heading: f64,
    walls: &Walls<2>,
    budget: &Budget<'_>,
) -> Result<Option<Clearance<2>>, Spent> {
    let curve = Curve::Line { from: *position, to: *position, heading, turned: 0.0 };
    clearance_rectangle_curve(footprint, &curve, walls, budget)
}

/// Clearance over one curve; `None` without walls. A line is travelled along the heading or
/// against it; over a turn in place `at` is 0.
///
/// ```
/// use planning::budget::Budget;
/// use planning::clearance::rectangle::{Footprint, clearance_rectangle_curve};
/// use planning::free_space::walls::{Wall, Walls};
/// use planning::geometry::Vector;
/// use planning::motion::Curve;
///
/// // A robot 1 m wide and 2 m long drives 6 m along x. A wall stands 1.5 m to its left,
/// // from x = 4 on: the front, 1 m ahead of the centre, reaches it first.
/// let robot = Footprint::new(1.0, 2.0)?;
/// let (from, to) = (Vector::from([0.0, 0.0]), Vector::from([6.0, 0.0]));
/// let curve = Curve::Line { from, to, heading: 0.0, turned: 0.0 };
/// let mut walls = Walls::default();
/// walls.push(Wall { from: [4.0, 1.5].into(), to: [9.0, 1.5].into() });
/// let clearance = clearance_rectangle_curve(&robot, &curve, &walls, &Budget::default())?;
/// let clearance = clearance.expect("there is a wall");
/// assert_eq!((clearance.value, clearance.at), (1.0, 3.0));
/// assert_eq!(clearance.wall, Vector::from([4.0, 1.5]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn clearance_rectangle_curve(
    footprint: &Footprint,
    curve: &Curve<2>,
    walls: &Walls<2>,
    budget: &Budget<'_>,
) -> Result<Option<Clearance<2>>, Spent> {
    let guess = footprint.width.max(footprint.length());
    let mut met = nearest(footprint, curve, walls, guess, budget)?;
    met.along *= curve.length();
    Ok(met.clearance())
}

/// The least distance over each leg in turn: calls `each` with the leg's index, with what it
/// meets, and with the arc length at which it does, from the start of the first leg.
pub(crate) fn nearest_along<E: From<Spent>>(
    footprint: &Footprint,
    legs: &[Leg<2>],
    walls: &Walls<2>,
    budget: &Budget<'_>,
    mut each: impl FnMut(usize, &Met, f64) -> Result<(), E>,
) -> Result<(), E> {
    let mut travelled = 0.0;
    let mut guess = footprint.width().max(footprint.length());
    for (index, leg) in legs.iter().enumerate() {
        let met = nearest(footprint, &leg.curve, walls, guess, budget)?;
        let length = leg.curve.length();
        each(index, &met, travelled + met.along * length)?;
        travelled += length;
        // The next leg begins where this one ends.
        if met.value.is_finite() {
            guess = 1.5 * met.value + 0.01;
        }
    }
    Ok(())
}

/// The least distance over one curve, with `along` as a part of it. `guess` is how far to
/// look for walls at first, metres; the result does not depend on it.
pub(crate) fn nearest(
    footprint: &Footprint,
    curve: &Curve<2>,
    walls: &Walls<2>,
    guess: f64,
    budget: &Budget<'_>,
) -> Result<Met, Spent> {
    let met = meet_walls(footprint, curve, (walls, Look::Within(guess), budget))?;
    if met.value <= guess {
        return Ok(met);
    }
    meet_walls(footprint, curve, (walls, Look::Everywhere, budget))
}

/// Whether the body stays farther than `least` metres from all walls over one curve.
pub(crate) fn stays_clear(
    footprint: &Footprint,
    curve: &Curve<2>,
    walls: &Walls<2>,
    least: f64,
    budget: &Budget<'_>,
) -> Result<bool, Spent> {
    Ok(meet_walls(footprint, curve, (walls, Look::Until(least), budget))?.value > least)
}

/// Which walls are looked at.
#[derive(Debug, Clone, Copy)]
enum Look {
    /// All within this reach, metres.
    Within(f64),
    /// All that can be the nearest.
    Everywhere,
    /// All within this reach, metres, up to the first that is met there.
    Until(f64),
}

fn meet_walls(
    footprint: &Footprint,
    curve: &Curve<2>,
    near: (&Walls<2>, Look, &Budget<'_>),
) -> Result<Met, Spent> {
    let budget = near.2;
    match *curve {
        Curve::Line { from, to, heading, turned } => {
            if turned == 0.0 {
                let back = curve.is_reverse();
                let slide = slide::Slide::new(footprint, (&from, &to), heading, back);
                search(near, slide.bounds(), |wall, met| {
                    slide.meet(wall, met);
                    Ok(())
                })
            } else {
                let moving = moving::Moving::new(footprint, &from, &to, heading, turned);
                search(near, moving.bounds(), |wall, met| moving.meet(wall, met, budget))
            }
        }
        Curve::Arc { center, radius, start_angle, sweep, reverse } => {
            let arc = (&center, radius, start_angle, sweep);
            let swing = swing::Swing::on_arc(footprint, arc, reverse);
            search(near, swing.bounds(), |wall, met| {
                swing.meet(wall, met);
                Ok(())
            })
        }
        Curve::Clothoid { .. } => meet_from_below(footprint, curve, near),
        Curve::Turn { position, from_heading, sweep } => {
            let swing = swing::Swing::in_place(footprint, &position, from_heading, sweep);
            search(near, swing.bounds(), |wall, met| {
                swing.meet(wall, met);
                Ok(())
            })
        }
    }
}

/// The clearance over a clothoid: a little less than the least distance, never more.
fn meet_from_below(
    footprint: &Footprint,
    curve: &Curve<2>,
    (walls, look, budget): (&Walls<2>, Look, &Budget<'_>),
) -> Result<Met, Spent> {
    let mut met = Met::NOTHING;
    let Some(clothoid) = PlacedClothoid::of(curve) else { return Ok(met) };
    let (most, enough) = match look {
        Look::Until(least) => (least.next_up(), least),
        Look::Within(_) | Look::Everywhere => (f64::INFINITY, f64::NEG_INFINITY),
    };
    let found = clothoid.least((footprint.swing_radius(), most, enough), |arc, less| {
        budget.step(1)?;
        let look = match look {
            Look::Within(reach) => Look::Within(reach + less),
            Look::Until(least) => Look::Until(least + less),
            Look::Everywhere => Look::Everywhere,
        };
        let Met { value, along, wall, .. } = meet_walls(footprint, arc, (walls, look, budget))?;
        Ok(Clearance { value, at: along, wall })
    })?;
    met.offer(found.value, found.at, found.wall);
    Ok(met)
}

fn search(
    (walls, look, budget): (&Walls<2>, Look, &Budget<'_>),
    (min, max): (Vector<2>, Vector<2>),
    meet: impl Fn(&Wall<2>, &mut Met) -> Result<(), Spent>,
) -> Result<Met, Spent> {
    let mut met = Met::NOTHING;
    if let Look::Until(least) = look {
        // What is farther away need not be told apart.
        met.value = least.next_up();
    }
    let mut spent = Ok(());
    // The index draws for the walls that it finds; what meeting them takes is drawn at the end.
    let mut count = 0;
    if let Look::Within(reach) = look {
        walls.near(&min, &max, reach, budget, |_, wall| {
            count += 1;
            if spent.is_ok() {
                spent = meet(wall, &mut met);
            }
        })?;
    } else {
        walls.nearest(&min, &max, budget, |_, wall| {
            count += 1;
            spent = meet(wall, &mut met);
            match look {
                _ if spent.is_err() => -1.0,
                Look::Until(least) if met.value <= least => -1.0,
                Look::Until(least) => least,
                _ => met.value + TIE,
            }
        })?;
    }
    budget.step(STEPS_PER_WALL * count)?;
    spent.map(|()| met)
}

#[cfg(test)]
pub(crate) mod tests;
