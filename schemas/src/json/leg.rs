//! Legs in JSON: an object of which `kind` says what other fields it has.

use std::fmt;

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::trajectory::{Distance, shorter_turn};
use super::values::{Element, Numbers, Point, Word};
use crate::message::{Curve, CurveKind, Leg, Rule, Rung};

/// A piece of the path.
#[derive(Serialize, Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(rename = "leg", transform = schema::split_by_kind)
)]
#[serde(deny_unknown_fields)]
pub(super) struct LegJson {
    /// The curve that the body's reference point follows.
    kind: Word<CurveKind>,
    /// Where the line or the clothoid begins, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<Point>,
    /// Where the line or the clothoid ends, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    to: Option<Point>,
    /// The heading at the end of the line, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    heading: Option<f64>,
    /// The signed angle turned on the line, radians, positive to the left. Default: 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    turned: Option<f64>,
    /// The centre of the arc, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    center: Option<Point>,
    /// The radius of the arc, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    /// The direction from the centre to the beginning of the arc, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    start_angle: Option<f64>,
    /// The signed angle of the arc, radians, positive to the left.
    #[serde(skip_serializing_if = "Option::is_none")]
    sweep: Option<f64>,
    /// Where the body turns, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<Point>,
    /// The heading before the turn, or where the clothoid begins, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_heading: Option<f64>,
    /// The heading after the turn, or where the clothoid ends, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    to_heading: Option<f64>,
    /// Radians turned per metre travelled where the clothoid begins, positive to the left.
    #[serde(skip_serializing_if = "Option::is_none")]
    start_curvature: Option<f64>,
    /// The same where it ends; between them it changes evenly with the arc length.
    #[serde(skip_serializing_if = "Option::is_none")]
    end_curvature: Option<f64>,
    /// Whether the robot drives the leg backwards; present only where it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    reverse: Option<bool>,
    /// Arc length, metres.
    length: f64,
    /// Least distance between the body and the walls on this leg, metres: exact, but on a clothoid
    /// certified from below.
    clearance: Distance,
    /// The rule of the paper that chose this leg.
    #[serde(skip_serializing_if = "Option::is_none")]
    rule: Option<RuleJson>,
    /// The junction that the leg leads to or turns in, counted from 0 in travel order.
    #[serde(skip_serializing_if = "Option::is_none")]
    junction: Option<u64>,
    /// How the leg was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    rung: Option<Word<Rung>>,
}

/// The fields of each kind beside those that all legs have.
const LINE: &[&str] = &["from", "to", "heading", "turned", "reverse"];
const ARC: &[&str] = &["center", "radius", "start_angle", "sweep", "reverse"];
const TURN: &[&str] = &["position", "from_heading", "to_heading"];
const CLOTHOID: &[&str] =
    &["from", "to", "from_heading", "to_heading", "start_curvature", "end_curvature", "reverse"];

const fn fields_of(kind: CurveKind) -> &'static [&'static str] {
    match kind {
        CurveKind::Line => LINE,
        CurveKind::Arc => ARC,
        CurveKind::Turn => TURN,
        CurveKind::Clothoid => CLOTHOID,
    }
}

/// The fields of a curve that can be left out.
#[cfg(feature = "json-schema")]
const OPTIONAL: &[&str] = &["turned", "reverse"];

impl From<&Leg> for LegJson {
    fn from(&Leg { curve, length, clearance, junction, rule, reverse, rung }: &Leg) -> Self {
        let reverse = reverse.then_some(true);
        let leg = Self {
            kind: Word(curve.kind()),
            from: None,
            to: None,
            heading: None,
            turned: None,
            center: None,
            radius: None,
            start_angle: None,
            sweep: None,
            position: None,
            from_heading: None,
            to_heading: None,
            start_curvature: None,
            end_curvature: None,
            reverse: None,
            length,
            clearance: Distance(clearance),
            rule: rule.map(RuleJson),
            junction,
            rung: rung.map(Word),
        };
        match curve {
            Curve::Line { from, to, heading, turned } => Self {
                from: Some(Numbers(from)),
                to: Some(Numbers(to)),
                heading: Some(heading),
                turned: (turned != 0.0).then_some(turned),
                reverse,
                ..leg
            },
            Curve::Arc { center, radius, start_angle, sweep } => Self {
                center: Some(Numbers(center)),
                radius: Some(radius),
                start_angle: Some(start_angle),
                sweep: Some(sweep),
                reverse,
                ..leg
            },
            Curve::Turn { position, from_heading, to_heading, sweep: _ } => Self {
                position: Some(Numbers(position)),
                from_heading: Some(from_heading),
                to_heading: Some(to_heading),
                ..leg
            },
            Curve::Clothoid { from, to, from_heading, to_heading, curvatures, length: _ } => Self {
                from: Some(Numbers(from)),
                to: Some(Numbers(to)),
                from_heading: Some(from_heading),
                to_heading: Some(to_heading),
                start_curvature: Some(curvatures[0]),
                end_curvature: Some(curvatures[1]),
                reverse,
                ..leg
            },
        }
    }
}

impl Element for Leg {
    type Json<'a> = LegJson;

    fn from_json<E: Error>(json: LegJson) -> Result<Self, E> {
        let LegJson {
            kind: Word(kind),
            from,
            to,
            heading,
            turned,
            center,
            radius,
            start_angle,
            sweep,
            position,
            from_heading,
            to_heading,
            start_curvature,
            end_curvature,
            reverse,
            length,
            clearance,
            rule,
            junction,
            rung,
        } = json;
        let given = [
            ("from", from.is_some()),
            ("to", to.is_some()),
            ("heading", heading.is_some()),
            ("turned", turned.is_some()),
            ("center", center.is_some()),
            ("radius", radius.is_some()),
            ("start_angle", start_angle.is_some()),
            ("sweep", sweep.is_some()),
            ("position", position.is_some()),
            ("from_heading", from_heading.is_some()),
            ("to_heading", to_heading.is_some()),
            ("start_curvature", start_curvature.is_some()),
            ("end_curvature", end_curvature.is_some()),
            ("reverse", reverse.is_some()),
        ];
        let fields = fields_of(kind);
        if let Some((name, _)) = given.iter().find(|(name, given)| *given && !fields.contains(name))
        {
            return Err(E::unknown_field(name, fields));
        }
        let need = |number: Option<f64>, name| number.ok_or_else(|| E::missing_field(name));
        let point = |point: Option<Point>, name| {
            point.map(|point| point.0).ok_or_else(|| E::missing_field(name))
        };
        let curve = match kind {
            CurveKind::Line => Curve::Line {
                from: point(from, "from")?,
                to: point(to, "to")?,
                heading: need(heading, "heading")?,
                turned: turned.unwrap_or(0.0),
            },
            CurveKind::Arc => Curve::Arc {
                center: point(center, "center")?,
                radius: need(radius, "radius")?,
                start_angle: need(start_angle, "start_angle")?,
                sweep: need(sweep, "sweep")?,
            },
            CurveKind::Turn => {
                let from_heading = need(from_heading, "from_heading")?;
                let to_heading = need(to_heading, "to_heading")?;
                Curve::Turn {
                    position: point(position, "position")?,
                    from_heading,
                    to_heading,
                    sweep: shorter_turn(from_heading, to_heading),
                }
            }
            CurveKind::Clothoid => Curve::Clothoid {
                from: point(from, "from")?,
                to: point(to, "to")?,
                from_heading: need(from_heading, "from_heading")?,
                to_heading: need(to_heading, "to_heading")?,
                curvatures: [
                    need(start_curvature, "start_curvature")?,
                    need(end_curvature, "end_curvature")?,
                ],
                length,
            },
        };
        let rule = rule.map(|RuleJson(rule)| rule);
        let rung = rung.map(|Word(rung)| rung);
        let reverse = reverse.unwrap_or(false);
        Ok(Self { curve, length, clearance: clearance.0, junction, rule, reverse, rung })
    }
}

/// A rule of the paper as a text: `table 1, rule 3`.
struct RuleJson(Rule);

impl Serialize for RuleJson {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.0)
    }
}

impl<'de> Deserialize<'de> for RuleJson {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct RuleVisitor;

        impl Visitor<'_> for RuleVisitor {
            type Value = Rule;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a rule such as \"table 1, rule 3\"")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Rule, E> {
                let numbers =
                    text.strip_prefix("table ").and_then(|rest| rest.split_once(", rule "));
                let rule = numbers.and_then(|(table, number)| {
                    Some(Rule { table: digits(table)?, number: digits(number)? })
                });
                rule.ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
            }
        }

        deserializer.deserialize_any(RuleVisitor).map(Self)
    }
}

/// A number as it is written: without sign and leading zeros.
fn digits(text: &str) -> Option<u16> {
    let plain = text.bytes().all(|byte| byte.is_ascii_digit());
    let canonical = text == "0" || !text.starts_with('0');
    (plain && canonical).then(|| text.parse().ok()).flatten()
}

#[cfg(feature = "json-schema")]
mod schema {
    use std::borrow::Cow;

    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
    use serde_json::{Map, Value, json};

    use super::{CurveKind, OPTIONAL, RuleJson, fields_of};

    /// One object for each kind, with the fields of that kind only.
    pub(super) fn split_by_kind(schema: &mut Schema) {
        let all = schema.remove("properties").expect("a leg is an object");
        let common = schema.remove("required").expect("fields that all legs have");
        schema.remove("additionalProperties");
        schema.remove("type");
        let kinds = CurveKind::ALL.iter().map(|kind| of_kind(*kind, &all, &common));
        schema.insert("oneOf".to_owned(), kinds.collect());
    }

    fn of_kind(kind: CurveKind, all: &Value, common: &Value) -> Value {
        let others = CurveKind::ALL.iter().filter(|other| **other != kind);
        let others: Vec<_> = others.flat_map(|other| fields_of(*other)).copied().collect();
        let mut required = common.as_array().expect("a list").clone();
        let mut properties = Map::new();
        for (name, schema) in all.as_object().expect("properties by name") {
            let of_this = fields_of(kind).contains(&name.as_str());
            if others.contains(&name.as_str()) && !of_this {
                // `null` is the same as a field left out.
                properties.insert(name.clone(), json!({ "type": "null" }));
                continue;
            }
            let mut schema = schema.clone();
            if name == "kind" {
                schema = json!({ "const": kind.name(), "description": description(kind) });
            } else if of_this && !OPTIONAL.contains(&name.as_str()) {
                required.push(Value::from(name.as_str()));
                without_null(&mut schema);
            }
            properties.insert(name.clone(), schema);
        }
        json!({
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": false,
        })
    }

    fn description(kind: CurveKind) -> &'static str {
        crate::message::Named::meaning(kind).trim()
    }

    /// What stands in `anyOf` or `type` beside null.
    fn without_null(schema: &mut Value) {
        let schema = schema.as_object_mut().expect("a schema of a field");
        if let Some(Value::Array(kinds)) = schema.get("type").cloned() {
            let kind = kinds.into_iter().find(|kind| kind != "null").expect("a kind beside null");
            schema.insert("type".to_owned(), kind);
        }
        if let Some(Value::Array(forms)) = schema.remove("anyOf") {
            let null = json!({ "type": "null" });
            let form = forms.into_iter().find(|form| *form != null).expect("a form beside null");
            let Value::Object(form) = form else { unreachable!("a schema of a point") };
            schema.extend(form);
        }
    }

    impl JsonSchema for RuleJson {
        fn schema_name() -> Cow<'static, str> {
            "rule".into()
        }

        fn json_schema(_: &mut SchemaGenerator) -> Schema {
            let number = "(0|[1-9][0-9]{0,4})";
            json_schema!({
                "type": "string",
                "description": "The table of the paper (1: part assembly, 2: mobile robot) and the \
                                number of the rule in it.",
                "pattern": format!("^table {number}, rule {number}$"),
            })
        }
    }
}
