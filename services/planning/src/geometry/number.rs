//! Numbers in messages.

use std::fmt;

use super::Vector;

/// A number as people read it: as `f64` is shown, but huge and tiny ones, which would have
/// hundreds of digits, as powers of ten.
///
/// ```
/// use planning::geometry::number::Number;
///
/// assert_eq!(format!("{} {:.4}", Number(0.25), Number(0.25)), "0.25 0.2500");
/// assert_eq!(format!("{} {:.4}", Number(1e150), Number(1e150)), "1e150 1.0000e150");
/// assert_eq!(format!("{} {:.4}", Number(-3e-9), Number(3e-9)), "-3e-9 0.0000");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number(pub f64);

impl Number {
    /// Whether it is huge or tiny.
    pub fn is_extreme(&self) -> bool {
        self.is_huge() || (self.0 != 0.0 && self.0.abs() < 1e-6)
    }

    fn is_huge(&self) -> bool {
        self.0.abs() >= 1e12
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A precision bounds the digits of tiny numbers.
        let power = if f.precision().is_some() { self.is_huge() } else { self.is_extreme() };
        if power { fmt::LowerExp::fmt(&self.0, f) } else { fmt::Display::fmt(&self.0, f) }
    }
}

/// A point as people read it: its coordinates as [`Number`]s, in brackets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<'a>(pub &'a Vector<2>);

impl fmt::Display for Point<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("(")?;
        Number(self.0.x).fmt(f)?;
        f.write_str(", ")?;
        Number(self.0.y).fmt(f)?;
        f.write_str(")")
    }
}
