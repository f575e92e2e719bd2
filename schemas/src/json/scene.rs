//! Scenes as people write them.

use serde::{Serialize, Serializer};

use crate::message::{
    AxisBox, Body, Choice, ClearanceWish, Direction, FreeSpace, Gap, Goal, Limits, Pose, Sampling,
    SceneRequest, Solid, StartTurn, Task, Vector,
};

/// Writes a scene request as people would, on one line.
pub fn scene_to_json(scene: &SceneRequest) -> String {
    serde_json::to_string(&SceneView::from(scene)).expect("scenes have text keys only")
}

#[derive(Serialize)]
struct SceneView<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u64>,
    task: Task,
    free_space: FreeSpaceView<'a>,
    body: &'a Body,
    #[serde(skip_serializing_if = "Option::is_none")]
    exit: Option<ExitsView<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<Pose>,
    #[serde(skip_serializing_if = "Option::is_none")]
    goal: Option<GoalView>,
    #[serde(skip_serializing_if = "Option::is_none")]
    start_turn: Option<StartTurn>,
    clearance: WishView<'a>,
    #[serde(skip_serializing_if = "LimitsView::is_empty")]
    limits: LimitsView,
    #[serde(skip_serializing_if = "Option::is_none")]
    sampling: Option<Sampling>,
    #[serde(skip_serializing_if = "Option::is_none")]
    deadline: Option<f64>,
}

impl<'a> From<&'a SceneRequest> for SceneView<'a> {
    fn from(scene: &'a SceneRequest) -> Self {
        let FreeSpace { channels, in_order, solids, bounds } = &scene.free_space;
        Self {
            id: scene.id,
            task: scene.task,
            free_space: FreeSpaceView {
                channels: channels.as_deref(),
                in_order: *in_order,
                solids: solids.as_deref(),
                bounds: *bounds,
            },
            body: &scene.body,
            exit: match scene.exit.as_slice() {
                [] => None,
                [exit] => Some(ExitsView::One(*exit)),
                exits => Some(ExitsView::Several(exits)),
            },
            start: scene.start,
            goal: scene.goal.map(|Goal { position, heading }| GoalView { position, heading }),
            start_turn: scene.start_turn,
            clearance: WishView(&scene.clearance),
            limits: LimitsView::from(scene.limits),
            sampling: scene.sampling,
            deadline: scene.deadline,
        }
    }
}

#[derive(Serialize)]
struct FreeSpaceView<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    channels: Option<&'a [AxisBox]>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    in_order: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    solids: Option<&'a [Solid]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bounds: Option<AxisBox>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum ExitsView<'a> {
    One(Direction),
    Several(&'a [Direction]),
}

#[derive(Serialize)]
struct GoalView {
    position: Vector,
    #[serde(skip_serializing_if = "Option::is_none")]
    heading: Option<f64>,
}

#[derive(Serialize, PartialEq, Default)]
struct LimitsView {
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    acceleration: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    yaw_rate: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    yaw_acceleration: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lateral_acceleration: Option<f64>,
}

impl LimitsView {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl From<Limits> for LimitsView {
    fn from(limits: Limits) -> Self {
        let Limits { speed, acceleration, yaw_rate, yaw_acceleration, lateral_acceleration } =
            limits;
        Self { speed, acceleration, yaw_rate, yaw_acceleration, lateral_acceleration }
    }
}

struct WishView<'a>(&'a ClearanceWish);

impl Serialize for WishView<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        #[serde(rename_all = "snake_case")]
        enum Wish<'a> {
            Gap(GapView),
            Gaps(Vec<GapView>),
            Each(Vec<ChoiceView<'a>>),
            Curve(u64),
        }
        let wish = match self.0 {
            ClearanceWish::Safest => return serializer.serialize_str("safest"),
            ClearanceWish::Gap(gap) => Wish::Gap(gap.into()),
            ClearanceWish::Gaps(gaps) => Wish::Gaps(gaps.iter().map(GapView::from).collect()),
            ClearanceWish::Each(choices) => Wish::Each(choices.iter().map(ChoiceView).collect()),
            ClearanceWish::Curve(points) => Wish::Curve(*points),
        };
        wish.serialize(serializer)
    }
}

struct ChoiceView<'a>(&'a Choice);

impl Serialize for ChoiceView<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Gaps {
            gaps: Vec<GapView>,
        }
        match self.0 {
            Choice::Safest => serializer.serialize_str("safest"),
            Choice::Gap(gap) => GapView::from(gap).serialize(serializer),
            Choice::Gaps(gaps) => {
                Gaps { gaps: gaps.iter().map(GapView::from).collect() }.serialize(serializer)
            }
        }
    }
}

#[derive(Serialize)]
#[serde(untagged)]
enum GapView {
    Uniform(f64),
    PerAxis(Vector),
}

impl From<&Gap> for GapView {
    fn from(gap: &Gap) -> Self {
        match gap {
            Gap::Uniform(gap) => Self::Uniform(*gap),
            Gap::PerAxis(gaps) => Self::PerAxis(*gaps),
        }
    }
}
