//! Colours: Okabe and Ito's, which are distinct to the colour-blind, on greys.

/// Keeps text readable over whatever is below; drawn before the text itself.
pub(super) const HALO: &str = r##"stroke="#fff" stroke-width="3" stroke-linejoin="round""##;
pub(super) const INK: &str = "#1f2328";
pub(super) const SUBTLE: &str = "#59636e";
pub(super) const FRAME: &str = "#8c959f";
pub(super) const WALL: &str = "#d9dde2";
pub(super) const WALL_EDGE: &str = "#6e7781";
/// Walls of a floor plan.
pub(super) const SOLID: &str = "#424a53";
/// What a floor plan does not know.
pub(super) const UNKNOWN: &str = "#e3e6ea";
pub(super) const CHANNEL_EDGE: &str = "#8c959f";
pub(super) const JUNCTION: &str = "#e69f00";
/// What moves.
pub(super) const BODY: &str = "#0072b2";
/// The inside of what moves, at rest.
pub(super) const BODY_FILL: &str = "#8fc0df";
pub(super) const PATH: &str = "#1f2328";
/// Where driving ends.
pub(super) const GOAL: &str = "#009e73";
pub(super) const GOAL_FILL: &str = "#8fd0bb";
/// The least clearance, and what is refused.
pub(super) const ALERT: &str = "#d55e00";
/// Turns in place.
pub(super) const TURN: &str = "#cc79a7";
/// Where a robot drives backwards.
pub(super) const REVERSE: &str = "#e69f00";
