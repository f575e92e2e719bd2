//! The search for a taut path beside the crate `polyanya`, on the same triangulation.
//!
//! `cargo run --release --manifest-path tests/peers/polyanya/Cargo.toml -- MAP.yaml...`
//!
//! polyanya knows points and 32-bit numbers. Ours runs twice: for a disc of 0.1 mm, whose paths
//! must be as long, and for one of 0.2 m.

use std::collections::HashMap;
use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

use floor_plan::UnknownCells;
use glam::Vec2;
use planning::any_angle::{Planner, disc_path};
use planning::budget::Budget;
use planning::free_space::floor::Floor;
use planning::free_space::walls::{Wall, Walls};
use planning::geometry::{AxisBox, Vector};
use polyanya::{Mesh, Polygon, Vertex};
use schemas::message::Solid;

/// Pairs of places on each map.
const PAIRS: usize = 1000;

/// Radii of the disc, metres.
const RADII: [f64; 2] = [1e-4, 0.2];

fn main() -> Result<(), Box<dyn Error>> {
    println!("| map | triangles | polyanya p50, p99 | a point | a disc of 0.2 m | ratio of sums |");
    println!("|---|--:|--:|--:|--:|--:|");
    for map in std::env::args_os().skip(1) {
        compare(Path::new(&map))?;
    }
    Ok(())
}

fn compare(map: &Path) -> Result<(), Box<dyn Error>> {
    let plan = floor_plan::read(map, UnknownCells::Occupied)?;
    let free_space = plan.free_space();
    let budget = Budget::default();
    let mut walls = Walls::default();
    let flat = |point: [f64; 3]| Vector::<2>::from([point[0], point[1]]);
    for solid in free_space.solids.iter().flatten() {
        let Solid::Polygon(vertices) = solid else { continue };
        let ends = vertices.iter().cycle().skip(1);
        for (from, to) in vertices.iter().zip(ends) {
            walls.push(Wall { from: flat(from.padded()), to: flat(to.padded()) });
        }
    }
    let bounds = free_space.bounds.ok_or("a map has bounds")?;
    let bounds = AxisBox::new(flat(bounds.min.padded()), flat(bounds.max.padded()))?;
    walls.push_inside(&bounds);
    walls.index(&budget)?;
    let floor = Floor::new(&walls, &budget)?;
    let is_free = |point: Vector<2>| {
        let [column, row] = plan.frame().locate(point.into());
        let cell = plan.grid().cell(column as usize, row as usize);
        column >= 0.0 && row >= 0.0 && cell == Some(floor_plan::CellState::Free)
    };
    let mesh = mesh(&floor, is_free)?;
    let mut rng = fastrand::Rng::with_seed(1);
    let mut place = || {
        loop {
            let (min, max) = (bounds.min(), bounds.max());
            let point = Vector::<2>::from([0, 1].map(|axis| {
                min[axis] + (max[axis] - min[axis]) * rng.f64()
            }));
            let mut near = false;
            let reach = 0.25;
            let _ = walls.near(&point, &point, reach, &budget, |_, _| near = true);
            if is_free(point) && !near {
                return point;
            }
        }
    };
    let mut times: [Vec<Duration>; 3] = Default::default();
    let mut planners = [Planner::default(), Planner::default()];
    while times[0].len() < PAIRS {
        let ends = [place(), place()];
        let [from, to] = ends.map(|end| Vec2::new(end.x as f32, end.y as f32));
        let begin = Instant::now();
        let Some(path) = mesh.path(from, to) else { continue };
        let theirs = begin.elapsed();
        let mut ours = [Duration::ZERO; 2];
        for index in 0..2 {
            let begin = Instant::now();
            let length =
                disc_path(&floor, &walls, RADII[index], ends, &mut planners[index], &budget)?;
            ours[index] = begin.elapsed();
            if index == 0 {
                let length = length.ok_or("a point passes wherever polyanya does")?;
                let off = (length - f64::from(path.length)).abs();
                if off > 1e-3 * length + 1e-3 {
                    eprintln!("{ends:?}: {length} m, polyanya has {} m", path.length);
                }
            }
        }
        times[0].push(theirs);
        times[1].push(ours[0]);
        times[2].push(ours[1]);
    }
    let sums = times.each_ref().map(|times| times.iter().sum::<Duration>().as_secs_f64());
    let shown = times.map(|mut times| {
        times.sort_unstable();
        let us = |part: usize| times[(PAIRS - 1) * part / 100].as_secs_f64() * 1e6;
        format!("{:.0}, {:.0} µs", us(50), us(99))
    });
    println!(
        "| {} | {} | {} | {} | {} | {:.1}, {:.1} |",
        map.file_stem().unwrap_or_default().to_string_lossy(),
        floor.triangles().count(),
        shown[0],
        shown[1],
        shown[2],
        sums[1] / sums[0],
        sums[2] / sums[0],
    );
    Ok(())
}

/// The free triangles.
fn mesh(floor: &Floor, is_free: impl Fn(Vector<2>) -> bool) -> Result<Mesh, Box<dyn Error>> {
    let (mut vertices, mut triangles, mut known) = (Vec::new(), Vec::new(), HashMap::new());
    for corners in floor.triangles() {
        if !is_free((corners[0] + corners[1] + corners[2]) / 3.0) {
            continue;
        }
        triangles.push(corners.map(|corner| {
            *known.entry([corner.x.to_bits(), corner.y.to_bits()]).or_insert_with(|| {
                vertices.push(Vec2::new(corner.x as f32, corner.y as f32));
                vertices.len() - 1
            })
        }));
    }
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); vertices.len()];
    for (index, triangle) in triangles.iter().enumerate() {
        for vertex in triangle {
            around[*vertex].push(index);
        }
    }
    let fan = |vertex: usize| {
        // Counter-clockwise, with a mark where what is between two triangles is not free.
        let center: Vec2 = vertices[vertex];
        let middle = |index: usize| {
            let corners: [usize; 3] = triangles[index];
            corners.iter().map(|corner| vertices[*corner]).sum::<Vec2>() / 3.0 - center
        };
        let mut fan = around[vertex].clone();
        fan.sort_by(|a, b| middle(*a).to_angle().total_cmp(&middle(*b).to_angle()));
        let mut marked = Vec::new();
        for (at, index) in fan.iter().enumerate() {
            marked.push(*index as u32);
            let next = triangles[fan[(at + 1) % fan.len()]];
            let shared = triangles[*index].iter().filter(|corner| next.contains(corner)).count();
            if shared < 2 || fan.len() == 1 {
                marked.push(u32::MAX);
            }
        }
        marked
    };
    let fans: Vec<_> = (0..vertices.len()).map(fan).collect();
    let vertices = vertices.iter().zip(fans).map(|(at, fan)| Vertex::new(*at, fan)).collect();
    let polygons = triangles
        .iter()
        .map(|corners| Polygon::new(corners.map(|corner| corner as u32).to_vec(), false))
        .collect();
    let mut mesh = Mesh::new(vertices, polygons)?;
    mesh.bake();
    Ok(mesh)
}
