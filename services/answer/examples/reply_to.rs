//! Plans a scene in this process: from JSON to JSON, without a bus.
//!
//! `cargo run -p clearway-answer --example reply_to [SCENE.json]`

use std::error::Error;

use answer::{Caps, reply_to};
use schemas::json;
use schemas::message::{Request, RequestContent, RequestKey};

/// Section 4 of the paper: an L-shaped part leaves its counterpart.
const SCENE: &str = include_str!("../../../recordings/scenes/disassemble-channels.json");

fn main() -> Result<(), Box<dyn Error>> {
    let text = match std::env::args_os().nth(1) {
        Some(path) => std::fs::read_to_string(path)?,
        None => SCENE.to_owned(),
    };
    let scene = json::read_scene(&text).map_err(|unreadable| unreadable.refusal.message)?;
    let content = RequestContent::Scene(scene);
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    let reply = reply_to(&request, &Caps::default());
    match &reply.answers {
        Ok(answers) => {
            for answer in answers {
                match answer {
                    Ok(path) => eprintln!(
                        "{:.3} m in {:.3} s, {:.3} m from the walls",
                        path.length, path.duration, path.clearance.value
                    ),
                    Err(refusal) => eprintln!("{}", refusal.message),
                }
            }
        }
        Err(refusal) => eprintln!("{}", refusal.message),
    }
    println!("{}", json::reply_to_json(&reply));
    Ok(())
}
