//! Prints all traffic of a planner until interrupted:
//! `cargo run -p clearway-bus --example tap`

use std::time::Duration;

use bus::{Domain, TapEvent, TapMessage, TapReader};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut tap = TapReader::connect(&Domain::default())?;
    while !tap.terminated() {
        match tap.receive() {
            None => std::thread::sleep(Duration::from_millis(1)),
            Some(TapEvent::Message(TapMessage::Request(request))) => {
                println!("{}  request", request.key);
            }
            Some(TapEvent::Message(TapMessage::Reply(part))) => {
                let last = if part.last { ", the last" } else { "" };
                println!("{}  reply part {}{last}", part.key, part.part);
            }
            Some(TapEvent::FreeSpace(request)) => println!("a free space sent {}", request.sent_ns),
            Some(TapEvent::Lost { messages }) => println!("{messages} messages lost"),
            Some(TapEvent::Restarted) => println!("another planner"),
        }
    }
    Ok(())
}
