//! Scenes from trees. Every refusal names the field at fault and says what was found.

use std::fmt;

use super::tree::{Excerpt, Node};
use crate::message::{
    AxisBox, Body, Choice, ClearanceWish, Direction, Footprint, FreeSpace, Gap, Goal, Limits, Pose,
    Refusal, Sampling, SceneRequest, Solid, StartTurn, Task, Vector,
};

/// Where in the scene a value stands; written as a path.
#[derive(Clone, Copy)]
enum Place<'p> {
    Scene,
    Field(&'p Place<'p>, &'p str),
    Entry(&'p Place<'p>, usize),
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene => f.write_str("scene"),
            Self::Field(parent, "") => write!(f, "{parent}.\"\""),
            Self::Field(Self::Scene, name) => Excerpt(name, 60).fmt(f),
            Self::Field(parent, name) => write!(f, "{parent}.{}", Excerpt(name, 60)),
            Self::Entry(parent, index) => write!(f, "{parent}[{index}]"),
        }
    }
}

fn refused(place: &Place, fault: impl fmt::Display) -> Refusal {
    Refusal::invalid(place.to_string(), format!("{place} {fault}"))
}

fn unexpected(place: &Place, expected: impl fmt::Display, found: &Node) -> Refusal {
    refused(place, format_args!("must be {expected}, but is {found}"))
}

/// The fields of an object of which all names are known.
struct Fields<'n, 'p> {
    place: &'p Place<'p>,
    known: &'static [&'static str],
    /// `null` stands for a field that is not given.
    given: Vec<(&'static str, &'n Node<'n>)>,
}

impl<'n, 'p> Fields<'n, 'p> {
    fn of(
        node: &'n Node,
        place: &'p Place<'p>,
        known: &'static [&'static str],
    ) -> Result<Self, Refusal> {
        let Node::Object(fields) = node else {
            return Err(unexpected(place, format_args!("an object with {}", Names(known)), node));
        };
        let mut given = Vec::with_capacity(known.len());
        for (name, value) in fields {
            let place = &Place::Field(place, name);
            let Some(known_name) = known.iter().find(|known| **known == *name) else {
                let fault = format_args!("is not a known field; known here are {}", Names(known));
                return Err(refused(place, fault));
            };
            if given.iter().any(|(before, _)| before == known_name) {
                return Err(refused(place, "is given twice"));
            }
            given.push((*known_name, value));
        }
        given.retain(|(_, value)| !matches!(value, Node::Null));
        Ok(Self { place, known, given })
    }

    fn get<T>(&self, name: &'static str, read: Read<T>) -> Result<Option<T>, Refusal> {
        debug_assert!(self.known.contains(&name));
        let found = self.given.iter().find(|(given, _)| *given == name);
        found.map(|(_, node)| read(node, &Place::Field(self.place, name))).transpose()
    }

    fn need<T>(&self, name: &'static str, read: Read<T>) -> Result<T, Refusal> {
        self.get(name, read)?.ok_or_else(|| refused(&Place::Field(self.place, name), "is missing"))
    }

    /// The name of the only field that is given.
    fn only(&self) -> Result<&'static str, Refusal> {
        let one_of = |found: fmt::Arguments| {
            let known = Names(self.known);
            refused(self.place, format_args!("must have exactly one of {known}, but has {found}"))
        };
        match self.given.as_slice() {
            [(name, _)] => Ok(name),
            [] => Err(one_of(format_args!("none"))),
            [(first, _), (second, _), ..] => Err(one_of(format_args!("`{first}` and `{second}`"))),
        }
    }
}

type Read<T> = fn(&Node, &Place) -> Result<T, Refusal>;

struct Names(&'static [&'static str]);

impl fmt::Display for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, name) in self.0.iter().enumerate() {
            write!(f, "{}`{name}`", if index > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}

fn list<T>(node: &Node, place: &Place, read: Read<T>) -> Result<Vec<T>, Refusal> {
    let Node::List(entries) = node else { return Err(unexpected(place, "a list", node)) };
    let entries = entries.iter().enumerate();
    entries.map(|(index, entry)| read(entry, &Place::Entry(place, index))).collect()
}

fn number(node: &Node, place: &Place) -> Result<f64, Refusal> {
    match node {
        Node::Whole(value) => Ok(*value as f64),
        Node::Number(value) => Ok(*value),
        _ => Err(unexpected(place, "a number", node)),
    }
}

fn whole(node: &Node, place: &Place) -> Result<u64, Refusal> {
    match node {
        Node::Whole(value) => Ok(*value),
        _ => Err(unexpected(place, format_args!("a whole number from 0 to {}", u64::MAX), node)),
    }
}

fn flag(node: &Node, place: &Place) -> Result<bool, Refusal> {
    match node {
        Node::Bool(value) => Ok(*value),
        _ => Err(unexpected(place, "true or false", node)),
    }
}

/// One of a few words, each of which stands for a value.
fn word<T: Copy>(node: &Node, place: &Place, words: &[(&str, T)]) -> Result<T, Refusal> {
    if let Node::Text(text) = node
        && let Some((_, value)) = words.iter().find(|(word, _)| word == text)
    {
        return Ok(*value);
    }
    let words: Vec<_> = words.iter().map(|(word, _)| format!("\"{word}\"")).collect();
    Err(unexpected(place, format_args!("one of {}", words.join(", ")), node))
}

fn numbers(node: &Node, place: &Place, least: usize) -> Result<Vector, Refusal> {
    let expected = format_args!("a list of {least} to 3 numbers");
    match node {
        Node::List(entries) if (least..=Vector::MOST).contains(&entries.len()) => {
            let mut values = [0.0; Vector::MOST];
            for (index, entry) in entries.iter().enumerate() {
                values[index] = number(entry, &Place::Entry(place, index))?;
            }
            Vector::new(&values[..entries.len()]).ok_or_else(|| unexpected(place, expected, node))
        }
        _ => Err(unexpected(place, expected, node)),
    }
}

fn point(node: &Node, place: &Place) -> Result<Vector, Refusal> {
    numbers(node, place, 2)
}

fn polygon(node: &Node, place: &Place) -> Result<Vec<Vector>, Refusal> {
    list(node, place, point)
}

fn axis_box(node: &Node, place: &Place) -> Result<AxisBox, Refusal> {
    let fields = Fields::of(node, place, &["min", "max"])?;
    Ok(AxisBox { min: fields.need("min", point)?, max: fields.need("max", point)? })
}

pub(super) fn scene(node: &Node) -> Result<SceneRequest, Refusal> {
    const KNOWN: &[&str] = &[
        "id",
        "task",
        "free_space",
        "body",
        "exit",
        "start",
        "goal",
        "start_turn",
        "clearance",
        "limits",
        "sampling",
        "deadline",
    ];
    let fields = Fields::of(node, &Place::Scene, KNOWN)?;
    Ok(SceneRequest {
        id: fields.get("id", whole)?,
        task: fields.need("task", task)?,
        free_space: fields.need("free_space", free_space)?,
        body: fields.need("body", body)?,
        exit: fields.get("exit", exits)?.unwrap_or_default(),
        start: fields.get("start", pose)?,
        goal: fields.get("goal", goal)?,
        start_turn: fields.get("start_turn", start_turn)?,
        clearance: fields.need("clearance", clearance)?,
        limits: fields.get("limits", limits)?.unwrap_or_default(),
        sampling: fields.get("sampling", sampling)?,
        deadline: fields.get("deadline", number)?,
    })
}

fn task(node: &Node, place: &Place) -> Result<Task, Refusal> {
    let words =
        [("disassemble", Task::Disassemble), ("assemble", Task::Assemble), ("drive", Task::Drive)];
    word(node, place, &words)
}

fn free_space(node: &Node, place: &Place) -> Result<FreeSpace, Refusal> {
    let fields = Fields::of(node, place, &["channels", "in_order", "solids", "bounds"])?;
    Ok(FreeSpace {
        channels: fields.get("channels", |node, place| list(node, place, axis_box))?,
        in_order: fields.get("in_order", flag)?.unwrap_or_default(),
        solids: fields.get("solids", |node, place| list(node, place, solid))?,
        bounds: fields.get("bounds", axis_box)?,
    })
}

fn solid(node: &Node, place: &Place) -> Result<Solid, Refusal> {
    let fields = Fields::of(node, place, &["polygon", "box"])?;
    Ok(match fields.only()? {
        "polygon" => Solid::Polygon(fields.need("polygon", polygon)?),
        _ => Solid::Box(fields.need("box", axis_box)?),
    })
}

fn body(node: &Node, place: &Place) -> Result<Body, Refusal> {
    let fields = Fields::of(node, place, &["polygon", "box", "footprint"])?;
    Ok(match fields.only()? {
        "polygon" => Body::Polygon(fields.need("polygon", polygon)?),
        "box" => Body::Box(fields.need("box", axis_box)?),
        _ => Body::Footprint(fields.need("footprint", footprint)?),
    })
}

fn footprint(node: &Node, place: &Place) -> Result<Footprint, Refusal> {
    let fields = Fields::of(node, place, &["width", "length"])?;
    Ok(Footprint { width: fields.need("width", number)?, length: fields.need("length", number)? })
}

fn exits(node: &Node, place: &Place) -> Result<Vec<Direction>, Refusal> {
    match node {
        Node::List(_) => list(node, place, direction),
        _ => direction(node, place).map(|exit| vec![exit]),
    }
}

fn direction(node: &Node, place: &Place) -> Result<Direction, Refusal> {
    let words = [
        ("+x", Direction::PlusX),
        ("-x", Direction::MinusX),
        ("+y", Direction::PlusY),
        ("-y", Direction::MinusY),
        ("+z", Direction::PlusZ),
        ("-z", Direction::MinusZ),
    ];
    word(node, place, &words)
}

fn pose(node: &Node, place: &Place) -> Result<Pose, Refusal> {
    let fields = Fields::of(node, place, &["position", "heading"])?;
    Ok(Pose { position: fields.need("position", point)?, heading: fields.need("heading", number)? })
}

fn goal(node: &Node, place: &Place) -> Result<Goal, Refusal> {
    let fields = Fields::of(node, place, &["position", "heading"])?;
    Ok(Goal { position: fields.need("position", point)?, heading: fields.get("heading", number)? })
}

fn start_turn(node: &Node, place: &Place) -> Result<StartTurn, Refusal> {
    let words = [("in_place", StartTurn::InPlace), ("while_moving", StartTurn::WhileMoving)];
    word(node, place, &words)
}

fn clearance(node: &Node, place: &Place) -> Result<ClearanceWish, Refusal> {
    match node {
        Node::Text(text) if text == "safest" => return Ok(ClearanceWish::Safest),
        Node::Object(_) => {}
        _ => {
            let expected = "\"safest\" or an object with `gap`, `gaps`, `each` or `curve`";
            return Err(unexpected(place, expected, node));
        }
    }
    let fields = Fields::of(node, place, &["gap", "gaps", "each", "curve"])?;
    Ok(match fields.only()? {
        "gap" => ClearanceWish::Gap(fields.need("gap", gap)?),
        "gaps" => ClearanceWish::Gaps(fields.need("gaps", gaps)?),
        "each" => {
            ClearanceWish::Each(fields.need("each", |node, place| list(node, place, choice))?)
        }
        _ => ClearanceWish::Curve(fields.need("curve", whole)?),
    })
}

fn gap(node: &Node, place: &Place) -> Result<Gap, Refusal> {
    match node {
        Node::Whole(_) | Node::Number(_) => number(node, place).map(Gap::Uniform),
        Node::List(_) => numbers(node, place, 1).map(Gap::PerAxis),
        _ => Err(unexpected(place, "a number or a list of 1 to 3 numbers", node)),
    }
}

fn gaps(node: &Node, place: &Place) -> Result<Vec<Gap>, Refusal> {
    list(node, place, gap)
}

fn choice(node: &Node, place: &Place) -> Result<Choice, Refusal> {
    match node {
        Node::Whole(_) | Node::Number(_) | Node::List(_) => {
            return gap(node, place).map(Choice::Gap);
        }
        Node::Text(text) if text == "safest" => return Ok(Choice::Safest),
        Node::Object(_) => {}
        _ => {
            let expected = "a gap (a number or a list of 1 to 3 numbers), \"safest\" or an object \
                            with `gap` or `gaps`";
            return Err(unexpected(place, expected, node));
        }
    }
    let fields = Fields::of(node, place, &["gap", "gaps"])?;
    Ok(match fields.only()? {
        "gap" => Choice::Gap(fields.need("gap", gap)?),
        _ => Choice::Gaps(fields.need("gaps", gaps)?),
    })
}

fn limits(node: &Node, place: &Place) -> Result<Limits, Refusal> {
    const KNOWN: &[&str] =
        &["speed", "acceleration", "yaw_rate", "yaw_acceleration", "lateral_acceleration"];
    let fields = Fields::of(node, place, KNOWN)?;
    Ok(Limits {
        speed: fields.get("speed", number)?,
        acceleration: fields.get("acceleration", number)?,
        yaw_rate: fields.get("yaw_rate", number)?,
        yaw_acceleration: fields.get("yaw_acceleration", number)?,
        lateral_acceleration: fields.get("lateral_acceleration", number)?,
    })
}

fn sampling(node: &Node, place: &Place) -> Result<Sampling, Refusal> {
    let fields = Fields::of(node, place, &["period", "spacing", "count"])?;
    Ok(match fields.only()? {
        "period" => Sampling::Period(fields.need("period", number)?),
        "spacing" => Sampling::Spacing(fields.need("spacing", number)?),
        _ => Sampling::Count(fields.need("count", whole)?),
    })
}
