//! Replies as CSV: a row for each sample.

use std::io::{self, Write};

use schemas::message::{Reply, Sample, SceneRequest, Task};

/// The first row.
pub const HEADER: &str = "scene,id,answer,t,x,y,z,heading,vx,vy,vz,yaw_rate";

/// Writes the samples of a reply to the scene with this number. Refusals have no rows. In
/// assembly scenes of two dimensions, which live in (x, z), y is 0.
pub fn write(
    out: &mut impl Write,
    number: usize,
    scene: &SceneRequest,
    reply: &Reply,
) -> io::Result<()> {
    let id = scene.id.map_or(String::new(), |id| id.to_string());
    for (answer, trajectory) in reply.answers.iter().flatten().enumerate() {
        let Ok(trajectory) = trajectory else { continue };
        let in_plane = trajectory.dimension == 2 && scene.task != Task::Drive;
        let axes = |[a, b, c]: [f64; 3]| if in_plane { [a, 0.0, b] } else { [a, b, c] };
        for sample in &trajectory.samples {
            let Sample { t, position, heading, velocity, yaw_rate } = sample;
            let ([x, y, z], [vx, vy, vz]) = (axes(*position), axes(*velocity));
            writeln!(
                out,
                "{number},{id},{answer},{t},{x},{y},{z},{heading},{vx},{vy},{vz},{yaw_rate}"
            )?;
        }
    }
    Ok(())
}
