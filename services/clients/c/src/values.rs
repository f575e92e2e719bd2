//! Plain values.

use std::ffi::c_char;

/// How a call ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// An argument is NULL, not UTF-8 or out of range.
    InvalidArgument = 1,
    /// No planner runs in the domain.
    NoPlanner = 2,
    /// The planner can't be reached.
    NotConnected = 3,
    /// The planner refuses, and says what would have to change: clearway_error_refusal.
    Refused = 4,
    /// No reply came in time.
    TimedOut = 5,
    /// The planner ended before it replied.
    PlannerLost = 6,
    /// The client was connected before this process was forked.
    Forked = 7,
    /// The request was sent, and no reply came, for another reason.
    Failed = 8,
}

/// A state of the motion.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Sample {
    /// Seconds from the beginning of the motion.
    pub t: f64,
    /// Metres; unused coordinates are 0. Of parts the displacement from the assembled state, of
    /// robots the reference point.
    pub position: [f64; 3],
    /// Radians counter-clockwise from +x, in (-pi, pi].
    pub heading: f64,
    /// Metres per second.
    pub velocity: [f64; 3],
    /// Radians per second.
    pub yaw_rate: f64,
}

/// Samples that follow each other.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Samples {
    /// The first; never NULL.
    pub data: *const Sample,
    /// How many there are.
    pub count: usize,
}

/// What a trajectory says beside its lists. Metres and seconds.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Summary {
    /// Arc length.
    pub length: f64,
    /// Seconds.
    pub duration: f64,
    /// Exact least distance of the body to the walls; infinite without walls.
    pub clearance: f64,
    /// Arc length where that is met.
    pub clearance_at: f64,
    /// The wall point there.
    pub clearance_wall: [f64; 3],
    /// Length of the shortest curve with the same free clearance; NaN if it is not reported.
    pub bound: f64,
    /// Free clearance; NaN if it is not reported.
    pub free_clearance: f64,
    /// Coordinates of positions: 2 or 3.
    pub dimension: u32,
    /// Whether the search ended by itself and not because its budget was spent.
    pub complete: bool,
    /// The way out that was taken, if the request gave several.
    pub exit: Exit,
    /// With smooth corners: at how many joints of legs the body stops because none fits; -1 if it is
    /// not reported.
    pub stops: i64,
    /// The limit that the motion does not obey.
    pub exceeds: Exceeds,
}

/// Ways out of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum Exit {
    /// None is reported.
    None = 0,
    /// Towards greater x.
    PlusX = 1,
    /// Towards smaller x.
    MinusX = 2,
    /// Towards greater y.
    PlusY = 3,
    /// Towards smaller y.
    MinusY = 4,
    /// Towards greater z.
    PlusZ = 5,
    /// Towards smaller z.
    MinusZ = 6,
}

/// A limit that a motion does not obey.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Exceeds {
    /// The limit.
    pub limit: Limit,
    /// At how many joints of legs.
    pub joints: u64,
    /// The greatest jump there of what the limit bounds the rate of, radians per second.
    pub jump: f64,
}

/// Limits that motions may not obey.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum Limit {
    /// None is exceeded, or none is reported.
    None = 0,
    /// The yaw rate jumps where the curvature does.
    YawAcceleration = 1,
}

/// A box with sides parallel to the axes, metres; unused coordinates are 0.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct AxisBox {
    /// The corner with the least coordinates.
    pub min: [f64; 3],
    /// The corner with the greatest coordinates.
    pub max: [f64; 3],
}

/// The kinds of legs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum LegKind {
    /// A straight line.
    Line = 0,
    /// A part of a circle.
    Arc = 1,
    /// A turn in place.
    Turn = 2,
    /// A curve whose curvature changes evenly with its arc length.
    Clothoid = 3,
}

/// How a leg was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum Rung {
    /// None is reported.
    None = 0,
    /// On the shortest path around the corners, at the gap asked for.
    Taut = 1,
    /// With another radius at the corners where the robot would not fit.
    Radius = 2,
    /// By lining up: straight legs between turns in place.
    Aligned = 3,
    /// With legs in reverse.
    Reverse = 4,
    /// By a search over positions and headings.
    Lattice = 5,
}

/// A piece of a path. Metres; radians counter-clockwise from +x. What its kind does not have is 0.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Leg {
    /// Which kind.
    pub kind: LegKind,
    /// Whether the robot drives it backwards.
    pub reverse: bool,
    /// Table of the rule that chose it, 0 for none.
    pub table: u16,
    /// Number of the rule in it.
    pub number: u16,
    /// How it was found.
    pub rung: Rung,
    /// The junction it leads to or turns in, counted from 0 in travel order; -1 for none.
    pub junction: i64,
    /// Arc length.
    pub length: f64,
    /// Least distance to the walls on it: exact, but on a clothoid certified from below; infinite
    /// without walls.
    pub clearance: f64,
    /// Line, clothoid: from. Arc: centre. Turn: position.
    pub point: [f64; 3],
    /// Line, clothoid: to.
    pub to: [f64; 3],
    /// Arc: radius.
    pub radius: f64,
    /// Arc: angle from the centre to the arriving point. Turn, clothoid: heading before.
    pub start: f64,
    /// Line: heading at its end. Turn, clothoid: heading after.
    pub heading: f64,
    /// Arc, turn: signed angle, positive to the left. Line: signed angle turned on the way.
    pub sweep: f64,
    /// Clothoid: radians turned per metre where it begins and where it ends, positive to the left.
    pub curvatures: [f64; 2],
}

/// A refusal. Texts live as long as the error; what does not apply is NULL, NaN or -1.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Refusal {
    /// Its code, such as "junction_too_small".
    pub code: *const c_char,
    /// For people, with the numbers; its wording may change.
    pub message: *const c_char,
    /// The field of the scene that is at fault, as a path.
    pub field: *const c_char,
    /// The setting of the planner whose limit was met.
    pub setting: *const c_char,
    /// The junction, counted from 0 in travel order.
    pub junction: i64,
    /// The axis: 0 x, 1 y, 2 z.
    pub axis: i32,
    /// What would be needed.
    pub needs: f64,
    /// What there is.
    pub has: f64,
    /// The bound below, itself excluded.
    pub least: f64,
    /// The bound above.
    pub most: f64,
    /// The heading that would be free, radians.
    pub heading: f64,
}
