//! Drawing an SVG: scenes in metres, text in pixels, one style sheet for light and dark themes.

use std::fmt::Write;

/// Metres in a view, or pixels to the right and down.
pub(super) type Point = [f64; 2];

/// Okabe and Ito's colours on greys, as in the pictures of `plan`. The card behind is opaque, so
/// text stays legible where a viewer announces no theme.
const STYLE: &str = "\
text{font:13px sans-serif;fill:#1f2328;stroke:none}\
.head{font-weight:bold}\
.note{fill:#59636e;font-size:12px}\
.math{font-style:italic}\
.over{paint-order:stroke;stroke:#fff;stroke-width:4px;stroke-linejoin:round}\
.alert{fill:#b34700}\
.card,.free{fill:#fff}\
.wall{fill:#d9dde2;stroke:#6e7781}\
.channel{fill:#0072b2;fill-opacity:.14;stroke:#0072b2}\
.layer{fill:#0072b2;fill-opacity:.07;stroke:#0072b2;stroke-opacity:.55}\
.junction{fill:#e69f00;fill-opacity:.25;stroke:#9a6a00;stroke-width:.8}\
.swept{fill:#0072b2;fill-opacity:.13;stroke:#0072b2;stroke-opacity:.5;stroke-width:.8}\
.body{fill:#8fc0df;fill-opacity:.85;stroke:#0072b2;stroke-width:1.5}\
.ghost{fill:none;stroke:#0072b2;stroke-width:1.1}\
.path{fill:none;stroke:#1f2328;stroke-width:1.8;stroke-linejoin:round}\
.tip,.dot{fill:#1f2328}\
.light,.limit{fill:none;stroke:#59636e;stroke-width:1}\
.light-tip{fill:#59636e}\
.limit{stroke-width:1.3}\
.guide{fill:none;stroke:#59636e;stroke-width:1.1;stroke-dasharray:4 3}\
.axis{fill:none;stroke:#0072b2;stroke-width:2}\
.axis-tip{fill:#0072b2}\
.curve{fill:none;stroke:#0072b2;stroke-width:2;stroke-linejoin:round}\
.gap{fill:none;stroke:#d55e00;stroke-width:1.8}\
.gap-dot{fill:#d55e00}\
.passed{fill:#fff;stroke:#1f2328;stroke-width:1.4}\
.grid{stroke:#d9dde2}\
@media (prefers-color-scheme:dark){\
text{fill:#e6edf3}\
.note{fill:#9da7b1}\
.over{stroke:#0d1117}\
.alert{fill:#f0954a}\
.card,.free,.passed{fill:#0d1117}\
.wall{fill:#343b44;stroke:#8b949e}\
.channel{fill:#56b4e9;fill-opacity:.2;stroke:#56b4e9}\
.layer{fill:#56b4e9;fill-opacity:.09;stroke:#56b4e9}\
.junction{fill-opacity:.3;stroke:#e69f00}\
.swept{fill:#56b4e9;fill-opacity:.18;stroke:#56b4e9}\
.body{fill:#1b5a85;stroke:#56b4e9}\
.ghost,.axis,.curve{stroke:#56b4e9}\
.axis-tip{fill:#56b4e9}\
.path,.passed{stroke:#e6edf3}\
.tip,.dot{fill:#e6edf3}\
.light,.limit,.guide{stroke:#9da7b1}\
.light-tip{fill:#9da7b1}\
.gap{stroke:#f0883e}\
.gap-dot{fill:#f0883e}\
.grid{stroke:#343b44}}";

/// A figure.
pub(super) struct Drawing {
    text: String,
}

/// Which end of a text is at its point.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Drawing {
    /// An empty figure of a size in pixels, with what it shows in words.
    pub(super) fn new(size: Point, title: &str, description: &str) -> Self {
        let [width, height] = size.map(number);
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" aria-labelledby=\"title desc\">\n\
             <title id=\"title\">{title}</title>\n<desc id=\"desc\">{description}</desc>\n\
             <style>{STYLE}</style>\n\
             <rect class=\"card\" width=\"{width}\" height=\"{height}\" rx=\"6\"/>\n"
        );
        Self { text }
    }

    /// The SVG.
    pub(super) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    pub(super) fn shape(&mut self, class: &str, data: &str) {
        _ = writeln!(self.text, "<path class=\"{class}\" d=\"{data}\"/>");
    }

    pub(super) fn circle(&mut self, class: &str, center: Point, radius: f64) {
        let ([x, y], r) = (center.map(number), number(radius));
        _ = writeln!(self.text, "<circle class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"{r}\"/>");
    }

    pub(super) fn line(&mut self, class: &str, from: Point, to: Point) {
        self.shape(class, &format!("M{}L{}", pair(from), pair(to)));
    }

    /// A line that ends in a tip; its class is `class`, its tip's `class-tip` (`tip` for
    /// a path).
    pub(super) fn arrow(&mut self, class: &str, from: Point, to: Point) {
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        let length = libm::hypot(x, y);
        let [x, y] = [x / length, y / length];
        let base = [to[0] - 9.0 * x, to[1] - 9.0 * y];
        self.line(class, from, [to[0] - 6.0 * x, to[1] - 6.0 * y]);
        let [left, right] = [1.0, -1.0].map(|s| [base[0] - 4.0 * s * y, base[1] + 4.0 * s * x]);
        let tip = if class == "path" { "tip".to_owned() } else { format!("{class}-tip") };
        self.shape(&tip, &format!("M{}L{}L{}Z", pair(to), pair(left), pair(right)));
    }

    /// A distance between two points, with a dot at each.
    pub(super) fn distance(&mut self, from: Point, to: Point) {
        self.line("gap", from, to);
        self.circle("gap-dot", from, 2.4);
        self.circle("gap-dot", to, 2.4);
    }

    /// A text; `_x` and `_{xy}` are subscripts.
    pub(super) fn label(&mut self, class: &str, anchor: Anchor, at: Point, label: &str) {
        let [x, y] = at.map(number);
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        _ = write!(
            self.text,
            "<text class=\"{class}\" x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\">"
        );
        let mut parts = label.split('_');
        self.text.push_str(parts.next().unwrap_or_default());
        for part in parts {
            let (below, rest) = match part.strip_prefix('{').and_then(|part| part.split_once('}')) {
                Some(split) => split,
                None => part.split_at(part.chars().next().map_or(0, char::len_utf8)),
            };
            // Viewers drop a space at the beginning of a part, so it is a distance.
            let (across, rest) = match rest.strip_prefix(' ') {
                Some(rest) => (4, rest),
                None => (0, rest),
            };
            _ = write!(
                self.text,
                "<tspan dy=\"3\" font-size=\"10\">{below}</tspan>\
                 <tspan dx=\"{across}\" dy=\"-3\">{rest}</tspan>"
            );
        }
        self.text.push_str("</text>\n");
    }
}

/// A scene to scale.
#[derive(Clone, Copy)]
pub(super) struct View {
    /// Where the scene's point `min` is, pixels.
    pub(super) corner: Point,
    /// Metres.
    pub(super) min: Point,
    /// Pixels per metre.
    pub(super) scale: f64,
}

impl View {
    pub(super) fn at(&self, [x, y]: Point) -> Point {
        let [left, bottom] = self.corner;
        [left + (x - self.min[0]) * self.scale, bottom - (y - self.min[1]) * self.scale]
    }

    pub(super) fn ring(&self, points: &[Point]) -> String {
        let points: Vec<_> = points.iter().map(|point| pair(self.at(*point))).collect();
        format!("M{}Z", points.join("L"))
    }

    pub(super) fn rectangle(&self, [min, max]: [Point; 2]) -> String {
        self.ring(&[min, [max[0], min[1]], max, [min[0], max[1]]])
    }

    pub(super) fn polyline(&self, points: &[Point]) -> String {
        let points: Vec<_> = points.iter().map(|point| pair(self.at(*point))).collect();
        format!("M{}", points.join("L"))
    }

    /// The rest of a path: the arc to `to`.
    pub(super) fn arc_to(&self, radius: f64, sweep: f64, to: Point) -> String {
        let (r, to) = (number(radius * self.scale), pair(self.at(to)));
        let large = u8::from(sweep.abs() > std::f64::consts::PI);
        format!("A{r} {r} 0 {large} {} {to}", u8::from(sweep < 0.0))
    }

    /// An arc by itself.
    pub(super) fn arc(&self, center: Point, radius: f64, start: f64, sweep: f64) -> String {
        let [from, to] = [start, start + sweep].map(|angle| polar(center, radius, angle));
        format!("M{}{}", pair(self.at(from)), self.arc_to(radius, sweep, to))
    }
}

/// The point at an angle and a distance from another.
pub(super) fn polar(center: Point, radius: f64, angle: f64) -> Point {
    let (sin, cos) = libm::sincos(angle);
    [center[0] + radius * cos, center[1] + radius * sin]
}

fn pair(point: Point) -> String {
    format!("{} {}", number(point[0]), number(point[1]))
}

/// Two decimals at most.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}
