//! What `replay diff` prints.

use std::io::{self, Write};
use std::path::Path;

use comparison::check::Counts;
use comparison::compare::Outcome;
use comparison::diff::Compared;
use serde_json::json;

use crate::report::{difference_json, write_json};

/// Whether the recordings differ.
pub(crate) fn differ(compared: &Compared) -> bool {
    counts(compared).different > 0 || compared.alone.iter().any(|keys| !keys.is_empty())
}

fn counts(compared: &Compared) -> Counts {
    let mut counts = Counts::default();
    compared.pairs.iter().for_each(|pair| counts.add(&pair.outcome));
    counts
}

/// Each difference in a line, and a line of counts.
pub(crate) fn text(compared: &Compared, paths: [&Path; 2], out: &mut impl Write) -> io::Result<()> {
    let [a, b] = paths.map(Path::display);
    for (index, pair) in compared.pairs.iter().enumerate() {
        if let Outcome::Different(difference) = &pair.outcome {
            let [one, other] = pair.keys;
            let (path, has_a, has_b) =
                (&difference.path, &difference.recorded, &difference.planned);
            writeln!(
                out,
                "pair {index} ({one} and {other}): {path}: {has_a} in {a}, {has_b} in {b}"
            )?;
        }
    }
    for (path, keys) in [&a, &b].into_iter().zip(&compared.alone) {
        for key in keys {
            writeln!(out, "request {key} is only in {path}")?;
        }
    }
    let [alone_a, alone_b] = compared.alone.each_ref().map(Vec::len);
    let Counts { equal, reworded, different, not_repeatable } = counts(compared);
    write!(out, "{equal} equal")?;
    if reworded > 0 {
        write!(out, " ({reworded} worded differently)")?;
    }
    write!(out, ", {different} different")?;
    if not_repeatable > 0 {
        write!(out, ", {not_repeatable} not repeatable (depend on load)")?;
    }
    writeln!(out, ", {alone_a} only in {a}, {alone_b} only in {b}")
}

/// All of it as one JSON object.
pub(crate) fn json(compared: &Compared, paths: [&Path; 2], out: &mut impl Write) -> io::Result<()> {
    let differences = compared.pairs.iter().enumerate().filter_map(|(index, pair)| {
        let Outcome::Different(difference) = &pair.outcome else { return None };
        let mut fields = difference_json(difference);
        fields.insert("pair".into(), index.into());
        fields.insert("keys".into(), json!(pair.keys.map(|key| key.to_string())));
        Some(fields)
    });
    let [only_in_a, only_in_b] = compared
        .alone
        .each_ref()
        .map(|keys| keys.iter().map(ToString::to_string).collect::<Vec<_>>());
    let Counts { equal, reworded, different, not_repeatable } = counts(compared);
    let value = json!({
        "a": paths[0].to_string_lossy(),
        "b": paths[1].to_string_lossy(),
        "equal": equal,
        "reworded": reworded,
        "different": different,
        "not_repeatable": not_repeatable,
        "differences": differences.collect::<Vec<_>>(),
        "only_in_a": only_in_a,
        "only_in_b": only_in_b,
    });
    write_json(&value, out)
}
