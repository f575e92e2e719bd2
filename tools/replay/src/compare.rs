//! What differs first between two replies.

use std::f64::consts::TAU;
use std::fmt;

use schemas::message::{
    Answer, AxisBox, Clearance, Curve, ErrorCode, Leg, Refusal, Reply, Sample, Trajectory, Vector,
};

/// How equal numbers must be.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Tolerance {
    /// Bit for bit.
    #[default]
    Exact,
    /// They may differ by so much (metres, radians, seconds alike); headings by so much of
    /// an angle. The wording of refusals, which repeats the numbers, is not compared.
    Within(f64),
}

/// How a recorded reply compares with the one that is expected to equal it.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// They are equal.
    Equal,
    /// They differ, first here.
    Different(Box<Difference>),
    /// The recorded one tells of the hour and not of the request: its deadline had passed,
    /// or too many others waited.
    NotRepeatable,
}

/// The first difference of two replies.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Where.
    pub place: Place,
    /// What was recorded there; numbers with 17 digits.
    pub recorded: String,
    /// What stands there in the other reply.
    pub planned: String,
    /// How far the numbers are apart, if they are numbers.
    pub distance: Option<f64>,
}

/// A place in a reply.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The answer, from 0.
    pub answer: Option<usize>,
    /// A list of its trajectory, in the singular, and the index in it.
    pub item: Option<(&'static str, usize)>,
    /// The field.
    pub field: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(answer) = self.answer {
            write!(f, "answer {answer}, ")?;
        }
        if let Some((list, index)) = self.item {
            write!(f, "{list} {index}, ")?;
        }
        f.write_str(&self.field)
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, recorded, planned, distance } = self;
        write!(f, "{place}: recorded {recorded}, planned {planned}")?;
        match distance {
            Some(distance) if distance.is_finite() => write!(f, " ({distance:.2e} apart)"),
            _ => Ok(()),
        }
    }
}

/// Compares two replies in the order in which a reply is read.
pub fn compare(recorded: &Reply, planned: &Reply, tolerance: Tolerance) -> Outcome {
    if recorded.answers.as_ref().is_err_and(is_of_the_hour) {
        return Outcome::NotRepeatable;
    }
    match (At { tolerance, answer: None, item: None }).replies(recorded, planned) {
        Ok(()) => Outcome::Equal,
        Err(difference) => Outcome::Different(difference),
    }
}

fn is_of_the_hour(refusal: &Refusal) -> bool {
    matches!(refusal.code, ErrorCode::DeadlineExceeded | ErrorCode::Overloaded)
}

/// `Err` is the first difference.
type Compared = Result<(), Box<Difference>>;

/// Where the comparison is.
#[derive(Clone, Copy)]
struct At {
    tolerance: Tolerance,
    answer: Option<usize>,
    item: Option<(&'static str, usize)>,
}

impl At {
    fn answer(self, answer: usize) -> Self {
        Self { answer: Some(answer), ..self }
    }

    fn item(self, list: &'static str, index: usize) -> Self {
        Self { item: Some((list, index)), ..self }
    }

    #[cold]
    fn differ(
        self,
        field: &str,
        [recorded, planned]: [String; 2],
        distance: Option<f64>,
    ) -> Compared {
        let place = Place { answer: self.answer, item: self.item, field: field.to_owned() };
        Err(Box::new(Difference { place, recorded, planned, distance }))
    }

    fn same<T: PartialEq + fmt::Debug>(self, field: &str, recorded: T, planned: T) -> Compared {
        if recorded == planned {
            return Ok(());
        }
        self.differ(field, [recorded, planned].map(|value| format!("{value:?}")), None)
    }

    fn number(self, field: &str, recorded: f64, planned: f64) -> Compared {
        self.distance(field, recorded, planned, (recorded - planned).abs())
    }

    /// Numbers that are equal when they are a whole turn apart.
    fn angle(self, field: &str, recorded: f64, planned: f64) -> Compared {
        let turned = (recorded - planned).rem_euclid(TAU);
        self.distance(field, recorded, planned, turned.min(TAU - turned))
    }

    fn distance(self, field: &str, recorded: f64, planned: f64, distance: f64) -> Compared {
        let equal = match self.tolerance {
            Tolerance::Exact => false,
            Tolerance::Within(most) => distance <= most || (recorded.is_nan() && planned.is_nan()),
        };
        if equal || recorded.to_bits() == planned.to_bits() {
            return Ok(());
        }
        let apart = (recorded - planned).abs();
        self.differ(field, [recorded, planned].map(digits), Some(apart))
    }

    fn numbers(self, field: &str, recorded: [f64; 3], planned: [f64; 3]) -> Compared {
        for (index, (recorded, planned)) in recorded.into_iter().zip(planned).enumerate() {
            if recorded.to_bits() != planned.to_bits() {
                self.number(&format!("{field}[{index}]"), recorded, planned)?;
            }
        }
        Ok(())
    }

    fn vector(self, field: &str, recorded: Vector, planned: Vector) -> Compared {
        self.numbers(field, recorded.padded(), planned.padded())?;
        let coordinates = format!("{field}, its number of coordinates");
        self.same(&coordinates, recorded.dimension(), planned.dimension())
    }

    /// Element by element, then the lengths: where a list ends early, what it still has
    /// comes first.
    fn list<T>(
        self,
        [singular, plural]: [&'static str; 2],
        recorded: &[T],
        planned: &[T],
        compare: impl Fn(Self, &T, &T) -> Compared,
    ) -> Compared {
        for (index, (one, other)) in recorded.iter().zip(planned).enumerate() {
            compare(self.item(singular, index), one, other)?;
        }
        self.same(&format!("number of {plural}"), recorded.len(), planned.len())
    }

    fn replies(self, recorded: &Reply, planned: &Reply) -> Compared {
        self.same("key", recorded.key, planned.key)?;
        self.same("id", recorded.id, planned.id)?;
        match (&recorded.answers, &planned.answers) {
            (Ok(recorded), Ok(planned)) => {
                for (index, (one, other)) in recorded.iter().zip(planned).enumerate() {
                    if !one.as_ref().is_err_and(is_of_the_hour) {
                        self.answer(index).answers(one, other)?;
                    }
                }
                self.same("number of answers", recorded.len(), planned.len())
            }
            (Err(recorded), Err(planned)) => self.refusals(recorded, planned),
            (Ok(recorded), Err(planned)) => {
                let answers = format!("{} answers", recorded.len());
                self.differ("answers", [answers, in_brief(planned)], None)
            }
            (Err(recorded), Ok(planned)) => {
                let answers = format!("{} answers", planned.len());
                self.differ("answers", [in_brief(recorded), answers], None)
            }
        }
    }

    fn answers(self, recorded: &Answer, planned: &Answer) -> Compared {
        let trajectory = || "a trajectory".to_owned();
        match (recorded, planned) {
            (Ok(recorded), Ok(planned)) => self.trajectories(recorded, planned),
            (Err(recorded), Err(planned)) => self.refusals(recorded, planned),
            (Ok(_), Err(planned)) => self.differ("answer", [trajectory(), in_brief(planned)], None),
            (Err(recorded), Ok(_)) => {
                self.differ("answer", [in_brief(recorded), trajectory()], None)
            }
        }
    }

    fn refusals(self, recorded: &Refusal, planned: &Refusal) -> Compared {
        self.same("error.code", recorded.code, planned.code)?;
        self.same("error.field", &recorded.field, &planned.field)?;
        self.same("error.junction", recorded.junction, planned.junction)?;
        self.same("error.axis", recorded.axis, planned.axis)?;
        let numbers = [
            ("error.needs", recorded.needs, planned.needs),
            ("error.has", recorded.has, planned.has),
            ("error.least", recorded.least, planned.least),
            ("error.most", recorded.most, planned.most),
            ("error.heading", recorded.heading, planned.heading),
        ];
        for (field, recorded, planned) in numbers {
            match (recorded, planned) {
                (Some(recorded), Some(planned)) => self.number(field, recorded, planned)?,
                (recorded, planned) => self.same(field, recorded, planned)?,
            }
        }
        match self.tolerance {
            Tolerance::Exact => self.same("error.message", &recorded.message, &planned.message),
            Tolerance::Within(_) => Ok(()),
        }
    }

    fn trajectories(self, recorded: &Trajectory, planned: &Trajectory) -> Compared {
        self.same("dimension", recorded.dimension, planned.dimension)?;
        self.same("gaps_per_junction", recorded.gaps_per_junction, planned.gaps_per_junction)?;
        self.same("exit", recorded.exit, planned.exit)?;
        self.number("length", recorded.length, planned.length)?;
        self.number("duration", recorded.duration, planned.duration)?;
        self.clearances(&recorded.clearance, &planned.clearance)?;
        self.list(["gap", "gaps"], &recorded.gaps, &planned.gaps, |at, one, other| {
            at.number("value", *one, *other)
        })?;
        self.list(
            ["route", "channels in the route"],
            &recorded.route,
            &planned.route,
            |at, one, other| at.same("channel", one, other),
        )?;
        self.list(["channel", "channels"], &recorded.channels, &planned.channels, Self::boxes)?;
        self.list(["leg", "legs"], &recorded.legs, &planned.legs, Self::legs)?;
        self.list(["sample", "samples"], &recorded.samples, &planned.samples, Self::samples)
    }

    fn clearances(self, recorded: &Clearance, planned: &Clearance) -> Compared {
        self.number("clearance.value", recorded.value, planned.value)?;
        self.number("clearance.at", recorded.at, planned.at)?;
        self.vector("clearance.wall", recorded.wall, planned.wall)
    }

    fn boxes(self, recorded: &AxisBox, planned: &AxisBox) -> Compared {
        self.vector("min", recorded.min, planned.min)?;
        self.vector("max", recorded.max, planned.max)
    }

    fn legs(self, recorded: &Leg, planned: &Leg) -> Compared {
        self.curves(&recorded.curve, &planned.curve)?;
        self.number("length", recorded.length, planned.length)?;
        self.number("clearance", recorded.clearance, planned.clearance)?;
        self.same("junction", recorded.junction, planned.junction)?;
        self.same("rule", recorded.rule, planned.rule)
    }

    fn curves(self, recorded: &Curve, planned: &Curve) -> Compared {
        use Curve::{Arc, Line, Turn};
        match (*recorded, *planned) {
            (
                Line { from, to, heading, turned },
                Line { from: f, to: t, heading: h, turned: s },
            ) => {
                self.vector("from", from, f)?;
                self.vector("to", to, t)?;
                self.angle("heading", heading, h)?;
                self.number("turned", turned, s)
            }
            (
                Arc { center, radius, start_angle, sweep },
                Arc { center: c, radius: r, start_angle: a, sweep: s },
            ) => {
                self.vector("center", center, c)?;
                self.number("radius", radius, r)?;
                self.angle("start_angle", start_angle, a)?;
                self.number("sweep", sweep, s)
            }
            (
                Turn { position, from_heading, to_heading, sweep },
                Turn { position: p, from_heading: f, to_heading: t, sweep: s },
            ) => {
                self.vector("position", position, p)?;
                self.angle("from_heading", from_heading, f)?;
                self.angle("to_heading", to_heading, t)?;
                self.number("sweep", sweep, s)
            }
            (recorded, planned) => {
                let kind = |curve| match curve {
                    Line { .. } => "line".to_owned(),
                    Arc { .. } => "arc".to_owned(),
                    Turn { .. } => "turn".to_owned(),
                };
                self.differ("kind", [kind(recorded), kind(planned)], None)
            }
        }
    }

    fn samples(self, recorded: &Sample, planned: &Sample) -> Compared {
        self.number("t", recorded.t, planned.t)?;
        self.numbers("position", recorded.position, planned.position)?;
        self.angle("heading", recorded.heading, planned.heading)?;
        self.numbers("velocity", recorded.velocity, planned.velocity)?;
        self.number("yaw_rate", recorded.yaw_rate, planned.yaw_rate)
    }
}

fn in_brief(refusal: &Refusal) -> String {
    format!("a refusal ({:?}: {})", refusal.code, refusal.message)
}

/// A number with 17 significant digits, which no other number shares.
fn digits(value: f64) -> String {
    if !value.is_finite() {
        return if value.is_nan() {
            format!("NaN ({:#018x})", value.to_bits())
        } else {
            value.to_string()
        };
    }
    let scientific = format!("{value:.16e}");
    let exponent: i32 = scientific
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .expect("scientific notation has an exponent");
    match exponent {
        -5..=16 => format!("{value:.*}", (16 - exponent) as usize),
        _ => scientific,
    }
}

#[cfg(test)]
mod tests {
    use schemas::message::{RequestKey, Rule};

    use super::*;

    fn trajectory() -> Trajectory {
        let sample = |t| Sample { t, position: [t, 0.25, 0.0], ..Sample::default() };
        let arc =
            Curve::Arc { center: [0.0, 1.0].into(), radius: 1.5, start_angle: 0.5, sweep: -1.0 };
        let rule = Some(Rule { table: 1, number: 3 });
        Trajectory {
            dimension: 2,
            gaps_per_junction: 1,
            length: 7.4,
            duration: 11.9,
            clearance: Clearance { value: 0.01, at: 0.0, wall: [6.99, 1.0].into() },
            gaps: vec![0.2, 0.3],
            route: vec![0, 1, 2],
            legs: vec![Leg { curve: arc, length: 1.5, clearance: 0.1, junction: Some(0), rule }],
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
            outcome => format!("{outcome:?}"),
        }
    }

    #[track_caller]
    fn check(change: impl Fn(&mut Trajectory), expected: &str) {
        assert_eq!(said(Tolerance::Exact, change), expected);
    }

    #[test]
    fn equal_replies_are_equal() {
        assert_eq!(compare(&whole(), &whole(), Tolerance::Exact), Outcome::Equal);
        assert_eq!(compare(&whole(), &whole(), Tolerance::Within(0.0)), Outcome::Equal);
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
            "answer 1, leg 0, rule: recorded Some(Rule { table: 1, number: 3 }), \
             planned Some(Rule { table: 2, number: 1 })",
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
            "answer 1, clearance.wall, its number of coordinates: recorded 2, planned 3",
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
        assert_eq!(said(Tolerance::Within(1e-9), change), "Equal");
        assert!(
            said(Tolerance::Within(0.99e-9), change).starts_with("answer 1, sample 1, velocity[0]")
        );
        let turned = |planned: &mut Trajectory| {
            let Curve::Arc { start_angle, .. } = &mut planned.legs[0].curve else { unreachable!() };
            *start_angle += TAU;
        };
        assert_eq!(said(Tolerance::Within(1e-12), turned), "Equal");
        assert!(said(Tolerance::Exact, turned).starts_with("answer 1, leg 0, start_angle"));
        let signed = |planned: &mut Trajectory| planned.samples[0].t = -0.0;
        assert_eq!(said(Tolerance::Within(0.0), signed), "Equal");
        let nan = |planned: &mut Trajectory| planned.samples[1].t = f64::NAN;
        assert!(said(Tolerance::Within(1e9), nan).contains("planned NaN (0x7ff8000000000000)"));
    }

    #[test]
    fn refusals_are_compared_by_their_numbers() {
        let (one, other) = (reply(Err(refusal(2.5))), reply(Err(refusal(2.75))));
        let Outcome::Different(difference) = compare(&one, &other, Tolerance::Exact) else {
            panic!("they differ");
        };
        assert_eq!(difference.place.to_string(), "error.needs");
        assert_eq!(compare(&one, &other, Tolerance::Within(0.25)), Outcome::Equal);
    }

    #[test]
    fn a_refusal_in_place_of_a_trajectory_is_quoted() {
        let planned = reply(Err(refusal(2.5)));
        let Outcome::Different(difference) = compare(&whole(), &planned, Tolerance::Exact) else {
            panic!("they differ");
        };
        assert_eq!(
            difference.to_string(),
            "answers: recorded 2 answers, planned a refusal (JunctionTooSmall: needs 2.5 m)"
        );
    }

    #[test]
    fn refusals_of_the_hour_are_not_repeatable() {
        let late = || Refusal::new(ErrorCode::DeadlineExceeded, "too late");
        assert_eq!(
            compare(&reply(Err(late())), &whole(), Tolerance::Exact),
            Outcome::NotRepeatable
        );
        let one_late = reply(Ok(vec![Err(late()), Ok(trajectory())]));
        assert_eq!(compare(&one_late, &whole(), Tolerance::Exact), Outcome::Equal);
    }

    #[test]
    fn numbers_have_17_digits() {
        let check = |value: f64, expected: &str| {
            assert_eq!(digits(value), expected);
            assert_eq!(expected.parse::<f64>().unwrap().to_bits(), value.to_bits());
        };
        check(7.40323366632768, "7.4032336663276803");
        check(-1234.5, "-1234.5000000000000");
        check(1e-5, "0.000010000000000000001");
        check(1e-6, "9.9999999999999995e-7");
        check(1e300, "1.0000000000000001e300");
        check(f64::INFINITY, "inf");
    }
}
