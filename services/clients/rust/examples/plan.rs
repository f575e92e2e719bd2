//! Plans a scene with the running planner, and prints where the body is when.
//! Start a planner first: `cargo run -p clearway-planner`, then
//! `cargo run -p clearway-client --example plan -- recordings/scenes/drive-a.json`

use std::time::Duration;

use clearway_client::{Client, Domain, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: plan SCENE.json")?;
    let scene = Scene::from_json(&std::fs::read_to_string(&path)?)?;
    let client = Client::connect(&Domain::default())?;
    let reply = client.plan(&scene, Duration::from_secs(10))?;
    for trajectory in reply.trajectories()? {
        let clearance = trajectory.clearance().value;
        eprintln!(
            "{:.3} m in {:.3} s, {clearance:.3} m from the walls",
            trajectory.length(),
            trajectory.duration()
        );
        for sample in trajectory.samples() {
            let [x, y, z] = sample.position;
            println!("{:.3} {x:.4} {y:.4} {z:.4} {:.4}", sample.t, sample.heading);
        }
    }
    Ok(())
}
