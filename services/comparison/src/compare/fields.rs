//! Field by field. No `..` in these patterns: a field that is left out is never compared.

use std::fmt;

use schemas::message::{
    Answer, Axis, AxisBox, Clearance, Curve, Exceeds, Leg, Refusal, Reply, Sample, Trajectory,
    Vector,
};

use super::number::digits;
use super::{Difference, FieldPath, depends_on_load};
use crate::motion::{apart, turned};
use crate::tolerance::{Quantity, Tolerance};

/// `Err` is the first difference beyond tolerance.
type Compared = Result<(), Box<Difference>>;

/// Where in the replies the comparison is.
pub(super) struct Comparer<'a> {
    tolerance: &'a Tolerance,
    /// The answer, if it is about one.
    answer: Option<usize>,
    item: Option<(&'static str, usize)>,
    /// Refusals whose messages differ.
    pub(super) reworded: usize,
    /// The first difference within tolerance.
    pub(super) within: Option<Box<Difference>>,
}

impl<'a> Comparer<'a> {
    pub(super) fn new(tolerance: &'a Tolerance, answer: Option<usize>) -> Self {
        Self { tolerance, answer, item: None, reworded: 0, within: None }
    }

    fn difference(
        &self,
        field: &str,
        [recorded, planned]: [String; 2],
        distance: Option<f64>,
    ) -> Box<Difference> {
        let path = FieldPath { answer: self.answer, item: self.item, field: field.to_owned() };
        Box::new(Difference { path, recorded, planned, distance })
    }

    #[cold]
    fn differ(&self, field: &str, texts: [String; 2], distance: Option<f64>) -> Compared {
        Err(self.difference(field, texts, distance))
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
    fn added_number(
        &mut self,
        quantity: Quantity,
        field: &str,
        recorded: Option<f64>,
        planned: Option<f64>,
    ) -> Compared {
        match recorded {
            None => Ok(()),
            Some(_) => self.optional_number(quantity, field, recorded, planned),
        }
    }

    fn number(&mut self, quantity: Quantity, field: &str, recorded: f64, planned: f64) -> Compared {
        self.distance(quantity, field, [recorded, planned], (recorded - planned).abs())
    }

    fn optional_number(
        &mut self,
        quantity: Quantity,
        field: &str,
        recorded: Option<f64>,
        planned: Option<f64>,
    ) -> Compared {
        match (recorded, planned) {
            (Some(recorded), Some(planned)) => self.number(quantity, field, recorded, planned),
            (recorded, planned) => self.named(field, recorded, planned, digits),
        }
    }

    /// Numbers that are equal when they are a whole turn apart.
    fn angle(&mut self, field: &str, recorded: f64, planned: f64) -> Compared {
        let distance = turned(recorded, planned);
        self.distance(Quantity::Heading, field, [recorded, planned], distance)
    }

    fn distance(
        &mut self,
        quantity: Quantity,
        field: &str,
        [recorded, planned]: [f64; 2],
        distance: f64,
    ) -> Compared {
        if recorded.to_bits() == planned.to_bits() {
            return Ok(());
        }
        let within = self
            .tolerance
            .of(quantity)
            .is_some_and(|most| distance <= most || (recorded.is_nan() && planned.is_nan()));
        if within && self.within.is_some() {
            return Ok(());
        }
        let apart = (recorded - planned).abs();
        let difference = self.difference(field, [recorded, planned].map(digits), Some(apart));
        if within {
            self.within = Some(difference);
            return Ok(());
        }
        Err(difference)
    }

    /// Coordinates. If the quantity has a tolerance of its own, the distance of the points counts;
    /// otherwise each coordinate does.
    fn numbers(
        &mut self,
        quantity: Quantity,
        field: &str,
        recorded: [f64; 3],
        planned: [f64; 3],
    ) -> Compared {
        if recorded.map(f64::to_bits) == planned.map(f64::to_bits) {
            return Ok(());
        }
        let own = self.tolerance.own(quantity);
        let is_beyond = own.is_some_and(|most| apart(recorded, planned) > most);
        let pairs = recorded.into_iter().zip(planned).enumerate();
        if is_beyond {
            // Each coordinate alone may be within: the one that is farthest off stands for all.
            let off = |(_, (one, other)): &(usize, (f64, f64))| (one - other).abs();
            let farthest = pairs.max_by(|one, other| off(one).total_cmp(&off(other)));
            let (index, (recorded, planned)) = farthest.expect("there are three");
            let apart = Some((recorded - planned).abs());
            let name = format!("{field}[{index}]");
            return self.differ(&name, [recorded, planned].map(digits), apart);
        }
        for (index, (recorded, planned)) in pairs {
            if recorded.to_bits() != planned.to_bits() {
                self.number(quantity, &format!("{field}[{index}]"), recorded, planned)?;
            }
        }
        Ok(())
    }

    /// A point.
    fn vector(&mut self, field: &str, recorded: Vector, planned: Vector) -> Compared {
        self.numbers(Quantity::Position, field, recorded.padded(), planned.padded())?;
        let coordinates = format!("{field}, number of coordinates");
        self.same(&coordinates, recorded.dimension(), planned.dimension())
    }

    /// Element by element, then the lengths: if one list is longer, a difference among the
    /// common elements comes first.
    fn list<T>(
        &mut self,
        [singular, plural]: [&'static str; 2],
        [recorded, planned]: [&[T]; 2],
        compare: impl Fn(&mut Self, &T, &T) -> Compared,
    ) -> Compared {
        for (index, (one, other)) in recorded.iter().zip(planned).enumerate() {
            self.item = Some((singular, index));
            compare(self, one, other)?;
        }
        self.item = None;
        self.same(&format!("number of {plural}"), recorded.len(), planned.len())
    }

    /// Everything of two replies but their answers.
    pub(super) fn replies(&mut self, recorded: &Reply, planned: &Reply) -> Compared {
        let Reply { key, id, answers } = recorded;
        let Reply { key: planned_key, id: planned_id, answers: planned_answers } = planned;
        self.same("key", key, planned_key)?;
        self.optional("id", *id, *planned_id)?;
        let count = |answers: &[Answer]| format!("{} answers", answers.len());
        match (answers, planned_answers) {
            (Ok(_), Ok(_)) => Ok(()),
            (Err(recorded), Err(planned)) => self.refusals(recorded, planned),
            (Ok(recorded), Err(planned)) => {
                self.differ("answers", [count(recorded), brief(planned)], None)
            }
            (Err(recorded), Ok(planned)) => {
                self.differ("answers", [brief(recorded), count(planned)], None)
            }
        }
    }

    /// How many answers there are.
    pub(super) fn counts(&self, recorded: usize, planned: usize) -> Compared {
        self.same("number of answers", recorded, planned)
    }

    pub(super) fn answers(&mut self, recorded: &Answer, planned: &Answer) -> Compared {
        let trajectory = || "a trajectory".to_owned();
        match (recorded, planned) {
            (Err(recorded), _) if depends_on_load(recorded) => Ok(()),
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
        self.optional_number(Quantity::Refusal, "error.needs", *needs, planned.needs)?;
        self.optional_number(Quantity::Refusal, "error.has", *has, planned.has)?;
        self.optional_number(Quantity::Refusal, "error.least", *least, planned.least)?;
        self.optional_number(Quantity::Refusal, "error.most", *most, planned.most)?;
        self.optional_number(Quantity::Heading, "error.heading", *heading, planned.heading)?;
        self.added("error.setting", setting.as_deref(), planned.setting.as_deref())?;
        self.reworded += usize::from(*message != planned.message);
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
            exceeds,
            stops,
        } = recorded;
        self.same("dimension", *dimension, planned.dimension)?;
        self.same("gaps_per_junction", *gaps_per_junction, planned.gaps_per_junction)?;
        self.optional("exit", *exit, planned.exit)?;
        self.number(Quantity::Length, "length", *length, planned.length)?;
        self.added_number(Quantity::Length, "bound", *bound, planned.bound)?;
        self.same("complete", *complete, planned.complete)?;
        if let Some(Exceeds { limit, joints, jump }) = exceeds {
            let other = planned.exceeds.as_ref();
            self.optional("exceeds.limit", Some(*limit), other.map(|other| other.limit))?;
            self.optional("exceeds.joints", Some(*joints), other.map(|other| other.joints))?;
            let other = other.map(|other| other.jump);
            self.optional_number(Quantity::YawRate, "exceeds.jump", Some(*jump), other)?;
        }
        self.added("stops", *stops, planned.stops)?;
        self.number(Quantity::Time, "duration", *duration, planned.duration)?;
        self.clearances(clearance, &planned.clearance)?;
        self.added_number(
            Quantity::Clearance,
            "free_clearance",
            *free_clearance,
            planned.free_clearance,
        )?;
        self.list(["gap", "gaps"], [gaps, &planned.gaps], |at, one, other| {
            at.number(Quantity::Gap, "value", *one, *other)
        })?;
        let names = ["route", "channels in the route"];
        self.list(names, [route, &planned.route], |at, one, other| at.same("channel", one, other))?;
        self.list(["channel", "channels"], [channels, &planned.channels], Self::boxes)?;
        self.list(["leg", "legs"], [legs, &planned.legs], Self::legs)?;
        self.list(["sample", "samples"], [samples, &planned.samples], Self::samples)
    }

    fn clearances(&mut self, recorded: &Clearance, planned: &Clearance) -> Compared {
        let Clearance { value, at, wall } = *recorded;
        self.number(Quantity::Clearance, "clearance.value", value, planned.value)?;
        self.number(Quantity::Length, "clearance.at", at, planned.at)?;
        self.vector("clearance.wall", wall, planned.wall)
    }

    fn boxes(&mut self, recorded: &AxisBox, planned: &AxisBox) -> Compared {
        let AxisBox { min, max } = *recorded;
        self.vector("min", min, planned.min)?;
        self.vector("max", max, planned.max)
    }

    fn legs(&mut self, recorded: &Leg, planned: &Leg) -> Compared {
        let Leg { curve, length, clearance, junction, rule, reverse, rung } = *recorded;
        self.curves(curve, planned.curve)?;
        self.number(Quantity::Length, "length", length, planned.length)?;
        self.number(Quantity::Clearance, "clearance", clearance, planned.clearance)?;
        self.optional("junction", junction, planned.junction)?;
        self.optional("rule", rule, planned.rule)?;
        self.same("reverse", reverse, planned.reverse)?;
        self.added("rung", rung, planned.rung)
    }

    fn curves(&mut self, recorded: Curve, planned: Curve) -> Compared {
        use Curve::{Arc, Clothoid, Line, Turn};
        match (recorded, planned) {
            (
                Line { from, to, heading, turned },
                Line { from: f, to: t, heading: h, turned: s },
            ) => {
                self.vector("from", from, f)?;
                self.vector("to", to, t)?;
                self.angle("heading", heading, h)?;
                self.number(Quantity::Heading, "turned", turned, s)
            }
            (
                Arc { center, radius, start_angle, sweep },
                Arc { center: c, radius: r, start_angle: a, sweep: s },
            ) => {
                self.vector("center", center, c)?;
                self.number(Quantity::Position, "radius", radius, r)?;
                self.angle("start_angle", start_angle, a)?;
                self.number(Quantity::Heading, "sweep", sweep, s)
            }
            (
                Turn { position, from_heading, to_heading, sweep },
                Turn { position: p, from_heading: f, to_heading: t, sweep: s },
            ) => {
                self.vector("position", position, p)?;
                self.angle("from_heading", from_heading, f)?;
                self.angle("to_heading", to_heading, t)?;
                self.number(Quantity::Heading, "sweep", sweep, s)
            }
            (
                Clothoid { from, to, from_heading, to_heading, curvatures, length },
                Clothoid {
                    from: f,
                    to: t,
                    from_heading: h,
                    to_heading: e,
                    curvatures: c,
                    length: l,
                },
            ) => {
                self.vector("from", from, f)?;
                self.vector("to", to, t)?;
                self.angle("from_heading", from_heading, h)?;
                self.angle("to_heading", to_heading, e)?;
                self.number(Quantity::YawRate, "start_curvature", curvatures[0], c[0])?;
                self.number(Quantity::YawRate, "end_curvature", curvatures[1], c[1])?;
                self.number(Quantity::Length, "length", length, l)
            }
            (recorded, planned) => self.same("kind", recorded.kind(), planned.kind()),
        }
    }

    fn samples(&mut self, recorded: &Sample, planned: &Sample) -> Compared {
        let Sample { t, position, heading, velocity, yaw_rate } = *recorded;
        self.number(Quantity::Time, "t", t, planned.t)?;
        self.numbers(Quantity::Position, "position", position, planned.position)?;
        self.angle("heading", heading, planned.heading)?;
        self.numbers(Quantity::Speed, "velocity", velocity, planned.velocity)?;
        self.number(Quantity::YawRate, "yaw_rate", yaw_rate, planned.yaw_rate)
    }
}

fn brief(refusal: &Refusal) -> String {
    format!("a refusal ({}: {})", refusal.code, refusal.message)
}

fn axis_name(axis: u32) -> String {
    Axis::ALL.get(axis as usize).map_or_else(|| format!("axis {axis}"), Axis::to_string)
}
