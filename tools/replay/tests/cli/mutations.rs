//! Planners that are changed in one way: `check` and `diff` say what has moved and how far, as
//! computed here apart from them, and `bless` accepts that and nothing else.

use std::path::Path;

use answer::Caps;
use recording::{Message, Options, Reader, Writer};
use schemas::codec;
use schemas::json as scenes;
use schemas::message::{
    ClearanceWish, Curve, Gap, Leg, Reply, Request, RequestContent, RequestKey, Sampling,
    SceneRequest, Trajectory, Vector,
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
    motion: fn(&mut Trajectory),
}

const NONE: Mutation = Mutation { scene: |_| {}, motion: |_| {} };

impl Mutation {
    fn reply_to(&self, request: &Request) -> Reply {
        let mut changed = request.clone();
        let RequestContent::Scene(scene) = &mut changed.content else { unreachable!() };
        if scene.limits.speed != Some(-1.0) {
            (self.scene)(scene);
        }
        let mut reply = answer::reply_to(&changed, &Caps::default());
        reply.answers.iter_mut().flatten().flatten().for_each(self.motion);
        reply
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

/// A planner whose first rule of table 1 leads 3 mm farther along x.
#[test]
fn one_changed_rule_moves_its_legs_only() {
    const BY: f64 = 0.003;
    let mutation = Mutation {
        motion: |motion| {
            let is_by_rule = |leg: &Leg| leg.rule.is_some_and(|rule| rule.table == 1);
            let Some(leg) = motion.legs.iter().position(is_by_rule) else { return };
            // The way-point of the rule; samples there follow.
            let Curve::Line { to, .. } = &mut motion.legs[leg].curve else { unreachable!() };
            let ([x, y, z], dimension) = (to.padded(), to.dimension());
            *to = Vector::new(&[x + BY, y, z][..dimension]).unwrap();
            if let Some(next) = motion.legs.get_mut(leg + 1) {
                let Curve::Line { from, .. } = &mut next.curve else { unreachable!() };
                *from = Vector::new(&[x + BY, y, z][..dimension]).unwrap();
            }
            let there = motion.samples.iter_mut().filter(|sample| sample.position == [x, y, z]);
            there.for_each(|sample| sample.position[0] += BY);
        },
        ..NONE
    };
    check(&mutation, &[0], |_, told, _| {
        near(&told["position"]["distance"], BY);
        near(&told["length"]["change"], 0.0);
    });
}
