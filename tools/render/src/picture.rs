//! A scene and its answers as an SVG picture, for papers, readmes and reports.
//!
//! Assembly tasks are drawn in (x, z), driving in (x, y), three dimensions along each axis.
//! Several answers are drawn side by side at one scale. Equal scenes and replies give equal
//! bytes. Pictures use no scripts, style sheets or fonts, and never exceed [`MOST_BYTES`].

mod assembly;
mod caption;
mod coverage;
mod drive;
mod free_space;
mod mark;
pub mod motion;
mod place;
mod plot;
mod style;
mod text;
mod world;

use std::fmt::Write;

use schemas::message::{Direction, Refusal, Reply, SceneRequest, Solid, Task, Trajectory};

use caption::{CaptionLine, Shown, Sign};
use free_space::Mouth;
use motion::Course;
use plot::Plot;
use text::{Escaped, Px};
use world::{Extent, Mover, Point, World, first};

/// The size of the largest picture.
pub const MOST_BYTES: usize = 2_000_000;

/// Answers that are drawn; of more, this many, spread evenly.
const MOST_PANELS: usize = 9;
/// Space between panels and around them, pixels.
const SPACE: f64 = 22.0;
const LINE: f64 = 17.0;
const HEAD: f64 = 52.0;

/// What one panel shows.
struct Panel<'a> {
    /// The answer's index; `None` if the whole request is refused.
    index: Option<usize>,
    content: Result<&'a Trajectory, &'a Refusal>,
}

/// What a picture shows beyond the scene and its reply.
#[derive(Debug, Clone, Copy, Default)]
pub struct Look<'a> {
    /// Channels that the planner made, and junctions, in floor plans.
    pub mesh: bool,
    /// Those parts of a floor plan's solids that are solid only because nothing is known there.
    pub unknown: &'a [Solid],
    /// The only answer that is drawn, from 0.
    pub only: Option<usize>,
    /// A motion to compare with, drawn over the others.
    pub before: Option<&'a Trajectory>,
    /// A place on the path where the motions are far apart: before, and now.
    pub apart: Option<[[f64; 3]; 2]>,
}

/// Draws a scene and the reply to it.
pub fn draw(scene: &SceneRequest, reply: &Reply) -> String {
    draw_with(scene, reply, Look::default())
}

/// Draws a scene and the reply to it in a look of its own.
pub fn draw_with(scene: &SceneRequest, reply: &Reply, look: Look) -> String {
    let panels = panels(reply, look.only);
    let world = World::of(scene);
    let region = region(scene, &world, &panels, look);
    let shown = shown(scene, &world, &panels, look);
    let wide = region[1][0] - region[0][0] > 2.5 * (region[1][1] - region[0][1]);
    let columns = match (world.dimension, panels.len()) {
        (3, _) | (_, 1) => 1,
        _ if wide => 1,
        (_, 2 | 4) => 2,
        _ => 3,
    };
    let plots = plots(scene, &world, &region, columns);
    let numbers = plots.iter().map(Plot::room_for_numbers).fold(0.0, f64::max);
    let across = plots.iter().map(|plot| plot.width + numbers).sum::<f64>() - numbers
        + SPACE * (plots.len() - 1) as f64;
    let panel_width = across.max(if columns == 1 { 330.0 } else { 232.0 });
    let plot_height = plots.iter().map(|plot| plot.height).fold(0.0, f64::max);

    let answers = reply.answers.as_ref().map_or(0, Vec::len);
    let caption = |panel: &Panel| match (&panel.content, panel.index) {
        (Ok(answer), index) => {
            caption::answered(scene, (index.unwrap_or(0), answers), answer, panel_width)
        }
        (Err(refusal), index) => {
            caption::refused(scene, index.map(|index| (index, answers)), refusal, panel_width)
        }
    };
    let captions: Vec<Vec<CaptionLine>> = panels.iter().map(caption).collect();

    let mut body = String::new();
    let mut backgrounds: Vec<(String, String)> = Vec::new();
    let mut y = HEAD;
    let rows = panels.chunks(columns).zip(captions.chunks(columns));
    for (panels, captions) in rows {
        for (column, (panel, lines)) in panels.iter().zip(captions).enumerate() {
            let x = SPACE + numbers + column as f64 * (panel_width + SPACE);
            _ = write!(body, r#"<g class="answer" transform="translate({} {})">"#, Px(x), Px(y));
            let upright = column == 0;
            let (plots, world) = (&plots, &world);
            let views = Views { scene, world, plots, numbers, upright, plot_height, look };
            views.draw(&mut body, panel, &mut backgrounds);
            for (index, line) in lines.iter().enumerate() {
                let y = plot_height + 38.0 + index as f64 * LINE;
                caption_line(&mut body, y, line);
            }
            body.push_str("</g>");
        }
        let lines = captions.iter().map(Vec::len).max().unwrap_or(0);
        y += plot_height + 38.0 + lines as f64 * LINE + 10.0;
    }
    let width = SPACE * 2.0 + numbers + panel_width * columns as f64 + SPACE * (columns - 1) as f64;
    y = legend(&mut body, &caption::legend(scene, &shown), width, y);
    finish(scene, reply, panels.len(), &backgrounds, &body, [width, y])
}

/// What the legend has to explain.
fn shown(scene: &SceneRequest, world: &World, panels: &[Panel], look: Look) -> Shown {
    let answers = || panels.iter().filter_map(|panel| panel.content.ok());
    let motion = answers().next().is_some();
    let drive = scene.task == Task::Drive;
    let has_junctions = |panel: &Panel| !junctions_of(scene, world, panel.content.ok()).is_empty();
    let turns = |answer: &Trajectory| Course::of(answer).turns().next().is_some();
    let reverse = |answer: &Trajectory| !Course::of(answer).reversed().is_empty();
    Shown {
        motion,
        junctions: (look.mesh || !world.is_floor_plan) && panels.iter().any(has_junctions),
        walls: world.is_floor_plan,
        unknown: world.is_floor_plan && !look.unknown.is_empty(),
        before: look.before.is_some(),
        apart: look.apart.is_some(),
        turns: drive && answers().any(turns),
        reverse: drive && answers().any(reverse),
    }
}

/// The junctions on the way of an answer, or of the chain that is given.
fn junctions_of(
    scene: &SceneRequest,
    world: &World,
    answer: Option<&Trajectory>,
) -> Vec<[Point; 2]> {
    let channels = world.channels_of(answer);
    let route: Vec<usize> = match answer {
        Some(answer) => answer.route.iter().map(|index| *index as usize).collect(),
        None if scene.free_space.in_order => (0..channels.len()).collect(),
        None => Vec::new(),
    };
    world::junctions(&channels, route.into_iter(), world.dimension)
}

fn panels(reply: &Reply, only: Option<usize>) -> Vec<Panel<'_>> {
    if let (Some(index), Ok(answers)) = (only, &reply.answers)
        && let Some(answer) = answers.get(index)
    {
        return vec![Panel { index: Some(index), content: answer.as_ref() }];
    }
    match &reply.answers {
        Err(refusal) => vec![Panel { index: None, content: Err(refusal) }],
        Ok(answers) => {
            let shown = answers.len().min(MOST_PANELS);
            let spread = |at: usize| match shown {
                0 | 1 => 0,
                _ => at * (answers.len() - 1) / (shown - 1),
            };
            let panel = |at: usize| {
                let index = spread(at);
                Panel { index: Some(index), content: answers[index].as_ref() }
            };
            (0..shown).map(panel).collect()
        }
    }
}

/// What all panels show: everything at rest, and the body wherever it goes.
fn region(scene: &SceneRequest, world: &World, panels: &[Panel], look: Look) -> [Point; 2] {
    let mut extent: Extent = world.extent();
    let answers = panels.iter().filter_map(|panel| panel.content.ok());
    for answer in answers.chain(look.before) {
        for corners in &world.channels_of(Some(answer)) {
            corners.iter().for_each(|corner| extent.add(*corner));
        }
        let motion = Course::of(answer);
        match &world.mover {
            Mover::Part(shapes) => {
                let mut reach = Extent::default();
                motion.way_points().iter().for_each(|placement| reach.add(placement.position));
                for by in reach.corners() {
                    shapes.iter().for_each(|shape| shape.grow(&mut extent, by));
                }
            }
            Mover::Robot(robot) => {
                let reach = drive::reach(&motion, robot);
                reach.into_iter().for_each(|corner| extent.add(corner));
            }
        }
    }
    let ends = [scene.start.map(|pose| pose.position), scene.goal.map(|goal| goal.position)];
    ends.iter().flatten().for_each(|position| extent.add(world::point(position)));
    extent.padded(0.05, world.dimension)
}

/// The views of one panel, at the scale that all panels share.
fn plots(scene: &SceneRequest, world: &World, region: &[Point; 2], columns: usize) -> Vec<Plot> {
    let [x, y, z]: Point = std::array::from_fn(|i| region[1][i] - region[0][i]);
    if world.dimension == 3 {
        let scale = (760.0 / (x + y + x)).min(300.0 / z.max(y));
        let view = |axes, names| Plot::new(region, axes, names, scale);
        return vec![view([0, 2], ["x", "z"]), view([1, 2], ["y", "z"]), view([0, 1], ["x", "y"])];
    }
    let names = if scene.task == Task::Drive { ["x", "y"] } else { ["x", "z"] };
    let (wide, high) = match columns {
        1 if x > 2.5 * y => (760.0, 440.0),
        1 if world.is_floor_plan => (760.0, 640.0),
        1 => (520.0, 440.0),
        2 => (340.0, 380.0),
        _ => (300.0, 360.0),
    };
    let scale = (wide / x).min(high / y);
    vec![Plot::new(region, [0, 1], names, scale)]
}

/// What the panels share.
struct Views<'a> {
    scene: &'a SceneRequest,
    world: &'a World,
    plots: &'a [Plot],
    /// Room for the numbers of an upward axis, pixels.
    numbers: f64,
    upright: bool,
    plot_height: f64,
    look: Look<'a>,
}

impl Views<'_> {
    fn draw(&self, out: &mut String, panel: &Panel, backgrounds: &mut Vec<(String, String)>) {
        let Self { scene, world, look, .. } = self;
        let (answer, refusal) = (panel.content.ok(), panel.content.err());
        let channels = world.channels_of(answer);
        let mouth = mouth(scene, world, answer, &channels);
        let junctions = junctions_of(scene, world, answer);
        let mut x = 0.0;
        for (index, plot) in self.plots.iter().enumerate() {
            let y = self.plot_height - plot.height;
            _ = write!(out, r#"<g transform="translate({} {})">"#, Px(x), Px(y));
            // A nested svg element clips what reaches beyond it.
            let (w, h) = (Px(plot.width), Px(plot.height));
            _ = write!(out, r#"<svg class="view" width="{w}" height="{h}">"#);
            let walls = match world.is_floor_plan {
                true => {
                    let mesh = if look.mesh { channels.as_slice() } else { &[] };
                    free_space::draw_floor_plan(plot, world, look.unknown, mesh)
                }
                false => free_space::draw(plot, world, &channels, mouth),
            };
            let id = background(backgrounds, walls);
            _ = write!(out, r##"<use href="#{id}"/>"##);
            if look.mesh || !world.is_floor_plan {
                free_space::junctions(out, plot, &junctions, refusal.and_then(|r| r.junction));
            }
            match &world.mover {
                Mover::Part(shapes) => assembly::draw(out, plot, shapes, answer),
                Mover::Robot(robot) => {
                    drive::draw(out, plot, robot, scene, answer);
                    let places = refusal.map(place::of).unwrap_or_default();
                    if !places.is_empty() {
                        free_space::place(out, plot, &places);
                    }
                }
            }
            compared(out, plot, &world.mover, look);
            out.push_str("</svg>");
            plot.axes(out, self.upright || index > 0);
            out.push_str("</g>");
            x += plot.width + SPACE + self.numbers;
        }
    }
}

/// The motion to compare with, and where it is far from this one.
fn compared(out: &mut String, plot: &Plot, mover: &Mover, look: &Look) {
    let offset = match mover {
        Mover::Part(shapes) => first(shapes),
        Mover::Robot(_) => [0.0; 3],
    };
    if let Some(before) = look.before {
        let dashes = format!(r#"stroke="{}" stroke-width="2" stroke-dasharray="5 3""#, style::TURN);
        plot.path_in(out, &Course::of(before), offset, ["before", &dashes]);
    }
    if let Some(apart) = look.apart {
        let place = |p: Point| plot.pixel(std::array::from_fn(|i| p[i] + offset[i])).map(Px);
        let alert = style::TURN;
        let [[x0, y0], [x1, y1]] = apart.map(|position| place(position.map(world::tame)));
        _ = write!(
            out,
            r#"<g class="apart" stroke="{alert}" stroke-width="2" fill="none"><path d="M{x0} {y0}L{x1} {y1}"/><circle cx="{x0}" cy="{y0}" r="6"/><circle cx="{x1}" cy="{y1}" r="6"/></g>"#
        );
    }
}

/// The channels' mouth, if they have one (docs/interface.md: `exit`).
fn mouth(
    scene: &SceneRequest,
    world: &World,
    answer: Option<&Trajectory>,
    channels: &[[Point; 2]],
) -> Option<Mouth> {
    if scene.task == Task::Drive {
        return None;
    }
    let exit = answer.and_then(|answer| answer.exit);
    let exit = exit.or(scene.exit.first().copied()).unwrap_or(Direction::PlusZ);
    let (axis, up) = world::axis(exit, world.dimension)?;
    let reach = |corners: &[Point; 2]| if up { corners[1][axis] } else { -corners[0][axis] };
    let at = match scene.free_space.in_order {
        true => channels.last().map(reach)?,
        false => channels.iter().map(reach).max_by(f64::total_cmp)?,
    };
    Some(Mouth { axis, up, at: if up { at } else { -at } })
}

/// The name of a background: equal for equal backgrounds in all pictures, so that several
/// pictures can share a page.
fn background(backgrounds: &mut Vec<(String, String)>, markup: String) -> String {
    if let Some((id, _)) = backgrounds.iter().find(|(_, known)| *known == markup) {
        return id.clone();
    }
    // FNV-1a.
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
    let hash = markup.bytes().fold(0xcbf2_9ce4_8422_2325, mix);
    let id = format!("scene-{hash:016x}");
    backgrounds.push((id.clone(), markup));
    id
}

fn caption_line(out: &mut String, y: f64, line: &CaptionLine) {
    let (size, weight) = if line.bold { (13, "bold") } else { (12, "normal") };
    let color = line.color;
    _ = write!(out, r#"<g font-size="{size}" font-weight="{weight}" fill="{color}">"#);
    plot::text(out, [0.0, y], "start", &line.text);
    out.push_str("</g>");
}

/// Draws the legend below `y`; returns where the picture ends.
fn legend(out: &mut String, signs: &[(Sign, &str)], width: f64, y: f64) -> f64 {
    let (mut x, mut y) = (SPACE, y + 4.0);
    _ = write!(out, r#"<g class="legend" font-size="11" fill="{}">"#, style::SUBTLE);
    for (sign, meaning) in signs {
        let room = 26.0 + text::width(meaning, 11.0) + 14.0;
        if x > SPACE && x + room > width - SPACE + 14.0 {
            (x, y) = (SPACE, y + 18.0);
        }
        _ = write!(
            out,
            r#"<g transform="translate({} {})">{}</g>"#,
            Px(x),
            Px(y),
            picture_of(*sign)
        );
        plot::text(out, [x + 26.0, y + 4.0], "start", meaning);
        x += room;
    }
    out.push_str("</g>");
    y + 20.0
}

/// A sign, 20 pixels wide, centred on height 0.
fn picture_of(sign: Sign) -> String {
    let (blue, green, ink, alert) = (style::BODY, style::GOAL, style::PATH, style::ALERT);
    let square = |look: String| format!(r#"<rect x="3" y="-6" width="14" height="12" {look}/>"#);
    let filled = |fill: &str, edge: &str| {
        square(format!(r#"fill="{fill}" stroke="{edge}" stroke-width="1.4""#))
    };
    match sign {
        Sign::Body => filled(style::BODY_FILL, blue),
        Sign::Goal => filled(style::GOAL_FILL, green),
        Sign::Ghost => square(format!(r#"fill="none" stroke="{blue}" stroke-width="1.1""#)),
        Sign::Path => format!(
            r#"<path d="M0 0h20" stroke="{ink}" stroke-width="1.6"/><circle cx="10" r="2.8" fill="{ink}"/>"#
        ),
        Sign::Circle => format!(
            r#"<circle cx="10" r="7" fill="none" stroke="{}" stroke-width="0.9" stroke-dasharray="3 2.5"/>"#,
            style::SUBTLE
        ),
        Sign::Clearance => {
            format!(r#"<circle cx="10" r="5" fill="none" stroke="{alert}" stroke-width="1.6"/>"#)
        }
        Sign::Wall => square(format!(r#"fill="{}""#, style::SOLID)),
        Sign::Unknown => square(format!(
            r#"fill="{}" stroke="{}" stroke-width="0.6""#,
            style::UNKNOWN,
            style::FRAME
        )),
        Sign::Turn => format!(
            r#"<path d="M4 4A7 7 0 0 1 16 0" fill="none" stroke="{0}" stroke-width="1.8"/><path d="M12.8 0L16.4 5L19.2 0Z" fill="{0}"/>"#,
            style::TURN
        ),
        Sign::Reverse => {
            format!(r#"<path d="M0 0h20" stroke="{}" stroke-width="2.6"/>"#, style::REVERSE)
        }
        Sign::Before => format!(
            r#"<path d="M0 0h20" stroke="{}" stroke-width="2" stroke-dasharray="5 3"/>"#,
            style::TURN
        ),
        Sign::Apart => format!(
            r#"<circle cx="10" r="6" fill="none" stroke="{}" stroke-width="2"/>"#,
            style::TURN
        ),
        Sign::Junction => square(format!(
            r#"fill="{}" fill-opacity="0.18" stroke="{}" stroke-width="0.6""#,
            style::JUNCTION,
            style::CHANNEL_EDGE
        )),
    }
}

fn finish(
    scene: &SceneRequest,
    reply: &Reply,
    shown: usize,
    backgrounds: &[(String, String)],
    body: &str,
    [width, height]: [f64; 2],
) -> String {
    let (task, detail) = caption::title(scene, reply, shown);
    let (w, h) = (Px(width), Px(height));
    let mut out = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}" viewBox="0 0 {w} {h}" font-family="sans-serif" role="img"><title>{}</title>"#,
        Escaped(&format!("{task} {detail}"))
    );
    out.push_str("<defs>");
    for (id, markup) in backgrounds {
        _ = write!(out, r#"<g id="{id}">{markup}</g>"#);
    }
    _ = write!(out, r##"</defs><rect width="{w}" height="{h}" fill="#fff"/>"##);
    _ = write!(out, r#"<g font-size="15" font-weight="bold" fill="{}">"#, style::INK);
    plot::text(&mut out, [SPACE, 22.0], "start", &task);
    _ = write!(out, r#"</g><g font-size="11" fill="{}">"#, style::SUBTLE);
    let detail = text::wrap(&detail, 11.0, width - 2.0 * SPACE, 1).pop().unwrap_or_default();
    plot::text(&mut out, [SPACE, 39.0], "start", &detail);
    out.push_str("</g>");
    out.push_str(body);
    out.push_str("</svg>\n");
    out
}

#[cfg(test)]
mod tests;
