//! From scenes to trajectories to a recording to its replay.

use integration_tests::{Ended, LONG, OFFICE, TestDomain, root, scene, scene_files};
use recording::Message;
use schemas::json;
use schemas::message::{
    AxisBox, ClearanceWish, Curve, Direction, ErrorCode, Gap, Leg, Refusal, Reply, RequestContent,
    Rung, SceneRequest, Task, Trajectory, Vector,
};

use crate::read::recording;

fn trajectories(reply: Reply) -> Vec<Trajectory> {
    let answers = reply.answers.expect("an answer to each wish");
    answers.into_iter().map(|answer| answer.expect("a trajectory")).collect()
}

/// Equal to the last digits that decimals of the issue can say.
#[track_caller]
fn check_number(what: &str, found: f64, expected: f64) {
    let far = (found - expected).abs();
    assert!(far <= 1e-15 * expected.max(1.0), "{what} is {found:?}, expected {expected:?}");
}

#[test]
fn every_scene_is_planned_recorded_and_replayed() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let recorder = test.recorder("run.mcap", &[]);
    let files = scene_files();
    let files: Vec<_> = files.iter().map(|path| path.to_str().unwrap()).collect();

    let begin = bus::now_ns();
    let planned = test.plan(&[&["--format", "json"], files.as_slice()].concat());
    let end = bus::now_ns();
    assert_eq!((planned.code, planned.stderr.as_str()), (Some(0), ""));
    assert_eq!(
        planned,
        test.run("plan", &[&["--local", "--format", "json"], files.as_slice()].concat())
    );

    let recorded = recorder.stop();
    assert_eq!(recorded.code, Some(0));
    assert_eq!(planner.stop().code, Some(0));
    let replayed = test.run("replay", &["check", "run.mcap"]);
    let count = files.len();
    let summary = format!("run.mcap: {count} requests, {count} equal\n");
    assert_eq!(replayed, Ended { code: Some(0), stdout: summary, stderr: String::new() });

    let recording = recording(&test.path("run.mcap"));
    let messages = recording.records.len();
    assert!(recording.error.is_none());
    assert_eq!(recorded.stdout, format!("run.mcap: {messages} messages recorded, 0 lost\n"));

    // In bus order, each request before its reply, under the same key.
    let mut asked = Vec::new();
    let (mut published, mut logged) = (begin, begin);
    for (sequence, record) in recording.records.iter().enumerate() {
        assert_eq!(record.sequence as usize, sequence, "no message is missing");
        assert!((published..=end).contains(&record.publish_ns), "sent in order, meanwhile");
        assert!(record.log_ns >= logged.max(record.publish_ns), "taken in order, once sent");
        (published, logged) = (record.publish_ns, record.log_ns);
        match &record.message {
            Message::Request(request) => asked.push(request.key),
            Message::Reply(part) => assert_eq!(asked.last(), Some(&part.key)),
        }
    }
    assert_eq!(asked.len(), count);
    for (sequence, key) in asked.iter().enumerate() {
        assert_eq!((key.client, key.sequence), (asked[0].client, sequence as u64));
    }

    // Requests as they were written, replies as they were printed.
    let asked: Vec<_> = recording.requests().iter().map(|asked| asked.content.clone()).collect();
    let written = files.iter().map(|path| {
        let text = std::fs::read_to_string(path).unwrap();
        RequestContent::Scene(json::read_scene(&text).unwrap())
    });
    assert_eq!(asked, written.collect::<Vec<_>>());
    let replies = recording.replies();
    let printed: String = replies.iter().map(|reply| json::reply_to_json(reply) + "\n").collect();
    assert!(printed == planned.stdout, "the recorded replies are those printed");
}

#[test]
fn a_recording_made_with_other_caps_replays_with_them() {
    let test = TestDomain::new();
    test.write("planner.toml", "cache = 0\n[caps]\nsamples = 100\ncells = 40");
    let planner = test.planner(&["--config", "planner.toml"]);
    let recorder = test.recorder("run.mcap", &[]);
    let files = scene_files();
    let files: Vec<_> = files.iter().map(|path| path.to_str().unwrap()).collect();
    let planned = test.plan(&[&["--format", "json"], files.as_slice()].concat());
    let local = ["--local", "--config", "planner.toml", "--format", "json"];
    assert_eq!(planned, test.run("plan", &[&local, files.as_slice()].concat()));
    for said in ["the limit is 100 (`caps.samples`)", "at most 40 are read (`caps.cells`)"] {
        assert!(planned.stdout.contains(said), "nothing is refused with {said:?}");
    }
    recorder.stop();
    planner.stop();
    let check = |arguments: &[&str]| test.run("replay", &[&["check"], arguments].concat()).code;
    assert_eq!(check(&["run.mcap", "--config", "planner.toml"]), Some(0));
    assert_eq!(check(&["run.mcap"]), Some(0), "the recording says what its caps were");
    test.write("default.toml", "");
    assert_eq!(check(&["run.mcap", "--config", "default.toml"]), Some(4), "other caps");
    test.write("wrong.toml", "[caps]\nsamples = 0");
    assert_eq!(check(&["run.mcap", "--config", "wrong.toml"]), Some(1));
}

#[test]
fn solids_have_the_papers_channels_and_paths() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = test.connect();
    let given = trajectories(client.call(&scene("disassemble.json"), LONG).unwrap());
    let made = trajectories(client.call(&scene("disassemble-solids.json"), LONG).unwrap());
    // C1, C2 and C3 of section 4, travelled from the last to the first.
    let boxes = [([1.0, 2.0], [5.0, 7.0]), ([1.0, 2.0], [7.0, 6.0]), ([4.0, 1.0], [7.0, 6.0])];
    let channels = boxes.map(|(min, max)| AxisBox { min: min.into(), max: max.into() });
    for (made, given) in made.into_iter().zip(given) {
        assert_eq!(made.channels, channels);
        assert_eq!(made.route, [2, 1, 0]);
        assert_eq!(made.exit, Some(Direction::PlusZ), "there is no mouth on the sides");
        assert_eq!((made.legs, made.samples), (given.legs, given.samples));
        assert_eq!(made.clearance, given.clearance);
    }
}

#[test]
fn channels_in_any_order_are_travelled_as_in_order() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = test.connect();
    for name in ["disassemble-channels.json", "drive-a.json"] {
        let mut scene = scene(name);
        let in_order = trajectories(client.call(&scene, LONG).unwrap());
        scene.free_space.in_order = false;
        let channels = scene.free_space.channels.as_mut().unwrap();
        let count = channels.len() as u64;
        channels.reverse();
        let routed = trajectories(client.call(&scene, LONG).unwrap());
        assert_eq!(routed.len(), in_order.len());
        for (routed, in_order) in routed.into_iter().zip(in_order) {
            let reversed: Vec<_> = (0..count).rev().collect();
            assert_eq!(routed.route, reversed);
            if scene.task == Task::Disassemble {
                assert_eq!(routed, Trajectory { route: reversed, ..in_order });
                continue;
            }
            // Where the taut way is asked for, a robot takes the same one, computed in another
            // manner; its safest has no less clearance.
            let rules = |legs: &[Leg]| legs.iter().map(|leg| leg.rule).collect::<Vec<_>>();
            assert_eq!(rules(&routed.legs), rules(&in_order.legs));
            let [found, expected] = [&routed, &in_order].map(|answer| answer.clearance.value);
            assert!(found >= expected - 1e-9, "{found} {expected}");
            if routed.legs.iter().all(|leg| leg.rung == Some(Rung::Taut)) {
                let by = (routed.length - in_order.length).abs();
                assert!(by < 1e-12, "{} {}", routed.length, in_order.length);
            }
        }
    }
}

#[test]
fn a_floor_plan_is_planned_through() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let scenes = root().join("recordings/scenes");
    let (map, office) = (scenes.join("office.yaml"), scenes.join(OFFICE));
    let arguments = ["--format", "json", "--map", map.to_str().unwrap(), office.to_str().unwrap()];
    let planned = test.plan(&arguments);
    assert_eq!((planned.code, planned.stderr.as_str()), (Some(0), ""));
    assert_eq!(planned, test.run("plan", &[&["--local"], &arguments[..]].concat()));
    let reply: serde_json::Value = serde_json::from_str(&planned.stdout).unwrap();
    let answers = reply["trajectories"].as_array().unwrap();
    assert_eq!(answers.len(), 3);
    for answer in answers {
        assert!(answer["bound"].as_f64().unwrap() <= answer["length"].as_f64().unwrap());
        assert!(answer["clearance"]["value"].as_f64().unwrap() > 0.19);
    }
}

#[test]
fn what_would_open_a_way_is_said() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = test.connect();
    let mut scene = scene("disassemble-channels.json");
    scene.free_space.in_order = false;
    // The middle channel ends 2.4 m above the others' floor: less than the part is high.
    scene.free_space.channels.as_mut().unwrap()[1].max = [7.0, 4.4].into();
    let refusal = client.call(&scene, LONG).unwrap().answers.unwrap_err();
    assert_eq!(refusal.code, ErrorCode::NoRoute);
    assert_eq!(
        (refusal.junction, refusal.axis, refusal.needs),
        (Some(0), Some(2), Some(2.99)),
        "{refusal:?}"
    );
    check_number("the junction's height", refusal.has.unwrap(), 2.4);
}

#[test]
fn what_would_open_a_way_is_said_of_each_kind() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = test.connect();
    let lines = std::fs::read_to_string(root().join("recordings/scenes/no-route.jsonl")).unwrap();
    let scenes = lines.lines().map(|line| json::read_scene(line).unwrap());
    let refusals: Vec<_> =
        scenes.map(|scene| client.call(&scene, LONG).unwrap().answers.unwrap_err()).collect();

    let (route, gap) = (ErrorCode::NoRoute, ErrorCode::GapOutOfRange);
    let (body, goal) = (ErrorCode::BodyOutsideFreeSpace, ErrorCode::GoalOutsideFreeSpace);
    let (x, y, z) = (Some(0), Some(1), Some(2));
    // What each refusal names: axis, what is needed and what there is, and in words.
    let expected = [
        (route, z, Some(1.0), Some(-0.25), "channels 0 and 1 are 0.25 m apart along z"),
        (route, x, Some(1.0), Some(0.75), "the junction of channels 0 and 2"),
        (gap, x, None, Some(0.2), "less than 0.125 m along x"),
        (route, None, Some(0.75), Some(0.5), "which are 0.5 m apart"),
        (gap, None, None, Some(0.5), "the gap must be less than 0.375 m, not 0.5 m"),
        (route, None, Some(0.0), Some(-0.25), "they are thinnest from (4, 6) to (4.25, 6), 0.25 m"),
        (body, None, None, None, "start: the robot touches the wall"),
        (goal, None, None, Some(0.125), "goal.position is inside solid 1, 0.125 m"),
        (route, x, Some(2.5), Some(2.0), "from (x 1, z 6) to (x 3, z 7) is 2 m wide along x"),
        (route, z, Some(4.25), Some(4.0), "from (x 1, z 2) to (x 7, z 6) is 4 m wide along z"),
        (route, z, Some(0.0), Some(-0.5), "a wall of solid 1, 0.5 m thick along z, separates"),
        (body, x, None, Some(0.25), "the body's bounding box reaches 0.25 m into solid 0"),
        (route, y, Some(0.875), Some(0.75), "to (x 2.5, y 1.75, z 2.5) is 0.75 m wide along y"),
    ];
    assert_eq!(refusals.len(), expected.len());
    for (refusal, (code, axis, needs, has, says)) in refusals.iter().zip(expected) {
        let found = (refusal.code, refusal.axis, refusal.needs, refusal.has);
        assert_eq!(found, (code, axis, needs, has), "{refusal:?}");
        assert!(refusal.message.contains(says), "{says}: {refusal:?}");
        // Among walls at any angle two wall points are named instead.
        let at_junction = (code == route || code == gap) && axis.is_some();
        assert_eq!(refusal.junction.is_some(), at_junction, "{refusal:?}");
    }
}

#[test]
fn section_4_has_the_papers_numbers() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = test.connect();
    let [tight, wide, safest] =
        trajectories(client.call(&scene("disassemble.json"), LONG).unwrap()).try_into().unwrap();
    check_number("the length at gap 0.01", tight.length, 6.919200165541185);
    check_number("the length at gap 0.2", wide.length, 7.40323366632768);
    check_number("the length at the safest gap", safest.length, 8.50994224312348);

    for (leg, clearance) in wide.legs.iter().zip([0.01, 0.2517622086923952, 0.2]) {
        check_number("the clearance of a leg", leg.clearance, clearance);
    }
    check_number("the clearance", wide.clearance.value, 0.01);
    for (gap, limit) in safest.gaps.iter().zip([0.255, 0.505, 0.755, 0.505]) {
        check_number("a safest gap", *gap, limit);
    }
    for trajectory in [&tight, &wide, &safest] {
        let rules: Vec<_> = trajectory.legs.iter().map(|leg| leg.rule).collect();
        let rules: Vec<_> =
            rules.into_iter().map(|rule| rule.map(|rule| (rule.table, rule.number))).collect();
        assert_eq!(rules, [Some((1, 1)), Some((1, 3)), None]);
        assert_eq!(trajectory.route, [0, 1, 2]);
    }
    // Without solids the channels' complement is the wall, and as far away on these paths.
    let [channels] = trajectories(client.call(&scene("disassemble-channels.json"), LONG).unwrap())
        .try_into()
        .unwrap();
    assert_eq!(channels.length, wide.length);
    check_number("the clearance from the channels", channels.clearance.value, 0.01);
}

#[test]
fn gaps_beyond_their_limits_are_refused_with_the_limits() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = test.connect();
    let per_axis = |x: f64, z: f64| Gap::PerAxis([x, z].into());
    let check = |gaps: [Gap; 2], junction: u64, axis: u32, most: f64| {
        let clearance = ClearanceWish::Gaps(gaps.to_vec());
        let scene = SceneRequest { clearance, ..scene("disassemble-channels.json") };
        let refusal: Refusal = client.call(&scene, LONG).unwrap().answers.unwrap_err();
        assert_eq!(refusal.code, ErrorCode::GapOutOfRange);
        assert_eq!((refusal.junction, refusal.axis), (Some(junction), Some(axis)));
        assert_eq!(refusal.least, Some(0.0));
        check_number("the limit of a gap", refusal.most.unwrap(), most);
        assert!(refusal.message.contains(&most.to_string()), "{refusal:?}");
        assert!(refusal.message.contains(&refusal.has.unwrap().to_string()), "{refusal:?}");
    };
    check([per_axis(0.256, 0.1), per_axis(0.1, 0.1)], 0, 0, 0.255);
    check([per_axis(0.1, 0.506), per_axis(0.1, 0.1)], 0, 2, 0.505);
    check([per_axis(0.1, 0.1), per_axis(0.756, 0.1)], 1, 0, 0.755);
    check([per_axis(0.1, 0.1), per_axis(0.1, 0.506)], 1, 2, 0.505);
}

fn way_points(trajectory: &Trajectory) -> Vec<(Vector, Vector)> {
    let ends = |leg: &Leg| match leg.curve {
        Curve::Line { from, to, .. } => (from, to),
        Curve::Arc { .. } | Curve::Clothoid { .. } | Curve::Turn { .. } => {
            panic!("a body of an assembly task translates")
        }
    };
    trajectory.legs.iter().map(ends).collect()
}

#[test]
fn assembling_is_disassembling_in_reverse() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = test.connect();
    let out = trajectories(client.call(&scene("disassemble.json"), LONG).unwrap());
    let back = trajectories(client.call(&scene("assemble.json"), LONG).unwrap());
    assert_eq!(out.len(), back.len());
    for (out, back) in out.iter().zip(&back) {
        let reversed: Vec<_> =
            way_points(back).into_iter().rev().map(|(from, to)| (to, from)).collect();
        assert_eq!(way_points(out), reversed);
        let told = |leg: &Leg| (leg.length, leg.rule, leg.junction);
        assert!(out.legs.iter().map(told).eq(back.legs.iter().rev().map(told)));
        assert_eq!((&out.gaps, &out.route), (&back.gaps, &back.route));
        check_number("the length", back.length, out.length);
        check_number("the duration", back.duration, out.duration);
        check_number("the clearance", back.clearance.value, out.clearance.value);
        let [first, last] = [back.samples.first(), back.samples.last()].map(Option::unwrap);
        assert_eq!(first.position, out.samples.last().unwrap().position);
        assert_eq!(last.position, [0.0; 3], "assembled");
    }
}
