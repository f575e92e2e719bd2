//! Runs of targets that outlive a panic.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

use fastrand::Rng;

use crate::Target;
use crate::mutate::mutated;

/// An input with which something is wrong.
#[derive(Clone)]
pub struct Failure {
    /// The input.
    pub input: Vec<u8>,
    /// Why the target panicked.
    pub reason: String,
}

impl fmt::Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes of input: {}", self.input.len(), self.reason)
    }
}

/// Runs a target on an input.
pub fn run(target: &Target, input: &[u8]) -> Result<(), Failure> {
    catch_unwind(AssertUnwindSafe(|| (target.run)(input))).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Failure { input: input.to_vec(), reason: text.unwrap_or("a panic").to_owned() }
    })
}

/// Runs a target on `count` mutations of `corpus`; the same `seed` makes the same mutations.
pub fn search(target: &Target, corpus: &[Vec<u8>], count: u64, seed: u64) -> Result<(), Failure> {
    let mut random = Rng::with_seed(seed);
    for _ in 0..count {
        let [input, other] = [0; 2].map(|_| &corpus[random.usize(..corpus.len())]);
        run(target, &mutated(&mut random, input, other, target.text))?;
    }
    Ok(())
}
