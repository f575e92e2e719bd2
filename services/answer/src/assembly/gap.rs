//! The gap that a request wishes for.

use planning::budget::Budget;
use planning::disassembly;
use planning::geometry::Vector;
use schemas::message::{Gap, Refusal, Task};

use crate::check;
use crate::refuse::Refused;
use crate::wish::{Gaps, Wish};

/// The gap that is wished for; a gap per junction in `memory`.
pub(super) fn gap_of<'m, const D: usize>(
    wish: &Wish<'_>,
    memory: &'m mut Vec<Vector<D>>,
    budget: &Budget<'_>,
) -> Result<disassembly::Gap<'m, D>, Refused> {
    Ok(match wish.gaps {
        Gaps::Same(Gap::Uniform(gap)) => disassembly::Gap::Uniform(gap),
        Gaps::Same(gap) => disassembly::Gap::PerAxis(per_axis(&gap, || wish.field())?),
        Gaps::Fraction(fraction) => disassembly::Gap::Fraction(fraction),
        Gaps::AtLeast(_) => return Err(check::stray_field(wish.field(), Task::Disassemble).into()),
        Gaps::Each(gaps) => {
            budget.step(gaps.len() as u64)?;
            memory.clear();
            for (junction, gap) in gaps.iter().enumerate() {
                memory.push(per_axis(gap, || format!("{}[{junction}]", wish.field()))?);
            }
            disassembly::Gap::PerJunction(memory)
        }
    })
}

fn per_axis<const D: usize>(
    gap: &Gap,
    field: impl FnOnce() -> String,
) -> Result<Vector<D>, Refusal> {
    match gap {
        Gap::Uniform(gap) => Ok(Vector::repeat(*gap)),
        Gap::PerAxis(gaps) if gaps.dimension() == D => Ok(check::vector(gaps)),
        Gap::PerAxis(gaps) => Err(check::gaps_per_axis(field(), gaps.dimension(), D)),
    }
}
