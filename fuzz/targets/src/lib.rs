//! What is fuzzed: everything that reads bytes which others wrote.
//!
//! Each target is a function that takes any bytes and panics if something is wrong with what the
//! project makes of them. `cargo fuzz` runs them under libFuzzer; the tests of this crate replay
//! the corpora in `fuzz/corpus/` and some thousand mutations of them; the program `fuzz`
//! does the same for as long as one likes, on any toolchain.

mod border;
mod floor_plan;
mod limits;
mod memory;
mod mesh;
mod mutate;
mod recording;
mod reply;
mod scene;
mod search;
mod seeds;

use std::path::{Path, PathBuf};

pub use border::{border, message};
pub use floor_plan::floor_plan;
pub use mesh::mesh;
pub use recording::recording;
pub use reply::reply;
pub use scene::scene;
pub use search::{Failure, run, search};

/// Something that reads bytes which others wrote.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name: that of its corpus, and for `cargo fuzz`.
    pub name: &'static str,
    /// Reads any bytes; panics if something is wrong with what comes of them.
    pub run: fn(&[u8]),
    /// Whether its bytes are mainly text.
    pub text: bool,
    /// Valid inputs to start from, each with a name, made from the scenes of the repository.
    pub seeds: fn() -> Vec<(String, Vec<u8>)>,
}

/// All targets.
pub const TARGETS: [Target; 7] = [
    Target { name: "border", run: border, text: false, seeds: seeds::border },
    Target { name: "floor_plan", run: floor_plan, text: true, seeds: seeds::floor_plan },
    Target { name: "mesh", run: mesh, text: false, seeds: seeds::mesh },
    Target { name: "message", run: message, text: false, seeds: seeds::message },
    Target { name: "recording", run: recording, text: false, seeds: seeds::recording },
    Target { name: "reply", run: reply, text: false, seeds: seeds::reply },
    Target { name: "scene", run: scene, text: true, seeds: seeds::scene },
];

impl Target {
    /// Where its corpus is, within the repository.
    pub fn corpus(&self) -> PathBuf {
        Path::new("fuzz/corpus").join(self.name)
    }
}
