//! Times round trips with the running planner: `round_trip SCENE.json DOMAIN CALLS`. Prints the
//! median and the 99th percentile, µs; see services/clients/round_trip.sh.

use std::hint::black_box;
use std::time::{Duration, Instant};

use clearway_client::{Client, Domain, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<_> = std::env::args().collect();
    let [_, path, domain, calls] = arguments.as_slice() else {
        return Err("usage: round_trip SCENE.json DOMAIN CALLS".into());
    };
    let scene = Scene::from_json(&std::fs::read_to_string(path)?)?;
    let client = Client::connect(&domain.parse::<Domain>()?)?;
    let calls: usize = calls.parse()?;
    let mut times = Vec::with_capacity(calls);
    for _ in 0..calls {
        let begin = Instant::now();
        let reply = client.plan(&scene, Duration::from_secs(10))?;
        for trajectory in reply.trajectories()? {
            for block in trajectory.blocks() {
                black_box(block.samples()[0].t);
            }
        }
        drop(reply);
        times.push(begin.elapsed());
    }
    times.sort_unstable();
    let at = |part: usize| times[calls * part / 100].as_secs_f64() * 1e6;
    println!("{:.1} {:.1}", at(50), at(99));
    Ok(())
}
