//! `replay export`: independent readers see what was planned.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;

use comparison::exchanges::{self, Asked};
use integration_tests::{TestDomain, root};
use schemas::message::{AxisBox, RequestContent, SceneRequest, Trajectory};
use serde_json::{Value, json};

use crate::independent::{node, python};

fn golden(name: &str) -> PathBuf {
    root().join("recordings").join(name)
}

/// The recording as viewers get it, its motions one after the other.
fn exported(test: &TestDomain, name: &str) -> PathBuf {
    let file = golden(name).display().to_string();
    let arguments = ["export", &file, "-o", "view.mcap", "--apart", "--grid", "10cm"];
    let exported = test.run("replay", &arguments);
    assert_eq!((exported.code, exported.stderr.as_str()), (Some(0), ""), "{exported:?}");
    test.path("view.mcap")
}

/// Each scene with its motions and the time of the reply.
fn recorded(name: &str) -> Vec<(SceneRequest, u64, Vec<Trajectory>)> {
    let mut all = Vec::new();
    let contents = exchanges::read_asked(
        &[golden(name)],
        |_| {},
        |asked| {
            let Asked { request, reply, replied_ns, .. } = asked;
            let RequestContent::Scene(scene) = request.content else { panic!("they are scenes") };
            let motions = reply.unwrap().answers.into_iter().flatten().flatten();
            all.push((scene, replied_ns.unwrap(), motions.collect()));
            std::ops::ControlFlow::Continue(())
        },
    );
    assert!(contents.error.is_none());
    all
}

fn output(command: &mut Command) -> Value {
    let done = command.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    serde_json::from_slice(&done.stdout).unwrap()
}

#[test]
fn viewers_see_the_motions_that_were_planned() {
    let Some(python) = python() else {
        println!("SKIPPED: no Python with the packages for MCAP can be had here");
        return;
    };
    let test = TestDomain::new();
    let view = exported(&test, "driving.mcap");
    let script = root().join("tests/system/view_mcap.py");
    let seen = output(Command::new(&python).arg(script).arg(&view));
    let messages = |topic: &str| seen[topic]["messages"].as_array().unwrap().clone();
    // What is expected, from the recording alone.
    let (mut paths, mut transforms, mut numbers) = (BTreeMap::new(), Vec::new(), BTreeMap::new());
    let (mut scenes, mut end) = (Vec::new(), 0);
    for (request, (scene, replied, motions)) in recorded("driving.mcap").into_iter().enumerate() {
        scenes.push(scene);
        let begin = replied.max(end);
        for (answer, motion) in motions.iter().enumerate() {
            let positions: Vec<_> = motion.samples.iter().map(|sample| sample.position).collect();
            let path = json!([begin, ["map", positions]]);
            let is_sampled = !motion.samples.is_empty();
            paths.entry(answer).or_insert_with(Vec::new).push(is_sampled.then_some(path));
            for sample in &motion.samples {
                let at = begin + (sample.t * 1e9).round() as u64;
                let ([x, y, z], half) = (sample.position, sample.heading / 2.0);
                transforms.push((
                    at,
                    format!("body/{answer}"),
                    [x, y, z],
                    [half.sin(), half.cos()],
                ));
                let speed = sample.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
                let its = numbers.entry(answer).or_insert_with(Vec::new);
                its.push((request, sample.t, speed, sample.heading, sample.yaw_rate));
            }
            end = end.max(begin + (motion.duration * 1e9).round() as u64);
        }
    }
    for (answer, paths) in paths {
        let seen = messages(&format!("/viewing/{answer}/path"));
        assert_eq!(seen.len(), paths.len());
        for (seen, expected) in seen.iter().zip(paths) {
            // Without samples there are places along the legs.
            assert!(expected.is_none_or(|expected| *seen == expected));
            assert!(seen[1][1].as_array().unwrap().len() > 1);
        }
    }
    let mut seen_transforms: Vec<_> = messages("/viewing/transforms")
        .into_iter()
        .map(|message| {
            let (at, [frame, stamp, place]) = (&message[0], [0, 1, 2].map(|i| &message[1][i]));
            assert_eq!(at, stamp);
            let number = |i: usize| place[i].as_f64().unwrap();
            let frame = frame.as_str().unwrap().to_owned();
            (at.as_u64().unwrap(), frame, [0, 1, 2].map(number), [3, 4].map(number))
        })
        .collect();
    let order = |(at, frame, ..): &(u64, String, [f64; 3], [f64; 2])| (*at, frame.clone());
    seen_transforms.sort_by_key(order);
    transforms.sort_by_key(order);
    assert_eq!(seen_transforms.len(), transforms.len());
    for (seen, expected) in seen_transforms.iter().zip(&transforms) {
        assert_eq!((seen.0, &seen.1, seen.2), (expected.0, &expected.1, expected.2));
        let off = seen.3.iter().zip(expected.3).map(|(one, other)| (one - other).abs());
        assert!(off.fold(0.0, f64::max) <= 1e-15, "{seen:?} and {expected:?}");
    }
    for (answer, expected) in numbers {
        let seen = messages(&format!("/viewing/{answer}/motion"));
        assert_eq!(seen.len(), expected.len());
        for (seen, (request, t, speed, heading, yaw_rate)) in seen.iter().zip(expected) {
            let seen = &seen[1];
            let fields = ["request", "t", "heading", "yaw_rate"].map(|name| &seen[name]);
            assert_eq!(fields, [&json!(request), &json!(t), &json!(heading), &json!(yaw_rate)]);
            let its = seen["speed"].as_f64().unwrap();
            assert!((its - speed).abs() <= 1e-15, "{its} and {speed}");
            assert!(seen["clearance"].as_f64().unwrap() > 0.0, "every sample has its leg");
        }
    }
    let requests = messages("/viewing/request");
    assert_eq!(requests.len(), 6);
    assert!(requests.iter().all(|request| request[1]["planning_time"].as_f64().unwrap() > 0.0));
    for scene in messages("/viewing/scene") {
        let entities = scene[1].as_object().unwrap();
        for name in ["channels", "body/0", "path/0", "clearance/0"] {
            assert!(entities.contains_key(name), "{name} is not in {entities:?}");
        }
    }
    // Cells of 0.1 m whose middle is in no corridor, counted one by one.
    let grids = messages("/viewing/grid");
    assert_eq!(grids.len(), scenes.len());
    for (grid, scene) in grids.iter().zip(scenes) {
        let channels: Vec<_> = scene.free_space.channels.iter().flatten().collect();
        let most = |axis: usize, of: fn(f64, f64) -> f64, ends: &dyn Fn(&AxisBox) -> [f64; 3]| {
            channels.iter().map(|sides| ends(sides)[axis]).reduce(of).unwrap()
        };
        let low = [0, 1].map(|axis| most(axis, f64::min, &|sides| sides.min.padded()));
        let high = [0, 1].map(|axis| most(axis, f64::max, &|sides| sides.max.padded()));
        let [columns, rows] = [0, 1].map(|axis| ((high[axis] - low[axis]) / 0.1).ceil() as u64);
        let is_taken = |cell: u64| {
            let middle = [(0, cell % columns), (1, cell / columns)]
                .map(|(axis, at): (usize, u64)| low[axis] + (at as f64 + 0.5) * 0.1);
            let within = |sides: &&AxisBox| {
                let (min, max) = (sides.min.padded(), sides.max.padded());
                [0, 1].iter().all(|i| (min[*i]..max[*i]).contains(&middle[*i]))
            };
            !channels.iter().any(within)
        };
        let taken = (0..columns * rows).filter(|cell| is_taken(*cell)).count();
        assert_eq!(grid[1], json!([columns, 0.1, taken, columns * rows]));
    }
    if let Some(folder) = node() {
        let script = folder.join("view_mcap.mjs");
        std::fs::copy(root().join("tests/system/view_mcap.mjs"), &script).unwrap();
        let counts = output(Command::new("node").arg(script).arg(&view));
        let expected = seen.as_object().unwrap().iter();
        let expected = expected.map(|(topic, seen)| {
            (topic.clone(), json!(seen["messages"].as_array().unwrap().len()))
        });
        assert_eq!(counts, Value::Object(expected.collect()));
    } else {
        println!("SKIPPED: no Node with the packages for MCAP can be had here");
    }
    let checked = test.run("replay", &["check", "view.mcap"]);
    assert_eq!(
        (checked.code, checked.stdout.as_str()),
        (Some(0), "view.mcap: 6 requests, 6 equal\n")
    );
}
