//! How corners are passed, and limits on jerk.

use answer::{Caps, reply_to};
use schemas::json::{read_scene, reply_to_json};
use schemas::message::{
    Curve, ExceededLimit, Refusal, Reply, Request, RequestContent, RequestKey, Trajectory,
};

fn reply(text: &str) -> Reply {
    let scene = read_scene(text).unwrap_or_else(|error| panic!("{error:?}"));
    let content = RequestContent::Scene(scene);
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    reply_to(&request, &Caps::default())
}

fn answer(text: &str) -> Result<Trajectory, Refusal> {
    reply(text).answers?.remove(0)
}

/// Section 4.
fn part(more: &str) -> String {
    format!(
        r#"{{"task": "disassemble", "free_space": {{"in_order": true, "channels": [
            {{"min": [4, 1], "max": [7, 6]}}, {{"min": [1, 2], "max": [7, 6]}},
            {{"min": [1, 2], "max": [5, 7]}}]}},
            "body": {{"box": {{"min": [4.5, 1.01], "max": [6.99, 4]}}}},
            "clearance": {{"gap": 0.2}} {more}}}"#
    )
}

fn robot(more: &str) -> String {
    format!(
        r#"{{"task": "drive", "free_space": {{"in_order": true, "channels": [
            {{"min": [0, 0], "max": [10, 3]}}, {{"min": [7, 0], "max": [10, 12]}}]}},
            "body": {{"footprint": {{"width": 1.0, "length": 1.5}}}},
            "start": {{"position": [2, 1.5], "heading": 0}}, "goal": {{"position": [8.5, 9]}},
            "clearance": {{"gap": 0.2}} {more}}}"#
    )
}

#[test]
fn defaults_are_as_if_not_given() {
    let plain = reply_to_json(&reply(&part("")));
    assert_eq!(reply_to_json(&reply(&part(r#", "corners": "sharp""#))), plain);
    let plain = answer(&robot("")).unwrap();
    let arcs = answer(&robot(r#", "corners": "arc""#)).unwrap();
    assert_eq!(Trajectory { exceeds: None, ..arcs }, plain);
    assert_eq!(plain.exceeds, None);
    let never = answer(&robot(r#", "stop_at_joints": false"#)).unwrap();
    assert_eq!(never, plain);
}

#[test]
fn rounded_part_does_not_stop_and_keeps_its_clearance() {
    let sharp = answer(&part("")).unwrap();
    let round = answer(&part(r#", "corners": "arc""#)).unwrap();
    let arcs = round.legs.iter().filter(|leg| matches!(leg.curve, Curve::Arc { .. })).count();
    assert_eq!((arcs, round.legs.len()), (2, 5), "{round:?}");
    assert_eq!(round.clearance.value, sharp.clearance.value);
    assert!(round.length < sharp.length && round.duration < sharp.duration, "{round:?}");
    let speed = |sample: &schemas::message::Sample| sample.velocity[0].hypot(sample.velocity[1]);
    let inside = &round.samples[1..round.samples.len() - 1];
    assert!(inside.iter().all(|sample| speed(sample) > 0.0));
    assert!(round.samples.iter().all(|sample| sample.heading == 0.0 && sample.yaw_rate == 0.0));
    // The acceleration as a vector, by differences.
    for three in round.samples.windows(3) {
        let even = ((three[2].t - three[1].t) - (three[1].t - three[0].t)).abs() < 1e-9;
        if even {
            let dt = three[1].t - three[0].t;
            let second = |axis: usize| {
                (three[2].position[axis] - 2.0 * three[1].position[axis] + three[0].position[axis])
                    / (dt * dt)
            };
            assert!(second(0).hypot(second(1)) <= 0.5 * (1.0 + 1e-3), "{three:?}");
        }
    }
}

#[test]
fn rounded_assembly_is_the_reverse() {
    let out = answer(&part(r#", "corners": "arc""#)).unwrap();
    let text = part(r#", "corners": "arc""#).replace("disassemble", "assemble");
    let back = answer(&text).unwrap();
    assert_eq!((back.length, back.clearance.value), (out.length, out.clearance.value));
    let (first, last) = (&back.samples[0], out.samples.last().unwrap());
    assert_eq!(first.position, last.position);
    assert!((back.duration - out.duration).abs() < 1e-12);
}

#[test]
fn robot_says_which_limit_it_exceeds() {
    let told = answer(&robot(r#", "corners": "arc""#)).unwrap().exceeds.unwrap();
    assert_eq!((told.limit, told.joints), (ExceededLimit::YawAcceleration, 2));
    // v = sqrt(a rho) = sqrt(0.5 x 0.7) m/s on the arc of 0.7 m: a yaw rate of v / rho.
    assert!((told.jump - (0.5 * 0.7_f64).sqrt() / 0.7).abs() < 1e-12, "{told:?}");
    assert!(answer(&robot(r#", "report": "full""#)).unwrap().exceeds.is_some());
}

#[test]
fn robot_that_stops_at_joints_exceeds_nothing() {
    let limits = r#", "limits": {"yaw_acceleration": 0.3}"#;
    let plain = answer(&robot(limits)).unwrap();
    let text = robot(&format!(r#"{limits}, "stop_at_joints": true, "corners": "arc""#));
    let found = answer(&text).unwrap();
    assert_eq!(found.exceeds, None);
    assert_eq!((found.legs == plain.legs, found.length), (true, plain.length));
    assert!(found.duration > plain.duration);
    for pair in found.samples.windows(2) {
        let change = (pair[1].yaw_rate - pair[0].yaw_rate).abs();
        assert!(change <= 0.3 * (pair[1].t - pair[0].t) + 1e-12, "{pair:?}");
    }
}

#[test]
fn jerk_is_a_limit_of_either_task() {
    // The legs from rest to rest: three, each slower than without the limit.
    let plain = answer(&part("")).unwrap();
    let gentle = answer(&part(r#", "limits": {"jerk": 0.5}"#)).unwrap();
    assert_eq!(gentle.legs, plain.legs);
    assert!(gentle.duration > plain.duration);
    let gentle = answer(&robot(r#", "limits": {"jerk": 0.5, "yaw_jerk": 1}"#)).unwrap();
    assert!(gentle.duration > answer(&robot("")).unwrap().duration);
    let refusal = answer(&part(r#", "limits": {"jerk": 0}"#)).unwrap_err();
    assert_eq!(refusal.field.as_deref(), Some("limits.jerk"));
}

#[test]
fn what_does_not_go_together_is_refused() {
    for (text, field) in [
        (part(r#", "limits": {"yaw_jerk": 1}"#), "limits.yaw_jerk"),
        (part(r#", "stop_at_joints": true"#), "stop_at_joints"),
        (robot(r#", "corners": "sharp""#), "corners"),
        (robot(r#", "frames": {"fixed": {"position": [0, 0], "heading": 0}}"#), "frames"),
    ] {
        assert_eq!(answer(&text).unwrap_err().field.as_deref(), Some(field));
    }
}
