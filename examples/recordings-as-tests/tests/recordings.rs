//! A test for each recording, by its name.

use answer::Answerer;
use comparison::check::find;
use comparison::tolerance::{Quantity, Tolerance};
use recordings_as_tests::{assert_unchanged, caps, checked, folder, planned_again};
use schemas::message::{Request, RequestContent};

macro_rules! recordings {
    ($($name:ident: $file:literal,)+) => {
        const FILES: &[&str] = &[$($file,)+];

        $(
            #[test]
            fn $name() {
                assert_unchanged(&planned_again($file, &Tolerance::EXACT));
            }
        )+
    };
}

recordings! {
    corners_are_planned_as_recorded: "corners.mcap",
    disassembly_is_planned_as_recorded: "disassembly.mcap",
    driving_is_planned_as_recorded: "driving.mcap",
    free_space_is_planned_as_recorded: "free-space.mcap",
    no_route_is_planned_as_recorded: "no-route.mcap",
    refusals_are_planned_as_recorded: "refusals.mcap",
    routes_are_planned_as_recorded: "routes.mcap",
    shortest_ways_are_planned_as_recorded: "shortest.mcap",
    unions_are_planned_as_recorded: "unions.mcap",
}

#[test]
fn every_recording_has_a_test() {
    let mut found = find(&[folder()]).unwrap();
    found.retain(|path| path.parent() == Some(&folder()));
    let name = |path: &std::path::PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
    assert_eq!(found.iter().map(name).collect::<Vec<_>>(), FILES);
}

/// Those of one scene each.
#[test]
fn each_scene_is_planned_as_recorded() {
    for path in find(&[folder().join("each")]).unwrap() {
        let file = path.file_name().unwrap().to_str().unwrap();
        assert_unchanged(&planned_again(&format!("each/{file}"), &Tolerance::EXACT));
    }
}

/// A planner that drives at another speed.
fn slower(request: &Request) -> Request {
    let mut slower = request.clone();
    if let RequestContent::Scene(scene) = &mut slower.content {
        scene.limits.speed = Some(0.5);
    }
    slower
}

#[test]
#[should_panic(expected = "request 0 (")]
fn a_planner_that_drives_slower_is_noticed() {
    let mut answerer = Answerer::new(&caps("driving.mcap"));
    let plan = |request: &Request| answerer.reply_to(&slower(request));
    assert_unchanged(&checked("driving.mcap", &Tolerance::EXACT, plan));
}

#[test]
fn tolerances_are_by_quantity() {
    let mut answerer = Answerer::new(&caps("disassembly.mcap"));
    let plan = |request: &Request| answerer.reply_to(&slower(request));
    // Samples are taken in time: of the motions that are slower they lie elsewhere.
    let tolerance = Tolerance::EXACT
        .with(Quantity::Position, 10.0)
        .with(Quantity::Time, 60.0)
        .with(Quantity::Speed, 1.0);
    let checked = checked("disassembly.mcap", &tolerance, plan);
    let answers = checked.cases.iter().flat_map(|case| &case.comparison.answers);
    let motions: Vec<_> = answers.filter_map(|answer| answer.motion.as_deref()).collect();
    assert_eq!(motions.len(), 7);
    for motion in motions {
        assert!(motion.duration.by() > 0.0 && motion.samples[1] > motion.samples[0]);
        assert_eq!((motion.length.by(), motion.clearance.by()), (0.0, 0.0), "the same path");
    }
}
