//! How far it makes sense to look.

use super::{Run, Sight};
use crate::any_angle::disc::distance_to;
use crate::any_angle::pockets::Pockets;
use crate::any_angle::sight::way_through;
use crate::budget::Spent;
use crate::free_space::floor::NONE;
use crate::free_space::walls::Wall;
use crate::geometry::Vector;
use crate::geometry::distance::{cross, distance_segment_segment};

impl Run<'_> {
    /// Finds the pockets of the disc, which need not be looked into from here on. Where it is
    /// docked, its radius differs from place to place, and there are none.
    pub(super) fn find_pockets(&mut self) -> Result<(), Spent> {
        let Self { floor, disc, radii, budget, .. } = *self;
        let search = &mut *self.search;
        budget.step(Pockets::steps(floor) + radii.own.len() as u64)?;
        let width = 2.0 * (disc.radius - disc.rounding);
        if let Some(pockets) = search.arcs.front().pockets(floor, width) {
            pockets.open_from(floor, &search.end_faces, budget)?;
            search.beyond_gates = Some(2.0 * radii.most().max(disc.radius) + disc.rounding);
        }
        Ok(())
    }

    /// The gate of the pocket that a face is in, or `NONE`.
    pub(super) fn gate_of(&mut self, face: u32) -> Result<u32, Spent> {
        let Self { floor, budget, .. } = *self;
        match self.pockets() {
            Some(pockets) => pockets.gate(floor, face, budget),
            None => Ok(NONE),
        }
    }

    /// Notes in which pockets the views lead.
    pub(super) fn note_gates(&mut self, views: [Option<Sight>; 2]) -> [Option<Sight>; 2] {
        let Some(pockets) = self.pockets() else { return views };
        views.map(|view| {
            let Sight { face, edge, gate, .. } = view?;
            Some(Sight { gate: pockets.gate_beyond(face, edge, gate), ..view? })
        })
    }

    fn pockets(&mut self) -> Option<&Pockets> {
        self.search.beyond_gates?;
        self.search.arcs.front().known_pockets()
    }

    fn gate(&self, gate: u32) -> Wall<2> {
        let (face, edge) = (self.floor.face(gate / 3), gate as usize % 3);
        let [from, to] = [edge, (edge + 1) % 3].map(|at| self.floor.vertex(face.vertices[at]));
        Wall { from, to }
    }

    /// Whether a point in a pocket may be turned about.
    pub(super) fn is_near_gate(&self, gate: u32, point: &Vector<2>) -> bool {
        let Some(most) = self.search.beyond_gates else { return true };
        gate == NONE || distance_to(&self.gate(gate), point) <= most
    }

    /// Whether nothing that is seen through a window in a pocket may be turned about.
    fn is_beyond_gate(&self, gate: u32, [right, left]: &[Vector<2>; 2]) -> bool {
        let Some(most) = self.search.beyond_gates else { return false };
        let Wall { from, to } = self.gate(gate);
        distance_segment_segment((right, left), (&from, &to)).distance > most
    }

    /// Whether a line that touches a vertex can be meant: beyond a junction too narrow for the
    /// disc, only where the disc touches it before the junction.
    pub(super) fn is_within_reach(&self, sight: &Sight, point: &Vector<2>) -> bool {
        let near_narrow =
            || (self.floor.vertex(sight.narrow) - point).norm() <= 5.0 * self.disc.radius;
        self.is_near_gate(sight.gate, point) && (sight.narrow == NONE || near_narrow())
    }

    /// Notes that a junction is too narrow for the disc, unless the root is beside it.
    pub(super) fn note_narrow(&self, root: u32, sight: &mut Sight) {
        let most = self.disc.radius;
        let ends = sight.ends(self.floor.face(sight.face));
        let [right, left] = ends.map(|end| self.floor.vertex(end));
        let width = (left - right).norm_squared();
        if width < 4.0 * most * most
            && width.sqrt()
                < self.disc.radius_at(&right) + self.disc.radius_at(&left)
                    - 2.0 * self.disc.rounding
            && distance_to(
                &Wall { from: right, to: left },
                &self.search.roots[root as usize].circle.center,
            ) >= 3.0 * most
        {
            sight.narrow = ends[0];
        }
    }

    /// No path from a root on through what is seen is shorter; `None` if none leads there.
    pub(super) fn least(&self, index: u32, sight: &mut Sight) -> Option<f64> {
        let root = &self.search.roots[index as usize];
        let center = root.circle.center;
        let window = sight.window(self.floor, &center);
        let most = self.disc.radius;
        if sight.narrow == NONE {
            self.note_narrow(index, sight);
        } else {
            let near = self.floor.vertex(sight.narrow);
            if distance_to(&Wall { from: window[0], to: window[1] }, &near) > 5.0 * most {
                return None;
            }
        }
        if sight.gate != NONE && self.is_beyond_gate(sight.gate, &window) {
            return None;
        }
        let own = root.circle.signed_radius;
        if root.vertex != NONE {
            // A line to the other side of a circle leads at most two radii to the side.
            let sense = own.signum();
            let left = |direction: &Vector<2>, point: &Vector<2>| {
                sense * cross(direction, &(point - center))
            };
            let first = &root.arrival.direction;
            if window.iter().all(|point| left(first, point) < -2.0 * most) {
                return None;
            }
            let last = &root.last_direction;
            if window.iter().all(|point| left(last, point) > 0.0 && left(first, point) >= 0.0) {
                return None;
            }
        }
        let goal = &self.disc.goal;
        // The line goes from circle to circle, not from centre to centre: at the same part of
        // both, it is up to a radius beside the window, at a right angle, and it is shorter by at
        // most both radii if it leads to the other side.
        let shorter = 2.0 * most + own.abs();
        let way = way_through(&center, &window, goal) - shorter;
        Some(root.length + way.max(root.to_goal))
    }
}
