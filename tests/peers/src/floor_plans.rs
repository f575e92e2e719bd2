//! Floor plans: how long the first answer takes, and further ones between random places that a
//! grid search of the turning circle connects.

use std::convert::Infallible;
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use answer::{CACHE_BYTES, Caps, StopFlag, Workspace};
use fastrand::Rng;
use floor_plan::{CellState, FloorPlan, OccupancyGrid, UnknownCells};
use schemas::convert::{CellWriter, PartSink, write_scene};
use schemas::message::{FreeSpace, RequestKey, SceneRequest, Solid};
use schemas::wire::ReplyHeader;

use crate::Point;

/// Width and length of the robot, metres; its turning circle has a radius of 0.275 m.
pub const FOOTPRINT: [f64; 2] = [0.35, 0.424];

/// What was measured on a floor plan.
#[derive(Debug, Clone)]
pub struct Figures {
    /// Columns and rows.
    pub cells: [usize; 2],
    /// Corners of the walls.
    pub corners: usize,
    /// Reading the picture and outlining its walls.
    pub read: Duration,
    /// The first answer, the free space sent with it.
    pub first: Duration,
    /// Further answers, the free space named, from the fastest to the slowest.
    pub further: Vec<Duration>,
    /// Pairs of places that were refused.
    pub refused: Vec<[Point; 2]>,
}

/// Measures a floor plan between `pairs` random pairs of places.
///
/// # Errors
///
/// If the map can't be read.
///
/// # Panics
///
/// If it has no two places to drive between.
pub fn measure(path: &Path, pairs: usize, gap: f64) -> Result<Figures, Box<dyn std::error::Error>> {
    let begin = Instant::now();
    let plan = floor_plan::read(path, UnknownCells::Occupied)?;
    let mut free_space = plan.free_space();
    let name = free_space.digest();
    free_space.named = Some(name);
    let read = begin.elapsed();
    let corners = free_space.solids.iter().flatten().map(corners_of).sum();
    let places = Places::of(&plan);
    let mut rng = Rng::with_seed(1);
    let mut workspace = Workspace::new(Caps::default(), CACHE_BYTES);
    let mut refused = Vec::new();
    let mut further = Vec::new();
    let mut first = Duration::ZERO;
    for index in 0..=pairs {
        let [start, goal] = places.pair(&plan, &mut rng);
        let mut scene = scene(start, rng.f64() * 6.0, goal, gap);
        scene.free_space = if index == 0 {
            free_space.clone()
        } else {
            FreeSpace { named: Some(name), ..FreeSpace::default() }
        };
        let (time, is_refused) = answer(&mut workspace, &scene);
        if index == 0 {
            first = time
        } else {
            further.push(time)
        }
        if is_refused {
            refused.push([start, goal]);
        }
    }
    further.sort_unstable();
    let cells = [plan.grid().width(), plan.grid().height()];
    Ok(Figures { cells, corners, read, first, further, refused })
}

fn corners_of(solid: &Solid) -> usize {
    match solid {
        Solid::Polygon(vertices) => vertices.len(),
        _ => 4,
    }
}

fn scene(start: Point, heading: f64, goal: Point, gap: f64) -> SceneRequest {
    let text = serde_json::json!({
        "task": "drive",
        "free_space": { "solids": [], "bounds": { "min": [0, 0], "max": [1, 1] } },
        "body": { "footprint": { "width": FOOTPRINT[0], "length": FOOTPRINT[1] } },
        "start": { "position": start, "heading": heading },
        "goal": { "position": goal },
        "clearance": { "gap": gap },
        "sampling": { "spacing": 0.05 },
    });
    schemas::json::read_scene(&text.to_string()).expect("a scene")
}

/// Takes the reply and drops it.
struct Discard {
    cells: Vec<u64>,
    is_refused: bool,
}

impl PartSink for Discard {
    type Error = Infallible;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Infallible> {
        self.cells.resize(self.cells.len().max(cells), 0);
        fill(&mut CellWriter::new(&mut self.cells[..cells]));
        self.is_refused |= header.kind != 0;
        Ok(())
    }
}

fn answer(workspace: &mut Workspace, scene: &SceneRequest) -> (Duration, bool) {
    let mut cells = Vec::new();
    let header = write_scene(scene, RequestKey::default(), 0, &mut cells).expect("two dimensions");
    let mut sink = Discard { cells: Vec::new(), is_refused: false };
    let begin = Instant::now();
    let Ok(()) = workspace.answer(&header, &cells, &StopFlag::new(), &mut sink);
    (begin.elapsed(), sink.is_refused)
}

/// Cells in which the turning circle is free, by the region they belong to.
struct Places {
    regions: Vec<Vec<[usize; 2]>>,
    cells: usize,
}

impl Places {
    fn of(plan: &FloorPlan) -> Self {
        let grid = plan.grid();
        let radius = FOOTPRINT[0].hypot(FOOTPRINT[1]) / 2.0 / plan.frame().resolution();
        let mut taken = taken(grid, radius + 0.2);
        let mut regions = Vec::new();
        for y in 0..grid.height() {
            for x in 0..grid.width() {
                if !taken[y * grid.width() + x] {
                    let region = flood(&mut taken, [grid.width(), grid.height()], [x, y]);
                    regions.push(region);
                }
            }
        }
        let cells = regions.iter().map(Vec::len).sum();
        Self { regions, cells }
    }

    /// Two places in one region.
    fn pair(&self, plan: &FloorPlan, rng: &mut Rng) -> [Point; 2] {
        let mut index = rng.usize(0..self.cells);
        let region = self
            .regions
            .iter()
            .find(|region| {
                let is_in = index < region.len();
                if !is_in {
                    index -= region.len();
                }
                is_in
            })
            .expect("an index of a cell");
        [region[index], region[rng.usize(0..region.len())]]
            .map(|[x, y]| plan.frame().middle([x as u32, y as u32]))
    }
}

/// Cells whose middle is within a radius of an occupied one, in cells.
fn taken(grid: &OccupancyGrid, radius: f64) -> Vec<bool> {
    let (width, height) = (grid.width(), grid.height());
    let is_free = |x: i64, y: i64| {
        let inside = 0 <= x && x < width as i64 && 0 <= y && y < height as i64;
        inside && grid.cell(x as usize, y as usize) == Some(CellState::Free)
    };
    let mut taken = vec![false; width * height];
    let reach = radius.ceil() as i64 + 1;
    for y in -1..=height as i64 {
        for x in -1..=width as i64 {
            if is_free(x, y) {
                continue;
            }
            let border = [(1, 0), (-1, 0), (0, 1), (0, -1)];
            let is_border = border.iter().any(|(dx, dy)| is_free(x + dx, y + dy));
            let span = if is_border { reach } else { 0 };
            for other_y in (y - span).max(0)..=(y + span).min(height as i64 - 1) {
                for other_x in (x - span).max(0)..=(x + span).min(width as i64 - 1) {
                    // From the middle of one cell to the square of the other.
                    let apart = |a: i64, b: i64| ((a - b).abs() as f64 - 0.5).max(0.0);
                    if apart(x, other_x).hypot(apart(y, other_y)) <= radius {
                        taken[other_y as usize * width + other_x as usize] = true;
                    }
                }
            }
        }
    }
    taken
}

/// The cells that are connected with one by their sides, which are then taken.
fn flood(taken: &mut [bool], [width, height]: [usize; 2], from: [usize; 2]) -> Vec<[usize; 2]> {
    let mut region = vec![from];
    taken[from[1] * width + from[0]] = true;
    let mut next = 0;
    while let Some(&[x, y]) = region.get(next) {
        next += 1;
        let sides = [(x + 1, y), (x.wrapping_sub(1), y), (x, y + 1), (x, y.wrapping_sub(1))];
        for (x, y) in sides {
            if x < width && y < height && !std::mem::replace(&mut taken[y * width + x], true) {
                region.push([x, y]);
            }
        }
    }
    region
}

/// Writes a map of random square blocks that cover about this part of it; blocks are ten cells
/// of 5 cm wide.
///
/// # Errors
///
/// If a file can't be written.
pub fn write_blocks(folder: &Path, side: usize, part: f64) -> io::Result<std::path::PathBuf> {
    const BLOCK: usize = 10;
    let mut rng = Rng::with_seed(side as u64);
    let mut cells = vec![254_u8; side * side];
    let blocks = (part * (side * side) as f64 / (BLOCK * BLOCK) as f64) as usize;
    for _ in 0..blocks {
        let (x, y) = (rng.usize(0..side - BLOCK), rng.usize(0..side - BLOCK));
        for row in y..y + BLOCK {
            cells[row * side + x..row * side + x + BLOCK].fill(0);
        }
    }
    let name = format!("blocks-{side}-{}", (part * 100.0).round());
    let mut picture = format!("P5\n{side} {side}\n255\n").into_bytes();
    picture.extend(cells);
    std::fs::write(folder.join(format!("{name}.pgm")), picture)?;
    let path = folder.join(format!("{name}.yaml"));
    let text = format!(
        "image: {name}.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    );
    std::fs::write(&path, text)?;
    Ok(path)
}
