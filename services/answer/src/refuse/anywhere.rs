//! Robots among walls at any angle that can't be driven as asked.

use planning::any_angle::{Errand, NoMotion, Resolution, Wish};
use planning::geometry::Vector;
use schemas::message::{ErrorCode, Refusal};

use super::refused::Refused;
use super::words::{FLOOR, Short, letter};

/// A gap for each junction, where the junctions depend on the route.
pub(crate) fn gap_per_junction(field: String, has: usize) -> Refusal {
    let message = format!(
        "{field} gives {has} gaps, one per junction; the junctions depend on the route here, so \
         give one gap"
    );
    Refusal { has: Some(has as f64), needs: Some(1.0), ..Refusal::invalid(field, message) }
}

/// A start or a goal out of bounds: along which axis, where they end, and where it is.
pub(crate) fn out_of_bounds(
    code: ErrorCode,
    field: &str,
    (axis, ends, at): (usize, f64, f64),
) -> Refusal {
    let letter = letter(&FLOOR, axis);
    let message = format!(
        "{field} is outside free_space.bounds: they end at {letter} = {} m, but it is at \
         {letter} = {} m",
        Short(ends),
        Short(at)
    );
    let refusal = Refusal { field: Some(field.to_owned()), ..Refusal::new(code, message) };
    Refusal { axis: Some(FLOOR[axis]), needs: Some(at), has: Some(ends), ..refusal }
}

/// A start or a goal inside a solid.
pub(crate) fn in_solid(code: ErrorCode, field: &str, solid: usize, depth: f64) -> Refusal {
    let message = format!(
        "{field} is inside solid {solid}, {} m from its nearest side; it must be outside",
        Short(depth)
    );
    let refusal = Refusal::new(code, message);
    let field = Some(format!("free_space.solids[{solid}]"));
    Refusal { field, has: Some(depth), most: Some(0.0), ..refusal }
}

pub(crate) fn no_motion(
    field: String,
    errand: &Errand<'_>,
    wish: Wish,
    error: NoMotion,
) -> Refused {
    let asked = match wish {
        Wish::Gap(gap) | Wish::AtLeast(gap) => gap,
        Wish::Safest => 0.0,
    };
    let (refusal, whole) = match error {
        NoMotion::Spent(spent) => return spent.into(),
        NoMotion::Occupied { at_goal, wall } => {
            let (code, ends) = match at_goal {
                false => (ErrorCode::BodyOutsideFreeSpace, "start: the robot touches"),
                true => (ErrorCode::GoalOutsideFreeSpace, "goal: the robot would touch"),
            };
            (Refusal::new(code, format!("{ends} the wall at {}", Place(wall))), true)
        }
        NoMotion::Enclosed { at_goal, across: [one, other], thickness } => {
            let end = if at_goal { "goal" } else { "start" };
            let message = format!(
                "no route: walls enclose the {end}; they are thinnest from {} to {}, {} m, and an \
                 opening there must be wider than {} m",
                Place(one),
                Place(other),
                Short(thickness),
                Short(errand.footprint.width())
            );
            let refusal = Refusal::new(ErrorCode::NoRoute, message);
            // No negative zero.
            let has = Some(0.0 - thickness + 0.0);
            (Refusal { needs: Some(0.0), has, ..refusal }, true)
        }
        NoMotion::TooNarrow { across: [one, other], has, needs } => {
            let width = errand.footprint.width();
            let passage = format!(
                "no route: the widest way leads between {} and {}, which are {} m apart",
                Place(one),
                Place(other),
                Short(has)
            );
            if has > width && asked > 0.0 {
                let most = (has - width) / 2.0;
                let message = format!(
                    "{passage}; the robot is {} m wide, so the gap must be less than {} m, not {} m",
                    Short(width),
                    Short(most),
                    Short(asked)
                );
                let refusal = Refusal {
                    field: Some(field),
                    has: Some(asked),
                    least: Some(0.0),
                    most: Some(most),
                    ..Refusal::new(ErrorCode::GapOutOfRange, message)
                };
                (refusal, false)
            } else {
                let message = format!("{passage}; the robot needs more than {} m", Short(needs));
                let refusal = Refusal {
                    needs: Some(needs),
                    has: Some(has),
                    ..Refusal::new(ErrorCode::NoRoute, message)
                };
                (refusal, has <= width)
            }
        }
        NoMotion::Blocked { wall, turning, reverse_helps, resolution } => {
            let (code, does) = match turning {
                true => (ErrorCode::TurnBlocked, "turns"),
                false => (ErrorCode::WallInTheWay, "drives"),
            };
            let at = resolution.map_or_else(String::new, |resolution| {
                let Resolution { step, headings, is_cut_short } = resolution;
                let limit = if is_cut_short { " before the search met its limit" } else { "" };
                format!(" with steps of {} m and {headings} headings{limit}", Short(step))
            });
            let remedy = if reverse_helps { "; \"reverse\": true would do" } else { "" };
            let message = format!(
                "the robot would touch the wall at {} where it {does}, and no other way was \
                 found{at}{remedy}",
                Place(wall)
            );
            (Refusal { needs: Some(0.0), has: Some(0.0), ..Refusal::new(code, message) }, false)
        }
    };
    Refused::new(refusal, whole)
}

/// A point as people read it.
struct Place(Vector<2>);

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({}, {})", Short(self.0.x), Short(self.0.y))
    }
}
