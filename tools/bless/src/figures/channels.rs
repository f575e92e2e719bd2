//! Section 4's cavity: its channels with their axes, and the junctions between them.

use planning::budget::Budget;
use planning::free_space::{Chain, End};
use planning::geometry::{AxisBox, Direction, Sign, Vector};
use schemas::message::{Body, FreeSpace, Solid};

use super::drawing::{Anchor, Drawing, Point, View};
use super::motion::{common, corners, flat, read};

const SCENE: &str = include_str!("../../../../recordings/scenes/disassemble.json");
const UP: Direction = Direction { axis: 1, sign: Sign::Positive };
const AXES: [&str; 2] = ["x", "z"];

pub(crate) fn figure() -> String {
    let section_4 = Section4::read();
    let mut drawing = Drawing::new(
        [792.0, 246.0],
        "Channels, junctions and axes",
        "The cavity of the female part of section 4. Three panels show its channels C3, C2 and \
         C1 with their axes z, x and z; the fourth shows the junctions J2 and J1 and the \
         directions in which they are passed: up, left, up.",
    );
    let count = section_4.channels.len();
    for (index, channel) in section_4.channels.iter().enumerate() {
        let view = view(index);
        section_4.draw_wall(&mut drawing, &view);
        drawing.shape("channel", &view.rectangle(*channel));
        section_4.draw_axis(&mut drawing, &view, index);
        let name = format!("C_{}", count - index);
        let axis = AXES[section_4.chain.axes()[index]];
        caption(&mut drawing, &view, &format!("{name}: axis {axis}"));
    }
    let view = view(count);
    section_4.draw_wall(&mut drawing, &view);
    section_4.draw_junctions(&mut drawing, &view);
    caption(&mut drawing, &view, "J_2, J_1: up, left, up");
    drawing.finish()
}

fn view(panel: usize) -> View {
    View { corner: [20.0 + 194.0 * panel as f64, 204.0], min: [0.0, 0.0], scale: 21.0 }
}

fn caption(drawing: &mut Drawing, view: &View, text: &str) {
    let [x, y] = view.at([4.0, 0.0]);
    drawing.label("head", Anchor::Middle, [x, y + 24.0], text);
}

struct Section4 {
    channels: Vec<[Point; 2]>,
    wall: Vec<Point>,
    body: [Point; 2],
    chain: Chain<2>,
}

impl Section4 {
    fn read() -> Self {
        let scene = read(SCENE);
        let FreeSpace { channels, solids, .. } = &scene.free_space;
        let channels: Vec<_> = channels.iter().flatten().map(corners).collect();
        let wall = match solids.iter().flatten().next() {
            Some(Solid::Polygon(vertices)) => vertices.iter().map(flat).collect(),
            other => panic!("the female part is a polygon, not {other:?}"),
        };
        let body = match &scene.body {
            Body::Polygon(vertices) => bounds(vertices.iter().map(flat)),
            other => panic!("the male part is a polygon, not {other:?}"),
        };
        let boxes: Vec<_> = channels
            .iter()
            .map(|[min, max]| AxisBox::new((*min).into(), (*max).into()).expect("a channel"))
            .collect();
        let mut chain = Chain::default();
        let center = [(body[0][0] + body[1][0]) / 2.0, (body[0][1] + body[1][1]) / 2.0];
        chain
            .build(&boxes, &Vector::from(center), End::Exit(UP), &Budget::default())
            .expect("section 4's chain");
        Self { channels, wall, body, chain }
    }

    fn draw_wall(&self, drawing: &mut Drawing, view: &View) {
        drawing.shape("wall", &view.ring(&self.wall));
    }

    fn draw_axis(&self, drawing: &mut Drawing, view: &View, index: usize) {
        let [min, max] = self.channels[index];
        let axis = self.chain.axes()[index];
        let mut middle = [(min[0] + max[0]) / 2.0, (min[1] + max[1]) / 2.0];
        let center = view.at(middle);
        for end in [min[axis] + 0.35, max[axis] - 0.35] {
            middle[axis] = end;
            drawing.arrow("axis", center, view.at(middle));
        }
    }

    fn draw_junctions(&self, drawing: &mut Drawing, view: &View) {
        let count = self.channels.len() - 1;
        for index in 0..count {
            let junction = common(self.channels[index], self.channels[index + 1]);
            drawing.shape("junction", &view.rectangle(junction));
            let [x, y] = match index {
                0 => view.at(junction[1]),
                _ => view.at([junction[0][0], junction[1][1]]),
            };
            let (anchor, aside) =
                if index == 0 { (Anchor::End, -5.0) } else { (Anchor::Start, 5.0) };
            let name = format!("J_{}", count - index);
            drawing.label("math over", anchor, [x + aside, y + 17.0], &name);
        }
        drawing.shape("ghost", &view.rectangle(self.body));
        // From the body's centre over the junctions' centres to the mouth.
        let [min, max] = self.body;
        let mut from = [(min[0] + max[0]) / 2.0, (min[1] + max[1]) / 2.0];
        drawing.circle("dot", view.at(from), 2.5);
        for junction in self.chain.junctions() {
            let center = junction.space.center();
            let to = [center[0], center[1]];
            drawing.arrow("path", view.at(from), view.at(to));
            from = to;
        }
        drawing.arrow("path", view.at(from), view.at([from[0], 7.9]));
    }
}

fn bounds(points: impl Iterator<Item = Point>) -> [Point; 2] {
    points.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[min, max], [x, y]| {
        [[min[0].min(x), min[1].min(y)], [max[0].max(x), max[1].max(y)]]
    })
}
