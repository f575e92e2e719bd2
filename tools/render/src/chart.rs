//! A quantity over time or arc length, before and now, as an SVG picture for a page: colours are
//! the page's (`currentColor`, and the classes `before` and `now`).

use std::fmt::Write;

/// Points of a line that are drawn.
const MOST_POINTS: usize = 600;
const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 130.0;
/// Room for the numbers.
const LEFT: f64 = 62.0;
const BELOW: f64 = 20.0;

/// What a chart shows.
#[derive(Debug, Clone, Copy)]
pub struct Chart<'a> {
    /// What is drawn upwards, with its unit.
    pub name: &'a str,
    /// The unit to the right.
    pub unit: &'a str,
    /// Points of the line before; empty if there is none.
    pub before: &'a [[f64; 2]],
    /// Points of the line now; empty if there is none.
    pub now: &'a [[f64; 2]],
}

impl Chart<'_> {
    /// Draws it; nothing if neither line has two points.
    pub fn draw(&self) -> String {
        let Self { name, unit, before, now } = *self;
        let all = || before.iter().chain(now).filter(|point| point.iter().all(|v| v.is_finite()));
        if before.len().max(now.len()) < 2 || all().next().is_none() {
            return String::new();
        }
        let [x0, x1] = range(all().map(|point| point[0]));
        let [y0, y1] = range(all().map(|point| point[1]));
        let place = |[x, y]: [f64; 2]| {
            let right = LEFT + (x - x0) / (x1 - x0) * (WIDTH - LEFT - 8.0);
            [right, 6.0 + (y1 - y) / (y1 - y0) * (HEIGHT - BELOW - 12.0)]
        };
        let (bottom, end) = (HEIGHT - BELOW, WIDTH - 8.0);
        let mut out = format!(
            r#"<svg class="chart" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{name}"><g font-size="10" fill="currentColor"><text x="{LEFT}" y="{HEIGHT}" dy="-6">{}</text><text x="{end}" y="{HEIGHT}" dy="-6" text-anchor="end">{} {unit}</text><text x="56" y="14" text-anchor="end">{}</text><text x="56" y="{bottom}" text-anchor="end">{}</text><text x="56" y="{}" text-anchor="end" font-weight="bold">{name}</text></g><path d="M{LEFT} 4V{bottom}H{end}" fill="none" stroke="currentColor" stroke-opacity="0.4"/>"#,
            short(x0),
            short(x1),
            short(y1),
            short(y0),
            (bottom + 14.0) / 2.0 + 4.0,
        );
        for (class, line) in [("before", before), ("now", now)] {
            if line.len() < 2 {
                continue;
            }
            _ = write!(out, r#"<path class="{class}" fill="none" d=""#);
            let mut pen = 'M';
            for point in thinned(line) {
                if !point.iter().all(|value| value.is_finite()) {
                    pen = 'M';
                    continue;
                }
                let [x, y] = place(point);
                _ = write!(out, "{pen}{x:.1} {y:.1}");
                pen = 'L';
            }
            out.push_str(r#""/>"#);
        }
        out.push_str("</svg>");
        out
    }
}

/// Least and greatest, a little apart.
fn range(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let least = values.clone().fold(f64::INFINITY, f64::min);
    let most = values.fold(f64::NEG_INFINITY, f64::max);
    let room = if most - least > 0.0 { 0.0 } else { least.abs().max(1.0) * 0.5 };
    [least - room, most + room]
}

/// Of each run of points, the first, the least and the greatest: no peak is lost.
fn thinned(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let run = line.len().div_ceil(MOST_POINTS / 3).max(1);
    if run == 1 {
        return line.to_vec();
    }
    let mut kept = Vec::with_capacity(MOST_POINTS + 3);
    for (index, points) in line.chunks(run).enumerate() {
        let by = |one: &&(usize, &[f64; 2]), other: &&(usize, &[f64; 2])| {
            one.1[1].total_cmp(&other.1[1])
        };
        let numbered: Vec<(usize, &[f64; 2])> = points.iter().enumerate().collect();
        let least = numbered.iter().min_by(by).map_or(0, |point| point.0);
        let most = numbered.iter().max_by(by).map_or(0, |point| point.0);
        let mut places = vec![0, least, most];
        if (index + 1) * run >= line.len() {
            places.push(points.len() - 1);
        }
        places.sort_unstable();
        places.dedup();
        kept.extend(places.into_iter().map(|place| points[place]));
    }
    kept
}

fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match (text, value.abs() < 1e6) {
        ("-0", _) => "0".to_owned(),
        (text, true) => text.to_owned(),
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(before: &[[f64; 2]], now: &[[f64; 2]]) -> String {
        Chart { name: "speed, m/s", unit: "s", before, now }.draw()
    }

    #[test]
    fn both_lines_are_drawn_to_one_scale() {
        let drawn = chart(&[[0.0, 0.0], [10.0, 1.0]], &[[0.0, 0.0], [5.0, 2.0]]);
        let document = roxmltree::Document::parse(&drawn).unwrap();
        let line = |class: &str| {
            let mut nodes = document.descendants();
            let node = nodes.find(|node| node.attribute("class") == Some(class)).unwrap();
            node.attribute("d").unwrap().to_owned()
        };
        // From 62 to 552 wide, from 6 to 104 high.
        assert_eq!(line("before"), "M62.0 104.0L552.0 55.0");
        assert_eq!(line("now"), "M62.0 104.0L307.0 6.0");
    }

    #[test]
    fn nothing_to_draw_is_nothing() {
        assert_eq!(chart(&[], &[[0.0, 1.0]]), "");
        assert_eq!(chart(&[[0.0, f64::NAN], [1.0, f64::INFINITY]], &[]), "");
        assert!(!chart(&[], &[[0.0, 1.0], [1.0, 1.0]]).contains("NaN"));
    }

    #[test]
    fn long_lines_keep_their_peaks_and_ends() {
        let mut line: Vec<[f64; 2]> = (0..10_000).map(|i| [f64::from(i), 0.0]).collect();
        line[7_777][1] = 3.0;
        let kept = thinned(&line);
        assert!(kept.len() <= MOST_POINTS + 3, "{}", kept.len());
        assert!(kept.contains(&[7_777.0, 3.0]));
        assert_eq!((kept.first(), kept.last()), (line.first(), line.last()));
    }
}
