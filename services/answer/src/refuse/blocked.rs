//! What blocks the way between solids.

use std::fmt;

use planning::free_space::solids::Solids;
use planning::geometry::AxisBox;
use planning::route::{Blocked, Passage, Region};
use schemas::message::{ErrorCode, Refusal};

use super::refused::Refused;
use super::words::{Axes, Others, Short, at_junction, letter};

/// A point with its axes' names.
struct At<'a>(&'a Axes, &'a [f64]);

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (coordinate, value) in self.1.iter().enumerate() {
            let before = if coordinate == 0 { "(" } else { ", " };
            write!(f, "{before}{} {}", letter(self.0, coordinate), Short(*value))?;
        }
        f.write_str(")")
    }
}

/// From where to where a place is.
struct Of<'a, const D: usize>(&'a Axes, &'a Region<D>);

impl<const D: usize> fmt::Display for Of<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(axes, Region { min, max }) = self;
        write!(f, "from {} to {}", At(axes, min.as_slice()), At(axes, max.as_slice()))
    }
}

/// `None` where there is nothing to name.
pub(crate) fn blocked<const D: usize>(
    axes: &Axes,
    blocked: &Blocked<D>,
    solids: &Solids<D>,
    bounds: &AxisBox<D>,
) -> Option<Refused> {
    let no_route = |message| Refusal::new(ErrorCode::NoRoute, message);
    let refusal = match blocked {
        Blocked::StartTaken(place) => {
            let what = if place.min == place.max {
                "the start lies"
            } else {
                "the body's bounding box reaches"
            };
            taken(axes, what, ErrorCode::BodyOutsideFreeSpace, place, (solids, bounds))?
        }
        Blocked::GoalTaken(place) => {
            let code = ErrorCode::GoalOutsideFreeSpace;
            taken(axes, "the goal lies", code, place, (solids, bounds))?
        }
        Blocked::NarrowStart(passage) => {
            narrow_end(axes, "start", ErrorCode::BodyOutsideFreeSpace, passage)
        }
        Blocked::NarrowGoal(passage) => {
            narrow_end(axes, "goal", ErrorCode::GoalOutsideFreeSpace, passage)
        }
        Blocked::NoRoom(passage) => {
            let message = format!(
                "no route: the free space has no channel larger than the body; {}",
                Narrow(axes, passage, "widest place")
            );
            let (needs, has) = (Some(passage.needs), Some(passage.has));
            Refusal { axis: Some(axes[passage.axis]), needs, has, ..no_route(message) }
        }
        Blocked::Narrow { passage, junction, others } => {
            let Passage { axis, needs, has, .. } = *passage;
            let message = format!(
                "no route: {}{}",
                Narrow(axes, passage, "passage"),
                Others("place", *others)
            );
            at_junction(axes, (*junction, axis), (needs, has), no_route(message))
        }
        Blocked::Wall { place, axis, thickness, needs, junction, others } => {
            let middle = (place.min + place.max) / 2.0;
            let solid = solids.deepest(&middle, &middle);
            let solid = solid.map_or(String::new(), |(solid, ..)| format!(" of solid {solid}"));
            let across = (0..D).filter(|across| across != axis);
            let across = across
                .map(|across| format!("{} m along {}", Short(needs[across]), letter(axes, across)));
            let message = format!(
                "no route: {} a wall{solid}, {} m thick along {}, separates start and end; an \
                 opening through it must be wider than {}{}",
                Of(axes, place),
                Short(*thickness),
                letter(axes, *axis),
                across.collect::<Vec<_>>().join(" and "),
                Others("place", *others)
            );
            // The free extent along the axis is negative: minus the wall's thickness.
            at_junction(axes, (*junction, *axis), (0.0, -thickness), no_route(message))
        }
    };
    Some(Refused::Request(refusal))
}

/// A passage by its name, and how wide it is.
struct Narrow<'a, const D: usize>(&'a Axes, &'a Passage<D>, &'static str);

impl<const D: usize> fmt::Display for Narrow<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(axes, Passage { place, axis, needs, has }, name) = self;
        write!(
            f,
            "the {name} {} is {} m wide along {}, but must be wider than {} m",
            Of(axes, place),
            Short(*has),
            letter(axes, *axis),
            Short(*needs)
        )
    }
}

fn narrow_end<const D: usize>(
    axes: &Axes,
    end: &str,
    code: ErrorCode,
    passage: &Passage<D>,
) -> Refusal {
    let message = format!("no room at the {end}: {}", Narrow(axes, passage, "passage"));
    let (needs, has) = (Some(passage.needs), Some(passage.has));
    Refusal { axis: Some(axes[passage.axis]), needs, has, ..Refusal::new(code, message) }
}

/// A start or goal that lies in a solid or outside the bounds.
fn taken<const D: usize>(
    axes: &Axes,
    what: &str,
    code: ErrorCode,
    place: &Region<D>,
    (solids, bounds): (&Solids<D>, &AxisBox<D>),
) -> Option<Refusal> {
    if let Some((solid, axis, depth)) = solids.deepest(&place.min, &place.max) {
        let message = format!(
            "{what} {} m into solid {solid} along {}; at most 0 m is allowed",
            Short(depth),
            letter(axes, axis)
        );
        let refusal = Refusal {
            field: Some(format!("free_space.solids[{solid}]")),
            axis: Some(axes[axis]),
            has: Some(depth),
            most: Some(0.0),
            ..Refusal::new(code, message)
        };
        return Some(refusal);
    }
    let mut farthest: Option<(f64, usize, f64, f64)> = None;
    for axis in 0..D {
        let (low, high) = (bounds.min()[axis], bounds.max()[axis]);
        let (min, max) = (place.min[axis], place.max[axis]);
        for (outside, side, end) in [(low - min, min, low), (max - high, max, high)] {
            if outside > 0.0 && farthest.is_none_or(|(most, ..)| outside > most) {
                farthest = Some((outside, axis, side, end));
            }
        }
    }
    let (_, axis, side, end) = farthest?;
    let message = format!(
        "{what} outside the bounds: they end at {axis} = {} m, but it is at {axis} = {} m",
        Short(end),
        Short(side),
        axis = letter(axes, axis)
    );
    let refusal = Refusal::new(code, message);
    Some(Refusal { axis: Some(axes[axis]), needs: Some(side), has: Some(end), ..refusal })
}
