//! Writes a recording of one request and its refusal:
//! `cargo run -p clearway-recording --example write -- /tmp/example.mcap`

use recording::{Options, Writer};
use schemas::json;
use schemas::message::{ErrorCode, Refusal, ReplyPart, Request, RequestContent, RequestKey};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: write FILE")?;
    let scene = r#"{ "task": "drive", "free_space": { "channels": [] },
        "body": { "footprint": { "width": 1.0, "length": 1.5 } },
        "start": { "position": [1, 2], "heading": 0 }, "goal": { "position": [9, 2] },
        "clearance": { "gap": 0.2 } }"#;
    let scene = json::read_scene(scene).map_err(|unreadable| unreadable.refusal.message)?;
    let key = RequestKey { client: 7, sequence: 0 };
    // Nanoseconds since the Unix epoch: when it was sent, and when it was recorded.
    let (asked, answered) = (1_700_000_000_000_000_000, 1_700_000_000_000_200_000);

    let mut writer = Writer::create(&path, Options::default())?;
    let content = RequestContent::Scene(scene);
    writer.write_request(&Request { key, sent_ns: asked, content }, asked + 1_000)?;
    let reply = ReplyPart {
        key,
        id: None,
        sent_ns: answered,
        part: 0,
        last: true,
        answer: 0,
        answers: 0,
        content: Err(Refusal::new(ErrorCode::NoRoute, "there are no channels")),
    };
    writer.write_reply(&reply, answered + 1_000)?;
    let summary = writer.finish()?;
    println!("{path}: {} messages", summary.recorded);
    Ok(())
}
