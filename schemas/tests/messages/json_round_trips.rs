//! Replies from JSON, and how broken ones are refused.

use proptest::collection::vec;
use proptest::option::of;
use proptest::prelude::*;
use schemas::json;
use schemas::message::{Answer, Curve, Refusal, Reply, RequestKey, Trajectory};

use super::examples::{KEY, assembly, assembly_3d, driving, invalid, refusal};
use super::memory::peak;
use super::strategies;

fn reply(answers: Result<Vec<Answer>, Refusal>) -> Reply {
    Reply { key: RequestKey::default(), id: Some(7), answers }
}

/// A trajectory whose lists agree with its dimension, as the planner's do.
fn trajectory() -> impl Strategy<Value = Trajectory> {
    (strategies::trajectory(strategies::finite()), 1..=3_u32).prop_map(|(mut trajectory, each)| {
        trajectory.gaps_per_junction = each;
        trajectory.gaps.truncate(trajectory.gaps.len() / each as usize * each as usize);
        if trajectory.gaps.is_empty() {
            trajectory.gaps_per_junction = 1;
        }
        if trajectory.dimension == 2 {
            for sample in &mut trajectory.samples {
                (sample.position[2], sample.velocity[2]) = (0.0, 0.0);
            }
        }
        trajectory
    })
}

fn any_reply() -> impl Strategy<Value = Reply> {
    let refusal = || strategies::refusal(&strategies::finite());
    let answer = prop_oneof![trajectory().prop_map(Ok), refusal().prop_map(Err)];
    let answers = prop_oneof![
        4 => vec(answer, 0..4).prop_map(Ok),
        1 => refusal().prop_map(Err),
    ];
    (of(any::<u64>()), answers).prop_map(|(id, answers)| Reply {
        key: RequestKey::default(),
        id,
        answers,
    })
}

/// The reply with the sense of each turn in place as JSON has it.
fn without_sweep(reply: &Reply) -> Reply {
    let mut reply = reply.clone();
    let trajectories = reply.answers.iter_mut().flatten().flatten();
    for leg in trajectories.flat_map(|trajectory| &mut trajectory.legs) {
        match &mut leg.curve {
            Curve::Turn { sweep, .. } => *sweep = 0.0,
            Curve::Line { turned, .. } => *turned += 0.0,
            Curve::Arc { .. } | Curve::Clothoid { .. } => {}
        }
    }
    reply
}

proptest! {
    #[test]
    fn replies_are_read_as_they_were_written(reply in any_reply()) {
        let text = json::reply_to_json(&reply);
        let read = json::read_reply(&text).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert_eq!(without_sweep(&read), without_sweep(&reply), "{}", text);
        let again = json::reply_to_json(&read);
        prop_assert_eq!(&again, &text);
        prop_assert_eq!(json::read_reply(&again), Ok(read));
    }

    #[test]
    fn numbers_are_read_back_bit_for_bit(bits: u64) {
        let number = f64::from_bits(bits);
        prop_assume!(number.is_finite());
        let refusal = Refusal { needs: Some(number), ..refusal() };
        let read = json::read_reply(&json::reply_to_json(&reply(Err(refusal)))).unwrap();
        prop_assert_eq!(read.answers.unwrap_err().needs.unwrap().to_bits(), bits);
    }

    /// Whatever a text is, it is read in memory that its length bounds.
    #[test]
    fn broken_replies_are_refused(
        reply in any_reply(), at: prop::sample::Index,
        piece in prop::sample::select(&["", ",", "[", "}", "null", "1e999", "\"x\":1,", "[[1]]"][..]),
    ) {
        let mut text = json::reply_to_json(&reply);
        let at = text.floor_char_boundary(at.index(text.len()));
        text.replace_range(at..text.ceil_char_boundary(at + 1), piece);
        let (read, taken) = peak(|| json::read_reply(&text));
        prop_assert!(taken <= 16384 + 100 * text.len(), "{} bytes for {}", taken, text.len());
        if let Err(error) = read {
            prop_assert!(error.message.starts_with(&error.field) || error.field == "reply");
        }
    }
}

#[test]
fn a_distance_to_no_wall_is_infinite() {
    let mut open = driving();
    open.clearance.value = f64::INFINITY;
    open.legs[1].clearance = f64::INFINITY;
    let written = reply(Ok(vec![Ok(open)]));
    let text = json::reply_to_json(&written);
    assert!(text.contains(r#""clearance":{"value":null,"#), "{text}");
    assert_eq!(without_sweep(&json::read_reply(&text).unwrap()), without_sweep(&written));
}

#[test]
fn a_free_clearance_without_walls_is_null() {
    let open = Trajectory { free_clearance: Some(f64::INFINITY), ..driving() };
    let written = reply(Ok(vec![Ok(open)]));
    let text = json::reply_to_json(&written);
    assert!(text.contains(r#""free_clearance":null"#), "{text}");
    assert_eq!(without_sweep(&json::read_reply(&text).unwrap()), without_sweep(&written));
}

#[test]
fn only_a_search_that_ended_early_says_so() {
    let text = json::reply_to_json(&reply(Ok(vec![Ok(driving())])));
    assert!(!text.contains("complete"), "{text}");
    let said = text.replacen(r#""duration""#, r#""complete":true,"duration""#, 1);
    assert_eq!(json::read_reply(&said), json::read_reply(&text));
    let turn = text.replacen(r#""kind":"turn""#, r#""kind":"turn","reverse":true"#, 1);
    let error = json::read_reply(&turn).unwrap_err();
    assert_eq!(error.field, "trajectories[0].legs[0].reverse");
}

#[test]
fn keys_are_not_in_json() {
    let written = Reply { key: KEY, ..reply(Err(invalid())) };
    let read = json::read_reply(&json::reply_to_json(&written)).unwrap();
    assert_eq!(read, reply(Err(invalid())));
}

#[test]
fn a_turn_in_place_is_the_shorter() {
    let check = |from_heading: f64, to_heading: f64, expected: f64| {
        let mut turn = driving();
        let Curve::Turn { from_heading: from, to_heading: to, .. } = &mut turn.legs[0].curve else {
            panic!("the first leg is a turn");
        };
        (*from, *to) = (from_heading, to_heading);
        let text = json::reply_to_json(&reply(Ok(vec![Ok(turn)])));
        let read = json::read_reply(&text).unwrap().answers.unwrap();
        let Curve::Turn { sweep, .. } = read[0].as_ref().unwrap().legs[0].curve else {
            panic!("it still is");
        };
        assert!((sweep - expected).abs() < 1e-12, "{sweep} from {from_heading} to {to_heading}");
    };
    check(0.0, 1.5, 1.5);
    check(1.5, 0.0, -1.5);
    check(3.0, -3.0, std::f64::consts::TAU - 6.0);
    check(-3.0, 3.0, 6.0 - std::f64::consts::TAU);
}

#[track_caller]
fn check(change: impl FnOnce(String) -> String, field: &str, message: &str) {
    let answers = vec![Ok(driving()), Err(refusal()), Ok(assembly()), Ok(assembly_3d())];
    let text = change(json::reply_to_json(&reply(Ok(answers))));
    let error = json::read_reply(&text).unwrap_err();
    assert_eq!((error.field.as_str(), error.message.as_str()), (field, message), "{text}");
}

#[track_caller]
fn check_replaced(old: &str, new: &str, field: &str, message: &str) {
    let replace = |text: String| {
        assert!(text.contains(old), "{old} in {text}");
        text.replacen(old, new, 1)
    };
    check(replace, field, &format!("{field} {message}"));
}

#[test]
fn faults_of_replies_are_named() {
    check_replaced(
        r#""id":7,"#,
        r#""error":{"code":"internal","message":""},"#,
        "reply",
        "must have either `trajectories` or `error`, but has both",
    );
    check(
        |_| "{}".to_owned(),
        "reply",
        "reply must have either `trajectories` or `error`, but has neither",
    );
    check(
        |_| "[]".to_owned(),
        "reply",
        "reply must be an object with `id`, `trajectories`, `error`, not an empty list",
    );
    check_replaced(
        r#""radius":1.5"#,
        r#""radius":"1.5""#,
        "trajectories[0].legs[2].radius",
        "must be a number, not the text \"1.5\"",
    );
    check_replaced(r#""radius":1.5,"#, "", "trajectories[0].legs[2].radius", "is missing");
    check_replaced(
        r#""kind":"arc""#,
        r#""kind":"line""#,
        "trajectories[0].legs[2].center",
        "is not a known field; expected one of `from`, `to`, `heading`, `turned`, `reverse`",
    );
    check_replaced(
        r#""kind":"arc""#,
        r#""kind":"spiral""#,
        "trajectories[0].legs[2].kind",
        "must be one of \"line\", \"arc\", \"turn\", \"clothoid\", not the text \"spiral\"",
    );
    check_replaced(
        "table 2, rule 4",
        "table 2, rule 04",
        "trajectories[0].legs[0].rule",
        "must be a rule such as \"table 1, rule 3\", not the text \"table 2, rule 04\"",
    );
    check_replaced(
        r#""gap":[0.2,0.3]"#,
        r#""gap":[0.2,[0.3,0.4]]"#,
        "trajectories[0].gap",
        "must be a list of numbers, or of lists of 2 or 3 numbers, all of one kind, not a list of 2",
    );
    check_replaced(
        r#""velocity":[0.0,0.0]"#,
        r#""velocity":[0.0,0.0,0.0]"#,
        "trajectories[0].samples",
        "must be a list of samples, all in 2 or all in 3 dimensions, not a list of 1",
    );
    check_replaced(
        r#""wall":[3.0,17.0]"#,
        r#""wall":[3.0,17.0,0.0]"#,
        "trajectories[0]",
        "has positions of 2 numbers in `samples`, but of 3 in `clearance.wall`",
    );
    check_replaced(
        "junction_too_small",
        "junction_too_large",
        "trajectories[1].error.code",
        &format!(
            "must be one of {}, not the text \"junction_too_large\"",
            schemas::message::ErrorCode::ALL
                .iter()
                .map(|code| format!("\"{code}\""))
                .collect::<Vec<_>>()
                .join(", ")
        ),
    );
    check_replaced(r#""at":0.0,"#, "", "trajectories[2].clearance.at", "is missing");
    check_replaced(
        r#""error":{"#,
        r#""length":1,"error":{"#,
        "trajectories[1].error",
        "is not a known field; expected one of `gap`, `route`, `channels`, `exit`, `length`, \
         `bound`, `complete`, `duration`, `clearance`, `free_clearance`, `legs`, `exceeds`, \
         `stops`, `samples`",
    );
}
