use std::f64::consts::TAU;

use schemas::message::{
    Answer, Clearance, Curve, Direction, Leg, RequestKey, Rule, Rung, Sample, Trajectory,
};

use super::*;
use crate::tolerance::Quantity;

/// How they compare as a whole.
fn compare(recorded: &Reply, planned: &Reply, tolerance: Tolerance) -> Outcome {
    super::compare(recorded, planned, &tolerance).outcome
}

const EQUAL: Outcome = Outcome::Equal { reworded: 0 };

fn trajectory() -> Trajectory {
    let sample = |t| Sample { t, position: [t, 0.25, 0.0], ..Sample::default() };
    let arc = Curve::Arc { center: [0.0, 1.0].into(), radius: 1.5, start_angle: 0.5, sweep: -1.0 };
    let rule = Some(Rule { table: 1, number: 3 });
    Trajectory {
        dimension: 2,
        gaps_per_junction: 1,
        length: 7.4,
        duration: 11.9,
        clearance: Clearance { value: 0.01, at: 0.0, wall: [6.99, 1.0].into() },
        gaps: vec![0.2, 0.3],
        route: vec![0, 1, 2],
        legs: vec![Leg { junction: Some(0), rule, ..Leg::new(arc, 1.5, 0.1) }],
        samples: [0.0, 0.02, 0.04].map(sample).to_vec(),
        ..Trajectory::default()
    }
}

fn refusal(needs: f64) -> Refusal {
    let refusal = Refusal::new(ErrorCode::JunctionTooSmall, format!("needs {needs} m"));
    Refusal { needs: Some(needs), ..refusal }
}

fn reply(answers: Result<Vec<Answer>, Refusal>) -> Reply {
    Reply { key: RequestKey { client: 1, sequence: 2 }, id: Some(7), answers }
}

fn whole() -> Reply {
    reply(Ok(vec![Err(refusal(2.5)), Ok(trajectory())]))
}

/// What is said of a reply whose second answer differs as `change` makes it.
fn said(tolerance: Tolerance, change: impl Fn(&mut Trajectory)) -> String {
    let mut planned = whole();
    let Ok(answers) = &mut planned.answers else { unreachable!() };
    change(answers[1].as_mut().unwrap());
    match compare(&whole(), &planned, tolerance) {
        Outcome::Different(difference) => difference.to_string(),
        Outcome::Equal { reworded: 0 } => "equal".to_owned(),
        outcome => panic!("{outcome:?}"),
    }
}

#[track_caller]
fn check(change: impl Fn(&mut Trajectory), expected: &str) {
    assert_eq!(said(Tolerance::EXACT, change), expected);
}

#[test]
fn equal_replies_are_equal() {
    assert_eq!(compare(&whole(), &whole(), Tolerance::EXACT), EQUAL);
    assert_eq!(compare(&whole(), &whole(), Tolerance::within(0.0)), EQUAL);
}

#[test]
fn the_first_difference_is_named() {
    check(
        |planned| {
            planned.samples[2].t = 9.0;
            planned.samples[1].position[1] = 0.25f64.next_up();
            planned.samples[1].yaw_rate = 1.0;
        },
        "answer 1, sample 1, position[1]: recorded 0.25000000000000000, \
         planned 0.25000000000000006 (5.55e-17 apart)",
    );
    check(
        |planned| {
            planned.samples.pop();
            planned.length = 7.5;
        },
        "answer 1, length: recorded 7.4000000000000004, planned 7.5000000000000000 \
         (1.00e-1 apart)",
    );
    check(
        |planned| planned.legs[0].rule = Some(Rule { table: 2, number: 1 }),
        "answer 1, leg 0, rule: recorded table 1, rule 3, planned table 2, rule 1",
    );
    check(
        |planned| {
            planned.legs[0].curve = Curve::Turn {
                position: [0.0, 0.0].into(),
                from_heading: 0.0,
                to_heading: 0.0,
                sweep: 0.0,
            };
        },
        "answer 1, leg 0, kind: recorded arc, planned turn",
    );
    check(
        |planned| planned.gaps[1] = 0.5,
        "answer 1, gap 1, value: recorded 0.29999999999999999, \
         planned 0.50000000000000000 (2.00e-1 apart)",
    );
    check(|planned| planned.route[2] = 5, "answer 1, route 2, channel: recorded 2, planned 5");
    check(
        |planned| planned.clearance.wall = [6.99, 1.0, 0.0].into(),
        "answer 1, clearance.wall, number of coordinates: recorded 2, planned 3",
    );
}

#[test]
fn a_list_that_ends_early_is_compared_as_far_as_it_goes() {
    check(
        |planned| planned.samples.truncate(2),
        "answer 1, number of samples: recorded 3, planned 2",
    );
    check(
        |planned| {
            planned.samples.truncate(2);
            planned.samples[0].t = -0.0;
        },
        "answer 1, sample 0, t: recorded 0.0000000000000000, planned -0.0000000000000000 \
         (0.00e0 apart)",
    );
}

#[test]
fn a_tolerance_forgives_as_much_as_it_says() {
    let change = |planned: &mut Trajectory| planned.samples[1].velocity[0] = 1e-9;
    assert_eq!(said(Tolerance::within(1e-9), change), "equal");
    assert!(
        said(Tolerance::within(0.99e-9), change).starts_with("answer 1, sample 1, velocity[0]")
    );
    let turned = |planned: &mut Trajectory| {
        let Curve::Arc { start_angle, .. } = &mut planned.legs[0].curve else { unreachable!() };
        *start_angle += TAU;
    };
    assert_eq!(said(Tolerance::within(1e-12), turned), "equal");
    assert!(said(Tolerance::EXACT, turned).starts_with("answer 1, leg 0, start_angle"));
    let signed = |planned: &mut Trajectory| planned.samples[0].t = -0.0;
    assert_eq!(said(Tolerance::within(0.0), signed), "equal");
    let nan = |planned: &mut Trajectory| planned.samples[1].t = f64::NAN;
    assert!(said(Tolerance::within(1e9), nan).contains("planned NaN (0x7ff8000000000000)"));
}

#[test]
fn refusals_are_compared_by_their_numbers() {
    let (one, other) = (reply(Err(refusal(2.5))), reply(Err(refusal(2.75))));
    let Outcome::Different(difference) = compare(&one, &other, Tolerance::EXACT) else {
        panic!("they differ");
    };
    assert_eq!(difference.path.to_string(), "error.needs");
    let within = compare(&one, &other, Tolerance::within(0.25));
    assert_eq!(within, Outcome::Equal { reworded: 1 }, "the message has the number, too");
}

#[test]
fn every_field_of_a_refusal_but_its_message_is_compared() {
    type Change = fn(&mut Refusal);
    let changes: [(Change, &str); 9] = [
        (
            |it| it.code = ErrorCode::NoRoute,
            "error.code: recorded junction_too_small, planned no_route",
        ),
        (|it| it.field = Some("body".into()), "error.field: recorded none, planned body"),
        (|it| it.junction = Some(3), "error.junction: recorded none, planned 3"),
        (|it| it.axis = Some(2), "error.axis: recorded none, planned z"),
        (|it| it.needs = None, "error.needs: recorded 2.5000000000000000, planned none"),
        (|it| it.has = Some(1.0), "error.has: recorded none, planned 1.0000000000000000"),
        (|it| it.least = Some(0.0), "error.least: recorded none, planned 0.0000000000000000"),
        (|it| it.most = Some(-0.0), "error.most: recorded none, planned -0.0000000000000000"),
        (|it| it.heading = Some(1.0), "error.heading: recorded none, planned 1.0000000000000000"),
    ];
    for (change, expected) in changes {
        let mut planned = refusal(2.5);
        change(&mut planned);
        let planned = reply(Err(planned));
        let Outcome::Different(difference) =
            compare(&reply(Err(refusal(2.5))), &planned, Tolerance::EXACT)
        else {
            panic!("{expected}");
        };
        assert_eq!(difference.to_string(), expected);
    }
}

#[test]
fn wording_is_counted_and_not_compared() {
    let planned = Refusal { message: "in other words".into(), ..refusal(2.5) };
    let one = reply(Ok(vec![Ok(trajectory()), Err(refusal(2.5)), Err(refusal(2.5))]));
    let other = reply(Ok(vec![Ok(trajectory()), Err(planned.clone()), Err(refusal(2.5))]));
    assert_eq!(compare(&one, &other, Tolerance::EXACT), Outcome::Equal { reworded: 1 });
    let whole = compare(&reply(Err(refusal(2.5))), &reply(Err(planned)), Tolerance::EXACT);
    assert_eq!(whole, Outcome::Equal { reworded: 1 });
}

#[test]
fn a_setting_is_compared_if_the_recording_has_it() {
    let with = |setting: Option<&str>| {
        reply(Err(Refusal { setting: setting.map(str::to_owned), ..refusal(2.5) }))
    };
    let [old, new, other] = [None, Some("caps.pieces"), Some("caps.answers")].map(with);
    assert_eq!(compare(&old, &new, Tolerance::EXACT), EQUAL, "version 1 has no settings");
    assert_eq!(compare(&new, &new, Tolerance::EXACT), EQUAL);
    for planned in [old, other] {
        assert!(matches!(compare(&new, &planned, Tolerance::EXACT), Outcome::Different(_)));
    }
}

#[test]
fn what_older_recordings_lack_is_compared_if_the_recording_has_it() {
    type Change = fn(&mut Trajectory);
    let changes: [(Change, &str); 3] = [
        (|it| it.bound = Some(7.0), "bound: recorded 7.0000000000000000, planned none"),
        (
            |it| it.free_clearance = Some(0.5),
            "free_clearance: recorded 0.50000000000000000, planned none",
        ),
        (|it| it.legs[0].rung = Some(Rung::Taut), "leg 0, rung: recorded taut, planned none"),
    ];
    for (change, expected) in changes {
        let mut added = trajectory();
        change(&mut added);
        let [old, new] = [trajectory(), added].map(|trajectory| reply(Ok(vec![Ok(trajectory)])));
        assert_eq!(compare(&old, &new, Tolerance::EXACT), EQUAL, "{expected}");
        assert_eq!(compare(&new, &new, Tolerance::EXACT), EQUAL, "{expected}");
        let Outcome::Different(difference) = compare(&new, &old, Tolerance::EXACT) else {
            panic!("{expected}");
        };
        assert_eq!(difference.to_string(), format!("answer 0, {expected}"));
    }
}

#[test]
fn bounds_reverse_legs_and_early_ends_are_compared() {
    check(|it| it.complete = false, "answer 1, complete: recorded true, planned false");
    check(|it| it.legs[0].reverse = true, "answer 1, leg 0, reverse: recorded false, planned true");
    let with = |bound| {
        let trajectory = Trajectory { bound: Some(bound), ..trajectory() };
        reply(Ok(vec![Ok(trajectory)]))
    };
    let Outcome::Different(difference) = compare(&with(7.0), &with(7.25), Tolerance::EXACT) else {
        panic!("they differ");
    };
    assert_eq!((difference.path.field.as_str(), difference.distance), ("bound", Some(0.25)));
    assert_eq!(compare(&with(7.0), &with(7.25), Tolerance::within(0.25)), EQUAL);
}

#[test]
fn exits_are_named() {
    check(
        |planned| planned.exit = Some(Direction::MinusX),
        "answer 1, exit: recorded none, planned -x",
    );
}

#[test]
fn a_refusal_in_place_of_a_trajectory_is_quoted() {
    let planned = reply(Err(refusal(2.5)));
    let Outcome::Different(difference) = compare(&whole(), &planned, Tolerance::EXACT) else {
        panic!("they differ");
    };
    assert_eq!(
        difference.to_string(),
        "answers: recorded 2 answers, planned a refusal (junction_too_small: needs 2.5 m)"
    );
}

#[test]
fn refusals_that_depend_on_load_are_not_repeatable() {
    let late = || Refusal::new(ErrorCode::DeadlineExceeded, "too late");
    assert_eq!(compare(&reply(Err(late())), &whole(), Tolerance::EXACT), Outcome::NotRepeatable);
    let one_late = reply(Ok(vec![Err(late()), Ok(trajectory())]));
    assert_eq!(compare(&one_late, &whole(), Tolerance::EXACT), EQUAL);
}

/// How the second answer compares if `change` is made to it.
fn second(tolerance: Tolerance, change: impl Fn(&mut Vec<Answer>)) -> Vec<AnswerComparison> {
    let mut planned = whole();
    change(planned.answers.as_mut().unwrap());
    super::compare(&whole(), &planned, &tolerance).answers
}

fn verdicts(answers: &[AnswerComparison]) -> Vec<Verdict> {
    answers.iter().map(|answer| answer.verdict).collect()
}

fn moved_by(metres: f64) -> impl Fn(&mut Vec<Answer>) {
    move |answers| answers[1].as_mut().unwrap().samples[2].position[1] += metres
}

#[test]
fn each_answer_has_a_verdict() {
    use Verdict::{Appeared, Equal, Moved, Vanished, Within};
    let check = |tolerance: Tolerance, change: &dyn Fn(&mut Vec<Answer>), expected: &[Verdict]| {
        assert_eq!(verdicts(&second(tolerance, change)), expected);
    };
    let exact = Tolerance::EXACT;
    check(exact, &|_| {}, &[Equal, Equal]);
    check(exact, &moved_by(0.125), &[Equal, Moved]);
    check(Tolerance::within(0.125), &moved_by(0.125), &[Equal, Within]);
    check(exact, &|answers| answers[1] = Err(refusal(1.0)), &[Equal, Vanished]);
    check(exact, &|answers| answers[0] = Ok(trajectory()), &[Appeared, Equal]);
    check(exact, &|answers| answers[0] = Err(refusal(2.75)), &[Moved, Equal]);
    check(Tolerance::within(0.25), &|answers| answers[0] = Err(refusal(2.75)), &[Within, Equal]);
    check(exact, &|answers| answers.truncate(1), &[Equal, Vanished]);
    check(exact, &|answers| answers.push(Ok(trajectory())), &[Equal, Equal, Appeared]);
    check(exact, &|answers| answers.push(Err(refusal(1.0))), &[Equal, Equal, Moved]);
}

#[test]
fn a_refusal_as_a_whole_takes_each_motion_away() {
    let refused = reply(Err(refusal(2.5)));
    let answers = super::compare(&whole(), &refused, &Tolerance::EXACT).answers;
    assert_eq!(verdicts(&answers), [Verdict::Equal, Verdict::Vanished]);
    let answers = super::compare(&refused, &whole(), &Tolerance::EXACT).answers;
    assert_eq!(verdicts(&answers), [Verdict::Equal, Verdict::Appeared]);
}

#[test]
fn a_tolerance_is_for_its_quantity_alone() {
    let check = |tolerance: Tolerance, expected: Verdict| {
        assert_eq!(second(tolerance, moved_by(0.125))[1].verdict, expected);
    };
    check(Tolerance::EXACT.with(Quantity::Position, 0.125), Verdict::Within);
    check(Tolerance::EXACT.with(Quantity::Position, 0.124), Verdict::Moved);
    check(Tolerance::EXACT.with(Quantity::Speed, 1.0), Verdict::Moved);
    check(Tolerance::within(1.0).with(Quantity::Position, 0.0), Verdict::Moved);
}

#[test]
fn the_distance_of_points_counts_where_positions_have_a_tolerance() {
    // 3 and 4 make 5.
    let change = |answers: &mut Vec<Answer>| {
        let position = &mut answers[1].as_mut().unwrap().samples[2].position;
        *position = [position[0] + 3.0, position[1] + 4.0, 0.0];
    };
    let verdict = |tolerance| second(tolerance, change)[1].verdict;
    assert_eq!(verdict(Tolerance::EXACT.with(Quantity::Position, 4.5)), Verdict::Moved);
    assert_eq!(verdict(Tolerance::EXACT.with(Quantity::Position, 5.5)), Verdict::Within);
    assert_eq!(verdict(Tolerance::within(4.5)), Verdict::Within, "coordinate by coordinate");
    let moved = second(Tolerance::EXACT.with(Quantity::Position, 4.5), change);
    assert_eq!(moved[1].first.as_ref().unwrap().path.field, "position[1]");
    assert_eq!(moved[1].motion.as_ref().unwrap().position.unwrap().distance, 5.0);
}

#[test]
fn a_moved_answer_says_how_far_and_where() {
    let answers = second(Tolerance::EXACT, |answers| {
        let trajectory = answers[1].as_mut().unwrap();
        trajectory.samples[2].position[1] += 0.5;
        trajectory.duration -= 0.5;
        trajectory.route = vec![0, 2];
    });
    // The chords, 0.02 m each, are stretched to the path's 7.4 m.
    assert_eq!(
        answers[1].to_string(),
        "answer 1 moved: position by 0.5 m (sample 2, 7.400 m along), duration -0.5 s, \
         route 0 1 2 -> 0 2"
    );
    let first = answers[1].first.as_ref().unwrap();
    assert_eq!(first.path.field, "duration", "the first in the order of the message");
}

#[test]
fn every_answer_that_differs_is_told() {
    let two = || reply(Ok(vec![Ok(trajectory()), Ok(trajectory())]));
    let mut planned = two();
    for answer in planned.answers.as_mut().unwrap() {
        answer.as_mut().unwrap().length += 1.0;
    }
    let Comparison { outcome, answers } = super::compare(&two(), &planned, &Tolerance::EXACT);
    assert_eq!(verdicts(&answers), [Verdict::Moved; 2]);
    let Outcome::Different(first) = outcome else { panic!("they differ") };
    assert_eq!(first.path.answer, Some(0));
}
