//! The messages: pinned layouts, round trips, and what becomes of broken ones.

#[path = "messages/described.rs"]
mod described;
#[path = "messages/examples.rs"]
mod examples;
#[path = "messages/half_spaces.rs"]
mod half_spaces;
#[path = "messages/hostile.rs"]
mod hostile;
#[path = "messages/json_reply.rs"]
mod json_reply;
#[path = "messages/json_round_trips.rs"]
mod json_round_trips;
#[path = "messages/json_scene.rs"]
mod json_scene;
#[path = "messages/memory.rs"]
mod memory;
#[path = "messages/names.rs"]
mod names;
#[path = "messages/pinned.rs"]
mod pinned;
#[path = "messages/round_trips.rs"]
mod round_trips;
#[path = "messages/strategies.rs"]
mod strategies;
#[path = "messages/version_1.rs"]
mod version_1;
#[path = "messages/version_2.rs"]
mod version_2;
