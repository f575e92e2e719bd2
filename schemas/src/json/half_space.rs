//! Boxes in JSON: by two corners, or as an intersection of half-spaces (paper, equation 2.2).

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use super::fault::Fault;
use super::tree::Node;
use super::values::{BoxJson, Numbers, Point, Word};
use crate::message::{Axis, Named, Task, Vector};

/// A box with sides parallel to the axes: `min` and `max`, or `half_spaces`.
#[derive(Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(rename = "box", transform = schema::corners_or_half_spaces)
)]
#[serde(deny_unknown_fields)]
struct BoxForm {
    /// The corner with the least coordinates, metres.
    min: Option<Point>,
    /// The corner with the greatest coordinates, metres. Each must exceed that of `min`.
    max: Option<Point>,
    /// In place of `min` and `max`: half-spaces, whose intersection is the box.
    half_spaces: Option<IntersectionJson>,
}

impl<'de> Deserialize<'de> for BoxJson {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match BoxForm::deserialize(deserializer)? {
            BoxForm { min: Some(min), max: Some(max), half_spaces: None } => Ok(Self { min, max }),
            BoxForm { min: None, max: None, half_spaces: Some(sides) } => Ok(sides.0),
            BoxForm { half_spaces: Some(_), .. } => Err(D::Error::custom(
                "has a corner beside `half_spaces`; give either `min` and `max`, or `half_spaces`",
            )),
            BoxForm { min: None, .. } => Err(D::Error::missing_field("min")),
            BoxForm { max: None, .. } => Err(D::Error::missing_field("max")),
        }
    }
}

/// A half-space (2.1): the points whose coordinate is at least, or at most, a number.
#[derive(Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(rename = "half_space", transform = schema::one_bound)
)]
#[serde(deny_unknown_fields)]
struct HalfSpaceJson {
    /// The coordinate.
    axis: Word<Axis>,
    /// The least that it may be, metres.
    at_least: Option<f64>,
    /// The most that it may be, metres.
    at_most: Option<f64>,
}

/// Half-spaces, whose intersection is a box.
pub(super) struct IntersectionJson(pub(super) BoxJson);

impl Serialize for IntersectionJson {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for IntersectionJson {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut sides = [[None::<f64>; 2]; Vector::MOST];
        for half_space in Vec::<HalfSpaceJson>::deserialize(deserializer)? {
            let HalfSpaceJson { axis: Word(axis), at_least, at_most } = half_space;
            let [least, most] = &mut sides[axis as usize];
            match (at_least, at_most) {
                (Some(bound), None) => *least = Some(least.map_or(bound, |least| least.max(bound))),
                (None, Some(bound)) => *most = Some(most.map_or(bound, |most| most.min(bound))),
                _ => {
                    return Err(D::Error::custom(
                        "must have half-spaces with one of `at_least` and `at_most` each",
                    ));
                }
            }
        }
        let (mut min, mut max) = (Vec::new(), Vec::new());
        for (axis, [least, most]) in Axis::VALUES.iter().zip(sides) {
            let name = axis.word();
            match (least, most) {
                (Some(least), Some(most)) => {
                    min.push(least);
                    max.push(most);
                }
                (None, None) => {}
                (None, Some(_)) => return Err(open("-", name)),
                (Some(_), None) => return Err(open("+", name)),
            }
        }
        let corners = (Vector::new(&min), Vector::new(&max));
        match (corners, sides[Axis::X as usize]) {
            ((Some(min), Some(max)), [Some(_), _]) if min.dimension() > 1 => {
                Ok(Self(BoxJson { min: Numbers(min), max: Numbers(max) }))
            }
            _ => Err(D::Error::custom(
                "must bound x and z in an assembly scene in the plane, x and y for \"drive\", and \
                 all three in space",
            )),
        }
    }
}

/// No half-space bounds a box on this side.
fn open<E: Error>(sign: &str, axis: &str) -> E {
    E::custom(format_args!("must bound a box, but are open towards {sign}{axis}"))
}

/// Refuses half-spaces across the axis that a scene in the plane does not have.
pub(super) fn check_plane(scene: &Node<'_>) -> Result<(), Fault> {
    let Node::Object(fields) = scene else { return Ok(()) };
    let is_drive = |(name, value): &(_, Node<'_>)| {
        *name == "task" && matches!(value, Node::Text(task) if *task == Task::Drive.word())
    };
    let stray = if fields.iter().any(is_drive) { Axis::Z } else { Axis::Y };
    match find(scene, stray) {
        Some(fault) => Err(fault),
        None => Ok(()),
    }
}

/// The first half-space across this axis, but for those in space.
fn find(node: &Node<'_>, stray: Axis) -> Option<Fault> {
    match node {
        Node::Object(fields) => fields.iter().find_map(|(name, value)| match value {
            Node::List(list) if *name == "half_spaces" => {
                let is_in_space = Axis::VALUES
                    .iter()
                    .all(|axis| list.iter().any(|entry| is_across(entry, *axis)));
                let at = list.iter().position(|entry| is_across(entry, stray));
                let at = at.filter(|_| !is_in_space)?;
                let [one, other] = match stray {
                    Axis::Z => ["x", "y"],
                    _ => ["x", "z"],
                };
                let message = format!(
                    "must be \"{one}\" or \"{other}\" in the plane of this task, not \"{}\"",
                    stray.word()
                );
                Some(Fault::custom(message).in_field("axis").in_entry(at).in_field(name))
            }
            value => find(value, stray).map(|fault| fault.in_field(name)),
        }),
        // Points have no half-spaces.
        Node::List(list) if matches!(list.first(), Some(Node::Object(_))) => {
            let faults = list.iter().enumerate();
            let mut faults =
                faults.filter_map(|(at, entry)| find(entry, stray).map(|fault| fault.in_entry(at)));
            faults.next()
        }
        _ => None,
    }
}

fn is_across(half_space: &Node<'_>, axis: Axis) -> bool {
    let Node::Object(fields) = half_space else { return false };
    fields.iter().any(|(name, value)| {
        *name == "axis" && matches!(value, Node::Text(word) if *word == axis.word())
    })
}

#[cfg(feature = "json-schema")]
mod schema {
    use std::borrow::Cow;

    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
    use serde_json::json;

    use super::{BoxForm, BoxJson, HalfSpaceJson, IntersectionJson};

    impl JsonSchema for BoxJson {
        fn schema_name() -> Cow<'static, str> {
            BoxForm::schema_name()
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            BoxForm::json_schema(generator)
        }
    }

    impl JsonSchema for IntersectionJson {
        fn inline_schema() -> bool {
            true
        }

        fn schema_name() -> Cow<'static, str> {
            "half_spaces".into()
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            json_schema!({
                "type": "array",
                "items": generator.subschema_for::<HalfSpaceJson>(),
                "minItems": 4,
            })
        }
    }

    /// Either both corners, or half-spaces.
    pub(super) fn corners_or_half_spaces(schema: &mut Schema) {
        let forms = json!([
            {
                "required": ["min", "max"],
                "properties": {
                    "min": { "not": { "type": "null" } },
                    "max": { "not": { "type": "null" } },
                    "half_spaces": { "type": "null" },
                },
            },
            {
                "required": ["half_spaces"],
                "properties": {
                    "min": { "type": "null" },
                    "max": { "type": "null" },
                    "half_spaces": { "not": { "type": "null" } },
                },
            },
        ]);
        schema.insert("oneOf".to_owned(), forms);
    }

    /// Either `at_least` or `at_most`.
    pub(super) fn one_bound(schema: &mut Schema) {
        let form = |given: &str, other: &str| {
            json!({
                "required": [given],
                "properties": { given: { "type": "number" }, other: { "type": "null" } },
            })
        };
        let forms = json!([form("at_least", "at_most"), form("at_most", "at_least")]);
        schema.insert("oneOf".to_owned(), forms);
    }
}
