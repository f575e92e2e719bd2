//! What `replay` prints as JSON has the published form.

use std::fs;
use std::path::{Path, PathBuf};

use answer::{Answerer, Caps};
use comparison::check::{Checked, check, find};
use comparison::diff::diff;
use comparison::report::{CheckReport, DiffReport, schema};
use comparison::tolerance::Tolerance;
use jsonschema::Validator;
use schemas::message::RequestContent;
use serde_json::{Value, json};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The published schema, which is the one that is generated.
fn published(name: &str, generated: &str) -> Validator {
    let path = root().join(format!("schemas/json/{name}.schema.json"));
    assert_eq!(fs::read_to_string(path).unwrap(), generated, "{name}: run `cargo bless`");
    let schema = serde_json::from_str(generated).unwrap();
    jsonschema::meta::validate(&schema).unwrap();
    jsonschema::draft202012::new(&schema).unwrap()
}

/// The golden recordings checked with another speed: motions, refusals, answers that vanish.
fn checked() -> Vec<Checked> {
    let files = find(&[root().join("recordings")]).unwrap();
    let each = files.iter().map(|path| {
        let mut answerer = Answerer::new(&Caps::default());
        let slower = |request: &schemas::message::Request| {
            let mut request = request.clone();
            if let RequestContent::Scene(scene) = &mut request.content {
                scene.limits.speed = Some(if scene.id == Some(14) { -1.0 } else { 0.5 });
            }
            answerer.reply_to(&request)
        };
        check(std::slice::from_ref(path), &Tolerance::EXACT, slower, |_| {})
    });
    each.collect()
}

#[test]
fn reports_of_check_have_the_published_form() {
    let validator = published("check", &schema::check());
    let report = serde_json::to_value(CheckReport::from(&checked()[..])).unwrap();
    let answers = report["files"].as_array().unwrap().iter();
    let verdicts: Vec<&Value> = answers
        .flat_map(|file| file["answers"].as_array().unwrap())
        .map(|answer| &answer["verdict"])
        .collect();
    for verdict in ["moved", "vanished"] {
        assert!(verdicts.contains(&&json!(verdict)), "{verdict}: {verdicts:?}");
    }
    assert!(validator.is_valid(&report), "{:?}", validator.iter_errors(&report).next());
    let mut wrong = report;
    wrong["files"][0]["answers"][0]["motion"]["position"]["sample"] = json!("first");
    assert!(!validator.is_valid(&wrong), "a schema that takes anything says nothing");
}

#[test]
fn reports_of_diff_have_the_published_form() {
    let validator = published("diff", &schema::diff());
    let [a, b] =
        ["routes", "free-space"].map(|name| root().join(format!("recordings/{name}.mcap")));
    let compared = diff([&[a], &[b]], &Tolerance::EXACT, |_| {}, |_, _, _| {});
    let names = ["a", "b"].map(str::to_owned);
    let report = serde_json::to_value(DiffReport::new(&compared, names)).unwrap();
    assert!(validator.is_valid(&report), "{:?}", validator.iter_errors(&report).next());
    let mut wrong = report;
    wrong["only_in_a"] = json!(3);
    assert!(!validator.is_valid(&wrong));
}
