//! `replay` and a running planner.

use integration_tests::{TestDomain, root};
use serde_json::Value;

fn golden(name: &str) -> String {
    root().join("recordings").join(name).display().to_string()
}

#[test]
fn recorded_requests_are_played_to_a_planner() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let domain = test.domain().to_string();
    let (file, domain) = (golden("driving.mcap"), domain.as_str());
    let play = |more: &[&str]| {
        let arguments = ["play", &file, "--domain", domain, "--timeout", "60s", "--format", "json"];
        let played = test.start("replay", &[&arguments, more].concat(), None).wait();
        assert_eq!((played.code, played.stderr.as_str()), (Some(0), ""), "{played:?}");
        serde_json::from_str::<Value>(&played.stdout).unwrap()
    };
    let played = play(&["--rate", "max", "--clients", "3"]);
    assert_eq!((&played["replies"], &played["failed"]), (&18.into(), &0.into()));
    let latency = |name: &str| played["latency"][name].as_f64().unwrap();
    assert!(latency("p50") > 0.0 && latency("p50") <= latency("max"), "{played}");
    // The first alone: the others were sent later.
    assert_eq!(play(&["--rate", "1000", "--until", "0s"])["replies"], 1);
    planner.stop();
}

#[test]
fn a_running_planner_is_checked() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let domain = test.domain().to_string();
    let check = |more: &[&str]| {
        let file = golden("refusals.mcap");
        let other = golden("driving.mcap");
        let arguments =
            ["check", &other, &file, "--via-bus", "--domain", &domain, "--timeout", "60s"];
        test.start("replay", &[&arguments, more].concat(), None).wait()
    };
    let equal = check(&[]);
    assert_eq!((equal.code, equal.stderr.as_str()), (Some(0), ""), "{equal:?}");
    assert!(equal.stdout.contains("driving.mcap: 6 requests, 6 equal\n"), "{equal:?}");
    let slower = check(&["--with", "limits.speed=0.5"]);
    assert_eq!(slower.code, Some(4), "{slower:?}");
    planner.stop();
    let none = check(&["--wait", "0s"]);
    assert_eq!(none.code, Some(1), "{none:?}");
    assert!(none.stderr.contains("no planner runs in domain"), "{none:?}");
}
