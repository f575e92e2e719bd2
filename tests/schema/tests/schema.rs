//! The published schemas are those of the reader: what one takes, the other takes.

#[expect(dead_code, reason = "the messages of shared memory and recordings have no schema")]
#[path = "../../../schemas/tests/messages/strategies.rs"]
mod strategies;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use jsonschema::Validator;
use proptest::collection::vec;
use proptest::option::of;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use schema_tests::{Change, changes, mutant};
use schemas::json::{self, schema};
use schemas::message::{Reply, Request, RequestContent, RequestKey};
use serde_json::{Value, json};

static SCENE: LazyLock<Validator> = LazyLock::new(|| validator(&schema::scene()));
static REPLY: LazyLock<Validator> = LazyLock::new(|| validator(&schema::reply()));
static SCENE_NAMES: LazyLock<Vec<String>> = LazyLock::new(|| names(&schema::scene()));
static REPLY_NAMES: LazyLock<Vec<String>> = LazyLock::new(|| names(&schema::reply()));

fn validator(schema: &str) -> Validator {
    let schema = serde_json::from_str(schema).unwrap();
    jsonschema::meta::validate(&schema).unwrap();
    jsonschema::draft202012::new(&schema).unwrap()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn published_schemas_are_current() {
    for (name, generated) in [("scene", schema::scene()), ("reply", schema::reply())] {
        let path = root().join(format!("schemas/json/{name}.schema.json"));
        let published = fs::read_to_string(&path).unwrap();
        assert_eq!(published, generated, "{name}: run `cargo bless`");
    }
}

/// JSON Schema takes 7.0 for an integer, the reader does not: an `id` is echoed as it is
/// written. This is what the schema is shown in place of such numbers.
fn without_whole_fractions(value: &Value) -> Value {
    match value {
        Value::Number(number) => match number.as_f64() {
            Some(value) if number.is_f64() && value.fract() == 0.0 => json!(0.5),
            _ => value.clone(),
        },
        Value::Array(list) => list.iter().map(without_whole_fractions).collect(),
        Value::Object(fields) => {
            let fields = fields.iter();
            fields.map(|(name, value)| (name.clone(), without_whole_fractions(value))).collect()
        }
        other => other.clone(),
    }
}

/// Why the schema refuses a document, if it does.
fn refused(validator: &Validator, document: &Value) -> Option<String> {
    let shown = without_whole_fractions(document);
    let error = validator.validate(&shown).err()?;
    Some(format!("{}: {error}", error.instance_path()))
}

/// What JSON Schema can't say of a scene: whether half-spaces bound a box, and that a robot's start
/// has a heading.
const OF_A_SCENE: [&str; 2] = ["half_spaces", "start.heading is missing"];

fn check_scene(document: &Value) -> Result<(), TestCaseError> {
    let read = json::read_scene(&document.to_string()).map_err(|error| error.refusal.message);
    match (read, refused(&SCENE, document)) {
        (Ok(_), None) | (Err(_), Some(_)) => Ok(()),
        (Ok(_), Some(error)) => Err(TestCaseError::fail(format!("{error}\n{document:#}"))),
        (Err(error), None) if OF_A_SCENE.iter().any(|known| error.contains(known)) => Ok(()),
        (Err(error), None) => Err(TestCaseError::fail(format!("only the reader: {error}"))),
    }
}

/// What JSON Schema can't say of a reply.
const ONLY_THE_READER: [&str; 3] = [
    // Points agree in their number of coordinates.
    "all in 2 or all in 3 dimensions",
    "has positions of",
    // The numbers of tables and rules are at most 65,535.
    "must be a rule",
];

fn check_reply(document: &Value) -> Result<(), TestCaseError> {
    let read = json::read_reply(&document.to_string()).map_err(|error| error.message);
    match (read, refused(&REPLY, document)) {
        (Ok(_), None) | (Err(_), Some(_)) => Ok(()),
        (Ok(_), Some(error)) => Err(TestCaseError::fail(format!("{error}\n{document:#}"))),
        (Err(error), None) if ONLY_THE_READER.iter().any(|known| error.contains(known)) => Ok(()),
        (Err(error), None) => Err(TestCaseError::fail(format!("only the reader: {error}"))),
    }
}

/// The names of all properties of a schema and all its fixed words, and two that it does not know.
fn names(schema: &str) -> Vec<String> {
    fn collect(schema: &Value, names: &mut BTreeSet<String>) {
        match schema {
            Value::Object(fields) => {
                if let Some(Value::Object(properties)) = fields.get("properties") {
                    names.extend(properties.keys().cloned());
                }
                for word in ["const", "enum"].iter().filter_map(|key| fields.get(*key)) {
                    names.extend(word.as_str().map(str::to_owned));
                    let words = word.as_array().into_iter().flatten();
                    names.extend(words.filter_map(Value::as_str).map(str::to_owned));
                }
                fields.values().for_each(|inner| collect(inner, names));
            }
            Value::Array(items) => items.iter().for_each(|inner| collect(inner, names)),
            _ => {}
        }
    }
    let mut all = BTreeSet::from(["unknown".to_owned(), String::new()]);
    collect(&serde_json::from_str(schema).unwrap(), &mut all);
    all.into_iter().collect()
}

fn any_reply() -> impl Strategy<Value = Reply> {
    let refusal = || strategies::refusal(&strategies::finite());
    let trajectory = strategies::trajectory(strategies::finite()).prop_map(|mut trajectory| {
        // As the planner's: a gap for each axis, or one.
        let each = if trajectory.gaps.len() % 2 == 0 { 2 } else { 1 };
        trajectory.gaps_per_junction = each;
        trajectory
    });
    let answer = prop_oneof![3 => trajectory.prop_map(Ok), 1 => refusal().prop_map(Err)];
    let answers = prop_oneof![4 => vec(answer, 0..3).prop_map(Ok), 1 => refusal().prop_map(Err)];
    (of(any::<u64>()), answers).prop_map(|(id, answers)| Reply {
        key: RequestKey::default(),
        id,
        answers,
    })
}

fn mutants<T>(
    document: impl Strategy<Value = T>,
    names: &'static [String],
) -> impl Strategy<Value = (T, Vec<Vec<Change>>)>
where
    T: std::fmt::Debug,
{
    (document, vec(changes(names), 16))
}

/// 512 documents, or as many as `PROPTEST_CASES` asks for, with 16 mutants each.
fn many() -> ProptestConfig {
    let config = ProptestConfig::default();
    ProptestConfig { cases: config.cases.max(512), ..config }
}

proptest! {
    #![proptest_config(many())]

    #[test]
    fn scenes_and_their_mutants_are_judged_alike(
        (scene, mutants) in mutants(strategies::scene(strategies::finite()), &SCENE_NAMES),
    ) {
        let document: Value = serde_json::from_str(&json::scene_to_json(&scene)).unwrap();
        prop_assert_eq!(refused(&SCENE, &document), None);
        check_scene(&document)?;
        for changes in mutants {
            check_scene(&mutant(document.clone(), &changes))?;
        }
    }

    #[test]
    fn replies_and_their_mutants_are_judged_alike(
        (reply, mutants) in mutants(any_reply(), &REPLY_NAMES),
    ) {
        let document: Value = serde_json::from_str(&json::reply_to_json(&reply)).unwrap();
        prop_assert_eq!(refused(&REPLY, &document), None);
        check_reply(&document)?;
        for changes in mutants {
            check_reply(&mutant(document.clone(), &changes))?;
        }
    }
}

/// The same mutants on every run: of 512 documents, 16 each.
fn fixed_mutants(documents: impl Strategy<Value = Value>, names: &'static [String]) -> Vec<Value> {
    let mut runner = TestRunner::deterministic();
    let strategy = mutants(documents, names);
    let mut all = Vec::new();
    for _ in 0..512 {
        let (document, mutants) = strategy.new_tree(&mut runner).unwrap().current();
        all.extend(mutants.iter().map(|changes| mutant(document.clone(), changes)));
    }
    all
}

/// How many documents a schema judges otherwise than the reader once it is changed: the value at
/// `place` becomes `changed`.
fn noticed(
    schema: &str,
    documents: &[Value],
    reads: fn(&str) -> bool,
    (place, changed): (&str, Value),
) -> usize {
    let mut schema: Value = serde_json::from_str(schema).unwrap();
    *schema.pointer_mut(place).unwrap_or_else(|| panic!("nothing is at {place}")) = changed;
    let changed = validator(&schema.to_string());
    let differs =
        |document: &&Value| reads(&document.to_string()) == refused(&changed, document).is_some();
    documents.iter().filter(differs).count()
}

/// The comparison would be worth nothing if it did not notice a wrong schema.
#[test]
fn wrong_schemas_are_noticed() {
    let scene = |scene| serde_json::from_str(&json::scene_to_json(&scene)).unwrap();
    let scenes = strategies::scene(strategies::finite()).prop_map(scene);
    let scenes = fixed_mutants(scenes, &SCENE_NAMES);
    let reads = |text: &str| json::read_scene(text).is_ok();
    let valid = scenes.iter().filter(|scene| reads(&scene.to_string())).count();
    assert!((100..scenes.len() - 100).contains(&valid), "{valid} of {}", scenes.len());
    for change in [
        ("/additionalProperties", json!(true)),
        ("/required", json!(["task"])),
        ("/properties/deadline/type", json!("number")),
        ("/properties/task", json!({ "type": "string" })),
        ("/$defs/point/maxItems", json!(4)),
        ("/$defs/box/oneOf/0/required", json!(["min"])),
    ] {
        let place = change.0;
        let noticed = noticed(&schema::scene(), &scenes, reads, change);
        assert!(noticed > 0, "nothing is noticed of {place}");
    }

    let reply = |reply| serde_json::from_str(&json::reply_to_json(&reply)).unwrap();
    let replies = fixed_mutants(any_reply().prop_map(reply), &REPLY_NAMES);
    let reads = |text: &str| match json::read_reply(text) {
        Ok(_) => true,
        Err(error) => ONLY_THE_READER.iter().any(|known| error.message.contains(known)),
    };
    for change in [
        ("/oneOf", json!([true])),
        ("/$defs/distance/type", json!("number")),
        ("/$defs/leg/oneOf/0/required", json!(["kind"])),
        ("/$defs/leg/oneOf/1/additionalProperties", json!(true)),
        ("/$defs/error/properties/axis", json!(true)),
    ] {
        let place = change.0;
        let noticed = noticed(&schema::reply(), &replies, reads, change);
        assert!(noticed > 0, "nothing is noticed of {place}");
    }
}

/// The scenes in `recordings/scenes`, by file and line; some of them are broken on purpose.
fn recorded_scenes() -> Vec<(String, String)> {
    let mut scenes = Vec::new();
    for file in fs::read_dir(root().join("recordings/scenes")).unwrap() {
        let path = file.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let text = || fs::read_to_string(&path).unwrap();
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("json") => scenes.push((name, text())),
            Some("jsonl") => {
                let lines = text();
                let lines = lines.lines().enumerate();
                scenes.extend(
                    lines.map(|(at, line)| (format!("{name}:{}", at + 1), line.to_owned())),
                );
            }
            _ => {}
        }
    }
    scenes
}

#[test]
fn recorded_scenes_and_their_replies_are_valid() {
    let caps = answer::Caps::default();
    let (mut planned, mut refused_requests) = (0, 0);
    for (name, text) in recorded_scenes() {
        let mut document: Value = serde_json::from_str(&text).unwrap();
        if document.get("free_space").is_none() {
            // Goes with a map.
            document["free_space"] =
                json!({ "solids": [], "bounds": { "min": [-50, -50], "max": [50, 50] } });
        }
        check_scene(&document).unwrap_or_else(|error| panic!("{name}: {error}"));
        let Ok(scene) = json::read_scene(&document.to_string()) else { continue };
        assert_eq!(refused(&SCENE, &document), None, "{name}");
        let request = Request {
            key: RequestKey::default(),
            sent_ns: 0,
            content: RequestContent::Scene(scene),
        };
        let reply = json::reply_to_json(&answer::reply_to(&request, &caps));
        let document = serde_json::from_str(&reply).unwrap();
        assert_eq!(refused(&REPLY, &document), None, "{name}");
        let read = json::read_reply(&reply).unwrap();
        assert_eq!(json::reply_to_json(&read), reply, "{name}");
        match read.answers {
            Ok(_) => planned += 1,
            Err(_) => refused_requests += 1,
        }
    }
    assert!(planned > 10 && refused_requests > 10, "{planned} planned, {refused_requests} refused");
}

#[test]
fn integers_have_the_range_of_the_reader() {
    let scene = |id: &str| -> Value {
        let text = format!(
            r#"{{"id":{id},"task":"drive","free_space":{{}},"body":{{"polygon":[]}},
                "clearance":"safest"}}"#
        );
        serde_json::from_str(&text).unwrap()
    };
    for (id, valid) in [
        ("0", true),
        ("18446744073709551615", true),
        ("18446744073709551616", false),
        ("-1", false),
        ("0.5", false),
        ("null", true),
    ] {
        assert_eq!(refused(&SCENE, &scene(id)).is_none(), valid, "{id}");
        check_scene(&scene(id)).unwrap();
    }
}

/// A text that names a field twice is not one that a schema can be shown; a `7.0` is.
#[test]
fn the_reader_alone_refuses_repeated_fields_and_whole_fractions() {
    let text =
        r#"{"id":7,"task":"drive","free_space":{},"body":{"polygon":[]},"clearance":"safest"}"#;
    for changed in [text.replace("7,", "7,\"id\":7,"), text.replace('7', "7.0")] {
        let document: Value = serde_json::from_str(&changed).unwrap();
        assert!(SCENE.is_valid(&document) && json::read_scene(&changed).is_err(), "{changed}");
    }
}
