//! The places that a refusal names.

use schemas::message::{ErrorCode, Refusal};

/// The points that the message of a refusal to drive names, at most two; metres. Refusals have no
/// field for them.
pub(super) fn of(refusal: &Refusal) -> Vec<[f64; 2]> {
    match refusal.code {
        ErrorCode::NoRoute
        | ErrorCode::GapOutOfRange
        | ErrorCode::BodyOutsideFreeSpace
        | ErrorCode::GoalOutsideFreeSpace
        | ErrorCode::TurnBlocked
        | ErrorCode::WallInTheWay => points(&refusal.message).take(2).collect(),
        _ => Vec::new(),
    }
}

/// Everything of the form `(x, y)`.
fn points(text: &str) -> impl Iterator<Item = [f64; 2]> {
    let in_brackets = text.split('(').skip(1).filter_map(|rest| Some(rest.split_once(')')?.0));
    in_brackets.filter_map(|pair| {
        let (x, y) = pair.split_once(", ")?;
        let number = |text: &str| text.parse().ok().filter(|value: &f64| value.abs() < 1e100);
        Some([number(x)?, number(y)?])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_found_in_words() {
        let all = |text: &str| points(text).collect::<Vec<_>>();
        assert_eq!(all("between (1, -2.5) and (3e-2, 4), which are"), [[1.0, -2.5], [0.03, 4.0]]);
        assert!(all("a (wall), (1, 2, 3), (1,2) and (inf, 1)").is_empty());
    }
}
