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

/// By differences of samples; the arc would exceed the limit on yaw acceleration.
#[test]
fn robot_with_smooth_corners_does_not_stop_and_obeys_its_limits() {
    let limits = r#", "limits": {"yaw_acceleration": 0.9}, "report": "full""#;
    let arcs = answer(&robot(limits)).unwrap();
    let stopping = answer(&robot(&format!(r#"{limits}, "stop_at_joints": true"#))).unwrap();
    let smooth = answer(&robot(&format!(r#"{limits}, "corners": "smooth""#))).unwrap();
    assert_eq!((smooth.exceeds, smooth.stops, arcs.stops), (None, Some(0), None));
    assert!(smooth.duration < stopping.duration, "{} {}", smooth.duration, stopping.duration);
    let is_clothoid = |leg: &&schemas::message::Leg| matches!(leg.curve, Curve::Clothoid { .. });
    assert_eq!(smooth.legs.iter().filter(is_clothoid).count(), 2, "{:?}", smooth.legs);
    for pair in smooth.samples.windows(2) {
        let change = (pair[1].yaw_rate - pair[0].yaw_rate).abs();
        assert!(change <= 0.9 * (pair[1].t - pair[0].t) + 1e-9, "{pair:?}");
    }
    // No closer to walls, and where it went before.
    assert!(smooth.clearance.value >= arcs.clearance.value - 1e-8);
    assert!(smooth.free_clearance.unwrap() >= arcs.free_clearance.unwrap() - 1e-8);
    assert!(smooth.bound.unwrap() <= smooth.length);
    let [end, expected] = [&smooth, &arcs].map(|answer| *answer.samples.last().unwrap());
    assert_eq!(end.position, expected.position);
    assert!((end.heading - expected.heading).abs() < 1e-12);
}

/// Among solids, in any order, the same motion is smooth as well.
#[test]
fn robot_among_solids_has_smooth_corners() {
    let text = r#"{"task": "drive", "free_space": {"solids": [
            {"box": {"min": [0, 3], "max": [7, 12]}}], "bounds": {"min": [0, 0], "max": [10, 12]}},
        "body": {"footprint": {"width": 1.0, "length": 1.5}},
        "start": {"position": [2, 1.5], "heading": 0}, "goal": {"position": [8.5, 9]},
        "clearance": {"at_least": 0.2}, "corners": "smooth"}"#;
    let smooth = answer(text).unwrap();
    assert_eq!((smooth.stops, smooth.exceeds), (Some(0), None));
    assert!(smooth.free_clearance.unwrap() >= 0.2 - 1e-8);
    assert!(smooth.legs.iter().any(|leg| matches!(leg.curve, Curve::Clothoid { .. })));
}

/// The arc's room is all that there is: a turn that begins outside of it, and is as sharp at most, does
/// not fit.
#[test]
fn robot_without_room_for_smooth_corners_says_where_it_stops() {
    let text = r#"{"task": "drive", "free_space": {"solids": [
            {"box": {"min": [0, 3], "max": [7, 12]}}], "bounds": {"min": [0, 0], "max": [10, 12]}},
        "body": {"footprint": {"width": 1.0, "length": 1.5}}, "min_turn_radius": 1.0,
        "start": {"position": [6.0, 2.0], "heading": 0}, "goal": {"position": [8.0, 4.0]},
        "clearance": {"gap": 0.5}, "corners": "smooth"}"#;
    let found = answer(text).unwrap();
    assert!(found.stops.unwrap() > 0, "{found:?}");
    assert!(found.legs.iter().any(|leg| matches!(leg.curve, Curve::Arc { .. })));
    // Through the first joint at rest: the yaw rate does not step.
    for pair in found.samples.windows(2) {
        let change = (pair[1].yaw_rate - pair[0].yaw_rate).abs();
        assert!(change <= pair[1].t - pair[0].t + 1e-9, "{pair:?}");
    }
}

#[test]
fn part_with_smooth_corners_does_not_stop_and_keeps_its_clearance() {
    let sharp = answer(&part("")).unwrap();
    for limits in ["", r#", "limits": {"jerk": 1.5}"#] {
        let smooth = answer(&part(&format!(r#"{limits}, "corners": "smooth""#))).unwrap();
        assert_eq!((smooth.stops, smooth.legs.len()), (Some(0), 7), "{smooth:?}");
        assert!(smooth.clearance.value >= sharp.clearance.value - 1e-8);
        assert!(smooth.length < sharp.length);
        let states = &smooth.samples;
        assert!(states.iter().all(|sample| sample.heading == 0.0 && sample.yaw_rate == 0.0));
        for pair in states.windows(2) {
            let change = [0, 1].map(|axis: usize| pair[1].velocity[axis] - pair[0].velocity[axis]);
            let most = 0.5 * (pair[1].t - pair[0].t);
            assert!(change[0].hypot(change[1]) <= most * (1.0 + 1e-9) + 1e-12, "{pair:?}");
        }
    }
}

/// Told as travelled, in either direction.
#[test]
fn smooth_assembly_is_the_reverse() {
    let out = answer(&part(r#", "corners": "smooth""#)).unwrap();
    let text = part(r#", "corners": "smooth""#).replace("disassemble", "assemble");
    let back = answer(&text).unwrap();
    assert_eq!(back.legs.len(), out.legs.len());
    for (leg, other) in back.legs.iter().zip(out.legs.iter().rev()) {
        let (
            Curve::Clothoid { from, to, from_heading, curvatures, .. },
            Curve::Clothoid { from: f, to: t, to_heading: h, curvatures: c, .. },
        ) = (leg.curve, other.curve)
        else {
            continue;
        };
        assert_eq!((from, to, curvatures), (t, f, [-c[1], -c[0]]));
        let apart = (from_heading - h).abs();
        assert!((apart - std::f64::consts::PI).abs() < 1e-12, "{from_heading} {h}");
    }
}

#[test]
fn smooth_corners_are_told_in_the_base_frame() {
    let frames = r#", "corners": "smooth", "frames": {
        "fixed": {"position": [0, 0], "heading": 0},
        "fixed_at_end": {"position": [4, 0], "heading": 0}, "samples": "base"}"#;
    let told = answer(&part(frames)).unwrap();
    let still = answer(&part(r#", "corners": "smooth""#)).unwrap();
    // The fixed part goes 4 m evenly with the length of the path.
    let mut travelled = 0.0;
    for (index, (one, other)) in told.samples.iter().zip(&still.samples).enumerate() {
        if let Some(before) = index.checked_sub(1).map(|before| still.samples[before]) {
            let mean = 0.5
                * (before.velocity[0].hypot(before.velocity[1])
                    + other.velocity[0].hypot(other.velocity[1]));
            travelled += mean * (other.t - before.t);
        }
        let moved = 4.0 * travelled / still.length;
        assert!((one.position[0] - other.position[0] - moved).abs() < 1e-3, "{index}");
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

/// A box in three dimensions.
const SPACE: &str = r#"{"task": "disassemble", "corners": "smooth",
    "free_space": {"channels": [{"min": [0, 0, 0], "max": [2, 2, 4]}], "in_order": true},
    "body": {"box": {"min": [0.5, 0.5, 0.5], "max": [1, 1, 1]}}, "clearance": "safest"}"#;

#[test]
fn what_does_not_go_together_is_refused() {
    for (text, field) in [
        (part(r#", "limits": {"yaw_jerk": 1}"#), "limits.yaw_jerk"),
        (part(r#", "stop_at_joints": true"#), "stop_at_joints"),
        (robot(r#", "corners": "sharp""#), "corners"),
        (SPACE.to_owned(), "corners"),
        (robot(r#", "frames": {"fixed": {"position": [0, 0], "heading": 0}}"#), "frames"),
    ] {
        assert_eq!(answer(&text).unwrap_err().field.as_deref(), Some(field));
    }
}
