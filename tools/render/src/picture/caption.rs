//! Title, captions, legend.

use schemas::message::{
    Body, Choice, ClearanceWish, Footprint, Gap, Refusal, Reply, SceneRequest, Task, Trajectory,
};

use super::style;
use super::text::{significant, wrap};

/// A line of a caption.
pub(super) struct CaptionLine {
    pub(super) text: String,
    pub(super) color: &'static str,
    pub(super) bold: bool,
}

impl CaptionLine {
    fn plain(text: String) -> Self {
        Self { text, color: style::INK, bold: false }
    }
}

/// Size of captions, pixels.
pub(super) const SIZE: f64 = 12.0;

/// The title, and the grey text beside it.
pub(super) fn title(scene: &SceneRequest, reply: &Reply, shown: usize) -> (String, String) {
    let task = match scene.task {
        Task::Disassemble => "Disassembly",
        Task::Assemble => "Assembly",
        Task::Drive => "Mobile robot",
    };
    let mut parts = Vec::new();
    parts.extend(scene.id.map(|id| format!("scene {id}")));
    let count = |count: usize, what: &str| match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    };
    let space = &scene.free_space;
    parts.extend(space.channels.as_ref().map(|channels| count(channels.len(), "channel")));
    parts.extend(space.solids.as_ref().map(|solids| count(solids.len(), "solid")));
    let sides = match &scene.body {
        Body::Footprint(footprint) => {
            Some(vec![footprint.width(), footprint.front() + footprint.rear()])
        }
        Body::Box(sides) => {
            let (min, max) = (sides.min.as_slice(), sides.max.as_slice());
            Some(min.iter().zip(max).map(|(min, max)| max - min).collect())
        }
        Body::Polygon(vertices) => extents(vertices),
        Body::Boxes(boxes) => {
            let corners: Vec<_> = boxes.iter().flat_map(|sides| [sides.min, sides.max]).collect();
            extents(&corners)
        }
    };
    if let Some(sides) = sides {
        let what = if scene.task == Task::Drive { "robot" } else { "body" };
        let sides: Vec<String> = sides.into_iter().map(significant).collect();
        parts.push(format!("{what} {} m", sides.join(" \u{d7} ")));
    }
    if let Ok(answers) = &reply.answers
        && answers.len() > shown
    {
        parts.push(format!("{shown} of {} answers shown", answers.len()));
    }
    (task.to_owned(), parts.join("  \u{b7}  "))
}

fn extents(vertices: &[schemas::message::Vector]) -> Option<Vec<f64>> {
    let side = |axis: usize| {
        let values = || vertices.iter().map(|v| v.padded()[axis]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let dimension = vertices.first()?.dimension().max(2);
    Some((0..dimension).map(side).collect())
}

/// "a) ", if there are several answers.
fn letter(index: usize, answers: usize) -> String {
    match (answers, u8::try_from(index)) {
        (0 | 1, _) => String::new(),
        (_, Ok(index @ 0..26)) => format!("{}) ", char::from(b'a' + index)),
        _ => format!("{}) ", index + 1),
    }
}

/// The gap asked for.
fn wish(scene: &SceneRequest, index: usize) -> String {
    let gap = |gap: &Gap| match gap {
        Gap::Uniform(gap) => format!("gap {} m", significant(*gap)),
        Gap::PerAxis(gaps) => {
            let gaps: Vec<String> = gaps.as_slice().iter().map(|gap| significant(*gap)).collect();
            format!("gaps {} m", gaps.join(", "))
        }
    };
    let safest = "safest gap".to_owned();
    let own = "own gap at each junction".to_owned();
    let at_least = |least: f64| format!("free clearance at least {} m", significant(least));
    match &scene.clearance {
        ClearanceWish::Gap(wished) => gap(wished),
        ClearanceWish::Gaps(_) => own,
        ClearanceWish::Safest => safest,
        ClearanceWish::AtLeast(least) => at_least(*least),
        ClearanceWish::Curve(points) => format!("point {} of {points}", index + 1),
        ClearanceWish::Each(choices) => match choices.get(index) {
            Some(Choice::Gap(wished)) => gap(wished),
            Some(Choice::Gaps(_)) => own,
            Some(Choice::Safest) => safest,
            Some(Choice::AtLeast(least)) => at_least(*least),
            None => format!("answer {}", index + 1),
        },
    }
}

/// The gaps used, unless the request names them.
fn used(scene: &SceneRequest, index: usize, gaps: &[f64]) -> Option<String> {
    let said = match &scene.clearance {
        ClearanceWish::Gap(_) => true,
        ClearanceWish::Each(choices) => matches!(choices.get(index), Some(Choice::Gap(_))),
        _ => false,
    };
    if said || gaps.is_empty() {
        return None;
    }
    let least = significant(gaps.iter().copied().fold(f64::INFINITY, f64::min));
    let most = significant(gaps.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    Some(if least == most { format!(": {least} m") } else { format!(": {least} to {most} m") })
}

/// The caption of an answer.
pub(super) fn answered(
    scene: &SceneRequest,
    (index, answers): (usize, usize),
    answer: &Trajectory,
    room: f64,
) -> Vec<CaptionLine> {
    let mut head = letter(index, answers) + &wish(scene, index);
    head += &used(scene, index, &answer.gaps).unwrap_or_default();
    let clearance = match answer.clearance.value {
        value if value.is_finite() => CaptionLine {
            text: format!("clearance {} m", significant(value)),
            color: style::ALERT,
            bold: false,
        },
        _ => CaptionLine::plain("no walls".to_owned()),
    };
    let exit = answer.exit.map(|exit| format!("  \u{b7}  out along {exit}"));
    let measures = format!(
        "length {} m  \u{b7}  duration {} s{}",
        significant(answer.length),
        significant(answer.duration),
        exit.unwrap_or_default()
    );
    let mut lines = heads(&head, style::INK, room);
    lines.extend(wrap(&measures, SIZE, room, 3).into_iter().map(CaptionLine::plain));
    lines.push(clearance);
    lines.extend(by_leg(answer).map(|text| CaptionLine {
        text,
        color: style::SUBTLE,
        bold: false,
    }));
    lines
}

/// The clearance of each leg, if they are few and differ.
fn by_leg(answer: &Trajectory) -> Option<String> {
    let values: Vec<String> = answer.legs.iter().map(|leg| significant(leg.clearance)).collect();
    let few = (2..=4).contains(&values.len());
    let differ = values.iter().any(|value| *value != values[0]);
    (few && differ).then(|| format!("by leg {} m", values.join(", ")))
}

fn heads(text: &str, color: &'static str, room: f64) -> Vec<CaptionLine> {
    let line = |text| CaptionLine { text, color, bold: true };
    wrap(text, SIZE * 1.06, room, 3).into_iter().map(line).collect()
}

/// Why there is no answer; without `place`, to the whole request.
pub(super) fn refused(
    scene: &SceneRequest,
    place: Option<(usize, usize)>,
    refusal: &Refusal,
    room: f64,
) -> Vec<CaptionLine> {
    let code = refusal.code.name().replace('_', " ");
    let head = match place {
        Some((index, answers)) => {
            format!("{}{}: {code}", letter(index, answers), wish(scene, index))
        }
        None => format!("No path: {code}"),
    };
    let mut lines = heads(&head, style::ALERT, room);
    lines.extend(wrap(&refusal.message, SIZE, room, 12).into_iter().map(CaptionLine::plain));
    lines
}

/// What a sign in the picture means.
#[derive(Clone, Copy)]
pub(super) enum Sign {
    Body,
    Goal,
    Ghost,
    Path,
    Circle,
    Clearance,
    Junction,
    Wall,
    Unknown,
    Turn,
    Reverse,
    Before,
    Apart,
}

/// What a picture shows, besides what its scene says.
#[derive(Clone, Copy, Default)]
pub(super) struct Shown {
    /// Any answer.
    pub(super) motion: bool,
    pub(super) junctions: bool,
    pub(super) walls: bool,
    pub(super) unknown: bool,
    pub(super) turns: bool,
    pub(super) reverse: bool,
    pub(super) before: bool,
    pub(super) apart: bool,
}

/// The signs used, with what they mean.
pub(super) fn legend(scene: &SceneRequest, shown: &Shown) -> Vec<(Sign, &'static str)> {
    let drive = scene.task == Task::Drive;
    let mut signs = Vec::new();
    let mut add = |is_shown: bool, sign: Sign, meaning| {
        if is_shown {
            signs.push((sign, meaning));
        }
    };
    add(shown.walls, Sign::Wall, "walls");
    add(shown.unknown, Sign::Unknown, "unknown");
    add(true, Sign::Body, if drive { "start" } else { "assembled" });
    add(drive, Sign::Goal, "goal");
    add(shown.motion, Sign::Ghost, if drive { "ends of legs" } else { "way-points" });
    let path = match &scene.body {
        Body::Footprint(Footprint::Offset { .. }) => "path of the reference point",
        Body::Footprint(_) => "path of the centre",
        _ => "path of the first vertex",
    };
    add(shown.motion, Sign::Path, path);
    add(shown.reverse, Sign::Reverse, "in reverse");
    add(shown.turns, Sign::Turn, "turns in place");
    add(shown.motion && drive, Sign::Circle, "guiding circles");
    add(shown.before, Sign::Before, "path as recorded");
    add(shown.apart, Sign::Apart, "farthest apart");
    add(shown.motion, Sign::Clearance, "least clearance");
    add(shown.junctions, Sign::Junction, "junctions");
    signs
}
