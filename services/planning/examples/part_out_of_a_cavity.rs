//! Section 4 of the paper: takes a male part out of the cavity of a female part.
//!
//! The channels are found from the female part's outline, the route from the channels, and
//! the path by Table 1, for a small gap and for the safest one.

use std::error::Error;

use planning::budget::Budget;
use planning::clearance::translating::{Body, clearance_body_legs};
use planning::disassembly::{DisassemblyPath, Gap, disassemble};
use planning::free_space::graph::Graph;
use planning::free_space::solids::Solids;
use planning::free_space::walls::Walls;
use planning::free_space::{Chain, End};
use planning::geometry::polygon::Polygon;
use planning::geometry::{AxisBox, Direction, Sign};
use planning::motion::Curve;
use planning::route::{BodyMover, Router};
use planning::trajectory::{Limits, Profile, Stops};

/// The outline of the female part, in (x, z), metres.
const FEMALE: [[f64; 2]; 12] = [
    [0.0, 0.0],
    [0.0, 7.0],
    [1.0, 7.0],
    [1.0, 2.0],
    [4.0, 2.0],
    [4.0, 1.0],
    [7.0, 1.0],
    [7.0, 6.0],
    [5.0, 6.0],
    [5.0, 7.0],
    [8.0, 7.0],
    [8.0, 0.0],
];

fn main() -> Result<(), Box<dyn Error>> {
    // Nothing here is large, so nothing is limited.
    let budget = &Budget::default();
    let female = Polygon::new(FEMALE.map(Into::into).to_vec(), budget)?;
    let male = AxisBox::new([4.5, 1.01].into(), [6.99, 4.0].into())?;
    let exit = Direction { axis: 1, sign: Sign::Positive };

    let (mut solids, mut walls) = (Solids::default(), Walls::default());
    solids.push_polygon(&female, budget)?;
    walls.push_polygon(&female);
    walls.index(budget)?;

    let cavity = solids.cavity(&male, exit).ok_or("there is no solid")?;
    let mut channels = Vec::new();
    solids.channels(&cavity, &male.size(), budget, &mut channels)?;
    println!("{} channels are wide and high enough for the male part:", channels.len());
    for (index, channel) in channels.iter().enumerate() {
        let (min, max) = (channel.min(), channel.max());
        println!("  {index}: x {} to {}, z {} to {}", min.x, max.x, min.y, max.y);
    }
    let mut graph = Graph::default();
    graph.build(&channels, budget)?;

    for (name, gap) in [("a gap of 0.2 m", Gap::Uniform(0.2)), ("the safest gap", Gap::Safest)] {
        let mut router = Router::default();
        let mut body = BodyMover::new(&male, gap, End::Exit(exit))?;
        router.find(&graph, &mut body, budget)?;
        let travelled: Vec<_> = router.route().iter().map(|index| channels[*index]).collect();

        let (mut chain, mut path) = (Chain::default(), DisassemblyPath::default());
        chain.build(&travelled, &male.center(), End::Exit(exit), budget)?;
        disassemble(&chain, &male, gap, &mut path, budget)?;

        let body = Body::from_box(&male);
        let mut each = Vec::new();
        let clearance = clearance_body_legs(&body, &walls, path.legs(), &mut each, budget)?;
        let clearance = clearance.ok_or("there are no walls")?;
        let mut profile = Profile::default();
        profile.plan(path.legs(), &Limits::default(), Stops::EveryLeg, budget)?;

        println!("\nWith {name}, through channels {:?}:", router.route());
        for (index, (leg, clearance)) in path.legs().iter().zip(&each).enumerate() {
            let Curve::Line { to, .. } = leg.curve else { continue };
            let rule = leg.rule.map_or("out along the exit".to_owned(), |rule| {
                format!("rule {} of Table {}", rule.number, rule.table)
            });
            let (start, end) = profile.leg_times(index);
            println!(
                "  {start:5.2} to {end:5.2} s, to ({:6.3}, {:6.3}): {rule}, {:.3} m from the walls",
                to.x, to.y, clearance.value
            );
        }
        println!(
            "  {:.3} m in {:.2} s, at least {:.3} m from the walls, first after {:.3} m",
            path.length(),
            profile.duration(),
            clearance.value,
            clearance.at
        );
    }
    Ok(())
}
