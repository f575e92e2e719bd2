//! Numbers and axes as people read them.

use std::fmt;

use planning::geometry::number::Number;
use planning::geometry::{Direction, Sign};
use schemas::message::Refusal;

/// Which coordinate of a scene is which axis: 0 x, 1 y, 2 z.
pub(crate) type Axes = [u32; 3];

/// Assembly in two dimensions lives in (x, z).
pub(crate) const PLANE: Axes = [0, 2, 1];
/// Assembly in three dimensions lives in (x, y, z).
pub(crate) const SPACE: Axes = [0, 1, 2];
/// Driving lives in (x, y).
pub(crate) const FLOOR: Axes = [0, 1, 2];

/// A number as people read it: to nanometres, without trailing zeros. The reply's
/// fields have it in full.
pub(super) struct Short(pub(super) f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = Number(self.0);
        if number.is_extreme() {
            return number.fmt(f);
        }
        let text = format!("{:.9}", self.0);
        f.write_str(text.trim_end_matches('0').trim_end_matches('.'))
    }
}

/// A number of things.
pub(super) struct Count(pub(super) usize, pub(super) &'static str);

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(count, what) = self;
        write!(f, "{count} {what}{}", if *count == 1 { "" } else { "s" })
    }
}

/// How many other junctions or places of a route would have to change.
pub(super) struct Others(pub(super) &'static str, pub(super) usize);

impl fmt::Display for Others {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(what, count) = self;
        match count {
            0 => Ok(()),
            1 => write!(f, "; 1 other {what} on that route is too small as well"),
            _ => write!(f, "; {count} other {what}s on that route are too small as well"),
        }
    }
}

/// With the numbers of a junction.
pub(super) fn at_junction(
    axes: &Axes,
    (junction, axis): (usize, usize),
    (needs, has): (f64, f64),
    refusal: Refusal,
) -> Refusal {
    Refusal {
        junction: Some(junction as u64),
        axis: Some(axes[axis]),
        needs: Some(needs),
        has: Some(has),
        ..refusal
    }
}

pub(super) fn letter(axes: &Axes, coordinate: usize) -> char {
    ['x', 'y', 'z'][axes[coordinate] as usize]
}

/// A direction with its sign, as a request writes it.
pub(super) struct Towards<'a>(pub(super) &'a Axes, pub(super) Direction);

impl fmt::Display for Towards<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(axes, Direction { axis, sign }) = *self;
        let sign = if sign == Sign::Positive { '+' } else { '-' };
        write!(f, "{sign}{}", letter(axes, axis))
    }
}
