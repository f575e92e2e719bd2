//! Plans motions with a Clearway planner over shared memory.
//!
//! Start a planner (`planner`), then ask it:
//!
//! ```
//! use std::time::Duration;
//!
//! use clearway_client::{Client, Domain, Scene};
//!
//! # mod planner { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/planner.rs")); }
//! # let planner = planner::Planner::start();
//! # let domain = planner.domain();
//! # const _: &str = stringify! {
//! let domain = Domain::default();
//! # };
//! let client = Client::connect(&domain)?;
//! let scene = Scene::from_json(
//!     r#"{ "task": "disassemble",
//!          "free_space": { "channels": [ {"min": [4, 1], "max": [7, 6]}, {"min": [1, 2], "max": [7, 6]},
//!                                        {"min": [1, 2], "max": [5, 7]} ], "in_order": true },
//!          "body": { "polygon": [[4.5, 1.01], [4.5, 4], [6.99, 4], [6.99, 1.01]] },
//!          "clearance": { "gap": 0.2 } }"#,
//! )?;
//! let reply = client.plan(&scene, Duration::from_secs(1))?;
//! for trajectory in reply.trajectories()? {
//!     println!("{:.2} m, {:.2} m from the walls", trajectory.length(), trajectory.clearance().value);
//!     for block in trajectory.blocks() {
//!         for sample in block.samples() { // where the planner wrote them
//!             println!("{:.2} s: {:?} m", sample.t, sample.position);
//!         }
//!     }
//! }
//! # assert!(reply.is_shared());
//! # assert_eq!(format!("{:.2}", reply.trajectories()?[0].length()), "7.40");
//! # Ok::<(), clearway_client::Error>(())
//! ```
//!
//! [`Client::plan`] waits, [`Client::start`] gives a [`Pending`] to poll, and `Client::plan_async`
//! (feature `async`) a future for any executor. Dropping a request cancels it in the planner.
//!
//! Units are metres, radians and seconds. Scenes and refusals are described field by field in
//! the project's `docs/interface.md`.

mod client;
mod error;
#[cfg(feature = "async")]
mod future;
mod gather;
mod pending;
mod pool;
mod reply;
mod scene;

pub use bus::{CallError, ConnectError, Domain, DomainError, Wait};
pub use client::Client;
pub use error::{Error, Refused};
#[cfg(feature = "async")]
pub use future::Planning;
pub use pending::Pending;
pub use pool::ClientOptions;
pub use reply::{Answer, Block, Reply, Trajectory};
pub use scene::Scene;
/// Scenes and the parts of trajectories as values.
pub use schemas::message;
pub use schemas::message::Sample;
