//! Channels from solids: a polygon cut into boxes, and maximal free boxes.

use planning::budget::Budget;
use planning::free_space::solids::Solids;
use planning::geometry::polygon::Polygon;
use planning::geometry::{AxisBox, Vector};

use super::drawing::{Anchor, Drawing, Point, View};

/// A solid with steps, and a block.
const STEPPED: [Point; 8] = [
    [0.6, 0.0],
    [5.0, 0.0],
    [5.0, 1.0],
    [3.4, 1.0],
    [3.4, 2.2],
    [1.8, 2.2],
    [1.8, 3.4],
    [0.6, 3.4],
];
const BLOCK: [Point; 4] = [[5.2, 4.0], [7.4, 4.0], [7.4, 5.8], [5.2, 5.8]];
const POLYGONS: [&[Point]; 2] = [&STEPPED, &BLOCK];
const BOUNDS: [Point; 2] = [[0.0, 0.0], [9.0, 7.0]];
const BODY: f64 = 1.0;

pub(crate) fn figure() -> String {
    let mut drawing = Drawing::new(
        [792.0, 350.0],
        "Channels from solids",
        "Left: a solid with steps, cut into boxes, and a block. Right: the channels, all maximal \
         boxes between the solids that are larger than the body on both axes.",
    );
    let left = View { corner: [20.0, 300.0], min: BOUNDS[0], scale: 40.0 };
    let right = View { corner: [412.0, 300.0], ..left };
    let budget = Budget::default();
    let mut solids = Solids::default();
    for polygon in POLYGONS {
        let vertices = polygon.iter().copied().map(Vector::from).collect();
        let polygon = Polygon::new(vertices, &budget).expect("a simple polygon");
        solids.push_polygon(&polygon, &budget).expect("few boxes");
    }
    let bounds = AxisBox::new(BOUNDS[0].into(), BOUNDS[1].into()).expect("a box");
    let mut channels = Vec::new();
    let found = solids.channels(&bounds, &Vector::repeat(BODY), &budget, &mut channels);
    found.expect("few channels");

    let ends = |space: &AxisBox<2>| [space.min(), space.max()].map(|point| [point.x, point.y]);
    for view in [&left, &right] {
        drawing.shape("free", &view.rectangle(BOUNDS));
        drawing.shape("ghost", &view.rectangle(BOUNDS));
    }
    for view in [&left, &right] {
        for polygon in POLYGONS {
            drawing.shape("wall", &view.ring(polygon));
        }
    }
    for solid in solids.boxes() {
        drawing.shape("junction", &left.rectangle(ends(solid)));
    }
    for channel in &channels {
        drawing.shape("layer", &right.rectangle(ends(channel)));
    }
    let side = [[7.85, 5.85], [7.85 + BODY, 5.85 + BODY]];
    drawing.shape("body", &left.rectangle(side));
    let [x, y] = left.at([side[0][0], side[0][1] + BODY / 2.0]);
    drawing.label("note over", Anchor::End, [x - 8.0, y + 4.0], "body");
    let count = format!("Channels: {} maximal free boxes", channels.len());
    for (view, text) in [(&left, "Solids: polygons become boxes"), (&right, &*count)] {
        let [x, y] = view.at([4.5, 0.0]);
        drawing.label("head", Anchor::Middle, [x, y + 26.0], text);
    }
    drawing.finish()
}
