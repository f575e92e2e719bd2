//! A scene as the peers see it: polygons, a rectangle, a start and a goal.

use serde_json::{Value, json};

use crate::Point;

/// Where a robot is: its reference point and its heading, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Reference point, metres.
    pub position: Point,
    /// Radians counter-clockwise from +x.
    pub heading: f64,
}

/// A robot among polygons.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Outlines of what is solid, metres.
    pub solids: Vec<Vec<Point>>,
    /// The outline that it all lies in.
    pub room: Vec<Point>,
    /// Width and length of the robot, its reference point in the middle; metres.
    pub footprint: [f64; 2],
    /// Where it stands.
    pub start: Pose,
    /// Where it goes.
    pub goal: Point,
    /// How it must stand there.
    pub goal_heading: Option<f64>,
    /// Whether it may drive backwards.
    pub reverse: bool,
    /// The direction of most walls, radians.
    pub grain: f64,
}

impl Scene {
    /// All edges.
    #[must_use]
    pub fn walls(&self) -> Vec<[Point; 2]> {
        let outlines = self.solids.iter().chain(std::iter::once(&self.room));
        outlines
            .flat_map(|outline| {
                let ends = outline.iter().cycle().skip(1);
                outline.iter().zip(ends).map(|(from, to)| [*from, *to])
            })
            .collect()
    }

    /// Whether a point is inside the room and outside all solids.
    #[must_use]
    pub fn is_free(&self, point: Point) -> bool {
        contains(&self.room, point) && !self.solids.iter().any(|solid| contains(solid, point))
    }

    /// Between samples, metres.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.footprint[1] / 50.0
    }

    /// The request that a planner gets, for a gap. The room's outline becomes solids around it.
    #[must_use]
    pub fn to_json(&self, gap: f64) -> String {
        self.request(&json!({ "gap": gap }), &json!({ "spacing": self.spacing() })).to_string()
    }

    /// The request for a clearance of any form.
    #[must_use]
    pub fn request(&self, clearance: &Value, sampling: &Value) -> Value {
        let mut solids: Vec<_> =
            self.solids.iter().map(|solid| json!({ "polygon": solid })).collect();
        solids.extend(self.frame().iter().map(|solid| json!({ "polygon": solid })));
        let [min, max] = self.bounds();
        let mut goal = json!({ "position": self.goal });
        if let Some(heading) = self.goal_heading {
            goal["heading"] = json!(heading);
        }
        json!({
            "task": "drive",
            "free_space": { "solids": solids, "bounds": { "min": min, "max": max } },
            "body": { "footprint": { "width": self.footprint[0], "length": self.footprint[1] } },
            "start": { "position": self.start.position, "heading": self.start.heading },
            "goal": goal,
            "clearance": clearance,
            "reverse": self.reverse,
            "sampling": sampling,
        })
    }

    /// A box around the room, a robot's length away.
    fn bounds(&self) -> [Point; 2] {
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for point in &self.room {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(point[axis] - self.footprint[1]);
                bounds[1][axis] = bounds[1][axis].max(point[axis] + self.footprint[1]);
            }
        }
        bounds
    }

    /// What lies between the room, which is convex, and its bounds: a quadrangle for each side.
    fn frame(&self) -> Vec<Vec<Point>> {
        let center = {
            let sum = self.room.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
            sum.map(|value| value / self.room.len() as f64)
        };
        let out = |point: Point| {
            [center[0] + 3.0 * (point[0] - center[0]), center[1] + 3.0 * (point[1] - center[1])]
        };
        let ends = self.room.iter().cycle().skip(1);
        self.room.iter().zip(ends).map(|(a, b)| vec![*a, *b, out(*b), out(*a)]).collect()
    }
}

/// Whether a polygon contains a point, by the crossings of a ray.
#[must_use]
pub fn contains(polygon: &[Point], point: Point) -> bool {
    let ends = polygon.iter().cycle().skip(1);
    polygon.iter().zip(ends).fold(false, |inside, (a, b)| {
        let crosses = (a[1] > point[1]) != (b[1] > point[1])
            && point[0] < (b[0] - a[0]) * (point[1] - a[1]) / (b[1] - a[1]) + a[0];
        inside != crosses
    })
}
