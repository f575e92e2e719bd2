//! Cells that a robot passes over although they are as grey as unknown ones.

use std::collections::BTreeSet;
use std::fmt;

use floor_plan::FloorPlan;
use render::picture::motion::{Course, Placement};
use schemas::message::{Body, Reply, SceneRequest};

/// What the answers to a scene pass over.
#[derive(Debug, PartialEq)]
pub(crate) struct GreyCells {
    /// How many cells.
    count: usize,
    /// The middle of the first on the way, metres.
    first: [f64; 2],
    /// What makes them free.
    free_threshold: f64,
}

impl fmt::Display for GreyCells {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, first: [x, y], free_threshold } = self;
        let (cells, they, them) = match count {
            1 => ("1 cell".to_owned(), "it is", "it"),
            count => (format!("{count} cells"), "they are", "them"),
        };
        write!(
            f,
            "the robot passes over {cells} that free_thresh {free_threshold} makes free although \
             {they} as grey as unknown, first at ({x:.3}, {y:.3}) m; free_thresh 0.196 closes {them}"
        )
    }
}

/// The grey cells that the robot passes over in any of the answers.
pub(crate) fn passed_over(
    plan: &FloorPlan,
    scene: &SceneRequest,
    reply: &Reply,
) -> Option<GreyCells> {
    let Body::Footprint(footprint) = scene.body else { return None };
    let answers = reply.answers.as_ref().ok()?;
    if !plan.grid().has_grey() {
        return None;
    }
    let cell = plan.frame().resolution();
    let sides = Sides {
        front: footprint.front() / cell,
        rear: footprint.rear() / cell,
        half_width: footprint.width() / cell / 2.0,
    };
    let reach = libm::hypot(sides.front.max(sides.rear), sides.half_width) * cell;
    let (mut passed, mut first) = (BTreeSet::new(), None);
    for answer in answers.iter().flatten() {
        // Half a cell: nothing that matters is stepped over.
        for placement in Course::of(answer).placements(cell / 2.0, reach) {
            sides.touched(plan, &placement, |touched| {
                first.get_or_insert(touched);
                passed.insert(touched);
            });
        }
    }
    let first = plan.frame().middle(first?);
    Some(GreyCells { count: passed.len(), first, free_threshold: plan.free_threshold() })
}

/// How far the robot reaches from its reference point, in cells.
struct Sides {
    front: f64,
    rear: f64,
    half_width: f64,
}

impl Sides {
    /// The grey cells that the robot touches in a placement, from the lowest.
    fn touched(&self, plan: &FloorPlan, placement: &Placement, mut each: impl FnMut([u32; 2])) {
        let [x, y, _] = placement.position;
        let [px, py] = plan.frame().locate([x, y]);
        // The heading in the picture, whichever way that is turned.
        let cell = plan.frame().resolution();
        let (sin, cos) = (libm::sin(placement.heading) * cell, libm::cos(placement.heading) * cell);
        let [qx, qy] = plan.frame().locate([x + cos, y + sin]);
        let (cos, sin) = (qx - px, qy - py);
        // The middle of the rectangle, and half its sides.
        let ahead = (self.front - self.rear) / 2.0;
        let (mx, my) = (px + ahead * cos, py + ahead * sin);
        let (half_length, half_width) = ((self.front + self.rear) / 2.0, self.half_width);
        let reach = [
            half_length * cos.abs() + half_width * sin.abs(),
            half_length * sin.abs() + half_width * cos.abs(),
        ];
        let grid = plan.grid();
        let columns = range(mx, reach[0], grid.width());
        let rows = range(my, reach[1], grid.height());
        // Half of what a cell measures along and across the robot.
        let half_cell = (cos.abs() + sin.abs()) / 2.0;
        for row in rows {
            for column in columns.clone().filter(|column| grid.is_grey(*column, row)) {
                let (dx, dy) = (column as f64 + 0.5 - mx, row as f64 + 0.5 - my);
                let along = (dx * cos + dy * sin).abs() < half_length + half_cell;
                let across = (dy * cos - dx * sin).abs() < half_width + half_cell;
                if along && across {
                    each([column as u32, row as u32]);
                }
            }
        }
    }
}

/// The cells that an interval touches, of so many.
fn range(middle: f64, reach: f64, count: usize) -> std::ops::Range<usize> {
    let end = |at: f64| at.clamp(0.0, count as f64) as usize;
    end((middle - reach).floor())..end((middle + reach).ceil())
}
