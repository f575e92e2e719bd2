//! Footprints in JSON: with a length, or with what lies before and behind the reference point.

use serde::de::Error;
use serde::{Deserialize, Serialize};

use super::fault::Fault;
use crate::message::Footprint;

/// The rectangle that a mobile robot covers: `width` and `length`, with the reference point in the
/// middle, or `width`, `front` and `rear`. Poses in the request and in the reply are those of the
/// reference point.
#[derive(Serialize, Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(rename = "footprint", transform = schema::split_by_reference)
)]
#[serde(deny_unknown_fields)]
pub(super) struct FootprintJson {
    /// Across the heading, metres; greater than 0.
    width: f64,
    /// Along the heading, metres; greater than 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    length: Option<f64>,
    /// From the reference point to the front end, metres; at least 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    front: Option<f64>,
    /// From the reference point to the rear end, metres; at least 0, and with `front` greater
    /// than 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    rear: Option<f64>,
}

impl From<Footprint> for FootprintJson {
    fn from(footprint: Footprint) -> Self {
        match footprint {
            Footprint::Centered { width, length } => {
                Self { width, length: Some(length), front: None, rear: None }
            }
            Footprint::Offset { width, front, rear } => {
                Self { width, length: None, front: Some(front), rear: Some(rear) }
            }
        }
    }
}

impl FootprintJson {
    pub(super) fn into_message(self) -> Result<Footprint, Fault> {
        let Self { width, length, front, rear } = self;
        match (length, front, rear) {
            (Some(length), None, None) => Ok(Footprint::Centered { width, length }),
            (None, Some(front), Some(rear)) => Ok(Footprint::Offset { width, front, rear }),
            (None, None, None) => Err(Fault::missing().in_field("length")),
            (None, Some(_), None) => Err(Fault::missing().in_field("rear")),
            (None, None, Some(_)) => Err(Fault::missing().in_field("front")),
            (Some(_), _, _) => {
                let other = if front.is_some() { "front" } else { "rear" };
                let message = format!(
                    "does not go with `{other}`; give either `length`, or `front` and `rear`"
                );
                Err(Fault::custom(message).in_field("length"))
            }
        }
    }
}

#[cfg(feature = "json-schema")]
mod schema {
    use schemars::Schema;
    use serde_json::{Map, Value, json};

    /// Either `length`, or `front` and `rear`.
    pub(super) fn split_by_reference(schema: &mut Schema) {
        let form = |given: &[&str], others: &[&str]| {
            let given_types = given.iter().map(|name| (*name, json!({ "type": "number" })));
            let other_types = others.iter().map(|name| (*name, json!({ "type": "null" })));
            let types = given_types.chain(other_types).map(|(name, form)| (name.to_owned(), form));
            json!({ "required": given, "properties": types.collect::<Map<String, Value>>() })
        };
        let (centered, offset) = (&["length"][..], &["front", "rear"][..]);
        let forms = json!([form(centered, offset), form(offset, centered)]);
        schema.insert("oneOf".to_owned(), forms);
    }
}
