//! Parts of a scene that are out of range.

use planning::geometry::BoxError;
use planning::geometry::number::Number;
use planning::trajectory::{LimitError, SamplingError};
use schemas::message::Refusal;

use super::words::{Axes, letter};

pub(crate) fn axis_box(field: String, axes: &Axes, error: BoxError) -> Refusal {
    let message = match error {
        BoxError::NotFinite { axis, min, max } => format!(
            "{field}: min {} and max {} along {} must be finite numbers",
            Number(min),
            Number(max),
            letter(axes, axis)
        ),
        BoxError::Inverted { axis, min, max } => {
            let (min, max, along) = (Number(min), Number(max), letter(axes, axis));
            format!("{field}: min {min} along {along} must be less than max {max}")
        }
    };
    let (BoxError::NotFinite { axis, .. } | BoxError::Inverted { axis, .. }) = error;
    Refusal { axis: Some(axes[axis]), ..Refusal::invalid(field, message) }
}

pub(crate) fn limit(error: LimitError) -> Refusal {
    let LimitError::OutOfRange { field, value, least, most } = error;
    let unit = match field {
        "speed" => "m/s",
        "yaw_rate" => "rad/s",
        "yaw_acceleration" => "rad/s\u{b2}",
        _ => "m/s\u{b2}",
    };
    let message = format!(
        "limits.{field} is {} {unit}; it must be between {least:e} and {most:e}",
        Number(value)
    );
    let refusal = Refusal::invalid(format!("limits.{field}"), message);
    Refusal { has: Some(value), least: Some(least), most: Some(most), ..refusal }
}

pub(crate) fn sampling(error: SamplingError) -> Refusal {
    match error {
        SamplingError::NotPositive { field, value } => {
            let unit = if field == "period" { "s" } else { "m" };
            let message = format!(
                "sampling.{field} is {} {unit}; it must be finite and greater than 0",
                Number(value)
            );
            let refusal = Refusal::invalid(format!("sampling.{field}"), message);
            Refusal { has: Some(value), least: Some(0.0), ..refusal }
        }
        SamplingError::TooFew { count, least } => {
            let message = format!(
                "sampling.count is {count}; it must be at least {least}, for the first and the \
                 last state"
            );
            let refusal = Refusal::invalid("sampling.count", message);
            Refusal { has: Some(count as f64), needs: Some(least as f64), ..refusal }
        }
    }
}
