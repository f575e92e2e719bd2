//! Answers in the form of ROS messages: `nav_msgs/Path` and
//! `trajectory_msgs/MultiDOFJointTrajectory`, as JSON.

use foxglove::messages::{Pose, Quaternion, Vector3};
use schemas::message::Trajectory;
use serde_json::{Value, json};

use crate::place::Axes;
use crate::{Shown, nanoseconds};

/// An object for each motion: `request`, `id`, `answer`, `path` and `trajectory`.
pub fn answers(shown: &Shown, frame: &str) -> Vec<Value> {
    let each = shown.motions().map(|(answer, motion)| {
        json!({
            "request": shown.index,
            "id": shown.scene.id,
            "answer": answer,
            "path": path(shown, frame, motion),
            "trajectory": trajectory(shown, frame, motion),
        })
    });
    each.collect()
}

fn path(shown: &Shown, frame: &str, motion: &Trajectory) -> Value {
    let axes = Axes::of(shown.scene);
    let poses = motion.samples.iter().map(|sample| {
        let (position, orientation) = parts(axes.pose(sample.position, sample.heading));
        json!({
            "header": header(shown.after(sample.t), frame),
            "pose": { "position": position, "orientation": orientation },
        })
    });
    let poses: Vec<Value> = poses.collect();
    json!({ "header": header(shown.begin_ns, frame), "poses": poses })
}

fn trajectory(shown: &Shown, frame: &str, motion: &Trajectory) -> Value {
    let axes = Axes::of(shown.scene);
    let points = motion.samples.iter().map(|sample| {
        let (translation, rotation) = parts(axes.pose(sample.position, sample.heading));
        let [x, y, z] = axes.place(sample.velocity);
        let angular = json!({ "x": 0.0, "y": 0.0, "z": sample.yaw_rate });
        json!({
            "transforms": [{ "translation": translation, "rotation": rotation }],
            "velocities": [{ "linear": { "x": x, "y": y, "z": z }, "angular": angular }],
            "accelerations": [],
            "time_from_start": time(nanoseconds(sample.t)),
        })
    });
    let points: Vec<Value> = points.collect();
    json!({ "header": header(shown.begin_ns, frame), "joint_names": ["body"], "points": points })
}

/// Position and orientation.
fn parts(pose: Pose) -> (Value, Value) {
    let Vector3 { x, y, z } = pose.position.unwrap_or_default();
    let position = json!({ "x": x, "y": y, "z": z });
    let Quaternion { x, y, z, w } = pose.orientation.unwrap_or_default();
    (position, json!({ "x": x, "y": y, "z": z, "w": w }))
}

fn header(ns: u64, frame: &str) -> Value {
    json!({ "stamp": time(ns), "frame_id": frame })
}

fn time(ns: u64) -> Value {
    json!({ "sec": ns / 1_000_000_000, "nanosec": ns % 1_000_000_000 })
}
