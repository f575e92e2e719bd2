//! A body that translates out of a part or into it, in one view.

use std::fmt::Write;

use schemas::message::Trajectory;

use super::mark;
use super::motion::Course;
use super::plot::{Pixel, Plot, distance, ring, simplified};
use super::style;
use super::text::Px;
use super::world::{Point, Shape, first, point};

/// The most vertices of a body that are drawn.
const MOST_VERTICES: usize = 200;
/// The most boxes of a body that are drawn.
const MOST_SHAPES: usize = 200;
/// The most outlines at way-points.
const MOST_GHOSTS: usize = 40;
/// Pixels between the faint outlines on the way.
const BETWEEN: f64 = 26.0;

/// The body where it is assembled, and its motion.
pub(super) fn draw(out: &mut String, plot: &Plot, body: &[Shape], answer: Option<&Trajectory>) {
    let outlines: Vec<Vec<Pixel>> = body
        .iter()
        .take(MOST_SHAPES)
        .map(|shape| {
            let outline = shape.outline(plot.axes).into_iter().map(|p| plot.flat(p));
            simplified(outline, MOST_VERTICES)
        })
        .collect();
    let [i, j] = plot.axes;
    let shifted = |outline: &[Pixel], by: Point| -> Vec<Pixel> {
        let (right, down) = (by[i] * plot.scale, -by[j] * plot.scale);
        outline.iter().map(|[x, y]| [x + right, y + down]).collect()
    };
    let moved = |out: &mut String, by: Point| {
        out.push_str(r#"<path d=""#);
        for outline in &outlines {
            ring(out, shifted(outline, by).into_iter(), MOST_VERTICES);
        }
        out.push_str(r#""/>"#);
    };
    let blue = style::BODY;
    let motion = answer.map(Course::of);
    if let Some(motion) = &motion {
        let (length, ends) = (motion.length(), motion.ends());
        let between = (BETWEEN / plot.scale).max(length / 24.0);
        _ = write!(
            out,
            r#"<g class="ghosts" fill="{blue}" fill-opacity="0.035" stroke="{blue}" stroke-opacity="0.22" stroke-width="0.7">"#
        );
        let mut begin = 0.0;
        for end in ends.iter().take(MOST_GHOSTS) {
            let count = ((end - begin) / between).clamp(0.0, 24.0) as usize;
            for step in 1..count {
                let at = begin + (end - begin) * step as f64 / count as f64;
                if let Some(placement) = motion.placement(at) {
                    moved(out, placement.position);
                }
            }
            begin = *end;
        }
        _ = write!(
            out,
            r#"</g><g class="way-points" fill="none" stroke="{blue}" stroke-width="1.1">"#
        );
        for placement in thinned(&motion.way_points(), MOST_GHOSTS) {
            moved(out, placement.position);
        }
        out.push_str("</g>");
    }
    _ = write!(
        out,
        r#"<g class="body" fill="{}" fill-opacity="0.85" stroke="{blue}" stroke-width="1.6">"#,
        style::BODY_FILL
    );
    moved(out, [0.0; 3]);
    out.push_str("</g>");
    let (Some(answer), Some(motion)) = (answer, &motion) else { return };

    let begin = first(body);
    plot.path(out, motion, begin);
    arrow(out, plot, motion, begin);
    let mut busy = dots(out, plot, motion, begin);
    let clearance = &answer.clearance;
    if let (true, Some(placement)) = (clearance.value.is_finite(), motion.placement(clearance.at)) {
        let wall = point(&clearance.wall);
        let by = placement.position;
        let local = std::array::from_fn(|axis| wall[axis] - by[axis]);
        let squared =
            |p: &Point| (0..3).map(|i| (p[i] - local[i]) * (p[i] - local[i])).sum::<f64>();
        let near = body.iter().map(|shape| shape.nearest(local));
        let near = near.min_by(|a, b| squared(a).total_cmp(&squared(b))).unwrap_or(local);
        let near = std::array::from_fn(|axis| near[axis] + by[axis]);
        busy.extend(along(plot, motion, begin));
        outlines.iter().for_each(|outline| busy.extend(rim(&shifted(outline, by))));
        mark::clearance(out, plot, wall, near, clearance.value, &busy);
    }
}

/// Pixels along the path, close enough that no label slips between.
pub(super) fn along(plot: &Plot, motion: &Course, offset: Point) -> Vec<Pixel> {
    let length = motion.length();
    let count = (length * plot.scale / 8.0).clamp(1.0, 400.0) as usize;
    let at = |step: usize| motion.placement(length * step as f64 / count as f64);
    let placements = (0..=count).filter_map(at);
    placements.map(|p| plot.pixel(std::array::from_fn(|i| p.position[i] + offset[i]))).collect()
}

/// Pixels along a closed outline.
pub(super) fn rim(outline: &[Pixel]) -> Vec<Pixel> {
    let next = outline.iter().cycle().skip(1);
    let edge = |(a, b): (&Pixel, &Pixel)| {
        let count = (distance(*a, *b) / 8.0).clamp(1.0, 100.0) as usize;
        let (a, b) = (*a, *b);
        (0..count).map(move |step| {
            let part = step as f64 / count as f64;
            [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]
        })
    };
    outline.iter().zip(next).flat_map(edge).collect()
}

/// A dot per way-point, as far as they can be told apart; and where the dots are.
pub(super) fn dots(out: &mut String, plot: &Plot, motion: &Course, offset: Point) -> Vec<Pixel> {
    let color = style::PATH;
    _ = write!(out, r##"<g class="dots" fill="{color}" stroke="#fff" stroke-width="0.8">"##);
    let mut drawn: Vec<Pixel> = Vec::new();
    for placement in thinned(&motion.way_points(), 400) {
        let pixel = plot.pixel(std::array::from_fn(|i| placement.position[i] + offset[i]));
        if drawn.last().is_none_or(|last| distance(*last, pixel) > 1.0) {
            let [x, y] = pixel.map(Px);
            _ = write!(out, r#"<circle cx="{x}" cy="{y}" r="2.8"/>"#);
            drawn.push(pixel);
        }
    }
    out.push_str("</g>");
    drawn
}

/// At most about `most` of a list, evenly, the first and the last among them.
pub(super) fn thinned<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    let stride = all.len().div_ceil(most).max(1);
    let last = all.len().saturating_sub(1);
    let kept = move |(index, _): &(usize, &T)| index % stride == 0 || *index == last;
    all.iter().enumerate().filter(kept).map(|(_, item)| item)
}

/// An arrow in the direction of travel.
fn arrow(out: &mut String, plot: &Plot, motion: &Course, offset: Point) {
    let Some((from, to)) = motion.longest_line() else { return };
    let [from, to] = [from, to].map(|p| plot.pixel(std::array::from_fn(|i| p[i] + offset[i])));
    let length = distance(from, to);
    if length < 30.0 {
        return;
    }
    let u = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    let tip = [from[0] + u[0] * length * 0.56, from[1] + u[1] * length * 0.56];
    let corner = |side: f64| {
        [tip[0] - u[0] * 9.0 - side * u[1] * 4.2, tip[1] - u[1] * 9.0 + side * u[0] * 4.2]
    };
    out.push_str(r#"<path class="arrow" d=""#);
    ring(out, [tip, corner(1.0), corner(-1.0)].into_iter(), 3);
    _ = write!(out, r#"" fill="{}"/>"#, style::PATH);
}
