//! Replies as people read them: the interface's names, letter by letter.

use schemas::json;
use schemas::message::{Answer, ErrorCode, Refusal, Reply};
use serde_json::Value;

use super::examples::{KEY, anywhere, assembly, assembly_3d, driving, invalid, refusal};

fn reply(id: Option<u64>, answers: Result<Vec<Answer>, Refusal>) -> Reply {
    Reply { key: KEY, id, answers }
}

#[track_caller]
fn check(reply: &Reply, expected: &[&str]) {
    let text = json::reply_to_json(reply);
    assert_eq!(text, expected.concat());
    let mut written = Vec::new();
    json::write_reply(reply, &mut written).unwrap();
    assert_eq!(written, text.as_bytes());
}

#[test]
fn assembly_in_two_dimensions() {
    check(
        &reply(Some(7), Ok(vec![Ok(assembly())])),
        &[
            r#"{"id":7,"trajectories":[{"gap":[[0.2,0.2],[0.1,0.3]],"route":[0,1,2],"#,
            r#""length":3.5,"duration":6.25,"#,
            r#""clearance":{"value":0.01,"at":0.0,"wall":[6.99,1.0]},"legs":["#,
            r#"{"kind":"line","from":[0.0,0.0],"to":[0.0,1.5],"heading":0.0,"length":1.5,"#,
            r#""clearance":0.01,"rule":"table 1, rule 1","junction":0},"#,
            r#"{"kind":"line","from":[0.0,1.5],"to":[-2.0,1.5],"heading":0.0,"length":2.0,"#,
            r#""clearance":0.01}],"samples":["#,
            r#"{"t":0.0,"position":[0.0,0.0],"heading":0.0,"velocity":[0.5,-0.5],"yaw_rate":0.0},"#,
            r#"{"t":6.25,"position":[-2.0,1.5],"heading":0.0,"velocity":[0.5,-0.5],"#,
            r#""yaw_rate":0.0}]}]}"#,
        ],
    );
}

#[test]
fn assembly_in_three_dimensions() {
    check(
        &reply(None, Ok(vec![Ok(assembly_3d())])),
        &[
            r#"{"trajectories":[{"gap":[[0.1,0.2,0.3]],"route":[1,0],"#,
            r#""channels":[{"min":[0.0,1.0,2.0],"max":[3.0,4.0,5.0]}],"exit":"+x","#,
            r#""length":3.0,"duration":4.0,"#,
            r#""clearance":{"value":0.5,"at":1.0,"wall":[1.0,2.0,3.0]},"legs":["#,
            r#"{"kind":"line","from":[0.0,0.0,0.0],"to":[1.0,2.0,2.0],"heading":0.0,"#,
            r#""length":3.0,"clearance":0.5,"junction":0}],"samples":["#,
            r#"{"t":4.0,"position":[1.0,2.0,2.0],"heading":0.0,"velocity":[0.0,0.25,0.5],"#,
            r#""yaw_rate":0.0}]}]}"#,
        ],
    );
}

#[test]
fn driving_with_every_kind_of_leg() {
    check(
        &reply(Some(0), Ok(vec![Ok(driving())])),
        &[
            r#"{"id":0,"trajectories":[{"gap":[0.2,0.3],"route":[0,1],"#,
            r#""channels":[{"min":[0.0,1.0],"max":[3.0,4.0]}],"length":17.25,"duration":20.0,"#,
            r#""clearance":{"value":0.2,"at":16.0,"wall":[3.0,17.0]},"legs":["#,
            r#"{"kind":"turn","position":[1.5,2.0],"from_heading":0.0,"to_heading":1.5,"#,
            r#""length":0.0,"clearance":1.0,"rule":"table 2, rule 4"},"#,
            r#"{"kind":"line","from":[1.5,2.0],"to":[1.5,17.0],"heading":1.5,"turned":-0.25,"#,
            r#""length":15.0,"clearance":0.75,"rule":"table 2, rule 4","junction":0},"#,
            r#"{"kind":"arc","center":[3.0,17.0],"radius":1.5,"start_angle":3.0,"sweep":-1.5,"#,
            r#""length":2.25,"clearance":0.2,"rule":"table 2, rule 4","junction":0}],"#,
            r#""samples":[{"t":0.5,"position":[1.5,2.0],"heading":0.25,"velocity":[0.0,0.0],"#,
            r#""yaw_rate":0.5}]}]}"#,
        ],
    );
}

#[test]
fn driving_anywhere() {
    check(
        &reply(None, Ok(vec![Ok(anywhere())])),
        &[
            r#"{"trajectories":[{"gap":[0.2,0.3],"route":[],"#,
            r#""length":17.25,"bound":17.125,"complete":false,"duration":20.0,"#,
            r#""clearance":{"value":0.2,"at":16.0,"wall":[3.0,17.0]},"free_clearance":0.25,"legs":["#,
            r#"{"kind":"turn","position":[1.5,2.0],"from_heading":0.0,"to_heading":1.5,"#,
            r#""length":0.0,"clearance":1.0,"rung":"aligned"},"#,
            r#"{"kind":"line","from":[1.5,2.0],"to":[1.5,17.0],"heading":1.5,"turned":-0.25,"#,
            r#""length":15.0,"clearance":0.75,"rung":"taut"},"#,
            r#"{"kind":"arc","center":[3.0,17.0],"radius":1.5,"start_angle":3.0,"sweep":-1.5,"#,
            r#""reverse":true,"length":2.25,"clearance":0.2,"rung":"reverse"}],"#,
            r#""samples":[{"t":0.5,"position":[1.5,2.0],"heading":0.25,"velocity":[0.0,0.0],"#,
            r#""yaw_rate":0.5}]}]}"#,
        ],
    );
}

#[test]
fn refusals_of_requests() {
    check(
        &reply(Some(7), Err(refusal())),
        &[
            r#"{"id":7,"error":{"code":"junction_too_small","message":"#,
            r#""junction 1 is 2.40 m wide, the body needs more than 2.49 m","#,
            r#""junction":1,"needs":2.49,"has":2.4}}"#,
        ],
    );
    check(
        &reply(None, Err(invalid())),
        &[
            r#"{"error":{"code":"invalid_scene","message":"#,
            r#""clearance.gap[1] must be positive — but is −1","field":"clearance.gap[1]","#,
            r#""axis":"z","least":0.0,"most":0.5,"heading":-0.5}}"#,
        ],
    );
}

#[test]
fn refusals_beside_trajectories() {
    let mut short = assembly();
    (short.legs, short.samples) = (Vec::new(), Vec::new());
    (short.gaps, short.route) = (Vec::new(), vec![0]);
    let no_route = Refusal::new(ErrorCode::NoRoute, "a \"quoted\" word\n");
    check(
        &reply(Some(1), Ok(vec![Err(no_route), Ok(short)])),
        &[
            r#"{"id":1,"trajectories":[{"error":{"code":"no_route","message":"#,
            r#""a \"quoted\" word\n"}},{"gap":[],"route":[0],"length":3.5,"duration":6.25,"#,
            r#""clearance":{"value":0.01,"at":0.0,"wall":[6.99,1.0]},"legs":[],"samples":[]}]}"#,
        ],
    );
}

#[test]
fn codes_are_written_by_name() {
    for code in ErrorCode::ALL {
        let text = json::reply_to_json(&reply(None, Err(Refusal::new(*code, ""))));
        assert_eq!(text, format!(r#"{{"error":{{"code":"{}","message":""}}}}"#, code.name()));
    }
}

#[test]
fn numbers_that_json_does_not_have_are_null() {
    let mut trajectory = driving();
    trajectory.length = f64::NAN;
    trajectory.clearance.value = f64::INFINITY;
    trajectory.clearance.wall = [f64::NEG_INFINITY, 0.0].into();
    trajectory.gaps[0] = f64::NAN;
    trajectory.samples[0].position[1] = f64::INFINITY;
    let refusal = Refusal { needs: Some(f64::INFINITY), ..refusal() };
    let text = json::reply_to_json(&reply(None, Ok(vec![Ok(trajectory), Err(refusal)])));
    let read: Value = serde_json::from_str(&text).unwrap();
    let first = &read["trajectories"][0];
    for value in [
        &first["length"],
        &first["clearance"]["value"],
        &first["clearance"]["wall"][0],
        &first["gap"][0],
        &first["samples"][0]["position"][1],
    ] {
        assert_eq!(value, &Value::Null);
    }
    assert_eq!(read["trajectories"][1]["error"]["needs"], Value::Null);
    assert_eq!(first["gap"][1], Value::from(0.3));
}

#[test]
fn what_peers_claim_does_not_break_the_json() {
    let mut trajectory = assembly();
    (trajectory.dimension, trajectory.gaps_per_junction) = (u32::MAX, u32::MAX);
    let refusal = Refusal { axis: Some(u32::MAX), ..refusal() };
    let text = json::reply_to_json(&reply(None, Ok(vec![Ok(trajectory), Err(refusal)])));
    let read: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(read["trajectories"][0]["gap"][0], Value::from(vec![0.2, 0.2, 0.1, 0.3]));
    assert_eq!(read["trajectories"][1]["error"]["axis"], Value::Null);
}
