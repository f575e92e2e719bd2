//! Parts that no translation takes out.

use planning::translation::{Demand, Narrow, NoWay};
use schemas::message::{ErrorCode, Refusal};

use super::refused::Refused;
use super::words::{Axes, Short, letter};

/// A gap for each junction, where there are none.
pub(crate) fn no_junctions(field: String, has: usize) -> Refusal {
    let message = format!(
        "{field} gives {has} gaps, one per junction; there are no junctions between slanted \
         solids, so give one gap"
    );
    Refusal { has: Some(has as f64), needs: Some(1.0), ..Refusal::invalid(field, message) }
}

pub(crate) fn no_way<const D: usize>(
    axes: &Axes,
    field: String,
    wish: Demand<D>,
    error: NoWay<D>,
) -> Refused {
    let outside = |message| Refusal::new(ErrorCode::BodyOutsideFreeSpace, message);
    match error {
        NoWay::Spent(spent) => spent.into(),
        NoWay::Overlap { solid, out } => {
            let field = Some(format!("free_space.solids[{solid}]"));
            let refusal = match out {
                Some(out) => {
                    let depth = out.norm();
                    let message = format!(
                        "the body reaches {} m into solid {solid}; at most 0 m is allowed",
                        Short(depth)
                    );
                    let axis = Some(axes[out.iamax()]);
                    Refusal { axis, has: Some(depth), ..outside(message) }
                }
                None => outside(format!("the body is inside solid {solid}; it must be outside")),
            };
            Refused::Request(Refusal { field, most: Some(0.0), ..refusal })
        }
        NoWay::OutOfBounds { axis, side, end } => {
            let letter = letter(axes, axis);
            let message = format!(
                "the body reaches outside the bounds: they end at {letter} = {} m, but it reaches \
                 {letter} = {} m",
                Short(end),
                Short(side)
            );
            let (needs, has) = (Some(side), Some(end));
            Refused::Request(Refusal { axis: Some(axes[axis]), needs, has, ..outside(message) })
        }
        NoWay::TooMuch { part } => {
            let (axis, asked) = match wish {
                Demand::Gap(gap) => (Some(axes[gap.imax()]), gap.max()),
                Demand::AtLeast(asked) | Demand::MoreThan(asked) => (None, asked),
                Demand::Part(part) => (None, part),
            };
            let most = asked * part;
            let message = format!(
                "no route with a gap of {} m; it must be less than {} m",
                Short(asked),
                Short(most)
            );
            Refused::Answer(Refusal {
                field: Some(field),
                axis,
                has: Some(asked),
                least: Some(0.0),
                most: Some(most),
                ..Refusal::new(ErrorCode::GapOutOfRange, message)
            })
        }
        NoWay::Closed(None) => {
            let message = "no route: no translation leads out".to_owned();
            Refused::Request(Refusal::new(ErrorCode::NoRoute, message))
        }
        NoWay::Closed(Some(Narrow { solid, across, needs, has, is_for_piece })) => {
            let [body, it] = if is_for_piece {
                [" of a convex piece of the body, moved alone,", "this piece"]
            } else {
                ["", "the body"]
            };
            let message = format!(
                "no route: the widest way{body} leads through a passage beside solid {solid} that \
                 is {} m wide across ({}, {}); {it} is {} m wide there",
                Short(has),
                Short(across.x),
                Short(across.y),
                Short(needs)
            );
            let refusal = Refusal::new(ErrorCode::NoRoute, message);
            Refused::Request(Refusal { needs: Some(needs), has: Some(has), ..refusal })
        }
    }
}
