//! Random floors.

use proptest::prelude::*;

use crate::budget::Budget;
use crate::free_space::floor::Floor;
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::{AxisBox, Vector};

/// A room of this size with solids in it, each a closed outline.
#[derive(Debug, Clone)]
pub(in crate::any_angle) struct Room {
    pub(in crate::any_angle) size: f64,
    pub(in crate::any_angle) solids: Vec<Vec<Vector<2>>>,
}

impl Room {
    /// All its walls, turned and moved.
    pub(in crate::any_angle) fn walls(&self, place: impl Fn(Vector<2>) -> Vector<2>) -> Walls<2> {
        let bounds = AxisBox::new([0.0, 0.0].into(), [self.size; 2].into()).unwrap();
        let mut inside = Walls::default();
        inside.push_inside(&bounds);
        let mut walls = Walls::default();
        for wall in inside.as_slice() {
            walls.push(Wall { from: place(wall.from), to: place(wall.to) });
        }
        for solid in &self.solids {
            for (index, from) in solid.iter().enumerate() {
                let to = solid[(index + 1) % solid.len()];
                walls.push(Wall { from: place(*from), to: place(to) });
            }
        }
        walls.index(&Budget::default()).unwrap();
        walls
    }

    /// Whether a point is in a solid or nearer than `radius` to a wall.
    pub(in crate::any_angle) fn is_taken(&self, point: &Vector<2>, radius: f64) -> bool {
        let walls = self.walls(|point| point);
        let near = walls.as_slice().iter().any(|wall| {
            let way = wall.to - wall.from;
            let part = ((point - wall.from).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            (point - wall.from - way * part).norm() <= radius
        });
        near || self.solids.iter().any(|solid| {
            let mut inside = false;
            for (index, a) in solid.iter().enumerate() {
                let b = solid[(index + 1) % solid.len()];
                if (a.y > point.y) != (b.y > point.y)
                    && point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x
                {
                    inside = !inside;
                }
            }
            inside
        })
    }
}

pub(in crate::any_angle) fn floor(walls: &Walls<2>) -> Floor {
    Floor::new(walls, &Budget::default()).unwrap()
}

/// Rooms of 10 m with boxes, turned boxes and triangles, some overlapping.
pub(in crate::any_angle) fn rooms() -> impl Strategy<Value = Room> {
    let solid = (
        prop::array::uniform2(0.5..9.5f64),
        prop::array::uniform2(0.1..2.0f64),
        prop_oneof![Just(0.0), 0.0..3.2f64],
        3..6_usize,
    )
        .prop_map(|(center, half, turn, corners)| {
            let (sin, cos) = libm::sincos(turn);
            (0..corners)
                .map(|corner| {
                    let angle = std::f64::consts::TAU * (corner as f64 + 0.5) / corners as f64;
                    let (y, x) = libm::sincos(angle);
                    let (x, y) = (half[0] * x, half[1] * y);
                    Vector::from([center[0] + cos * x - sin * y, center[1] + sin * x + cos * y])
                })
                .collect()
        });
    prop::collection::vec(solid, 0..7).prop_map(|solids| Room { size: 10.0, solids })
}
