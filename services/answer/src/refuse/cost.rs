//! What a request may not cost.

use planning::budget::{Cap, Spent};
use schemas::message::{ErrorCode, Refusal};

use crate::stop::StopReason;

/// Whether the answers that follow have no budget either. Other caps are for one part of the
/// request, or for what is held at a time.
pub(super) fn is_final(spent: &Spent) -> bool {
    matches!(spent, Spent::Stopped | Spent::Limit { cap: Cap::Steps, .. })
}

pub(super) fn spent(spent: Spent, reason: Option<StopReason>) -> Refusal {
    match spent {
        Spent::Limit { cap, most } => too_costly(cap, most),
        Spent::Stopped => reason.unwrap_or(StopReason::Deadline).refusal(),
    }
}

fn too_costly(cap: Cap, most: u64) -> Refusal {
    let (costs, change, field) = match cap {
        Cap::Steps => (
            format!("planning takes more than {most} steps"),
            "ask for fewer answers, or describe the free space with fewer channels or solids",
            None,
        ),
        Cap::Bytes => (
            format!("planning needs more than {most} bytes of memory"),
            "describe the free space with fewer channels or solids",
            None,
        ),
        Cap::Pieces => (
            format!("the solids are cut into more than {most} boxes"),
            "use fewer solids, or fewer slanted edges",
            Some("free_space.solids"),
        ),
        Cap::Channels => (
            format!("the solids leave more than {most} channels"),
            "use fewer solids, or give the channels",
            Some("free_space.solids"),
        ),
        Cap::ChannelSteps => (
            format!("making channels from the solids takes more than {most} steps"),
            "use fewer solids, or give the channels",
            Some("free_space.solids"),
        ),
        Cap::Junctions => (
            format!("the channels have more than {most} junctions"),
            "use fewer channels, or give them in travel order (`in_order`)",
            Some("free_space"),
        ),
        Cap::RouteSteps => (
            format!("finding a route takes more than {most} steps"),
            "use fewer channels or solids, or give the channels in travel order (`in_order`)",
            Some("free_space"),
        ),
    };
    let setting = format!("caps.{}", cap.name());
    let message = format!("{costs} (`{setting}`); {change}");
    Refusal {
        field: field.map(str::to_owned),
        most: Some(most as f64),
        setting: Some(setting),
        ..Refusal::new(ErrorCode::TooCostly, message)
    }
}

/// More of something than a setting allows.
fn over(setting: &str, (needs, most): (u64, u64), refusal: Refusal) -> Refusal {
    Refusal {
        needs: Some(needs as f64),
        has: Some(most as f64),
        most: Some(most as f64),
        setting: Some(setting.to_owned()),
        ..refusal
    }
}

/// No answer asked for, or too many.
pub(crate) fn answers(field: &str, count: u64, most: u64) -> Refusal {
    let message = format!(
        "{field} asks for {count} answers; the number must be between 1 and {most} (`caps.answers`)"
    );
    if count == 0 {
        return Refusal::invalid(field, message);
    }
    let refusal = Refusal::new(ErrorCode::TooCostly, message);
    over("caps.answers", (count, most), Refusal { field: Some(field.to_owned()), ..refusal })
}

/// A request that is too large to be read.
pub(crate) fn cells(count: u64, most: u64) -> Refusal {
    let message = format!(
        "the request has {count} cells of 8 bytes; at most {most} are read (`caps.cells`): use \
         fewer channels, solids or vertices"
    );
    let refusal = Refusal::new(ErrorCode::TooCostly, message);
    over("caps.cells", (count, most), Refusal { field: Some("request".to_owned()), ..refusal })
}

pub(crate) fn too_many_samples(count: u64, most: u64) -> Refusal {
    let message = format!(
        "the trajectory would have {count} samples; the limit is {most} (`caps.samples`): sample \
         less densely"
    );
    let refusal = Refusal::new(ErrorCode::TooManySamples, message);
    Refusal { most: None, ..over("caps.samples", (count, most), refusal) }
}
