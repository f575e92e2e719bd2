//! The JSON Schemas of scenes and replies (draft 2020-12), generated from the types
//! that read and write them.
//!
//! They describe the form. What the numbers must be, such as `min` less than `max`, is
//! checked by the planner.

use std::borrow::Cow;
use std::collections::BTreeSet;

use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use super::clearance::{ChoiceJson, GapJson, GivenChoice, GivenWish, SAFEST, WishJson};
use super::reply::{AnswerJson, RefusedJson, ReplyJson};
use super::scene::SceneJson;
use super::trajectory::TrajectoryJson;
use super::values::{Element, List, Numbers, Word, Words};
use crate::message::{Named, Vector};

/// The schema of scene requests, as the text of its file.
///
/// ```
/// let schema: serde_json::Value = serde_json::from_str(&schemas::json::schema::scene()).unwrap();
/// assert_eq!(schema["required"], serde_json::json!(["task", "free_space", "body", "clearance"]));
/// ```
pub fn scene() -> String {
    describe::<SceneJson>("urn:clearway:schema:scene", "Clearway scene request")
}

/// The schema of replies, as the text of its file.
///
/// ```
/// let schema: serde_json::Value = serde_json::from_str(&schemas::json::schema::reply()).unwrap();
/// assert_eq!(schema["title"], "Clearway reply");
/// ```
pub fn reply() -> String {
    describe::<ReplyJson>("urn:clearway:schema:reply", "Clearway reply")
}

/// The schema of a type, as the text of its file.
pub fn describe<T: JsonSchema>(id: &str, title: &str) -> String {
    let settings = SchemaSettings::draft2020_12();
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    Plain.transform(&mut schema);
    schema.insert("$id".to_owned(), id.into());
    schema.insert("title".to_owned(), title.into());
    let mut schema = schema.to_value();
    // The same text whatever features of serde_json a build has.
    schema.sort_all_objects();
    serde_json::to_string_pretty(&schema).expect("a String takes any text") + "\n"
}

/// Removes what only Rust knows: formats of numbers, and the ends of lines in descriptions.
struct Plain;

impl Transform for Plain {
    fn transform(&mut self, schema: &mut Schema) {
        match schema.remove("format") {
            Some(format) if format == "uint64" || format == "uint" => {
                schema.insert("maximum".to_owned(), u64::MAX.into());
            }
            Some(format) if format == "double" => {}
            None => {}
            Some(format) => unreachable!("{format} has no rule"),
        }
        if let Some(Value::String(text)) = schema.get_mut("description") {
            *text = text.replace('\n', " ");
        }
        transform_subschemas(self, schema);
    }
}

/// Of an object with exactly one of several fields, allows the others to be `null`, which
/// is the same as leaving them out.
pub(super) fn allow_null_alternatives(schema: &mut Schema) {
    let alternatives = schema.get_mut("oneOf").and_then(Value::as_array_mut);
    let alternatives = alternatives.expect("an enumeration has alternatives");
    let fields = |alternative: &Value| -> Vec<String> {
        let properties = alternative["properties"].as_object().expect("an object's fields");
        properties.keys().cloned().collect()
    };
    let all: BTreeSet<_> = alternatives.iter().flat_map(fields).collect();
    for alternative in alternatives {
        let own: BTreeSet<_> = fields(alternative).into_iter().collect();
        let properties = alternative["properties"].as_object_mut().expect("an object's fields");
        for other in all.difference(&own) {
            properties.insert(other.clone(), json!({ "type": "null" }));
        }
    }
}

/// A reply has either trajectories or an error.
pub(super) fn require_one(schema: &mut Schema) {
    let only = |one: &str, other: &str| {
        json!({
            "required": [one],
            "properties": { one: { "not": { "type": "null" } }, other: { "type": "null" } },
        })
    };
    let forms = json!([only("trajectories", "error"), only("error", "trajectories")]);
    schema.insert("oneOf".to_owned(), forms);
}

impl<M: Element> JsonSchema for List<'_, M>
where
    M: 'static,
    M::Json<'static>: JsonSchema,
{
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        Vec::<M::Json<'static>>::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Vec::<M::Json<'static>>::json_schema(generator)
    }
}

impl<T: Named> JsonSchema for Word<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "word".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let words = T::VALUES
            .iter()
            .map(|value| json!({ "const": value.word(), "description": value.meaning().trim() }));
        json_schema!({ "oneOf": words.collect::<Value>() })
    }
}

impl<T: Named + Element> JsonSchema for Words<'_, T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "words".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let word = Word::<T>::json_schema(generator);
        json_schema!({ "anyOf": [word, { "type": "array", "items": word }] })
    }
}

impl<const LEAST: usize> JsonSchema for Numbers<LEAST> {
    fn schema_name() -> Cow<'static, str> {
        if LEAST == 1 { "per_axis" } else { "point" }.into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let description = match LEAST {
            1 => "A number per axis.",
            _ => "(x, z) or (x, y) in two dimensions, (x, y, z) in three.",
        };
        json_schema!({
            "description": description,
            "type": "array",
            "items": { "type": "number" },
            "minItems": LEAST,
            "maxItems": Vector::MOST,
        })
    }
}

impl JsonSchema for GapJson {
    fn schema_name() -> Cow<'static, str> {
        "gap".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A clearance gap, metres: one number for all axes, or a number per axis \
                            (assembly tasks).",
            "anyOf": [{ "type": "number" }, generator.subschema_for::<Numbers<1>>()],
        })
    }
}

impl JsonSchema for WishJson<'_> {
    fn schema_name() -> Cow<'static, str> {
        "clearance".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut given = GivenWish::json_schema(generator);
        let forms = given.remove("oneOf").expect("an enumeration has alternatives");
        json_schema!({ "oneOf": with_safest(forms) })
    }
}

impl JsonSchema for ChoiceJson<'_> {
    fn schema_name() -> Cow<'static, str> {
        "choice".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut given = GivenChoice::json_schema(generator);
        let forms = given.remove("oneOf").expect("an enumeration has alternatives");
        let mut forms = with_safest(forms);
        forms.push(generator.subschema_for::<GapJson>().to_value());
        json_schema!({
            "description": "The gaps of one answer.",
            "oneOf": forms,
        })
    }
}

fn with_safest(forms: Value) -> Vec<Value> {
    let Value::Array(mut forms) = forms else { unreachable!("alternatives are a list") };
    let description = "The gap that leaves the greatest clearance.";
    forms.push(json!({ "const": SAFEST, "description": description }));
    forms
}

impl JsonSchema for AnswerJson<'_> {
    fn schema_name() -> Cow<'static, str> {
        "answer".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A trajectory, or why there is none for this clearance.",
            "oneOf": [
                generator.subschema_for::<TrajectoryJson>(),
                RefusedJson::json_schema(generator),
            ],
        })
    }
}
