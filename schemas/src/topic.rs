//! Names on the bus and in recordings.

/// The service that answers scene requests, in the current version of the messages.
pub const PLAN: &str = "clearway/plan/2";
/// The planner's copy of all traffic, for recorders, in the current version.
pub const TAP: &str = "clearway/tap/2";
/// The event by which clients of every version wake the planner.
pub const WAKE: &str = "clearway/wake";
/// The event by which the planner wakes its clients of every version.
pub const ANSWERED: &str = "clearway/answered";

/// What the planner says of itself: JSON text, once a second and when it changes.
pub const STATUS: &str = "/planner/status";

/// Topic of recorded requests.
pub const REQUEST: &str = "/planner/request";
/// Topic of recorded reply parts.
pub const REPLY: &str = "/planner/reply";
/// Topic of recorded free spaces that requests name: the requests that had made them known.
pub const FREE_SPACE: &str = "/planner/free_space";
/// Profile of recordings.
pub const PROFILE: &str = "planning";
/// Message and schema encoding of recordings.
pub const ENCODING: &str = "bincode";
