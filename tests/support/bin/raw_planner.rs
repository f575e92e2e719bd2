//! A planner that lies to its clients, for the tests of clients in other languages:
//! `raw-planner DOMAIN LIE`, until it is killed. See [`Lie`].

use integration_tests::raw::{Lie, RawPlanner};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let domain = arguments.next().ok_or("which domain?")?.parse()?;
    let lie: Lie = arguments.next().ok_or("which lie?")?.parse()?;
    let planner = RawPlanner::open(&domain, lie)?;
    println!("ready");
    while planner.serve().is_ok() {}
    Ok(())
}
