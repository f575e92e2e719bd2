//! The least clearance, and labels that find room beside it.

use std::fmt::Write;

use super::plot::{Pixel, Plot, distance, text};
use super::style;
use super::text::{self, Px};
use super::world::Point;

/// Joins the closest points of wall and body and labels their distance.
/// The label avoids `busy` points.
pub(super) fn clearance(
    out: &mut String,
    plot: &Plot,
    wall: Point,
    body: Point,
    value: f64,
    busy: &[Pixel],
) {
    let (from, to) = (plot.pixel(wall), plot.pixel(body));
    let middle = [(from[0] + to[0]) / 2.0, (from[1] + to[1]) / 2.0];
    let alert = style::ALERT;
    _ = write!(out, r#"<g class="clearance" stroke="{alert}" stroke-width="1.6" fill="none">"#);
    if distance(from, to) > 9.0 {
        let [x0, y0, x1, y1] = [from[0], from[1], to[0], to[1]].map(Px);
        _ = write!(out, r#"<path d="M{x0} {y0}L{x1} {y1}"/>"#);
        for [x, y] in [from, to] {
            _ = write!(
                out,
                r#"<circle cx="{}" cy="{}" r="2.2" fill="{alert}" stroke="none"/>"#,
                Px(x),
                Px(y)
            );
        }
    } else {
        let [x, y] = middle;
        _ = write!(out, r#"<circle cx="{}" cy="{}" r="5"/>"#, Px(x), Px(y));
    }
    out.push_str("</g>");
    let label = format!("{} m", text::significant(value));
    let anchor = if distance(from, to) > 9.0 { middle } else { from };
    let mut busy = busy.to_vec();
    busy.extend([from, to]);
    let [x, y] = room(plot, anchor, text::width(&label, 11.0), &busy);
    for look in [style::HALO, r#"stroke="none""#] {
        _ = write!(out, r#"<g font-size="11" font-weight="bold" fill="{alert}" {look}>"#);
        text(out, [x, y], "middle", &label);
        out.push_str("</g>");
    }
}

/// The middle of the base line for a label of this width near a point: within the plot and
/// over as few marks as possible.
fn room(plot: &Plot, near: Pixel, width: f64, busy: &[Pixel]) -> Pixel {
    const HEIGHT: f64 = 11.0;
    let half = width / 2.0;
    let mut best = (f64::INFINITY, near);
    for away in [9.0, 16.0, 26.0, 40.0] {
        for (right, down) in [(1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1)]
        {
            let x = near[0] + f64::from(right) * (half + away);
            let y = near[1] + f64::from(down) * (HEIGHT / 2.0 + away) + HEIGHT * 0.36;
            // Kept within the plot if it fits.
            let x = x.min(plot.width - half - 3.0).max(half + 3.0);
            let y = y.min(plot.height - 4.0).max(HEIGHT + 3.0);
            let under = |p: &&Pixel| {
                (p[0] - x).abs() < half + 3.0 && p[1] > y - HEIGHT - 2.0 && p[1] < y + 4.0
            };
            let cost = busy.iter().filter(under).count() as f64 * 6.0 + away;
            if cost < best.0 {
                best = (cost, [x, y]);
            }
        }
    }
    best.1
}
