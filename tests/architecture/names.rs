//! One word for one thing: types of our crates have distinct names.

use std::collections::BTreeMap;

use crate::code::Code;

/// What `planning` works with and what the messages of `schemas` say of it: the same things,
/// and so the same names, once in each. A field of a request is found by its name in the code.
const IN_MESSAGES: [&str; 16] = [
    "AxisBox",
    "Body",
    "Clearance",
    "Curve",
    "Direction",
    "Footprint",
    "Gap",
    "Goal",
    "Leg",
    "Limits",
    "Pose",
    "Rule",
    "Rung",
    "Sampling",
    "StartTurn",
    "Vector",
];

/// What users see, in any language, has the names of what it stands for.
const FOR_USERS: &str = "services/clients";

/// The layout of a message on the wire is named for the message.
const ON_THE_WIRE: &str = "schemas/src/wire";

#[test]
fn public_types_have_distinct_names() {
    let mut places: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for code in Code::of_services_and_tools() {
        for module in code.modules.values() {
            let file = module.file.display().to_string();
            for (line, name, is_public) in &module.types {
                if *is_public && !file.starts_with(ON_THE_WIRE) && !file.starts_with(FOR_USERS) {
                    let place = (code.package.clone(), format!("{file}:{line}"));
                    places.entry(name.clone()).or_default().push(place);
                }
            }
        }
    }
    assert!(places.len() > 100, "there are more types than these {}", places.len());
    for name in IN_MESSAGES {
        let mut crates: Vec<_> = places[name].iter().map(|(package, _)| &**package).collect();
        crates.sort_unstable();
        assert_eq!(crates, ["planning", "schemas"], "{name} stands once in each");
        places.remove(name);
    }
    let twice: Vec<_> = places.iter().filter(|(_, places)| places.len() > 1).collect();
    assert!(twice.is_empty(), "types of the same name: {twice:#?}");
}

/// Here private names are distinct as well: the paper's words are few.
#[test]
fn types_of_planning_have_distinct_names() {
    let all = Code::of_services_and_tools();
    let planning = all.iter().find(|code| code.package == "planning").expect("it is ours");
    let mut places: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for module in planning.modules.values() {
        for (line, name, _) in &module.types {
            places.entry(name).or_default().push(format!("{}:{line}", module.file.display()));
        }
    }
    places.retain(|_, places| places.len() > 1);
    assert!(places.is_empty(), "types of the same name: {places:#?}");
}
