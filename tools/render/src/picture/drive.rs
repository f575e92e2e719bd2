//! A mobile robot that drives through corridors.

use std::fmt::Write;

use schemas::message::{Curve, SceneRequest, Trajectory};

use super::assembly::{along, dots, rim, thinned};
use super::mark;
use super::motion::{Course, Placement};
use super::plot::{Pixel, Plot, ring};
use super::style;
use super::text::Px;
use super::world::{Point, Robot, point};

/// The most guiding circles that are drawn.
const MOST_CIRCLES: usize = 120;

/// A robot of fewer pixels than this gets a ring.
const SMALL: f64 = 10.0;

/// The robot at the start, at the goal and on the way.
pub(super) fn draw(
    out: &mut String,
    plot: &Plot,
    robot: &Robot,
    scene: &SceneRequest,
    answer: Option<&Trajectory>,
) {
    let (width, length) = (robot.width, robot.length());
    let motion = answer.map(Course::of);
    let rectangle = |out: &mut String, placement: &Placement, tick: bool| {
        out.push_str(r#"<path d=""#);
        let corners = corners(placement, robot);
        ring(out, corners.iter().map(|corner| plot.pixel(*corner)), 4);
        out.push_str(r#""/>"#);
        if tick {
            let [[x0, y0], [x1, y1]] = [corners[0], corners[3]].map(|p| plot.pixel(p).map(Px));
            _ = write!(out, r#"<path d="M{x0} {y0}L{x1} {y1}" stroke-width="3"/>"#);
        }
    };
    // In a large building a ring shows where the robot is.
    let small = |out: &mut String, placement: &Placement| {
        if width.max(length) * plot.scale < SMALL {
            let [x, y] = plot.pixel(placement.position).map(Px);
            _ = write!(out, r#"<circle cx="{x}" cy="{y}" r="7" fill="none"/>"#);
        }
    };
    let (blue, green) = (style::BODY, style::GOAL);
    if let Some(motion) = &motion {
        circles(out, plot, motion);
        _ = write!(
            out,
            r#"<g class="ghosts" fill="{blue}" fill-opacity="0.07" stroke="{blue}" stroke-opacity="0.3" stroke-width="0.7">"#
        );
        for at in between(motion, length) {
            if let Some(placement) = motion.placement(at) {
                rectangle(out, &placement, false);
            }
        }
        _ = write!(
            out,
            r#"</g><g class="way-points" fill="none" stroke="{blue}" stroke-width="1.1">"#
        );
        let way_points = motion.way_points();
        for placement in thinned(&way_points, 60) {
            rectangle(out, placement, true);
        }
        out.push_str("</g>");
    }
    let way_points = motion.as_ref().map(Course::way_points).unwrap_or_default();
    let start = scene
        .start
        .map(|pose| Placement { position: point(&pose.position), heading: tame(pose.heading) });
    let goal = scene.goal.map(|pose| {
        let arrives = way_points.last().map_or(0.0, |last| last.heading);
        let heading = pose.heading.map_or(arrives, tame);
        (
            Placement { position: point(&pose.position), heading },
            pose.heading.is_some() || !way_points.is_empty(),
        )
    });
    if let Some(start) = &start {
        _ = write!(
            out,
            r#"<g class="start" fill="{}" fill-opacity="0.85" stroke="{blue}" stroke-width="1.6">"#,
            style::BODY_FILL
        );
        rectangle(out, start, true);
        small(out, start);
        out.push_str("</g>");
    }
    if let Some((goal, heading_known)) = &goal {
        _ = write!(
            out,
            r#"<g class="goal" fill="{}" fill-opacity="0.85" stroke="{green}" stroke-width="1.6">"#,
            style::GOAL_FILL
        );
        match heading_known {
            true => {
                rectangle(out, goal, true);
                small(out, goal);
            }
            false => {
                let [x, y] = plot.pixel(goal.position).map(Px);
                let r = Px(width.min(length) / 2.0 * plot.scale);
                _ = write!(out, r#"<circle cx="{x}" cy="{y}" r="{r}"/>"#);
            }
        }
        out.push_str("</g>");
    }
    let (Some(answer), Some(motion)) = (answer, &motion) else { return };
    let still = [0.0; 3];
    plot.path(out, motion, still);
    for stretch in motion.reversed() {
        let look = format!(r#"stroke="{}" stroke-width="2.6""#, style::REVERSE);
        plot.path_in(out, &stretch, still, ["reverse", &look]);
    }
    turns(out, plot, motion, width);
    let mut busy: Vec<Pixel> = dots(out, plot, motion, still);
    let clearance = &answer.clearance;
    if let (true, Some(placement)) = (clearance.value.is_finite(), motion.placement(clearance.at)) {
        let wall = point(&clearance.wall);
        busy.extend(along(plot, motion, still));
        busy.extend(rim(&corners(&placement, robot).map(|p| plot.pixel(p))));
        let near = nearest(&placement, robot, wall);
        mark::clearance(out, plot, wall, near, clearance.value, &busy);
    }
}

fn tame(heading: f64) -> f64 {
    if heading.is_finite() { heading } else { 0.0 }
}

/// The guiding circles, dashed, and the corners at their centres.
fn circles(out: &mut String, plot: &Plot, motion: &Course) {
    let grey = style::SUBTLE;
    _ = write!(
        out,
        r#"<g class="circles" fill="none" stroke="{grey}" stroke-width="0.9" stroke-dasharray="3 2.5">"#
    );
    let arcs: Vec<(Point, f64)> = motion
        .curves()
        .filter_map(|curve| match curve {
            Curve::Arc { center, radius, .. } => Some((point(center), radius * plot.scale)),
            _ => None,
        })
        .filter(|(_, radius)| *radius > 1.5)
        .collect();
    for (center, radius) in thinned(&arcs, MOST_CIRCLES) {
        let [x, y] = plot.pixel(*center).map(Px);
        _ = write!(out, r#"<circle cx="{x}" cy="{y}" r="{}"/>"#, Px(*radius));
    }
    _ = write!(out, r#"</g><g fill="{grey}">"#);
    for (center, _) in thinned(&arcs, MOST_CIRCLES) {
        let [x, y] = plot.pixel(*center).map(Px);
        _ = write!(out, r#"<circle cx="{x}" cy="{y}" r="1.8"/>"#);
    }
    out.push_str("</g>");
}

/// The most turns in place that are marked.
const MOST_TURNS: usize = 60;

/// Arrows about the places where the robot turns.
fn turns(out: &mut String, plot: &Plot, motion: &Course, width: f64) {
    let turns: Vec<(Point, f64, f64)> = motion.turns().collect();
    if turns.is_empty() {
        return;
    }
    let color = style::TURN;
    _ = write!(out, r#"<g class="turns" fill="none" stroke="{color}" stroke-width="1.8">"#);
    let r = (0.4 * width * plot.scale).clamp(7.0, 18.0);
    for (position, from, sweep) in thinned(&turns, MOST_TURNS) {
        let [x, y] = plot.pixel(*position);
        let sweep = sweep.clamp(-6.0, 6.0);
        let at =
            |heading: f64, r: f64| [x + r * libm::cos(heading), y - r * libm::sin(heading)].map(Px);
        let ([x0, y0], [x1, y1]) = (at(*from, r), at(from + sweep, r));
        let large = u8::from(sweep.abs() > std::f64::consts::PI);
        let left = u8::from(sweep < 0.0);
        _ = write!(out, r#"<path d="M{x0} {y0}A{r} {r} 0 {large} {left} {x1} {y1}"/>"#, r = Px(r));
        // The tip leads on along the circle.
        let along = sweep.signum() * 5.0 / r;
        let tip =
            [at(from + sweep, r - 3.2), at(from + sweep + along, r), at(from + sweep, r + 3.2)];
        let [[ax, ay], [bx, by], [cx, cy]] = tip;
        _ = write!(
            out,
            r#"<path d="M{ax} {ay}L{bx} {by}L{cx} {cy}Z" fill="{color}" stroke="none"/>"#
        );
    }
    out.push_str("</g>");
}

/// Front left, rear left, rear right, front right.
fn corners(placement: &Placement, robot: &Robot) -> [Point; 4] {
    let (sin, cos) = (libm::sin(placement.heading), libm::cos(placement.heading));
    let [x, y, _] = placement.position;
    let (front, rear, left) = (robot.front, -robot.rear, robot.width / 2.0);
    [(front, left), (rear, left), (rear, -left), (front, -left)]
        .map(|(a, l)| [x + a * cos - l * sin, y + a * sin + l * cos, 0.0])
}

/// The point of the robot that is closest to `target`.
fn nearest(placement: &Placement, robot: &Robot, target: Point) -> Point {
    let (sin, cos) = (libm::sin(placement.heading), libm::cos(placement.heading));
    let [x, y, _] = placement.position;
    let (dx, dy) = (target[0] - x, target[1] - y);
    let ahead = (dx * cos + dy * sin).clamp(-robot.rear, robot.front);
    let left = (dy * cos - dx * sin).clamp(-robot.width / 2.0, robot.width / 2.0);
    [x + ahead * cos - left * sin, y + ahead * sin + left * cos, 0.0]
}

/// Arc lengths at which the robot is shown between the ends of legs: on lines about every
/// length of the robot, on arcs closer.
fn between(motion: &Course, length: f64) -> Vec<f64> {
    let least = motion.length() / 80.0;
    let mut places = Vec::new();
    let mut begin = 0.0;
    for (curve, end) in motion.curves().zip(motion.ends()) {
        let apart = match curve {
            Curve::Arc { .. } | Curve::Clothoid { .. } => length * 0.35,
            _ => length,
        };
        let count = ((end - begin) / apart.max(least)).round().clamp(0.0, 80.0) as usize;
        places.extend((1..count).map(|step| begin + (end - begin) * step as f64 / count as f64));
        begin = end;
    }
    places.truncate(200);
    places
}

/// The corners of the robot at the poses it certainly reaches.
pub(super) fn reach(motion: &Course, robot: &Robot) -> Vec<Point> {
    let way_points = motion.way_points();
    way_points.iter().flat_map(|placement| corners(placement, robot)).collect()
}
