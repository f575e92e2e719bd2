//! Vectors, boxes, directions and half-spaces.
//!
//! Distances between shapes are in [`distance`], simple polygons in [`polygon`], the index
//! over many boxes in [`box_tree`].

use nalgebra::SVector;
use number::Number;
use thiserror::Error;

/// A point or a displacement in `D` dimensions, in metres.
pub type Vector<const D: usize> = SVector<f64, D>;

/// A box with sides parallel to the axes and with an interior: the intersection
/// of `2 D` closed half-spaces (paper, equations 2.1 and 2.2).
///
/// ```
/// use planning::geometry::AxisBox;
///
/// // C_3 and C_2 of section 4, and their junction (2.4).
/// let c_3 = AxisBox::new([4.0, 1.0].into(), [7.0, 6.0].into())?;
/// let c_2 = AxisBox::new([1.0, 2.0].into(), [7.0, 6.0].into())?;
/// let junction = AxisBox::new([4.0, 2.0].into(), [7.0, 6.0].into())?;
/// assert_eq!(c_3.intersection(&c_2), Some(junction));
/// // Equal bounds leave no interior.
/// assert!(AxisBox::new([4.0, 1.0].into(), [4.0, 6.0].into()).is_err());
/// # Ok::<(), planning::geometry::BoxError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisBox<const D: usize> {
    min: Vector<D>,
    max: Vector<D>,
}

/// Why two corners are no [`AxisBox`].
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum BoxError {
    /// A coordinate is infinite or not a number.
    #[error("coordinate {axis} is not finite: min {}, max {}", Number(*min), Number(*max))]
    NotFinite {
        /// Index of the coordinate.
        axis: usize,
        /// Its least value, metres.
        min: f64,
        /// Its greatest value, metres.
        max: f64,
    },
    /// The box has no interior along a coordinate.
    #[error(
        "coordinate {axis} is inverted or empty: min {} must be less than max {}",
        Number(*min), Number(*max)
    )]
    Inverted {
        /// Index of the coordinate.
        axis: usize,
        /// Its least value, metres.
        min: f64,
        /// Its greatest value, metres.
        max: f64,
    },
}

impl<const D: usize> AxisBox<D> {
    /// The box between two opposite corners, which must be finite and in order.
    pub fn new(min: Vector<D>, max: Vector<D>) -> Result<Self, BoxError> {
        for axis in 0..D {
            let (min, max) = (min[axis], max[axis]);
            if !(min.is_finite() && max.is_finite()) {
                return Err(BoxError::NotFinite { axis, min, max });
            }
            if min >= max {
                return Err(BoxError::Inverted { axis, min, max });
            }
        }
        Ok(Self { min, max })
    }

    /// The corner with the least coordinates, metres.
    pub fn min(&self) -> Vector<D> {
        self.min
    }

    /// The corner with the greatest coordinates, metres.
    pub fn max(&self) -> Vector<D> {
        self.max
    }

    /// Extent along every axis, metres.
    pub fn size(&self) -> Vector<D> {
        self.max - self.min
    }

    /// The middle of the box, metres.
    pub fn center(&self) -> Vector<D> {
        (self.min + self.max) / 2.0
    }

    /// The common part of two boxes, if it has an interior (equation 2.4: a junction).
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let min = self.min.sup(&other.min);
        let max = self.max.inf(&other.max);
        (0..D).all(|axis| min[axis] < max[axis]).then_some(Self { min, max })
    }

    /// Whether `point` lies in the box or on its boundary.
    pub fn holds(&self, point: &Vector<D>) -> bool {
        (0..D).all(|axis| self.min[axis] <= point[axis] && point[axis] <= self.max[axis])
    }

    /// Whether `other` lies in the box; it may touch the boundary.
    pub fn contains(&self, other: &Self) -> bool {
        (0..D).all(|axis| self.min[axis] <= other.min[axis] && other.max[axis] <= self.max[axis])
    }

    /// The same box moved by `displacement`, metres.
    pub fn translated(&self, displacement: &Vector<D>) -> Self {
        Self { min: self.min + displacement, max: self.max + displacement }
    }
}

/// A sense along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Sign {
    /// Towards smaller coordinates.
    Negative,
    /// Towards greater coordinates.
    Positive,
}

impl Sign {
    /// The sign of `value`; zero counts as positive.
    pub fn of(value: f64) -> Self {
        if value < 0.0 { Self::Negative } else { Self::Positive }
    }

    /// -1.0 or +1.0.
    pub fn factor(self) -> f64 {
        match self {
            Self::Negative => -1.0,
            Self::Positive => 1.0,
        }
    }

    /// The opposite sense.
    pub fn opposite(self) -> Self {
        match self {
            Self::Negative => Self::Positive,
            Self::Positive => Self::Negative,
        }
    }
}

/// A direction along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Direction {
    /// Index of the coordinate.
    pub axis: usize,
    /// The sense along it.
    pub sign: Sign,
}

impl Direction {
    /// The coordinate of `point` along this direction, metres: it grows in this direction.
    pub fn coordinate<const D: usize>(self, point: &Vector<D>) -> f64 {
        self.sign.factor() * point[self.axis]
    }
}

pub mod box_tree;
pub mod clothoid;
pub mod distance;
mod half_space;
pub mod number;
pub(crate) mod orientation;
pub mod polygon;
#[cfg(test)]
pub(crate) mod work;

pub use half_space::HalfSpace;

/// The unit vector at `angle` radians counter-clockwise from +x.
pub(crate) fn unit(angle: f64) -> Vector<2> {
    let (sin, cos) = libm::sincos(angle);
    Vector::<2>::new(cos, sin)
}

/// `vector` rotated by the angle of the unit vector `by`: their complex product.
pub(crate) fn rotated(vector: &Vector<2>, by: &Vector<2>) -> Vector<2> {
    Vector::<2>::new(vector.x * by.x - vector.y * by.y, vector.x * by.y + vector.y * by.x)
}

/// `vector` rotated back by the angle of the unit vector `by`: the product with
/// its conjugate. Its coordinates are the dot and the cross product of `by` and
/// `vector`.
pub(crate) fn unrotated(vector: &Vector<2>, by: &Vector<2>) -> Vector<2> {
    Vector::<2>::new(vector.x * by.x + vector.y * by.y, vector.y * by.x - vector.x * by.y)
}
