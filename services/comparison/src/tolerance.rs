//! How far numbers may differ.

use std::fmt;

/// What a number of a reply measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Where something is: samples, ends and centres of legs with their radii, the closest wall
    /// point, channels; metres.
    Position,
    /// Angles, of samples and legs, modulo a whole turn where they are headings; radians.
    Heading,
    /// When: of samples, and the duration; seconds.
    Time,
    /// Lengths of trajectories, legs and bounds, and where on the path; metres.
    Length,
    /// Clearances of trajectories and legs; metres.
    Clearance,
    /// Gaps used; metres.
    Gap,
    /// Velocities of samples; m/s.
    Speed,
    /// Yaw rates of samples; rad/s.
    YawRate,
    /// Numbers of refusals, in their units.
    Refusal,
}

impl Quantity {
    /// All, in order.
    pub const ALL: [Self; 9] = [
        Self::Position,
        Self::Heading,
        Self::Time,
        Self::Length,
        Self::Clearance,
        Self::Gap,
        Self::Speed,
        Self::YawRate,
        Self::Refusal,
    ];

    /// The name, as in `position=1mm`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Heading => "heading",
            Self::Time => "time",
            Self::Length => "length",
            Self::Clearance => "clearance",
            Self::Gap => "gap",
            Self::Speed => "speed",
            Self::YawRate => "yaw_rate",
            Self::Refusal => "refusal",
        }
    }

    /// The quantity with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.name() == name)
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// How far numbers may differ; by default not by a bit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tolerance {
    /// For each number of every quantity that has no tolerance of its own.
    each: Option<f64>,
    own: [Option<f64>; Quantity::ALL.len()],
}

impl Tolerance {
    /// Numbers must be equal bit for bit.
    pub const EXACT: Self = Self { each: None, own: [None; Quantity::ALL.len()] };

    /// Numbers of all quantities may be this far apart, coordinate by coordinate.
    pub const fn within(most: f64) -> Self {
        Self { each: Some(most), ..Self::EXACT }
    }

    /// Numbers of a quantity may be this far apart; for points and velocities, their distance
    /// counts.
    #[must_use]
    pub fn with(mut self, quantity: Quantity, most: f64) -> Self {
        self.own[quantity as usize] = Some(most);
        self
    }

    /// This one, and where it says nothing, the other.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        let own = std::array::from_fn(|at| {
            self.own[at].or(match self.each {
                Some(_) => None,
                None => other.own[at],
            })
        });
        Self { each: self.each.or(other.each), own }
    }

    /// The tolerance of its own that a quantity has.
    pub fn own(&self, quantity: Quantity) -> Option<f64> {
        self.own[quantity as usize]
    }

    /// The tolerance of a single number of a quantity.
    pub fn of(&self, quantity: Quantity) -> Option<f64> {
        self.own(quantity).or(self.each)
    }

    /// The tolerance of every number whose quantity has none of its own.
    pub fn each(&self) -> Option<f64> {
        self.each
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_first_counts() {
        let file = Tolerance::within(1e-3).with(Quantity::Time, 0.5);
        let given = Tolerance::EXACT.with(Quantity::Position, 0.1);
        let both = given.or(file);
        let of = [Quantity::Position, Quantity::Time, Quantity::Gap].map(|it| both.of(it));
        assert_eq!(of, [Some(0.1), Some(0.5), Some(1e-3)]);
        // A tolerance for all numbers is for those of the file, too.
        assert_eq!(Tolerance::within(1e-9).or(file).of(Quantity::Time), Some(1e-9));
        assert_eq!(Tolerance::EXACT.or(Tolerance::EXACT).of(Quantity::Gap), None);
    }

    #[test]
    fn quantities_have_distinct_names() {
        for (index, quantity) in Quantity::ALL.into_iter().enumerate() {
            assert_eq!(quantity as usize, index);
            assert_eq!(Quantity::from_name(quantity.name()), Some(quantity));
        }
    }
}
