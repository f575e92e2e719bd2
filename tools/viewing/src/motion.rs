//! Motions as poses, and as transforms of the body's frame over time.

use foxglove::messages::{FrameTransform, FrameTransforms, Pose, PosesInFrame, Vector3};
use render::picture::motion::Course;
use schemas::message::Trajectory;

use crate::Shown;
use crate::place::{Axes, rotation, timestamp};
use crate::topics::{Kind, ViewMessage, encoded};

/// The frame that moves with the body.
pub(crate) fn body_frame(answer: usize) -> String {
    format!("body/{answer}")
}

/// Poses along a motion: its samples, or those of its legs if it has none.
pub(crate) fn poses(axes: Axes, motion: &Trajectory) -> Vec<Pose> {
    match motion.samples.is_empty() {
        false => {
            let samples = motion.samples.iter();
            samples.map(|sample| axes.pose(sample.position, sample.heading)).collect()
        }
        true => course(motion).map(|place| axes.pose(place.position, place.heading)).collect(),
    }
}

/// Places along the legs, close enough to look like the curve.
pub(crate) fn course(
    motion: &Trajectory,
) -> impl Iterator<Item = render::picture::motion::Placement> + use<> {
    const PIECES: f64 = 400.0;
    let step = (motion.length / PIECES).max(1e-6);
    // A turn in place is shown by its ends.
    Course::of(motion).placements(step, 0.0).collect::<Vec<_>>().into_iter()
}

pub(crate) fn path(shown: &Shown, frame: &str, answer: usize, motion: &Trajectory) -> ViewMessage {
    let message = PosesInFrame {
        timestamp: Some(timestamp(shown.begin_ns)),
        frame_id: frame.to_owned(),
        poses: poses(Axes::of(shown.scene), motion),
    };
    encoded(format!("/viewing/{answer}/path"), Kind::Path, shown.begin_ns, &message)
}

/// A transform for each sample.
pub(crate) fn transforms(
    shown: &Shown,
    frame: &str,
    answer: usize,
    motion: &Trajectory,
) -> Vec<ViewMessage> {
    let axes = Axes::of(shown.scene);
    let samples = motion.samples.iter();
    let message = samples.map(|sample| {
        let [x, y, z] = axes.place(sample.position);
        let at = shown.after(sample.t);
        let transform = FrameTransform {
            timestamp: Some(timestamp(at)),
            parent_frame_id: frame.to_owned(),
            child_frame_id: body_frame(answer),
            translation: Some(Vector3 { x, y, z }),
            rotation: Some(rotation(sample.heading)),
        };
        let message = FrameTransforms { transforms: vec![transform] };
        encoded("/viewing/transforms", Kind::Transforms, at, &message)
    });
    message.collect()
}
