//! Planners that are changed in one way: `check` and `diff` say what has moved and how far, as
//! computed here apart from them, and `bless` accepts that and nothing else.

use std::path::Path;

use answer::{Caps, with_rule_altered};
use recording::{Message, Options, Reader, Writer};
use schemas::codec;
use schemas::json as scenes;
use schemas::message::{
    ClearanceWish, Curve, Gap, Reply, Request, RequestContent, RequestKey, Sampling, SceneRequest,
    Trajectory,
};
use serde_json::{Value, json};

use crate::recorded::{Folder, parts};

/// Section 4 at gap 0.2 through channels, corridor A at gap 0.2, and a scene that is refused.
fn requests() -> [Request; 3] {
    let read = |text: &str| scenes::read_scene(text).unwrap_or_else(|bad| panic!("{bad:?}"));
    let assembly = read(include_str!("../../../../recordings/scenes/disassemble-channels.json"));
    let mut drive = read(include_str!("../../../../recordings/scenes/drive-a.json"));
    drive.clearance = ClearanceWish::Gap(Gap::Uniform(0.2));
    let mut refused = assembly.clone();
    refused.limits.speed = Some(-1.0);
    let mut sequence = 0;
    [assembly, drive, refused].map(|mut scene| {
        scene.id = Some(100 + sequence);
        let key = RequestKey { client: 7, sequence };
        sequence += 1;
        Request { key, sent_ns: 1_000, content: RequestContent::Scene(scene) }
    })
}

/// A planner that is changed.
struct Mutation {
    scene: fn(&mut SceneRequest),
    /// The rule of Table 1 that is another one.
    rule: Option<u8>,
}

const NONE: Mutation = Mutation { scene: |_| {}, rule: None };

impl Mutation {
    fn reply_to(&self, request: &Request) -> Reply {
        let mut changed = request.clone();
        let RequestContent::Scene(scene) = &mut changed.content else { unreachable!() };
        if scene.limits.speed != Some(-1.0) {
            (self.scene)(scene);
        }
        let reply_to = || answer::reply_to(&changed, &Caps::default());
        match self.rule {
            Some(number) => with_rule_altered(number, reply_to),
            None => reply_to(),
        }
    }

    fn record(&self, path: &Path, client: u64) {
        let mut writer = Writer::create(path, Options::default()).unwrap();
        for mut request in requests() {
            request.key.client = client;
            writer.write_request(&request, 2_000).unwrap();
            for part in parts(self.reply_to(&request)) {
                writer.write_reply(&part, 3_000).unwrap();
            }
        }
        writer.finish().unwrap();
    }
}

/// The largest distance between the n-th samples, by hand.
fn farthest(before: &Trajectory, now: &Trajectory) -> (f64, usize) {
    let mut farthest = (0.0, 0);
    for index in 0..before.samples.len().min(now.samples.len()) {
        let [one, other] = [before, now].map(|motion| motion.samples[index].position);
        let [x, y, z] = [0, 1, 2].map(|axis| one[axis] - other[axis]);
        let distance = (x * x + y * y + z * z).sqrt();
        if distance > farthest.0 {
            farthest = (distance, index);
        }
    }
    farthest
}

fn motion(mutation: &Mutation, request: usize) -> Trajectory {
    mutation.reply_to(&requests()[request]).answers.unwrap().remove(0).unwrap()
}

/// What is recorded by the changed planner, checked by the real one, compared with a recording of
/// the real one, and accepted. `moved` are the requests whose replies have moved; `tell` holds the
/// told motions of these against the trajectories as recorded and as planned now.
fn check(mutation: &Mutation, moved: &[usize], tell: impl Fn(usize, &Value, [&Trajectory; 2])) {
    let folder = Folder::new();
    NONE.record(&folder.path("real.mcap"), 8);
    mutation.record(&folder.path("a.mcap"), 7);
    let report = |arguments: &[&str]| {
        let (code, out, said) = folder.run(&[arguments, &["--format", "json"]].concat());
        assert_eq!((code, said.as_str()), (4, ""), "{out}");
        serde_json::from_str::<Value>(&out).unwrap()
    };
    let checked = report(&["check", "a.mcap"]);
    let compared = report(&["diff", "a.mcap", "real.mcap"]);
    for answers in [&checked["files"][0]["answers"], &compared["answers"]] {
        let answers = answers.as_array().unwrap();
        let told: Vec<_> =
            answers.iter().map(|answer| answer["request"].as_u64().unwrap()).collect();
        assert_eq!(told, moved.iter().map(|request| *request as u64).collect::<Vec<_>>());
        for (answer, request) in answers.iter().zip(moved) {
            assert_eq!(answer["verdict"], "moved");
            assert_eq!(answer["id"], 100 + *request as u64);
            let [before, now] = [motion(mutation, *request), motion(&NONE, *request)];
            let told = &answer["motion"];
            let (distance, sample) = farthest(&before, &now);
            match distance > 0.0 {
                true => {
                    assert_eq!(told["position"]["sample"], sample);
                    let its = told["position"]["distance"].as_f64().unwrap();
                    assert!((its - distance).abs() <= 1e-15 * distance, "{its} and {distance}");
                }
                false => assert_eq!(told["position"], Value::Null),
            }
            tell(*request, told, [&before, &now]);
        }
    }
    let messages = || -> Vec<_> {
        let reader = Reader::open(folder.path("a.mcap")).unwrap();
        reader.map(|record| record.unwrap().message).collect()
    };
    let is_moved = |key: &RequestKey| moved.contains(&(key.sequence as usize));
    let stays = |messages: &[Message]| -> Vec<Vec<u8>> {
        let of = |message: &Message| match message {
            Message::Request(request) => Some(codec::encode(request)),
            Message::Reply(part) if is_moved(&part.key) => None,
            Message::Reply(part) => Some(codec::encode(part)),
        };
        messages.iter().filter_map(of).collect()
    };
    let before = stays(&messages());
    folder.check(&["bless", "a.mcap", "--uncommitted"], 0, &format!("{} of 3", moved.len()), "");
    folder.check(&["check", "a.mcap"], 0, "3 requests, 3 equal\n", "");
    folder.check(&["diff", "a.mcap", "real.mcap"], 0, "3 equal, 0 different", "");
    assert_eq!(stays(&messages()), before, "nothing else changes");
}

#[track_caller]
fn near(told: &Value, expected: f64) {
    let told = told.as_f64().unwrap();
    assert!((told - expected).abs() <= 1e-9, "{told}, expected {expected}");
}

#[test]
fn nothing_moves_without_a_change() {
    let folder = Folder::new();
    NONE.record(&folder.path("a.mcap"), 7);
    folder.check(&["check", "a.mcap"], 0, "3 requests, 3 equal\n", "");
}

#[test]
fn another_gap_moves_paths() {
    let mutation = Mutation {
        scene: |scene| scene.clearance = ClearanceWish::Gap(Gap::Uniform(0.25)),
        ..NONE
    };
    check(&mutation, &[0, 1], |_, told, [before, now]| {
        // The length of the chain of legs, from their ends alone.
        let length = |motion: &Trajectory| -> f64 {
            let each = motion.legs.iter().map(|leg| match &leg.curve {
                Curve::Line { from, to, .. } => {
                    let ([a, b, c], [x, y, z]) = (from.padded(), to.padded());
                    ((x - a).powi(2) + (y - b).powi(2) + (z - c).powi(2)).sqrt()
                }
                Curve::Arc { radius, sweep, .. } => radius * sweep.abs(),
                Curve::Clothoid { length, .. } => *length,
                Curve::Turn { .. } => 0.0,
            });
            each.sum()
        };
        near(&told["length"]["recorded"], length(before));
        near(&told["length"]["planned"], length(now));
        near(&told["length"]["change"], length(now) - length(before));
    });
}

#[test]
fn another_limit_moves_times_and_no_path() {
    let mutation = Mutation { scene: |scene| scene.limits.speed = Some(0.5), ..NONE };
    check(&mutation, &[0, 1], |request, told, [before, _]| {
        near(&told["length"]["change"], 0.0);
        near(&told["clearance"]["change"], 0.0);
        if request == 0 {
            near(&told["duration"]["recorded"], times(before, 0.5).iter().sum());
            near(&told["duration"]["planned"], times(before, 1.0).iter().sum());
        }
    });
}

/// How long straight legs take, each from rest to rest: up to speed and down again at 0.5 m/s2.
fn times(motion: &Trajectory, speed: f64) -> Vec<f64> {
    let legs = motion.legs.iter().map(|leg| leg.length);
    let each = legs.map(|length| match length * 0.5 >= speed * speed {
        true => length / speed + speed / 0.5,
        false => 2.0 * (length / 0.5).sqrt(),
    });
    each.collect()
}

#[test]
fn another_sampling_moves_samples_only() {
    let mutation =
        Mutation { scene: |scene| scene.sampling = Some(Sampling::Period(0.04)), ..NONE };
    check(&mutation, &[0, 1], |request, told, [before, now]| {
        let counts = [before, now].map(|motion| motion.samples.len());
        assert_eq!(told["samples"], json!(counts));
        if request == 0 {
            // The grid in time, and the ends of legs that are not on it.
            let expected = [0.04, 0.02].map(|period| {
                let mut at = 0.0;
                let ends = times(now, 1.0).into_iter().filter(|time| {
                    at += time;
                    (at / period - (at / period).round()).abs() * period > 1e-6
                });
                let others = ends.count();
                (at / period).floor() as usize + 1 + others
            });
            assert_eq!(counts, expected);
        }
        for name in ["length", "duration", "clearance"] {
            near(&told[name]["change"], 0.0);
        }
    });
}

/// A planner whose rule 3 of Table 1 puts the body to the left of its junction instead of to the right.
///
/// By hand: the body spans x from 4.5 to 6.99, the junction from 1 to 5. At gap 0.2 its right side comes
/// to 4.8 by the rule, which moves it by -2.19, and its left side to 1.2 by the other, which moves it by
/// -3.3. The way-point before (-0.3, 1.19), the height of this one (1.8) and of the end (5.99) stay.
#[test]
fn one_changed_rule_moves_its_legs_only() {
    let ways = [-3.3, -2.19].map(|x| [[0.0, 0.0], [-0.3, 1.19], [x, 1.8], [x, 5.99]]);
    let lengths = ways.map(|way| {
        let length = |ends: &[[f64; 2]]| {
            let [x, z] = [0, 1].map(|axis| ends[1][axis] - ends[0][axis]);
            (x * x + z * z).sqrt()
        };
        way.windows(2).map(length).sum::<f64>()
    });
    let mutation = Mutation { rule: Some(3), ..NONE };
    check(&mutation, &[0], |_, told, motions| {
        for (motion, way) in motions.into_iter().zip(ways) {
            let mut legs = 0;
            for (leg, ends) in motion.legs.iter().zip(way.windows(2)) {
                let Curve::Line { from, to, .. } = &leg.curve else { panic!("{leg:?}") };
                for (point, by_hand) in [from, to].into_iter().zip(ends) {
                    let apart =
                        point.as_slice().iter().zip(by_hand).map(|(one, other)| one - other);
                    assert!(apart.map(f64::abs).sum::<f64>() < 1e-12, "{point:?}, {by_hand:?}");
                }
                legs += 1;
            }
            assert_eq!(legs, 3);
        }
        let [recorded, planned] = lengths;
        near(&told["length"]["recorded"], recorded);
        near(&told["length"]["planned"], planned);
        near(&told["length"]["change"], planned - recorded);
        near(&told["duration"]["recorded"], times(motions[0], 1.0).iter().sum());
        near(&told["duration"]["planned"], times(motions[1], 1.0).iter().sum());
    });
}

/// The same planner without the switch plans by the rules.
#[test]
fn the_switch_is_off_by_itself() {
    let rules =
        |motion: &Trajectory| -> Vec<_> { motion.legs.iter().map(|leg| leg.rule).collect() };
    let altered = motion(&Mutation { rule: Some(3), ..NONE }, 0);
    let by_rules = motion(&NONE, 0);
    assert_eq!(rules(&altered), rules(&by_rules));
    assert_ne!(altered.legs[1], by_rules.legs[1]);
    assert_eq!(altered.legs[0], by_rules.legs[0], "rule 1 stays");
    assert_eq!(motion(&Mutation { rule: Some(4), ..NONE }, 0), by_rules, "no leg is by rule 4");
}
