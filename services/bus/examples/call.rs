//! Plans a scene over the bus and prints the reply. Start a planner first:
//! `cargo run -p clearway-planner`, then
//! `cargo run -p clearway-bus --example call -- recordings/scenes/drive-a.json`

use std::time::Duration;

use bus::{Client, Domain, Wait};
use schemas::json;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: plan SCENE.json")?;
    let text = std::fs::read_to_string(&path)?;
    let scene = json::read_scene(&text).map_err(|unreadable| unreadable.refusal.message)?;

    let client = Client::connect(&Domain::default(), Wait::Hybrid)?;
    let reply = client.call(&scene, Duration::from_secs(10))?;
    match reply.answers {
        Err(refusal) => println!("refused: {}", refusal.message),
        Ok(answers) => {
            for answer in answers {
                match answer {
                    Err(refusal) => println!("refused: {}", refusal.message),
                    Ok(motion) => println!(
                        "{:.3} m in {:.3} s, {:.3} m from the walls, {} samples",
                        motion.length,
                        motion.duration,
                        motion.clearance.value,
                        motion.samples.len()
                    ),
                }
            }
        }
    }
    Ok(())
}
