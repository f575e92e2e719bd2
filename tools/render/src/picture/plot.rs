//! One view of a scene: metres to pixels, the axes, and what is drawn to scale.

use std::f64::consts::TAU;
use std::fmt::Write;

use schemas::message::Curve;

use super::motion::{self, Course};
use super::style;
use super::text::{self, Escaped, Px};
use super::world::Point;

/// A point in a plot, pixels to the right and down from its upper left corner.
pub(super) type Pixel = [f64; 2];

/// Lines and arcs of a path.
const MOST_COMMANDS: usize = 1500;

/// Straight pieces in which a clothoid is drawn.
const CLOTHOID_PIECES: usize = 24;

/// A view along one axis.
#[derive(Clone)]
pub(super) struct Plot {
    /// The coordinates that run to the right and up.
    pub(super) axes: [usize; 2],
    /// What they are called.
    pub(super) names: [&'static str; 2],
    /// The lower left corner, metres.
    pub(super) min: [f64; 2],
    /// Pixels per metre.
    pub(super) scale: f64,
    /// Pixels.
    pub(super) width: f64,
    /// Pixels.
    pub(super) height: f64,
}

impl Plot {
    /// The view of a region at a scale.
    pub(super) fn new(
        region: &[Point; 2],
        axes: [usize; 2],
        names: [&'static str; 2],
        scale: f64,
    ) -> Self {
        let [i, j] = axes;
        let [min, max] = region;
        let (width, height) = ((max[i] - min[i]) * scale, (max[j] - min[j]) * scale);
        Self { axes, names, min: [min[i], min[j]], scale, width, height }
    }

    pub(super) fn pixel(&self, p: Point) -> Pixel {
        self.flat([p[self.axes[0]], p[self.axes[1]]])
    }

    /// A point that has only the view's coordinates.
    pub(super) fn flat(&self, p: [f64; 2]) -> Pixel {
        let x = (p[0] - self.min[0]) * self.scale;
        [x, self.height - (p[1] - self.min[1]) * self.scale]
    }

    /// The axes: a frame, some round numbers, and the names. `upright` says whether the
    /// numbers of the upward axis are written too.
    pub(super) fn axes(&self, out: &mut String, upright: bool) {
        let (w, h) = (self.width, self.height);
        let frame = style::FRAME;
        _ = write!(
            out,
            r#"<rect width="{}" height="{}" fill="none" stroke="{frame}"/>"#,
            Px(w),
            Px(h)
        );
        let grey = style::SUBTLE;
        _ = write!(out, r#"<g font-size="10" fill="{grey}" stroke="none">"#);
        let numbers = labels(self.min[0], w / self.scale, w);
        let mut free_from = f64::NEG_INFINITY;
        for (value, label) in &numbers {
            let x = self.flat([*value, 0.0])[0];
            let half = text::width(label, 10.0) / 2.0;
            _ = write!(out, r#"<path d="M{} {}v4" stroke="{frame}"/>"#, Px(x), Px(h));
            if x - half > free_from {
                text(out, [x, h + 15.0], "middle", label);
                free_from = x + half + 6.0;
            }
        }
        for (value, label) in labels(self.min[1], h / self.scale, h) {
            let y = self.flat([0.0, value])[1];
            _ = write!(out, r#"<path d="M0 {}h-4" stroke="{frame}"/>"#, Px(y));
            if upright {
                text(out, [-7.0, y + 3.5], "end", &label);
            }
        }
        out.push_str("</g>");
        for look in [style::HALO, r#"stroke="none""#] {
            _ = write!(out, r#"<g font-size="12" font-style="italic" fill="{grey}" {look}>"#);
            text(out, [w - 7.0, h - 6.0], "end", self.names[0]);
            text(out, [7.0, 14.0], "start", self.names[1]);
            out.push_str("</g>");
        }
    }

    /// Room that the numbers of the upward axis take.
    pub(super) fn room_for_numbers(&self) -> f64 {
        let labels = labels(self.min[1], self.height / self.scale, self.height);
        let widths = labels.iter().map(|(_, label)| text::width(label, 10.0));
        widths.fold(0.0, f64::max) + 12.0
    }

    /// The path of the reference point, moved by `offset`: lines and true arcs.
    pub(super) fn path(&self, out: &mut String, motion: &Course, offset: Point) {
        let look = format!(r#"stroke="{}" stroke-width="1.6""#, style::PATH);
        self.path_in(out, motion, offset, ["path", &look]);
    }

    /// A path of a class and look of its own.
    pub(super) fn path_in(
        &self,
        out: &mut String,
        motion: &Course,
        offset: Point,
        [class, look]: [&str; 2],
    ) {
        let mut fine = 0.25;
        // Details too small to see are left out, more and more until few enough remain.
        let path = loop {
            if let Some(path) = self.path_data(motion, offset, fine) {
                break path;
            }
            fine *= 2.0;
        };
        _ = write!(
            out,
            r#"<path class="{class}" d="{path}" fill="none" {look} stroke-linejoin="round" stroke-linecap="round"/>"#
        );
    }

    /// `None` if it takes too many commands.
    fn path_data(&self, motion: &Course, offset: Point, fine: f64) -> Option<String> {
        let place = |p: Point| self.pixel(std::array::from_fn(|i| p[i] + offset[i]));
        let (mut data, mut commands) = (String::new(), 0);
        let mut pen: Option<Pixel> = None;
        let mut skipped = None;
        for curve in motion.curves() {
            let (from, to) = (place(motion::begin(curve)), place(motion::end(curve)));
            if pen.is_none() {
                _ = write!(data, "M{} {}", Px(from[0]), Px(from[1]));
                pen = Some(from);
            }
            let run = match curve {
                Curve::Arc { radius, sweep, .. } => {
                    radius.abs() * sweep.abs().min(TAU) * self.scale
                }
                Curve::Clothoid { length, .. } => length * self.scale,
                _ => distance(pen.unwrap_or(from), to),
            };
            if !run.is_finite() || run < fine {
                skipped = Some(to);
                continue;
            }
            skipped = None;
            commands += 1;
            if commands > MOST_COMMANDS {
                return None;
            }
            match curve {
                Curve::Arc { radius, sweep, .. } => {
                    if pen.is_some_and(|pen| distance(pen, from) > 0.01) {
                        _ = write!(data, "L{} {}", Px(from[0]), Px(from[1]));
                    }
                    let [radius, sweep] = [radius * self.scale, *sweep];
                    // More than half a circle is drawn in pieces: an SVG arc would be ambiguous.
                    let pieces = (sweep.abs().min(TAU) / 3.0).ceil().max(1.0) as usize;
                    for piece in 1..=pieces {
                        let to = place(motion::along(curve, piece as f64 / pieces as f64));
                        let left = if sweep > 0.0 { 0 } else { 1 };
                        let r = Px(radius);
                        _ = write!(data, "A{r} {r} 0 0 {left} {} {}", Px(to[0]), Px(to[1]));
                    }
                }
                Curve::Clothoid { .. } => {
                    for piece in 1..=CLOTHOID_PIECES {
                        let part = piece as f64 / CLOTHOID_PIECES as f64;
                        let to = place(motion::along(curve, part));
                        _ = write!(data, "L{} {}", Px(to[0]), Px(to[1]));
                    }
                }
                _ => _ = write!(data, "L{} {}", Px(to[0]), Px(to[1])),
            }
            pen = Some(to);
        }
        if let Some(end) = skipped {
            _ = write!(data, "L{} {}", Px(end[0]), Px(end[1]));
        }
        Some(data)
    }
}

pub(super) fn distance(a: Pixel, b: Pixel) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// A closed outline as path data, [`simplified`].
pub(super) fn ring(out: &mut String, pixels: impl Iterator<Item = Pixel>, most: usize) {
    let kept = simplified(pixels, most);
    for (index, [x, y]) in kept.iter().enumerate() {
        _ = write!(out, "{}{} {}", if index == 0 { 'M' } else { 'L' }, Px(*x), Px(*y));
    }
    if !kept.is_empty() {
        out.push('Z');
    }
}

/// An outline without the vertices that fall on the one before, and with at most `most`.
pub(super) fn simplified(pixels: impl Iterator<Item = Pixel>, most: usize) -> Vec<Pixel> {
    let mut kept: Vec<Pixel> = Vec::new();
    for pixel in pixels {
        if kept.last().is_none_or(|last| distance(*last, pixel) > 0.1) {
            kept.push(pixel);
        }
    }
    let stride = kept.len().div_ceil(most.max(3)).max(1);
    kept.into_iter().step_by(stride).collect()
}

/// A line of text.
pub(super) fn text(out: &mut String, [x, y]: Pixel, anchor: &str, text: &str) {
    let (x, y) = (Px(x), Px(y));
    _ = write!(out, r#"<text x="{x}" y="{y}" text-anchor="{anchor}">{}</text>"#, Escaped(text));
}

/// Ticks, the last with the unit.
fn labels(min: f64, extent: f64, pixels: f64) -> Vec<(f64, String)> {
    let mut ticks = ticks(min, extent, pixels);
    if let Some((_, label)) = ticks.last_mut() {
        label.push_str(" m");
    }
    ticks
}

/// Round numbers from `min` on over `extent` metres, about one every 45 pixels.
fn ticks(min: f64, extent: f64, pixels: f64) -> Vec<(f64, String)> {
    let wished = extent / (pixels / 45.0).max(1.0);
    let power = libm::floor(libm::log10(wished));
    if extent <= 0.0 || !power.is_finite() {
        return Vec::new();
    }
    let ten = libm::pow(10.0, power);
    let step = [1.0, 2.0, 5.0, 10.0].map(|n| n * ten).into_iter().find(|step| *step >= wished);
    let step = step.unwrap_or(10.0 * ten);
    let first = (min / step).ceil();
    let decimals = libm::floor(libm::log10(step * 1.000001)).min(0.0).abs() as usize;
    let far = min.abs().max((min + extent).abs());
    let mut ticks: Vec<(f64, String)> = Vec::new();
    for count in 0..40 {
        let value = (first + f64::from(count)) * step + 0.0;
        if value > min + extent {
            break;
        }
        let label = match far < 1e6 && decimals <= 4 {
            true => format!("{value:.decimals$}"),
            false => format!("{value:.3e}"),
        };
        if ticks.last().is_none_or(|(_, last)| *last != label) {
            ticks.push((value, label));
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_ticks(min: f64, extent: f64, pixels: f64, expected: &[&str]) {
        let labels: Vec<String> = ticks(min, extent, pixels).into_iter().map(|t| t.1).collect();
        assert_eq!(labels, expected);
    }

    #[test]
    fn ticks_are_round_and_sparse() {
        check_ticks(-0.5, 9.0, 300.0, &["0", "2", "4", "6", "8"]);
        check_ticks(0.03, 0.2, 200.0, &["0.05", "0.10", "0.15", "0.20"]);
        check_ticks(
            -4e-7,
            1e-6,
            300.0,
            &["-4.000e-7", "-2.000e-7", "0.000e0", "2.000e-7", "4.000e-7", "6.000e-7"],
        );
        check_ticks(0.0, 0.0, 300.0, &[]);
    }

    #[test]
    fn upward_is_upward() {
        let plot = Plot::new(&[[1.0, 2.0, 0.0], [4.0, 7.0, 0.0]], [0, 1], ["x", "z"], 10.0);
        assert_eq!((plot.width, plot.height), (30.0, 50.0));
        assert_eq!(plot.pixel([1.0, 2.0, 9.0]), [0.0, 50.0]);
        assert_eq!(plot.pixel([4.0, 7.0, 9.0]), [30.0, 0.0]);
    }

    #[test]
    fn rings_keep_within_their_bound() {
        let mut out = String::new();
        ring(&mut out, (0..10_000).map(|i| [f64::from(i), f64::from(i % 2)]), 200);
        assert_eq!(out.matches(['M', 'L']).count(), 200);
    }
}
