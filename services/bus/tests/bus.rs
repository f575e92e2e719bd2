//! The bus over real shared memory, every test in a domain of its own.

#[path = "bus/death.rs"]
mod death;
#[path = "bus/hostile.rs"]
mod hostile;
#[path = "bus/memory.rs"]
mod memory;
#[path = "bus/process.rs"]
mod process;
#[path = "bus/remains.rs"]
mod remains;
#[path = "bus/round_trip.rs"]
mod round_trip;
#[path = "bus/support.rs"]
mod support;
#[path = "bus/tap.rs"]
mod tap;
#[path = "bus/version_1.rs"]
mod version_1;
#[path = "bus/versions.rs"]
mod versions;
