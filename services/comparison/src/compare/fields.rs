//! Field by field. No `..` in these patterns: a field that is left out is never compared.

use std::f64::consts::TAU;
use std::fmt;

use schemas::message::{
    Answer, Axis, AxisBox, Clearance, Curve, Leg, Refusal, Reply, Sample, Trajectory, Vector,
};

use super::number::digits;
use super::{Difference, FieldPath, Tolerance, is_not_repeatable};

/// `Err` is the first difference.
type Compared = Result<(), Box<Difference>>;

/// Where in the replies the comparison is.
pub(super) struct Comparer<'a> {
    tolerance: Tolerance,
    /// Counts refusals whose messages differ.
    reworded: &'a mut usize,
    answer: Option<usize>,
    item: Option<(&'static str, usize)>,
}

impl<'a> Comparer<'a> {
    pub(super) fn new(tolerance: Tolerance, reworded: &'a mut usize) -> Self {
        Self { tolerance, reworded, answer: None, item: None }
    }

    #[cold]
    fn differ(
        &self,
        field: &str,
        [recorded, planned]: [String; 2],
        distance: Option<f64>,
    ) -> Compared {
        let path = FieldPath { answer: self.answer, item: self.item, field: field.to_owned() };
        Err(Box::new(Difference { path, recorded, planned, distance }))
    }

    fn same<T: PartialEq + fmt::Display>(&self, field: &str, recorded: T, planned: T) -> Compared {
        if recorded == planned {
            return Ok(());
        }
        self.differ(field, [recorded, planned].map(|value| value.to_string()), None)
    }

    fn optional<T: PartialEq + fmt::Display>(
        &self,
        field: &str,
        recorded: Option<T>,
        planned: Option<T>,
    ) -> Compared {
        self.named(field, recorded, planned, |value| value.to_string())
    }

    /// An optional value that is shown by its name.
    fn named<T: PartialEq>(
        &self,
        field: &str,
        recorded: Option<T>,
        planned: Option<T>,
        name: impl Fn(T) -> String,
    ) -> Compared {
        if recorded == planned {
            return Ok(());
        }
        let text = |value: Option<T>| value.map_or("none".to_owned(), &name);
        self.differ(field, [recorded, planned].map(text), None)
    }

    /// A field that older recordings do not have: compared only if the recording has it.
    fn added<T: PartialEq + fmt::Display>(
        &self,
        field: &str,
        recorded: Option<T>,
        planned: Option<T>,
    ) -> Compared {
        if recorded.is_none() { Ok(()) } else { self.optional(field, recorded, planned) }
    }

    /// As [`Comparer::added`], for a number.
    fn added_number(&self, field: &str, recorded: Option<f64>, planned: Option<f64>) -> Compared {
        if recorded.is_none() { Ok(()) } else { self.optional_number(field, recorded, planned) }
    }

    fn number(&self, field: &str, recorded: f64, planned: f64) -> Compared {
        self.distance(field, recorded, planned, (recorded - planned).abs())
    }

    fn optional_number(
        &self,
        field: &str,
        recorded: Option<f64>,
        planned: Option<f64>,
    ) -> Compared {
        match (recorded, planned) {
            (Some(recorded), Some(planned)) => self.number(field, recorded, planned),
            (recorded, planned) => self.named(field, recorded, planned, digits),
        }
    }

    /// Numbers that are equal when they are a whole turn apart.
    fn angle(&self, field: &str, recorded: f64, planned: f64) -> Compared {
        let turned = (recorded - planned).rem_euclid(TAU);
        self.distance(field, recorded, planned, turned.min(TAU - turned))
    }

    fn distance(&self, field: &str, recorded: f64, planned: f64, distance: f64) -> Compared {
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

    fn numbers(&self, field: &str, recorded: [f64; 3], planned: [f64; 3]) -> Compared {
        for (index, (recorded, planned)) in recorded.into_iter().zip(planned).enumerate() {
            if recorded.to_bits() != planned.to_bits() {
                self.number(&format!("{field}[{index}]"), recorded, planned)?;
            }
        }
        Ok(())
    }

    fn vector(&self, field: &str, recorded: Vector, planned: Vector) -> Compared {
        self.numbers(field, recorded.padded(), planned.padded())?;
        let coordinates = format!("{field}, number of coordinates");
        self.same(&coordinates, recorded.dimension(), planned.dimension())
    }

    /// Element by element, then the lengths: if one list is longer, a difference among the
    /// common elements comes first.
    fn list<T>(
        &mut self,
        [singular, plural]: [&'static str; 2],
        [recorded, planned]: [&[T]; 2],
        compare: impl Fn(&Self, &T, &T) -> Compared,
    ) -> Compared {
        for (index, (one, other)) in recorded.iter().zip(planned).enumerate() {
            self.item = Some((singular, index));
            compare(self, one, other)?;
        }
        self.item = None;
        self.same(&format!("number of {plural}"), recorded.len(), planned.len())
    }

    pub(super) fn replies(mut self, recorded: &Reply, planned: &Reply) -> Compared {
        let Reply { key, id, answers } = recorded;
        let Reply { key: planned_key, id: planned_id, answers: planned_answers } = planned;
        self.same("key", key, planned_key)?;
        self.optional("id", *id, *planned_id)?;
        let count = |answers: &[Answer]| format!("{} answers", answers.len());
        match (answers, planned_answers) {
            (Ok(recorded), Ok(planned)) => {
                for (index, (one, other)) in recorded.iter().zip(planned).enumerate() {
                    if !one.as_ref().is_err_and(is_not_repeatable) {
                        self.answer = Some(index);
                        self.answers(one, other)?;
                    }
                }
                self.answer = None;
                self.same("number of answers", recorded.len(), planned.len())
            }
            (Err(recorded), Err(planned)) => self.refusals(recorded, planned),
            (Ok(recorded), Err(planned)) => {
                self.differ("answers", [count(recorded), brief(planned)], None)
            }
            (Err(recorded), Ok(planned)) => {
                self.differ("answers", [brief(recorded), count(planned)], None)
            }
        }
    }

    fn answers(&mut self, recorded: &Answer, planned: &Answer) -> Compared {
        let trajectory = || "a trajectory".to_owned();
        match (recorded, planned) {
            (Ok(recorded), Ok(planned)) => self.trajectories(recorded, planned),
            (Err(recorded), Err(planned)) => self.refusals(recorded, planned),
            (Ok(_), Err(planned)) => self.differ("answer", [trajectory(), brief(planned)], None),
            (Err(recorded), Ok(_)) => self.differ("answer", [brief(recorded), trajectory()], None),
        }
    }

    fn refusals(&mut self, recorded: &Refusal, planned: &Refusal) -> Compared {
        let Refusal {
            code,
            message,
            field,
            junction,
            axis,
            needs,
            has,
            least,
            most,
            heading,
            setting,
        } = recorded;
        self.same("error.code", *code, planned.code)?;
        self.optional("error.field", field.as_deref(), planned.field.as_deref())?;
        self.optional("error.junction", *junction, planned.junction)?;
        self.named("error.axis", *axis, planned.axis, axis_name)?;
        self.optional_number("error.needs", *needs, planned.needs)?;
        self.optional_number("error.has", *has, planned.has)?;
        self.optional_number("error.least", *least, planned.least)?;
        self.optional_number("error.most", *most, planned.most)?;
        self.optional_number("error.heading", *heading, planned.heading)?;
        self.added("error.setting", setting.as_deref(), planned.setting.as_deref())?;
        *self.reworded += usize::from(*message != planned.message);
        Ok(())
    }

    fn trajectories(&mut self, recorded: &Trajectory, planned: &Trajectory) -> Compared {
        let Trajectory {
            dimension,
            gaps_per_junction,
            exit,
            length,
            bound,
            complete,
            duration,
            clearance,
            free_clearance,
            gaps,
            route,
            channels,
            legs,
            samples,
        } = recorded;
        self.same("dimension", *dimension, planned.dimension)?;
        self.same("gaps_per_junction", *gaps_per_junction, planned.gaps_per_junction)?;
        self.optional("exit", *exit, planned.exit)?;
        self.number("length", *length, planned.length)?;
        self.added_number("bound", *bound, planned.bound)?;
        self.same("complete", *complete, planned.complete)?;
        self.number("duration", *duration, planned.duration)?;
        self.clearances(clearance, &planned.clearance)?;
        self.added_number("free_clearance", *free_clearance, planned.free_clearance)?;
        self.list(["gap", "gaps"], [gaps, &planned.gaps], |at, one, other| {
            at.number("value", *one, *other)
        })?;
        let names = ["route", "channels in the route"];
        self.list(names, [route, &planned.route], |at, one, other| at.same("channel", one, other))?;
        self.list(["channel", "channels"], [channels, &planned.channels], Self::boxes)?;
        self.list(["leg", "legs"], [legs, &planned.legs], Self::legs)?;
        self.list(["sample", "samples"], [samples, &planned.samples], Self::samples)
    }

    fn clearances(&self, recorded: &Clearance, planned: &Clearance) -> Compared {
        let Clearance { value, at, wall } = *recorded;
        self.number("clearance.value", value, planned.value)?;
        self.number("clearance.at", at, planned.at)?;
        self.vector("clearance.wall", wall, planned.wall)
    }

    fn boxes(&self, recorded: &AxisBox, planned: &AxisBox) -> Compared {
        let AxisBox { min, max } = *recorded;
        self.vector("min", min, planned.min)?;
        self.vector("max", max, planned.max)
    }

    fn legs(&self, recorded: &Leg, planned: &Leg) -> Compared {
        let Leg { curve, length, clearance, junction, rule, reverse, rung } = *recorded;
        self.curves(curve, planned.curve)?;
        self.number("length", length, planned.length)?;
        self.number("clearance", clearance, planned.clearance)?;
        self.optional("junction", junction, planned.junction)?;
        self.optional("rule", rule, planned.rule)?;
        self.same("reverse", reverse, planned.reverse)?;
        self.added("rung", rung, planned.rung)
    }

    fn curves(&self, recorded: Curve, planned: Curve) -> Compared {
        use Curve::{Arc, Line, Turn};
        match (recorded, planned) {
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
            (recorded, planned) => self.same("kind", recorded.kind(), planned.kind()),
        }
    }

    fn samples(&self, recorded: &Sample, planned: &Sample) -> Compared {
        let Sample { t, position, heading, velocity, yaw_rate } = *recorded;
        self.number("t", t, planned.t)?;
        self.numbers("position", position, planned.position)?;
        self.angle("heading", heading, planned.heading)?;
        self.numbers("velocity", velocity, planned.velocity)?;
        self.number("yaw_rate", yaw_rate, planned.yaw_rate)
    }
}

fn brief(refusal: &Refusal) -> String {
    format!("a refusal ({}: {})", refusal.code, refusal.message)
}

fn axis_name(axis: u32) -> String {
    Axis::ALL.get(axis as usize).map_or_else(|| format!("axis {axis}"), Axis::to_string)
}
