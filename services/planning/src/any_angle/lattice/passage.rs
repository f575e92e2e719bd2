//! Narrow passages: the lines along which a robot passes where it can't turn.

use super::field::Field;
use super::probe::Probe;
use crate::budget::Spent;
use crate::free_space::floor::{Face, NONE};
use crate::geometry::Vector;

/// Lines looked at, those on the shortest ways first.
const MOST_LINES: usize = 4096;

/// Passages on ways longer than this times the shortest are left out.
const DETOUR: f64 = 1.6;

/// How far from a passage there must be room to turn, in turning circles' radii.
const LONGEST: f64 = 16.0;

/// Lines that differ by less than this part count as one.
const SAME: f64 = 1e-6;

/// Steps of the budget that a face of the floor takes.
const STEPS_PER_FACE: u64 = 16;

/// A straight line through a narrow passage.
#[derive(Debug, Clone, Copy)]
pub(super) struct GateAxis {
    /// A point in the middle of the passage, metres.
    pub(super) middle: Vector<2>,
    /// Unit vector.
    pub(super) direction: Vector<2>,
    /// How long a way through here is at least, metres.
    way: f64,
}

impl GateAxis {
    /// The nearest places before and after it where the robot can turn, if it can drive straight
    /// from one to the other.
    pub(super) fn ends(&self, probe: &Probe<'_>) -> Result<Option<[Vector<2>; 2]>, Spent> {
        let most = LONGEST * probe.swing;
        let mut ends = [Vector::zeros(); 2];
        for (end, direction) in ends.iter_mut().zip([-self.direction, self.direction]) {
            let Some(way) = probe.way_to_turn(&self.middle, &direction, most)? else {
                return Ok(None);
            };
            *end = self.middle + direction * way;
        }
        Ok(Some(ends))
    }
}

/// Finds the lines through narrow passages: midway between two corners, or between a corner and
/// a wall, at a right angle to the gap or along the walls beside it.
pub(super) fn find(
    probe: &Probe<'_>,
    field: &Field,
    axes: &mut Vec<GateAxis>,
) -> Result<(), Spent> {
    axes.clear();
    let floor = probe.errand.floor;
    let shortest = field.to_goal(&Vector::zeros());
    let wide = 2.0 * probe.swing + 4.0 * field.step;
    let count = u32::try_from(floor.triangles().count()).unwrap_or(NONE);
    let mut offer = |middle: Vector<2>, directions: &[Vector<2>]| {
        // From its cell, or from one beside it.
        let way = middle.norm() + field.to_goal(&middle);
        if way > DETOUR * shortest + 8.0 * probe.swing {
            return;
        }
        for direction in directions {
            // Either sense is the same line.
            let is_left = direction.x < -SAME || direction.x <= SAME && direction.y < 0.0;
            let direction = if is_left { -direction } else { *direction };
            axes.push(GateAxis { middle, direction, way });
        }
    };
    for index in 0..count {
        probe.budget.step(STEPS_PER_FACE)?;
        let face = floor.face(index);
        let corners = face.vertices.map(|vertex| probe.in_frame(&floor.vertex(vertex)));
        let edge = |edge: usize| corners[(edge + 1) % 3] - corners[edge];
        // Too small for any gap.
        if (0..3).all(|side| edge(side).norm() <= probe.width()) {
            continue;
        }
        for side in 0..3 {
            let (from, way) = (corners[side], edge(side));
            let length = way.norm();
            if face.is_wall[side] {
                // From the corner opposite.
                let along = way / length;
                let apart = corners[(side + 2) % 3] - from;
                let foot = apart.dot(&along);
                let across = apart - along * foot;
                let gap = across.norm();
                let inside = SAME * length..(1.0 - SAME) * length;
                if inside.contains(&foot) && probe.width() < gap && gap < wide {
                    offer(from + along * foot + across / 2.0, &[along]);
                }
            } else if face.across[side] > index
                && face.across[side] != NONE
                && probe.width() < length
                && length < wide
                && is_narrowest(probe, (face, index, side))
            {
                let middle = from + way / 2.0;
                let along = way / length;
                offer(middle, &[Vector::<2>::new(-along.y, along.x)]);
                for end in [face.vertices[side], face.vertices[(side + 1) % 3]] {
                    let at = probe.in_frame(&floor.vertex(end));
                    floor.walls_at(end, |other| {
                        let direction = (probe.in_frame(&floor.vertex(other)) - at).normalize();
                        // Along the gap it does not lead through.
                        if direction.dot(&along).abs() < 0.9 {
                            offer(middle, &[direction]);
                        }
                    });
                }
            }
        }
    }
    // In an order that does not depend on the triangulation, nor on rounding.
    let unit = SAME * probe.swing;
    let key = |axis: &GateAxis| {
        let GateAxis { middle, direction, way } = axis;
        [way / unit, middle.x / unit, middle.y / unit, direction.x / SAME, direction.y / SAME]
            .map(|part| libm::round(part) as i64)
    };
    axes.sort_by_key(key);
    axes.dedup_by_key(|axis| key(axis));
    axes.truncate(MOST_LINES);
    Ok(())
}

/// Whether no vertex is in the circle about an edge, nor on it: the edge is the narrowest place
/// there, and an edge of every such triangulation.
fn is_narrowest(probe: &Probe<'_>, (face, index, side): (&Face, u32, usize)) -> bool {
    let floor = probe.errand.floor;
    let ends = [side, (side + 1) % 3].map(|at| floor.vertex(face.vertices[at]));
    let square = (ends[1] - ends[0]).norm_squared();
    let other = floor.face(face.across[side]);
    let Some(back) = other.edge_to(index) else { return false };
    [face.vertices[(side + 2) % 3], other.vertices[(back + 2) % 3]].into_iter().all(|apex| {
        let apex = floor.vertex(apex);
        (ends[0] - apex).dot(&(ends[1] - apex)) > SAME * square
    })
}
