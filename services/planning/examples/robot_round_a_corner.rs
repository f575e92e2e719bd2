//! Drives a rectangular robot round the corner of an L-shaped corridor by Table 2.
//!
//! The wider the gap to the corner, the longer the path; the safest gap has a closed form.

use std::error::Error;
use std::f64::consts::FRAC_PI_2;

use planning::budget::Budget;
use planning::clearance::rectangle::Footprint;
use planning::driving::limits::{balanced_gap, greatest_gap, least_width};
use planning::driving::{
    CornerGaps, Drive, DrivingPath, Goal, Pose, StartTurn, corners_of, drive, safest,
};
use planning::free_space::walls::{Complement, Walls};
use planning::free_space::{Chain, End};
use planning::geometry::AxisBox;
use planning::motion::Curve;

fn main() -> Result<(), Box<dyn Error>> {
    let budget = &Budget::default();
    let footprint = Footprint::new(1.0, 1.5)?;
    // Up a corridor 3 m wide, then to the right along one 2.5 m wide. In (x, y), metres.
    let channels = [
        AxisBox::new([0.0, 0.0].into(), [3.0, 10.0].into())?,
        AxisBox::new([0.0, 7.5].into(), [12.0, 10.0].into())?,
    ];
    let start = Pose { position: [1.5, 1.5].into(), heading: FRAC_PI_2 };
    let goal = Goal { position: [10.0, 8.75].into(), heading: Some(0.0) };

    let (mut chain, mut corners, mut walls) = (Chain::default(), Vec::new(), Walls::default());
    chain.build(&channels, &start.position, End::Goal(goal.position), budget)?;
    corners_of(&chain, &mut corners);
    walls.set_complement(&channels, None, &mut Complement::default(), budget)?;

    let corner = &corners[0];
    println!(
        "The corner at ({}, {}), rule {} of Table 2: a corridor {} m wide, the robot needs more \
         than {:.3} m.",
        corner.point.x,
        corner.point.y,
        corner.rule.number,
        corner.width(),
        least_width(&footprint)
    );
    println!(
        "A gap must be less than {:.3} m; {:.3} m leaves as much to the outer wall.",
        greatest_gap(&footprint, corner.width()),
        balanced_gap(&footprint, corner.width())
    );

    let task = Drive {
        footprint,
        start,
        goal,
        start_turn: StartTurn::InPlace,
        first: channels[0],
        last: channels[1],
        corners: &corners,
        walls: &walls,
    };
    let mut path = DrivingPath::default();
    let best = safest(&task, &mut path, budget)?;
    println!("\n   gap, m  length, m  clearance in the turn, m");
    for quarters in 1..=4 {
        let gap = best * f64::from(quarters) / 4.0;
        drive(&task, CornerGaps::Uniform(gap), &mut path, budget)?;
        let turning = path.turning().ok_or("there are no walls")?;
        println!("{gap:9.4} {:10.4} {:13.4}", path.length(), turning.value);
    }

    println!("\nWith the safest gap:");
    for leg in path.legs() {
        let end = leg.curve.end();
        let what = match leg.curve {
            Curve::Line { .. } => format!("{:.3} m straight", leg.curve.length()),
            Curve::Arc { radius, .. } => {
                format!("{:.3} m on a circle of radius {radius:.3} m", leg.curve.length())
            }
            Curve::Clothoid { .. } => format!("{:.3} m on a clothoid", leg.curve.length()),
            Curve::Turn { .. } => "turn in place".to_owned(),
        };
        let heading = leg.curve.end_heading().to_degrees();
        println!("  {what}, to ({:.3}, {:.3}), heading {heading:.1} degrees", end.x, end.y);
    }
    Ok(())
}
