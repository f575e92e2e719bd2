//! Walls, channels and junctions: everything at rest in a view.

use std::fmt::Write;

use schemas::message::Solid;

use super::coverage::covered;
use super::plot::{Pixel, Plot, ring};
use super::style;
use super::text::Px;
use super::world::{self, Point, Shape, World};

/// With more vertices than this, only the covered area is drawn.
const MOST_VERTICES: usize = 6000;
/// The same for a floor plan's walls, which are all there is to see.
const MOST_OF_A_PLAN: usize = 40_000;
/// With more solids than this, none has an edge.
const FEW_SOLIDS: usize = 60;
/// With more junctions than this, none are tinted.
const MOST_JUNCTIONS: usize = 300;

/// The free space beyond the channels: everything on one side of a plane.
#[derive(Clone, Copy)]
pub(super) struct Mouth {
    pub(super) axis: usize,
    /// Whether it opens towards greater coordinates.
    pub(super) up: bool,
    /// Metres.
    pub(super) at: f64,
}

/// Walls and channels.
pub(super) fn draw(
    plot: &Plot,
    world: &World,
    channels: &[[Point; 2]],
    mouth: Option<Mouth>,
) -> String {
    let mut out = String::new();
    let outlines = |shapes: &[Shape]| outlines(plot, shapes);
    let boxes: Vec<Shape> = channels.iter().map(|corners| Shape::Box(*corners)).collect();
    let (solids, channels) = (outlines(&world.solids), outlines(&boxes));
    let bounds: Vec<Shape> = world.bounds.iter().map(|corners| Shape::Box(*corners)).collect();
    let flat = world.dimension == 2;

    // Walls are the solids, or all that is not channel.
    let carved = if world.solids.is_empty() { channels.clone() } else { outlines(&bounds) };
    if flat && !carved.is_empty() {
        let wall = style::WALL;
        let [x, y, w, h] = closed_side(plot, mouth);
        let (x, y, w, h) = (Px(x), Px(y), Px(w), Px(h));
        _ = write!(out, r#"<rect x="{x}" y="{y}" width="{w}" height="{h}" fill="{wall}"/>"#);
        area(&mut out, plot, &carved, r##"fill="#fff""##, false, MOST_VERTICES);
    }
    if !solids.is_empty() {
        // The edges of very many solids would hide them.
        let few = solids.len() <= FEW_SOLIDS;
        let (wall, edge) = match few {
            true => (style::WALL, style::WALL_EDGE),
            false => (style::WALL_EDGE, "none"),
        };
        let opacity = if flat { "1" } else { "0.55" };
        let look = format!(
            r#"fill="{wall}" fill-opacity="{opacity}" stroke="{edge}" stroke-width="0.9" stroke-linejoin="round""#
        );
        area(&mut out, plot, &solids, &look, true, MOST_VERTICES);
    }
    if !channels.is_empty() && fits(&channels, MOST_VERTICES) {
        let edge = style::CHANNEL_EDGE;
        let fill = if flat { "none" } else { "#56b4e9" };
        let look = format!(
            r#"class="channels" fill="{fill}" fill-opacity="0.05" stroke="{edge}" stroke-width="0.8""#
        );
        area(&mut out, plot, &channels, &look, false, MOST_VERTICES);
    }
    out
}

/// A floor plan: dark walls, light where nothing is known, white where robots may drive.
pub(super) fn draw_floor_plan(
    plot: &Plot,
    world: &World,
    unknown: &[Solid],
    mesh: &[[Point; 2]],
) -> String {
    let mut out = String::new();
    let (w, h) = (Px(plot.width), Px(plot.height));
    let (dark, light) = (style::SOLID, style::UNKNOWN);
    _ = write!(out, r#"<rect width="{w}" height="{h}" fill="{dark}"/>"#);
    let bounds: Vec<Shape> = world.bounds.iter().map(|corners| Shape::Box(*corners)).collect();
    area(&mut out, plot, &outlines(plot, &bounds), r##"fill="#fff""##, false, MOST_OF_A_PLAN);
    // Walls are visible however thin they are.
    let walls = format!(r#"class="walls" fill="{dark}" stroke="{dark}" stroke-width="0.8""#);
    area(&mut out, plot, &outlines(plot, &world.solids), &walls, true, MOST_OF_A_PLAN);
    if !unknown.is_empty() {
        let unknown: Vec<Shape> = unknown.iter().flat_map(world::solid).collect();
        let look = format!(r#"class="unknown" fill="{light}""#);
        area(&mut out, plot, &outlines(plot, &unknown), &look, false, MOST_OF_A_PLAN);
    }
    let mesh: Vec<Shape> = mesh.iter().map(|corners| Shape::Box(*corners)).collect();
    let mesh = outlines(plot, &mesh);
    if !mesh.is_empty() && fits(&mesh, MOST_VERTICES) {
        let edge = style::CHANNEL_EDGE;
        let look = format!(
            r#"class="channels" fill="none" stroke="{edge}" stroke-opacity="0.4" stroke-width="0.5""#
        );
        area(&mut out, plot, &mesh, &look, false, MOST_VERTICES);
    }
    out
}

/// Marks a passage between two points of the walls, or the point where a wall is met.
pub(super) fn place(out: &mut String, plot: &Plot, points: &[[f64; 2]]) {
    let alert = style::ALERT;
    _ = write!(out, r#"<g class="place" fill="none" stroke="{alert}" stroke-width="2">"#);
    let pixels: Vec<Pixel> = points.iter().map(|point| plot.flat(*point)).collect();
    if let [[x0, y0], [x1, y1]] = pixels[..] {
        _ = write!(out, r#"<path d="M{} {}L{} {}"/>"#, Px(x0), Px(y0), Px(x1), Px(y1));
    }
    for [x, y] in pixels {
        _ = write!(out, r#"<circle cx="{}" cy="{}" r="6"/>"#, Px(x), Px(y));
    }
    out.push_str("</g>");
}

/// Tints the junctions, the refused one more than the others.
pub(super) fn junctions(
    out: &mut String,
    plot: &Plot,
    junctions: &[[Point; 2]],
    refused: Option<u64>,
) {
    let tint = |out: &mut String, corners: &[Point; 2], look: &str| {
        out.push_str(r#"<path d=""#);
        let outline = Shape::Box(*corners).outline(plot.axes);
        ring(out, outline.into_iter().map(|p| plot.flat(p)), 4);
        _ = write!(out, r#"" {look}/>"#);
    };
    if junctions.len() <= MOST_JUNCTIONS {
        let look = format!(r#"class="junction" fill="{}" fill-opacity="0.13""#, style::JUNCTION);
        junctions.iter().for_each(|corners| tint(out, corners, &look));
    }
    let at_fault = refused.and_then(|index| junctions.get(usize::try_from(index).ok()?));
    if let Some(corners) = at_fault {
        let alert = style::ALERT;
        let look =
            format!(r#"fill="{alert}" fill-opacity="0.22" stroke="{alert}" stroke-width="1.2""#);
        tint(out, corners, &look);
    }
}

fn outlines(plot: &Plot, shapes: &[Shape]) -> Vec<Vec<Pixel>> {
    let pixels =
        |shape: &Shape| shape.outline(plot.axes).into_iter().map(|p| plot.flat(p)).collect();
    shapes.iter().map(pixels).collect()
}

fn fits(outlines: &[Vec<Pixel>], most: usize) -> bool {
    outlines.iter().map(Vec::len).sum::<usize>() <= most
}

/// Outlines as they are, or the area that they cover if there are too many.
fn area(
    out: &mut String,
    plot: &Plot,
    outlines: &[Vec<Pixel>],
    look: &str,
    thin: bool,
    most: usize,
) {
    if fits(outlines, most) {
        out.push_str(r#"<path d=""#);
        for outline in outlines {
            ring(out, outline.iter().copied(), most);
        }
        // Solids may overlap whichever way they run around; each has its own inside.
        _ = write!(out, r#"" {look}/>"#);
    } else {
        let data = covered(outlines, plot.width, plot.height, thin);
        let look = look.split(" stroke").next().unwrap_or(look);
        _ = write!(out, r#"<path d="{data}" {look} shape-rendering="crispEdges"/>"#);
    }
}

/// The part of the plot, as (x, y, width, height), on the inner side of the mouth.
fn closed_side(plot: &Plot, mouth: Option<Mouth>) -> [f64; 4] {
    let (w, h) = (plot.width, plot.height);
    let all = [0.0, 0.0, w, h];
    let Some(Mouth { axis, up, at }) = mouth else { return all };
    let Some(side) = plot.axes.iter().position(|shown| *shown == axis) else { return all };
    let pixel = plot.flat([at, at])[side];
    match (side, up) {
        (0, true) => [0.0, 0.0, pixel.clamp(0.0, w), h],
        (0, false) => [pixel.clamp(0.0, w), 0.0, w - pixel.clamp(0.0, w), h],
        (_, true) => [0.0, pixel.clamp(0.0, h), w, h - pixel.clamp(0.0, h)],
        (_, false) => [0.0, 0.0, w, pixel.clamp(0.0, h)],
    }
}
