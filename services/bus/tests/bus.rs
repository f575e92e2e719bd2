//! The bus over real shared memory, every test in a domain of its own.

#[path = "bus/costs.rs"]
mod costs;
#[path = "bus/round_trip.rs"]
mod round_trip;
#[path = "bus/support.rs"]
mod support;
