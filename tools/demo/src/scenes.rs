//! The paper's examples.

use schemas::json;
use schemas::message::{Choice, ClearanceWish, SceneRequest};

const SCENES: [(&str, &str); 4] = [
    ("disassemble", include_str!("../../../recordings/scenes/disassemble.json")),
    ("assemble", include_str!("../../../recordings/scenes/assemble.json")),
    ("drive A", include_str!("../../../recordings/scenes/drive-a.json")),
    ("drive B", include_str!("../../../recordings/scenes/drive-b.json")),
];

/// All examples by name; each wishes for several answers.
pub(crate) fn all() -> impl Iterator<Item = (&'static str, SceneRequest)> {
    SCENES.iter().map(|(name, text)| {
        (*name, json::read_scene(text).expect("the project's scenes can be read"))
    })
}

/// The same scene, once for every answer that it wishes for.
pub(crate) fn one_by_one(scene: &SceneRequest) -> Vec<SceneRequest> {
    let ClearanceWish::Each(choices) = &scene.clearance else { return vec![scene.clone()] };
    let wish = |choice: &Choice| match choice {
        Choice::Gap(gap) => ClearanceWish::Gap(*gap),
        Choice::Gaps(gaps) => ClearanceWish::Gaps(gaps.clone()),
        Choice::Safest => ClearanceWish::Safest,
        Choice::AtLeast(least) => ClearanceWish::AtLeast(*least),
    };
    choices.iter().map(|choice| SceneRequest { clearance: wish(choice), ..scene.clone() }).collect()
}
