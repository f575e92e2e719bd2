//! A request and its answers as a scene of three dimensions.

use foxglove::messages::{
    Color, CubePrimitive, LinePrimitive, Point3, Pose, Quaternion, SceneEntity,
    SceneEntityDeletion, SceneUpdate, SpherePrimitive, TextPrimitive, Vector3, line_primitive,
    scene_entity_deletion,
};
use render::picture::motion::Course;
use schemas::message::{AxisBox, Body, Solid, Trajectory, Vector};

use crate::Shown;
use crate::motion::{body_frame, course};
use crate::place::{Axes, timestamp};
use crate::topics::{Kind, ViewMessage, encoded};

/// Colours that can be told apart with any eyes (Okabe and Ito), for answers in turn.
const ANSWERS: [Color; 4] = [
    color(0.0, 0.447, 0.698, 1.0),
    color(0.902, 0.624, 0.0, 1.0),
    color(0.0, 0.620, 0.451, 1.0),
    color(0.8, 0.475, 0.655, 1.0),
];
const WALLS: Color = color(0.35, 0.35, 0.35, 1.0);
const SOLID: Color = color(0.5, 0.5, 0.5, 0.35);
const CHANNELS: Color = color(0.55, 0.70, 0.80, 0.9);
const CLEARANCE: Color = color(0.835, 0.369, 0.0, 1.0);

const fn color(r: f64, g: f64, b: f64, a: f64) -> Color {
    Color { r, g, b, a }
}

/// Pixels.
const THICKNESS: f64 = 2.0;

/// Everything of a request; what was shown before goes.
pub(crate) fn update(shown: &Shown, frame: &str) -> ViewMessage {
    let (axes, space) = (Axes::of(shown.scene), &shown.scene.free_space);
    let entity = |id: String, frame: String| SceneEntity {
        timestamp: Some(timestamp(shown.begin_ns)),
        frame_id: frame,
        id,
        frame_locked: true,
        ..SceneEntity::default()
    };
    let still = |id: &str| entity(id.to_owned(), frame.to_owned());
    let mut walls = still("walls");
    let solids = space.solids.iter().flatten();
    let shapes = solids.flat_map(|solid| match solid {
        Solid::Polygon(vertices) => {
            vec![Shape::Outline(vertices.iter().map(|v| axes.vertex(v)).collect())]
        }
        Solid::Box(sides) => vec![Shape::of_box(axes, sides)],
        Solid::Boxes(boxes) => boxes.iter().map(|sides| Shape::of_box(axes, sides)).collect(),
    });
    draw(
        &mut walls,
        shapes.chain(space.bounds.iter().map(|sides| Shape::of_box(axes, sides).open())),
        WALLS,
    );
    let mut channels = still("channels");
    let boxes = space.channels.iter().flatten();
    draw(&mut channels, boxes.map(|sides| Shape::of_box(axes, sides).open()), CHANNELS);
    let mut entities = vec![walls, channels];
    for (answer, motion) in shown.motions() {
        let color = ANSWERS[answer % ANSWERS.len()];
        let mut body = entity(format!("body/{answer}"), body_frame(answer));
        draw(&mut body, body_shapes(axes, &shown.scene.body), color);
        let mut path = still(&format!("path/{answer}"));
        let points: Vec<Point3> = course(motion).map(|place| axes.point(place.position)).collect();
        path.lines.push(line(line_primitive::Type::LineStrip, points, color));
        let mut clearance = still(&format!("clearance/{answer}"));
        draw_clearance(&mut clearance, axes, &shown.scene.body, motion);
        entities.extend([body, path, clearance]);
    }
    let deletion = SceneEntityDeletion {
        timestamp: Some(timestamp(shown.begin_ns)),
        r#type: scene_entity_deletion::Type::All.into(),
        id: String::new(),
    };
    let message = SceneUpdate { deletions: vec![deletion], entities };
    encoded("/viewing/scene", Kind::Scene, shown.begin_ns, &message)
}

/// Something that is drawn.
enum Shape {
    Outline(Vec<Point3>),
    /// Its centre and size, and whether its sides are filled.
    Block([f64; 3], [f64; 3], bool),
}

impl Shape {
    fn of_box(axes: Axes, AxisBox { min, max }: &AxisBox) -> Self {
        let (low, high) = (min.padded(), max.padded());
        match axes {
            Axes::Xyz => {
                let centre = std::array::from_fn(|i| (low[i] + high[i]) / 2.0);
                Self::Block(centre, std::array::from_fn(|i| high[i] - low[i]), true)
            }
            Axes::Xy | Axes::Xz => {
                let corners =
                    [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
                Self::Outline(corners.map(|corner| axes.vertex(&Vector::from(corner))).to_vec())
            }
        }
    }

    /// Its edges alone.
    fn open(self) -> Self {
        match self {
            Self::Outline(points) => Self::Outline(points),
            Self::Block(centre, size, _) => Self::Block(centre, size, false),
        }
    }
}

/// The body about its reference point: as it is where the displacement is none and the heading 0.
fn body_shapes(axes: Axes, body: &Body) -> Vec<Shape> {
    match body {
        Body::Polygon(vertices) => {
            vec![Shape::Outline(vertices.iter().map(|v| axes.vertex(v)).collect())]
        }
        Body::Box(sides) => vec![Shape::of_box(axes, sides)],
        Body::Boxes(boxes) => boxes.iter().map(|sides| Shape::of_box(axes, sides)).collect(),
        Body::Footprint(footprint) => {
            let (side, front, rear) =
                (footprint.width() / 2.0, footprint.front(), footprint.rear());
            let corners = [[-rear, -side], [front, -side], [front, side], [-rear, side]];
            vec![Shape::Outline(corners.map(|[x, y]| Point3 { x, y, z: 0.0 }).to_vec())]
        }
    }
}

/// All outlines and edges as one list of lines, and filled blocks.
fn draw(entity: &mut SceneEntity, shapes: impl IntoIterator<Item = Shape>, color: Color) {
    let (mut points, mut indices) = (Vec::new(), Vec::new());
    for shape in shapes {
        let begin = points.len() as u32;
        match shape {
            Shape::Outline(outline) => {
                let count = outline.len() as u32;
                points.extend(outline);
                indices.extend((0..count).flat_map(|i| [begin + i, begin + (i + 1) % count]));
            }
            Shape::Block(centre, size, filled) => {
                let corner = |at: u32| {
                    let [x, y, z] = std::array::from_fn(|i| {
                        let up = if at >> i & 1 == 1 { 0.5 } else { -0.5 };
                        centre[i] + up * size[i]
                    });
                    Point3 { x, y, z }
                };
                points.extend((0..8).map(corner));
                let edges = (0..8_u32).flat_map(|at| (0..3).map(move |axis| (at, at | 1 << axis)));
                let edges = edges.filter(|(at, to)| at != to);
                indices.extend(edges.flat_map(|(at, to)| [begin + at, begin + to]));
                if filled {
                    let [[x, y, z], [a, b, c]] = [centre, size];
                    entity.cubes.push(CubePrimitive {
                        pose: Some(still_at([x, y, z])),
                        size: Some(Vector3 { x: a, y: b, z: c }),
                        color: Some(Color { a: SOLID.a, ..color }),
                    });
                }
            }
        }
    }
    if !points.is_empty() {
        let mut edges = line(line_primitive::Type::LineList, points, color);
        edges.indices = indices;
        entity.lines.push(edges);
    }
}

fn line(kind: line_primitive::Type, points: Vec<Point3>, color: Color) -> LinePrimitive {
    LinePrimitive {
        r#type: kind.into(),
        pose: Some(still_at([0.0; 3])),
        thickness: THICKNESS,
        scale_invariant: true,
        points,
        color: Some(color),
        ..LinePrimitive::default()
    }
}

fn still_at([x, y, z]: [f64; 3]) -> Pose {
    let orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
    Pose { position: Some(Vector3 { x, y, z }), orientation: Some(orientation) }
}

/// The body where it is closest to the walls, and the closest point of them.
fn draw_clearance(entity: &mut SceneEntity, axes: Axes, body: &Body, motion: &Trajectory) {
    let least = &motion.clearance;
    let Some(place) = Course::of(motion).placement(least.at) else { return };
    if !least.value.is_finite() {
        return;
    }
    let begin = entity.lines.len();
    draw(entity, body_shapes(axes, body).into_iter().map(Shape::open), CLEARANCE);
    for line in &mut entity.lines[begin..] {
        line.pose = Some(axes.pose(place.position, place.heading));
    }
    let Point3 { x, y, z } = axes.vertex(&least.wall);
    let size = (motion.length * 0.01).max(1e-3);
    entity.spheres.push(SpherePrimitive {
        pose: Some(still_at([x, y, z])),
        size: Some(Vector3 { x: size, y: size, z: size }),
        color: Some(CLEARANCE),
    });
    entity.texts.push(TextPrimitive {
        pose: Some(still_at([x, y, z])),
        billboard: true,
        font_size: 12.0,
        scale_invariant: true,
        color: Some(CLEARANCE),
        text: format!("{:.4} m", least.value),
    });
}
