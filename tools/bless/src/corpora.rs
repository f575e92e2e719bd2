//! The seeds of the fuzz targets' corpora. Other inputs in these folders, such as those of mended
//! crashes, stay as they are.

use fuzz_targets::TARGETS;

/// The files and their bytes.
pub(crate) fn seeds() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for target in TARGETS {
        for (name, bytes) in (target.seeds)() {
            files.push((format!("{}/{name}", target.corpus().display()), bytes));
        }
    }
    files
}
