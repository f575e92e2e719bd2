//! The safest motion beside those with many gaps: none of them may have more clearance.

use std::time::{Duration, Instant};

use answer::Answerer;
use fastrand::Rng;
use serde_json::{Value, json};

use crate::judge::{Drive, drive, trajectory};
use crate::scene::Scene;

/// Gaps asked for beside the safest.
const GAPS: usize = 50;

/// From one to the next, metres.
const APART: f64 = 0.02;

/// Clearances that differ by less are the same, metres.
const SAME: f64 = 1e-9;

/// The safest motion of a scene, and what beats it.
#[derive(Debug)]
pub struct Contest {
    /// The safest motion, or what its refusal says.
    pub safest: Result<Drive, String>,
    /// How long that took.
    pub took: Duration,
    /// The gap whose motion has the greatest free clearance, and that motion.
    pub freest: Option<(f64, Drive)>,
    /// The gap whose motion is the farthest from all walls, and that motion.
    pub clearest: Option<(f64, Drive)>,
    /// What a motion with that free clearance, asked for by itself, is refused with.
    pub at_least: Option<String>,
}

impl Contest {
    /// By how much a gap has more free clearance than the safest, metres.
    #[must_use]
    pub fn free_excess(&self) -> Option<f64> {
        self.excess(self.freest.as_ref(), |drive| drive.free_clearance)
    }

    /// By how much a gap has more clearance than the safest, metres.
    #[must_use]
    pub fn clear_excess(&self) -> Option<f64> {
        self.excess(self.clearest.as_ref(), |drive| drive.clearance)
    }

    fn excess(&self, best: Option<&(f64, Drive)>, value: fn(&Drive) -> f64) -> Option<f64> {
        let most = best.map_or(0.0, |(_, drive)| value(drive));
        let own = self.safest.as_ref().map_or(0.0, value);
        (most > own + SAME).then_some(most - own)
    }
}

/// Asks for the safest motion, for many gaps, and for what these reach. `number` chooses the gaps.
#[must_use]
pub fn contest(scene: &Scene, number: u64) -> Contest {
    let mut answerer = Answerer::new(&answer::Caps::default());
    let mut ask = |clearance: Value| ask(&mut answerer, scene, &clearance);
    let begin = Instant::now();
    let safest = ask(json!("safest"));
    let took = begin.elapsed();
    let first = Rng::with_seed(number).f64();
    let mut freest: Option<(f64, Drive)> = None;
    let mut clearest: Option<(f64, Drive)> = None;
    for index in 0..GAPS {
        let gap = APART * (index as f64 + first);
        match ask(json!({ "gap": gap })) {
            Ok(drive) => {
                if freest.as_ref().is_none_or(|(_, b)| drive.free_clearance > b.free_clearance) {
                    freest = Some((gap, drive.clone()));
                }
                if clearest.as_ref().is_none_or(|(_, best)| drive.clearance > best.clearance) {
                    clearest = Some((gap, drive));
                }
            }
            // No larger gap passes, either.
            Err(refusal) if refusal.contains("so the gap must be") => break,
            Err(_) => {}
        }
    }
    let known = [freest.as_ref().map(|(_, drive)| drive), safest.as_ref().ok()];
    let most = known.into_iter().flatten().map(|drive| drive.free_clearance).fold(0.0, f64::max);
    let at_least = (most > 0.0 && most.is_finite())
        .then(|| ask(json!({ "at_least": most - SAME })).err())
        .flatten();
    Contest { safest, took, freest, clearest, at_least }
}

fn ask(answerer: &mut Answerer, scene: &Scene, clearance: &Value) -> Result<Drive, String> {
    let request = scene.request(clearance, &json!({ "count": 2 }));
    trajectory(answerer, &request).map(|trajectory| drive(&trajectory))
}
