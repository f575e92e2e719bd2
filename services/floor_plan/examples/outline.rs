//! What reading maps takes, and what comes of it: `outline MAP.yaml...`.

use std::path::PathBuf;
use std::time::Instant;

use floor_plan::UnknownCells;

const RUNS: u32 = 10;

fn main() -> Result<(), floor_plan::MapError> {
    for path in std::env::args_os().skip(1).map(PathBuf::from) {
        let plan = floor_plan::read(&path, UnknownCells::default())?;
        let begin = Instant::now();
        for _ in 0..RUNS {
            floor_plan::read(&path, UnknownCells::default())?;
        }
        println!(
            "{}: {} x {} cells, {} outlines with {} vertices, {:.1?}",
            path.display(),
            plan.grid().width(),
            plan.grid().height(),
            plan.outlines().count(),
            plan.outlines().vertices(),
            begin.elapsed() / RUNS
        );
    }
    Ok(())
}
