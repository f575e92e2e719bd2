//! `replay check` beyond equality: tolerances, changes, several files.

use answer::Caps;
use schemas::message::{Reply, RequestContent, Trajectory};
use serde_json::Value;

use crate::recorded::{Folder, keep, record, request, samples};

fn report(folder: &Folder, arguments: &[&str]) -> (i32, Value) {
    let (code, out, error) = folder.run(&[&["check", "--format", "json"], arguments].concat());
    (code, serde_json::from_str(&out).unwrap_or_else(|_| panic!("{out}{error}")))
}

/// Recorded half a metre off at one sample.
fn off() -> Folder {
    Folder::with("a.mcap", |part| {
        if part.key.sequence == 1 {
            samples(part)[4].position[1] += 0.5;
        }
        true
    })
}

#[test]
fn deviations_are_numbers() {
    let (code, report) = report(&off(), &["a.mcap"]);
    let file = &report["files"][0];
    assert_eq!((code, file["answers"].as_array().unwrap().len()), (4, 1));
    let answer = &file["answers"][0];
    assert_eq!((&answer["request"], &answer["id"]), (&1.into(), &1.into()));
    assert_eq!((&answer["answer"], &answer["verdict"]), (&0.into(), &"moved".into()));
    let motion = &answer["motion"];
    let distance = motion["position"]["distance"].as_f64().unwrap();
    assert!((distance - 0.5).abs() < 1e-12, "{distance}");
    assert_eq!(motion["position"]["sample"], 4);
    assert_eq!((&motion["heading"], &motion["length"]["change"]), (&Value::Null, &0.0.into()));
    assert_eq!(
        (&answer["first"]["list"], &answer["first"]["index"]),
        (&"sample".into(), &4.into())
    );
    let (_, text, _) = off().run(&["check", "a.mcap"]);
    let said = "    answer 0 moved: position by 0.5 m (sample 4, ";
    assert!(text.contains(said), "{text}");
}

#[test]
fn tolerances_are_per_quantity() {
    let folder = off();
    let tolerant = ["check", "a.mcap", "--tolerance", "position=501mm,time=1ms"];
    folder.check(&tolerant, 0, "3 equal (1 within tolerance)", "");
    folder.check(&["check", "a.mcap", "--tolerance", "position=499mm"], 4, "1 different", "");
    folder.check(&["check", "a.mcap", "--tolerance", "speed=9"], 4, "1 different", "");
    let (code, report) = report(&folder, &["a.mcap", "--tolerance", "position=1m"]);
    assert_eq!((code, &report["files"][0]["answers"][0]["verdict"]), (0, &"within".into()));
    assert_eq!(report["files"][0]["equal_within"], 1);
}

#[test]
fn tolerances_lie_beside_recordings() {
    let folder = off();
    let write = |text: &str| std::fs::write(folder.path("replay.toml"), text).unwrap();
    write("[tolerance]\nposition = \"501mm\"\n");
    folder.check(&["check", "a.mcap"], 0, "3 equal (1 within tolerance)", "");
    folder.check(&["check", "a.mcap", "--tolerance", "position=0"], 4, "1 different", "");
    write("[tolerance]\nplace = 1\n");
    let said = "replay.toml: tolerance.place: \"place\" is none of position, ";
    folder.check(&["check", "a.mcap"], 1, "", said);
}

#[test]
fn a_bad_file_does_not_stop_the_others() {
    let folder = Folder::with("c.mcap", keep);
    std::fs::write(folder.path("b.mcap"), "this is no recording").unwrap();
    folder.check(
        &["check", "a.mcap", "b.mcap", "c.mcap"],
        1,
        "c.mcap: 3 requests, 3 equal",
        "a.mcap: No such",
    );
    folder.check(&["check", "."], 1, "c.mcap: 3 requests, 3 equal", "b.mcap: ");
}

#[test]
fn the_number_of_cores_changes_nothing() {
    let folder = off();
    record(&folder.path("b.mcap"), 8, keep);
    let run = |jobs: &str| folder.run(&["check", ".", "--format", "json", "--jobs", jobs]);
    assert_eq!(run("1"), run("7"));
    folder.check(&["check", ".", "--jobs", "0"], 2, "", "--jobs");
}

fn planned(speed: f64) -> Trajectory {
    let mut request = request(7, 0);
    let RequestContent::Scene(scene) = &mut request.content else { unreachable!() };
    scene.limits.speed = Some(speed);
    let Reply { answers, .. } = answer::reply_to(&request, &Caps::default());
    answers.unwrap().remove(0).unwrap()
}

#[test]
fn a_changed_limit_moves_what_it_must() {
    let folder = Folder::with("a.mcap", keep);
    let (code, report) = report(&folder, &["a.mcap", "--with", "limits.speed=0.25"]);
    let RequestContent::Scene(scene) = request(7, 0).content else { unreachable!() };
    let (before, after) = (planned(scene.limits.speed.unwrap_or(1.0)), planned(0.25));
    let answers = report["files"][0]["answers"].as_array().unwrap();
    assert_eq!((code, answers.len()), (4, 3));
    for answer in answers {
        let motion = &answer["motion"];
        assert_eq!(motion["duration"]["recorded"], before.duration);
        assert_eq!(motion["duration"]["planned"], after.duration);
        assert_eq!(motion["duration"]["change"], after.duration - before.duration);
        assert_eq!(motion["length"]["change"], 0.0);
        assert_eq!(motion["samples"][1], after.samples.len());
        // The largest distance, computed in the other order and without roots.
        let squares = before.samples.iter().zip(&after.samples).map(|(one, other)| {
            let [x, y] = [0, 1].map(|axis| other.position[axis] - one.position[axis]);
            x.mul_add(x, y * y)
        });
        let most = squares.fold(0.0, f64::max).sqrt();
        assert!((motion["position"]["distance"].as_f64().unwrap() - most).abs() < 1e-9);
    }
    folder.check(
        &["check", "a.mcap", "--with", "limits.sped=1"],
        1,
        "",
        "request 0 (and 2 more) can't be changed: limits.sped",
    );
    folder.check(&["check", "a.mcap", "--with", "limits.speed"], 2, "", "a field and its value");
}
