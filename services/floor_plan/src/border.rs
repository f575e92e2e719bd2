//! What lies between a turned picture and the box around it.

use crate::frame::MapFrame;
use crate::outlines::Outlines;

/// The sides of a picture, counter-clockwise from its lower left corner: each corner, then
/// the vertices that outlines have on the side that begins there.
pub(crate) fn sides([width, height]: [u32; 2], outlines: &Outlines) -> [Vec<[u32; 2]>; 4] {
    let corners = [[0, 0], [width, 0], [width, height], [0, height]];
    let mut sides = corners.map(|corner| vec![corner]);
    for [x, y] in outlines.iter().flatten().copied() {
        let inner = |c: u32, most: u32| 0 < c && c < most;
        let side = match (x, y) {
            (_, 0) if inner(x, width) => 0,
            (_, _) if x == width && inner(y, height) => 1,
            (_, _) if y == height && inner(x, width) => 2,
            (0, _) if inner(y, height) => 3,
            _ => continue,
        };
        sides[side].push([x, y]);
    }
    for (index, side) in sides.iter_mut().enumerate() {
        // The other coordinate is the same for all.
        side.sort_unstable();
        if index >= 2 {
            side.reverse();
        }
        side.dedup();
    }
    // The corner of a side that runs back is its greatest, so it stays first.
    sides
}

/// Four polygons, each between a side of the turned picture and a corner of the box around
/// it. They have all vertices of the sides, so that no gap is between them and outlines.
pub(crate) fn between(
    frame: &MapFrame,
    sides: &[Vec<[u32; 2]>; 4],
    [min, max]: [[f64; 2]; 2],
) -> impl Iterator<Item = Vec<[f64; 2]>> {
    (0..4).map(move |index| {
        let end = sides[(index + 1) % 4][0];
        let along = sides[index].iter().copied().chain([end]);
        // The picture is to the left of the way along the side, this polygon to the right.
        let mut vertices: Vec<[f64; 2]> = along.map(|corner| frame.place(corner)).collect();
        vertices.reverse();
        let (to, from) = (vertices[0], vertices[vertices.len() - 1]);
        // Where both ends of the side touch the box, its corner is the one beyond the side.
        let beyond = |a: [f64; 2], b: [f64; 2]| (b[0] - a[0], b[1] - a[1]);
        let (dx, dy) = beyond(from, to);
        // To the right of (dx, dy) is (dy, -dx).
        let corner =
            [if dy > 0.0 { max[0] } else { min[0] }, if dx > 0.0 { min[1] } else { max[1] }];
        vertices.push(corner);
        vertices
    })
}
