//! What a reply says, every client shows.
//!
//! The Python client's own tests compare its objects with the schema in the same way.

use std::collections::BTreeSet;
use std::fs;

use integration_tests::root;
use serde_json::Value;

/// Fields of a reply, and what has another name in a client.
type Renamed = &'static [(&'static str, &'static str)];

/// The objects of the published schema, and what C has of each: a struct whose fields have the same
/// names, but for those that are said otherwise.
const OBJECTS: [(&str, &str, Renamed); 7] = [
    (
        "",
        "",
        &[
            ("id", "clearway_reply_id"),
            ("trajectories", "clearway_reply_trajectory"),
            ("error", "clearway_error_refusal"),
        ],
    ),
    (
        "trajectory",
        "clearway_summary",
        &[
            ("gap", "clearway_trajectory_gaps"),
            ("route", "clearway_trajectory_route"),
            ("channels", "clearway_trajectory_channel"),
            ("legs", "clearway_trajectory_leg"),
            ("samples", "clearway_trajectory_block"),
        ],
    ),
    (
        "nearest_wall",
        "clearway_summary",
        &[("value", "clearance"), ("at", "clearance_at"), ("wall", "clearance_wall")],
    ),
    ("exceeds", "clearway_exceeds", &[]),
    (
        "leg",
        "clearway_leg",
        &[
            ("from", "point"),
            ("center", "point"),
            ("position", "point"),
            ("from_heading", "start"),
            ("start_angle", "start"),
            ("to_heading", "heading"),
            ("turned", "sweep"),
            ("start_curvature", "curvatures"),
            ("end_curvature", "curvatures"),
            ("rule", "table"),
        ],
    ),
    ("sample", "clearway_sample", &[]),
    ("error", "clearway_refusal", &[]),
];

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn schema() -> Value {
    serde_json::from_str(&read("schemas/json/reply.schema.json")).expect("it is JSON")
}

/// The names of the fields that an object of the schema can have; `""` is the reply itself.
fn fields(schema: &Value, object: &str) -> BTreeSet<String> {
    let object = if object.is_empty() { schema } else { &schema["$defs"][object] };
    let forms = object["oneOf"].as_array().into_iter().flatten();
    let forms = forms.chain(std::iter::once(object));
    let names = forms.filter_map(|form| form["properties"].as_object()).flatten();
    names.map(|(name, _)| name.clone()).collect()
}

/// The words of code, comments left out.
fn words(text: &str) -> BTreeSet<&str> {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_')).collect()
}

/// The lines of a struct of the C header.
fn fields_in_c(header: &str, name: &str) -> String {
    let begin = format!("typedef struct {name} {{");
    let (_, inside) = header.split_once(&begin).unwrap_or_else(|| panic!("C has no {name}"));
    inside.split('}').next().unwrap_or_default().to_owned()
}

#[test]
fn every_object_of_a_reply_is_known_to_these_tests() {
    let schema = schema();
    let objects = schema["$defs"].as_object().expect("the schema has definitions").keys();
    let objects: BTreeSet<_> = objects.filter(|name| !fields(&schema, name).is_empty()).collect();
    let mut known: BTreeSet<_> = OBJECTS.map(|(object, ..)| object.to_owned()).into();
    known.remove("");
    // An answer is a trajectory or an error; boxes are those of scenes.
    known.extend(["answer", "box", "half_space"].map(str::to_owned));
    assert_eq!(objects, known.iter().collect());
}

#[test]
fn every_field_of_a_reply_is_in_the_c_header() {
    let (schema, header) = (schema(), read("services/clients/c/include/clearway.h"));
    let functions = words(&header);
    for (object, name, renamed) in OBJECTS {
        let members = if name.is_empty() { String::new() } else { fields_in_c(&header, name) };
        let members = words(&members);
        let all = fields(&schema, object);
        assert!(!all.is_empty(), "the schema has no {object}");
        for field in &all {
            let there =
                renamed.iter().find(|(from, _)| from == field).map_or(&**field, |(_, to)| to);
            let found = members.contains(there)
                || (there.starts_with("clearway_") && functions.contains(there));
            assert!(found, "C does not show `{field}` of {object:?}: no `{there}` in {name:?}");
        }
        for (field, _) in renamed {
            assert!(all.contains(*field), "{object:?} has no `{field}` any more");
        }
    }
}

#[test]
fn every_function_of_the_c_header_is_wrapped_in_cpp() {
    let (header, wrapper) = (
        read("services/clients/c/include/clearway.h"),
        read("services/clients/c/include/clearway.hpp"),
    );
    let wrapped = words(&wrapper);
    let lines = header.lines().filter(|line| !line.trim_start().starts_with("//"));
    let functions: Vec<_> = lines
        .filter_map(|line| line.split_once('(')?.0.rsplit([' ', '*']).next())
        .filter(|name| name.starts_with("clearway_"))
        .collect();
    assert!(functions.len() > 20, "there are more functions than {functions:?}");
    for function in functions {
        assert!(wrapped.contains(function), "C++ has nothing that calls {function}");
    }
}

#[test]
fn every_field_of_a_trajectory_is_a_method_in_rust() {
    let client = read("services/clients/rust/src/reply.rs");
    let (_, trajectory) = client.split_once("impl Trajectory {").expect("there are trajectories");
    let (trajectory, _) = trajectory.split_once("\n}").expect("a block ends");
    for field in fields(&schema(), "trajectory") {
        let method = match &*field {
            "gap" => "gaps",
            "complete" => "is_complete",
            other => other,
        };
        let found = trajectory.contains(&format!("pub fn {method}(&self)"));
        assert!(found, "a trajectory of the Rust client does not show `{field}`: no `{method}`");
    }
}
