//! The planner's answer beside the peer's, and checked on its own.

use answer::Answerer;
use schemas::message::{Curve, Request, RequestContent, RequestKey, Trajectory};
use schemas::wire::Sample;
use serde_json::{Value, json};

use crate::lattice::{self, Resolution};
use crate::rectangle::{Rectangle, Walls};
use crate::scene::{Pose, Scene};
use crate::{between, direction, norm, wrapped};

/// What the planner and the peer made of a scene.
#[derive(Debug, Clone)]
pub struct Verdict {
    /// Length, or what the refusal says.
    pub planner: Result<Drive, String>,
    /// Length of the peer's way, shortened.
    pub peer: Option<f64>,
    /// What is wrong with the planner's motion.
    pub faults: Vec<String>,
}

/// The planner's drive, in metres.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Its length.
    pub length: f64,
    /// No drive with its free clearance is shorter.
    pub bound: f64,
    /// The least distance from the walls.
    pub clearance: f64,
    /// The same, apart from walls that are nearer at the start or the goal.
    pub free_clearance: f64,
    /// Angle turned in place, radians.
    pub turned: f64,
    /// Names of the rungs that its legs came from.
    pub rungs: Vec<&'static str>,
    /// Whether all of the scene was searched.
    pub complete: bool,
}

/// Asks both.
///
/// # Panics
///
/// If the scene's JSON is refused as such.
#[must_use]
pub fn judge(scene: &Scene, gap: f64, resolution: Resolution) -> Verdict {
    let peer = lattice::find(scene, resolution).map(|way| lattice::length(&way));
    let (planner, faults) = ask(scene, &json!({ "gap": gap }));
    Verdict { planner, peer, faults }
}

/// Asks the planner, and checks its answer.
///
/// # Panics
///
/// If the scene's JSON is refused as such.
pub fn ask(scene: &Scene, clearance: &Value) -> (Result<Drive, String>, Vec<String>) {
    let mut answerer = Answerer::new(&answer::Caps::default());
    let request = scene.request(clearance, &json!({ "spacing": scene.spacing() }));
    match trajectory(&mut answerer, &request) {
        Err(message) => (Err(message), Vec::new()),
        Ok(trajectory) => (Ok(drive(&trajectory)), faults(scene, &trajectory)),
    }
}

/// The first answer to a request, or what its refusal says.
pub(crate) fn trajectory(answerer: &mut Answerer, request: &Value) -> Result<Trajectory, String> {
    let scene = schemas::json::read_scene(&request.to_string()).expect("a scene");
    let (key, content) = (RequestKey::default(), RequestContent::Scene(scene));
    let reply = answerer.reply_to(&Request { key, sent_ns: 0, content });
    let mut answers = reply.answers.map_err(|refusal| refusal.message)?;
    answers.swap_remove(0).map_err(|refusal| refusal.message)
}

pub(crate) fn drive(trajectory: &Trajectory) -> Drive {
    let turned = trajectory.legs.iter().map(|leg| match leg.curve {
        Curve::Turn { sweep, .. } => sweep.abs(),
        _ => 0.0,
    });
    let mut rungs: Vec<_> =
        trajectory.legs.iter().filter_map(|leg| leg.rung).map(|rung| rung.name()).collect();
    rungs.dedup();
    Drive {
        length: trajectory.length,
        bound: trajectory.bound.unwrap_or(0.0),
        clearance: trajectory.clearance.value,
        free_clearance: trajectory.free_clearance.unwrap_or(f64::INFINITY),
        turned: turned.sum(),
        rungs,
        complete: trajectory.complete,
    }
}

/// Whatever is wrong with a motion, by its samples.
fn faults(scene: &Scene, trajectory: &Trajectory) -> Vec<String> {
    let mut faults = Vec::new();
    let mut fault = |is_fault: bool, says: &dyn Fn() -> String| {
        if is_fault {
            faults.push(says());
        }
    };
    let walls = Walls::new(scene.walls());
    let clearance = trajectory.clearance.value;
    let mut nearest = f64::INFINITY;
    let mut before: Option<&Sample> = None;
    for sample in &trajectory.samples {
        let [x, y, _] = sample.position;
        let pose = Pose { position: [x, y], heading: sample.heading };
        let rectangle = Rectangle::new(pose, scene.footprint, 0.0);
        let distance = walls.distance(&rectangle, clearance + 4.0 * scene.spacing());
        nearest = nearest.min(distance);
        fault(!(distance > 0.0 && scene.is_free([x, y])), &|| {
            format!("touches a wall at {pose:?}")
        });
        fault(distance < clearance - 1e-9, &|| {
            format!("is {distance} from a wall at {pose:?}, clearance {clearance}")
        });
        if let Some(before) = before {
            let step = between([before.position[0], before.position[1]], [x, y]);
            let drift = wrapped(sample.heading - before.heading).abs();
            fault(sample.t <= before.t, &|| format!("time stands still at {}", sample.t));
            fault(norm(step) > 1.1 * scene.spacing(), &|| {
                format!("jumps by {} m at {pose:?}", norm(step))
            });
            // Along the heading, or against it.
            let (ahead, side) = (direction(before.heading + drift / 2.0), norm(step));
            let forwards = step[0] * ahead[0] + step[1] * ahead[1];
            fault(!scene.reverse && forwards < -1e-6 * side, &|| {
                format!("drives backwards at {pose:?}")
            });
        }
        before = Some(sample);
    }
    fault(nearest > clearance + 2.0 * scene.spacing(), &|| {
        format!("clearance {clearance}, but {nearest} seen")
    });
    let ends = [trajectory.samples.first(), trajectory.samples.last()];
    let wanted =
        [(scene.start.position, Some(scene.start.heading)), (scene.goal, scene.goal_heading)];
    for (sample, (position, heading)) in ends.into_iter().zip(wanted) {
        let Some(sample) = sample else {
            fault(true, &|| "no samples".to_owned());
            continue;
        };
        let off = norm(between(position, [sample.position[0], sample.position[1]]));
        let turned = heading.map_or(0.0, |heading| wrapped(heading - sample.heading).abs());
        fault(off > 1e-9 || turned > 1e-9, &|| format!("is off {position:?} by {off}, {turned}"));
    }
    let bound = trajectory.bound.unwrap_or(f64::INFINITY);
    fault(bound.is_nan() || bound > trajectory.length + 1e-9, &|| {
        format!("length {} below the bound {bound}", trajectory.length)
    });
    faults
}
