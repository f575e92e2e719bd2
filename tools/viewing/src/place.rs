//! Where things are in the common frame.

use foxglove::messages::{Point3, Pose, Quaternion, Timestamp, Vector3};
use schemas::message::{AxisBox, Body, SceneRequest, Task, Vector};

/// Which coordinates a scene has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Axes {
    /// Two, on the floor.
    Xy,
    /// Two, upright.
    Xz,
    /// Three.
    Xyz,
}

impl Axes {
    pub(crate) fn of(scene: &SceneRequest) -> Self {
        let is_solid = |sides: &AxisBox| sides.min.dimension() == 3;
        let space = &scene.free_space;
        let mut boxes = space.channels.iter().flatten().chain(&space.bounds);
        match &scene.body {
            _ if scene.task == Task::Drive => Self::Xy,
            Body::Box(sides) if is_solid(sides) => Self::Xyz,
            Body::Boxes(boxes) if boxes.iter().any(is_solid) => Self::Xyz,
            _ if boxes.any(is_solid) => Self::Xyz,
            _ => Self::Xz,
        }
    }

    pub(crate) fn place(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Xy | Self::Xyz => [a, b, c],
            Self::Xz => [a, 0.0, b],
        }
    }

    pub(crate) fn point(self, place: [f64; 3]) -> Point3 {
        let [x, y, z] = self.place(place);
        Point3 { x, y, z }
    }

    pub(crate) fn vertex(self, vertex: &Vector) -> Point3 {
        self.point(vertex.padded())
    }

    /// A pose from its position as in the messages, and its heading.
    pub(crate) fn pose(self, place: [f64; 3], heading: f64) -> Pose {
        let [x, y, z] = self.place(place);
        Pose { position: Some(Vector3 { x, y, z }), orientation: Some(rotation(heading)) }
    }
}

/// A turn about z.
pub(crate) fn rotation(heading: f64) -> Quaternion {
    let half = heading / 2.0;
    Quaternion { x: 0.0, y: 0.0, z: libm::sin(half), w: libm::cos(half) }
}

/// Seconds and nanoseconds since the Unix epoch.
pub(crate) fn timestamp(ns: u64) -> Timestamp {
    let seconds = u32::try_from(ns / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (ns % 1_000_000_000) as u32)
}
