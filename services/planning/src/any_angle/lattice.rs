//! The last rungs of the ladder: turns in place anywhere, and a search over poses.
//!
//! [`aligned`] joins places where the robot can turn by straight lines, above all those through
//! narrow passages. [`search`] knows poses in narrow places too, and arcs. It is complete at its
//! [`Resolution`]. What they find is shortened. Both work in the [scene's own frame](OwnScene), so
//! that a scene that is moved, turned or in another unit has the same answer.

use super::Errand;
use crate::budget::{Budget, Held, Spent};
use crate::motion::{Curve, Leg};

use explore::Manner;
use field::Field;
use headings::Headings;
use passage::GateAxis;
use probe::Probe;
use scene::OwnScene;
use steer::Steering;
use way::Way;

mod car;
mod explore;
mod field;
mod headings;
mod passage;
mod probe;
mod scene;
mod shorten;
mod smooth;
mod steer;
mod table;
mod way;
mod widen;

#[cfg(test)]
mod tests;

/// How finely a search looks.
#[derive(Debug, Clone, Copy)]
struct Level {
    /// Side of a bin, as a part of the footprint's width.
    bin: f64,
    /// Even parts of a turn.
    headings: u16,
    /// Whether there are poses where the robot can't turn.
    is_fine: bool,
    /// Steps of the budget after which it ends.
    most_steps: u64,
}

const COARSE: Level = Level { bin: 0.25, headings: 16, is_fine: false, most_steps: 30_000_000 };

const FINE: Level = Level { bin: 0.125, headings: 16, is_fine: true, most_steps: 40_000_000 };

/// Sides of bins in the search with arcs, as parts of the footprint's width: the next one where
/// the one before finds nothing.
const BINS: [f64; 2] = [0.25, 0.125];

/// Steps of the budget after which each of them ends.
const MOST_STEPS: u64 = 20_000_000;

/// Its least radius, as a part of the footprint's width.
const LEAST_RADIUS: f64 = 0.5;

/// How finely a search over poses tells them apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Side of a bin, metres.
    pub step: f64,
    /// Headings in a turn.
    pub headings: usize,
    /// Whether a search ended at its limit of steps, before it had looked everywhere.
    pub is_cut_short: bool,
}

/// What a search is to keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Kept {
    /// From the walls, on every leg, metres.
    pub(super) least: f64,
    /// Whether from wall points that are nearer at the start or the goal only as much as there.
    pub(super) as_at_ends: bool,
    /// Ways longer than this are of no use, metres.
    pub(super) most_length: f64,
}

impl Kept {
    /// It need not touch a wall, and may be of any length.
    const NOTHING: Self = Self { least: 0.0, as_at_ends: false, most_length: f64::INFINITY };

    /// So much from all walls.
    #[cfg(test)]
    fn all_along(least: f64) -> Self {
        Self { least, as_at_ends: false, most_length: f64::INFINITY }
    }
}

/// Memory that is used again from one search to the next.
#[derive(Debug, Default)]
pub(super) struct LatticeMemory {
    field: Field,
    axes: Vec<GateAxis>,
    headings: Headings,
    search: explore::PoseMemory,
    car: car::ArcMemory,
    resolution: Option<Resolution>,
    /// The scene as searches see it, once there has been one.
    scene: Option<OwnScene>,
    /// What [`aligned`] found there that need keep nothing, by whether it may drive backwards.
    bare: [Option<Option<Vec<Curve<2>>>>; 2],
}

impl LatticeMemory {
    /// Ends with a scene: the next search is in another.
    pub(super) fn end(&mut self, budget: &Budget<'_>) {
        if let Some(scene) = self.scene.take() {
            scene.release(budget);
        }
        self.field.forget();
        self.bare = [None, None];
    }

    /// The memory that it holds, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.field.bytes()
            + self.search.bytes()
            + self.car.bytes()
            + self.axes.capacity() * size_of::<GateAxis>()
    }

    /// The resolution of the last search; `None` if there was no way even for a disc.
    pub(super) fn resolution(&self) -> Option<Resolution> {
        self.resolution
    }

    /// Notes how finely a search has looked, and whether it or one before it for the same errand
    /// ended at its limit.
    fn note(&mut self, step: f64, headings: usize, is_cut_short: bool) {
        let was_cut_short = self.resolution.is_some_and(|before| before.is_cut_short);
        let is_cut_short = is_cut_short || was_cut_short;
        self.resolution = Some(Resolution { step, headings, is_cut_short });
    }
}

/// Straight lines between places where the robot can turn. The curves lead from the start to the
/// goal; `None` if no such motion is found.
pub(super) fn aligned(
    errand: &Errand<'_>,
    kept: Kept,
    memory: &mut LatticeMemory,
    budget: &Budget<'_>,
) -> Result<Option<Vec<Curve<2>>>, Spent> {
    if !errand.abilities.turn_in_place {
        return Ok(None);
    }
    // The ladder asks for that with many gaps.
    let is_bare = kept == Kept::NOTHING;
    let reverse = usize::from(errand.abilities.reverse);
    if is_bare && let Some(known) = &memory.bare[reverse] {
        return Ok(known.clone());
    }
    let run = |probes: &Probes<'_>, memory: &mut _| straight(probes, COARSE, memory);
    let found = in_own_scene((errand, kept), memory, budget, run)?;
    if is_bare {
        memory.bare[reverse] = Some(found.clone());
    }
    Ok(found)
}

/// The search over poses. The curves lead from the start to the goal; `None` if there are none at
/// the memory's [resolution](LatticeMemory::resolution).
pub(super) fn search(
    errand: &Errand<'_>,
    kept: Kept,
    memory: &mut LatticeMemory,
    budget: &Budget<'_>,
) -> Result<Option<Vec<Curve<2>>>, Spent> {
    in_own_scene((errand, kept), memory, budget, |probes, memory| {
        if errand.abilities.turn_in_place {
            let found = straight(probes, FINE, memory)?;
            if found.is_some() {
                return Ok(found);
            }
        }
        steered(probes, memory)
    })
}

/// What searches ask, in the scene's own frame, and in the scene as it is.
struct Probes<'a> {
    own: Probe<'a>,
    exact: Probe<'a>,
}

/// Lays out a search in the scene's own frame, and runs it if there is a way for a disc.
fn in_own_scene(
    (errand, kept): (&Errand<'_>, Kept),
    memory: &mut LatticeMemory,
    budget: &Budget<'_>,
    run: impl FnOnce(&Probes<'_>, &mut LatticeMemory) -> Result<Option<Vec<Curve<2>>>, Spent>,
) -> Result<Option<Vec<Curve<2>>>, Spent> {
    memory.resolution = None;
    let scene = match memory.scene.take() {
        Some(scene) => scene,
        None => match OwnScene::of(errand, budget)? {
            Some(scene) => scene,
            None => return Ok(None),
        },
    };
    let found = (|| {
        let own = scene.errand(errand);
        let probes = Probes {
            own: Probe::own((errand, kept), (&own, &scene), budget)?,
            exact: Probe::new(errand, kept, budget)?,
        };
        let Some(_held) = lay_out(&probes.own, memory)? else { return Ok(None) };
        run(&probes, memory)
    })();
    if let Some(resolution) = &mut memory.resolution {
        resolution.step *= scene.length;
    }
    memory.scene = Some(scene);
    if found.is_err() {
        memory.end(budget);
    }
    found
}

/// A motion of straight legs, led farther from the walls: the free clearance is as large as it can
/// be made by moving the places where it turns. `None` if it is no such motion, or nowhere turns.
pub(super) fn widened(
    errand: &Errand<'_>,
    legs: &[Leg<2>],
    budget: &Budget<'_>,
) -> Result<Option<Vec<Curve<2>>>, Spent> {
    let probe = Probe::new(errand, Kept::NOTHING, budget)?;
    let Some(mut way) = Way::of(legs, &probe) else { return Ok(None) };
    if way.backs.len() < 2 {
        return Ok(None);
    }
    widen::widen(&mut way, &probe)?;
    way.curves(&probe)
}

/// The way for a disc, and the narrow passages; `None` if there is no way for a disc.
fn lay_out<'a>(probe: &Probe<'a>, memory: &mut LatticeMemory) -> Result<Option<Held<'a>>, Spent> {
    let held = memory.field.build(probe)?;
    if held.is_some() {
        passage::find(probe, &memory.field, &mut memory.axes)?;
    }
    Ok(held)
}

fn straight(
    Probes { own: probe, exact }: &Probes<'_>,
    level: Level,
    memory: &mut LatticeMemory,
) -> Result<Option<Vec<Curve<2>>>, Spent> {
    memory.headings.set(probe, level.headings, &memory.axes);
    let bin = level.bin * probe.errand.footprint.width();
    let headings = memory.headings.all.len();
    let Level { is_fine, most_steps, .. } = level;
    let manner = Manner { bin, is_fine, most_steps };
    let LatticeMemory { field, axes, headings: all, search, .. } = memory;
    let found = explore::explore(probe, (field, all, axes), manner, search)?;
    memory.note(bin, headings, memory.search.is_cut_short);
    let Some(mut way) = found else { return Ok(None) };
    if !way.check(probe)? {
        return Ok(None);
    }
    let found = way.clone();
    shorten::shorten(&mut way, probe)?;
    // As it was found, if rounding does not let it be shortened.
    for way in [way, found] {
        let curves = way.brought_back(probe, exact).curves(exact)?;
        if curves.is_some() {
            return Ok(curves);
        }
    }
    Ok(None)
}

fn steered(
    Probes { own: probe, exact }: &Probes<'_>,
    memory: &mut LatticeMemory,
) -> Result<Option<Vec<Curve<2>>>, Spent> {
    let [steering, exactly] = [probe, exact].map(|probe| {
        let Errand { footprint, abilities, costs, .. } = probe.errand;
        let radius = abilities.min_turn_radius.max(LEAST_RADIUS * footprint.width());
        let turn = abilities.turn_in_place.then_some(costs.turn);
        Steering { radius, reverse: abilities.reverse, stop: costs.stop, turn }
    });
    for bin in BINS {
        let step = bin * probe.errand.footprint.width();
        let manner = car::ArcManner { steering: &steering, bin: step, most_steps: MOST_STEPS };
        let found = car::explore(probe, &mut memory.field, manner, &mut memory.car)?;
        memory.note(step, usize::from(car::HEADINGS), memory.car.is_cut_short);
        let Some(mut track) = found else { continue };
        let rough = track.clone();
        smooth::smooth(&mut track, &steering, probe)?;
        for track in [track, rough] {
            let track = smooth::brought_back(&track, (&steering, &exactly), probe, exact)?;
            let Some(track) = track else { continue };
            let curves = smooth::curves(&track, &exactly, exact)?;
            if curves.is_some() {
                return Ok(curves);
            }
        }
        return Ok(None);
    }
    Ok(None)
}
