//! Lists the messages of a recording:
//! `cargo run -p clearway-recording --example list -- recordings/driving.mcap`

use recording::{Message, Reader};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: list FILE")?;
    let mut reader = Reader::open(&path)?;
    for record in reader.by_ref() {
        let record = record?;
        match record.message {
            Message::Request(request) => {
                println!("{:>6}  {}  request", record.sequence, request.key);
            }
            Message::Reply(part) => {
                let content = match &part.content {
                    Ok(trajectory) => {
                        format!("{} m, {} samples", trajectory.length, trajectory.samples.len())
                    }
                    Err(refusal) => refusal.message.clone(),
                };
                println!(
                    "{:>6}  {}  reply part {}: {content}",
                    record.sequence, part.key, part.part
                );
            }
        }
    }
    println!("{} messages missing, in {} gaps", reader.lost(), reader.gaps());
    Ok(())
}
