//! Shortens tracks with arcs.

use super::car::ArcTrack;
use super::probe::Probe;
use super::steer::{RunAlong, SAME_COST, SteerPlace, Steered, Steering, Word};
use crate::budget::Spent;
use crate::geometry::{Vector, unit};
use crate::motion::{Curve, wrapped};

/// Places between which other motions are tried.
const MOST_PLACES: usize = 64;

/// Motions are tried from each place to as many that follow, and then to every so many.
const NEXT: usize = 8;
const STRIDE: usize = 5;

/// How often shortcuts and moves of places follow each other.
const ROUNDS: usize = 4;

/// Places are moved by steps from the first to the last part of the least radius.
const FIRST_STEP: f64 = 0.25;
const LAST_STEP: f64 = 1e-3;
const MOST_SWEEPS: usize = 8;

/// Parts of a length that are rounding.
const ROUNDING: f64 = 1e-6;

/// A change must lower the cost by this part of a step.
const WORTH: f64 = 1e-3;
const WORTH_ROUND: f64 = 1e-3;

/// Lowers the cost of a track.
pub(super) fn smooth(
    track: &mut ArcTrack,
    steering: &Steering,
    probe: &Probe<'_>,
) -> Result<(), Spent> {
    let mut cost = cost_of(&track.words, steering);
    for _ in 0..ROUNDS {
        if let Some(other) = shortcut(&places_on(track, steering), steering, probe)?
            && cost_of(&other.words, steering) < cost
        {
            *track = other;
        }
        descend(track, steering, probe)?;
        let before = std::mem::replace(&mut cost, cost_of(&track.words, steering));
        if before - cost <= WORTH_ROUND * before {
            break;
        }
    }
    Ok(())
}

/// The curves of a track: pieces of one line or circle are one.
pub(super) fn curves(
    track: &ArcTrack,
    steering: &Steering,
    probe: &Probe<'_>,
) -> Result<Option<Vec<Curve<2>>>, Spent> {
    let mut pieces: Vec<Steered> = Vec::new();
    for piece in track.words.iter().flat_map(|word| word.pieces()) {
        match pieces.last_mut() {
            Some(last) if last.along == piece.along && last.back == piece.back => {
                last.size += piece.size;
            }
            _ => pieces.push(*piece),
        }
    }
    let mut curves = Vec::with_capacity(pieces.len());
    let mut at = track.places[0];
    for piece in &pieces {
        curves.push(steering.curve(&at, piece, probe));
        at = steering.follow(&at, piece);
    }
    if let Some(Curve::Line { to, .. }) = curves.last_mut() {
        *to = probe.errand.goal.position;
    }
    if curves.is_empty() {
        let position = probe.errand.start.position;
        let from_heading = wrapped(probe.errand.start.heading);
        curves.push(Curve::Turn { position, from_heading, sweep: 0.0 });
    }
    for curve in &curves {
        if !probe.is_free(curve)? {
            return Ok(None);
        }
    }
    Ok(Some(curves))
}

/// A track in the scene as it is, to the goal as it is; `None` if its last motion can't lead there.
pub(super) fn brought_back(
    track: &ArcTrack,
    (own, exactly): (&Steering, &Steering),
    probe: &Probe<'_>,
    exact: &Probe<'_>,
) -> Result<Option<ArcTrack>, Spent> {
    let mut at = SteerPlace { at: Vector::zeros(), heading: 0.0 };
    let mut back = ArcTrack { places: vec![at], words: Vec::new() };
    let mut others = Vec::new();
    for (index, word) in track.words.iter().enumerate() {
        let grown = word.pieces().iter().map(|piece| {
            let factor = match piece.along {
                RunAlong::Line => probe.unit,
                RunAlong::Circle(_) => exactly.radius / own.radius,
                RunAlong::Turn(_) => 1.0,
            };
            Steered { size: factor * piece.size, ..*piece }
        });
        let pieces: Vec<_> = grown.collect();
        let mut word = exactly.word(&pieces);
        if index + 1 == track.words.len() {
            // To the goal the same way, or the most alike.
            let goal = (&exact.goal, exact.goal_heading);
            exactly.join(&at, goal, f64::INFINITY, &mut others, exact)?;
            let differs = |other: &Word| {
                let kind = |word: &Word| -> Vec<_> {
                    word.pieces().iter().map(|piece| (piece.along, piece.back)).collect()
                };
                (kind(other) != kind(&word), (other.cost - word.cost).abs())
            };
            let alike = others.iter().min_by(|one, other| {
                let (one, other) = (differs(one), differs(other));
                one.0.cmp(&other.0).then(one.1.total_cmp(&other.1))
            });
            let Some(alike) = alike else { return Ok(None) };
            word = *alike;
        }
        for piece in word.pieces() {
            at = exactly.follow(&at, piece);
        }
        back.places.push(at);
        back.words.push(word);
    }
    Ok(Some(back))
}

fn cost_of(words: &[Word], steering: &Steering) -> f64 {
    let stops = words.windows(2).map(|pair| steering.cost_of_change(&pair[0], &pair[1]));
    words.iter().map(|word| word.cost).sum::<f64>() + stops.sum::<f64>()
}

/// Places along a track, evenly.
fn places_on(track: &ArcTrack, steering: &Steering) -> Vec<SteerPlace> {
    let total: f64 =
        track.words.iter().flat_map(|word| word.pieces()).map(|piece| piece.size).sum();
    let apart = (total / MOST_PLACES as f64).max(1e-9);
    let mut places = vec![track.places[0]];
    let mut since = 0.0;
    for (word, from) in track.words.iter().zip(&track.places) {
        let mut at = *from;
        for piece in word.pieces() {
            let mut done = 0.0;
            // A piece that ends just there needs no other place.
            while since + (piece.size - done) > apart * (1.0 + ROUNDING) {
                done += apart - since;
                since = 0.0;
                places.push(steering.follow(&at, &Steered { size: done, ..*piece }));
            }
            since += piece.size - done;
            at = steering.follow(&at, piece);
        }
        // Where it changes between forwards and backwards, it may have to.
        if since > ROUNDING * apart {
            places.push(at);
            since = 0.0;
        }
    }
    if let (Some(last), Some(end)) = (places.last_mut(), track.places.last()) {
        *last = *end;
    }
    thin(places)
}

fn thin(places: Vec<SteerPlace>) -> Vec<SteerPlace> {
    let every = places.len().div_ceil(2 * MOST_PLACES);
    let last = places.len() - 1;
    let is_kept = |index: &usize| index.is_multiple_of(every) || *index == last;
    (0..places.len()).filter(is_kept).map(|index| places[index]).collect()
}

/// The least costly motion to a place that is free and costs less than `most`.
fn best_word(
    (from, to): (&SteerPlace, &SteerPlace),
    is_last: bool,
    (steering, most): (&Steering, f64),
    words: &mut Vec<Word>,
    probe: &Probe<'_>,
) -> Result<Option<Word>, Spent> {
    let heading = if is_last { probe.goal_heading } else { Some(to.heading) };
    let at = if is_last { &probe.goal } else { &to.at };
    steering.join(from, (at, heading), most, words, probe)?;
    for word in &*words {
        if steering.drive(from, word.pieces(), probe)?.is_some() {
            return Ok(Some(*word));
        }
    }
    Ok(None)
}

/// The least costly way along some of the places, in order.
fn shortcut(
    places: &[SteerPlace],
    steering: &Steering,
    probe: &Probe<'_>,
) -> Result<Option<ArcTrack>, Spent> {
    let last = places.len() - 1;
    let mut best: Vec<(f64, usize, Option<Word>)> = vec![(f64::INFINITY, 0, None); places.len()];
    best[0].0 = 0.0;
    let mut words = Vec::new();
    for from in 0..last {
        let (cost, _, before) = best[from];
        if cost.is_infinite() {
            continue;
        }
        for to in from + 1..=last {
            let is_tried = to - from <= NEXT || (to - from) % STRIDE == 0 || to == last;
            let most = best[to].0 - cost - SAME_COST * steering.radius;
            if !is_tried || (places[to].at - places[from].at).norm() >= most {
                continue;
            }
            let ends = (&places[from], &places[to]);
            let word = best_word(ends, to == last, (steering, most), &mut words, probe)?;
            if let Some(word) = word {
                let stop = before.map_or(0.0, |before| steering.cost_of_change(&before, &word));
                if word.cost + stop < most {
                    best[to] = (cost + word.cost + stop, from, Some(word));
                }
            }
        }
    }
    let mut track = ArcTrack::default();
    let mut at = last;
    while let Some(word) = best[at].2 {
        track.places.push(places[at]);
        track.words.push(word);
        at = best[at].1;
    }
    if at != 0 {
        return Ok(None);
    }
    track.places.push(places[0]);
    track.places.reverse();
    track.words.reverse();
    Ok(Some(track))
}

/// Moves and turns the places as long as that lowers the cost.
fn descend(track: &mut ArcTrack, steering: &Steering, probe: &Probe<'_>) -> Result<(), Spent> {
    let mut words = Vec::new();
    let mut part = FIRST_STEP;
    while part > LAST_STEP {
        for _ in 0..MOST_SWEEPS {
            let mut changed = false;
            for index in 1..track.places.len().saturating_sub(1) {
                for way in 0..6 {
                    let to = moved(&track.places[index], way, part, steering);
                    changed |= replace(track, index, &to, part, steering, &mut words, probe)?;
                }
            }
            if !changed {
                break;
            }
        }
        part /= 2.0;
    }
    Ok(())
}

/// A place a little ahead, behind, to the left or right, or turned.
fn moved(place: &SteerPlace, way: usize, part: f64, steering: &Steering) -> SteerPlace {
    let by = if way.is_multiple_of(2) { part } else { -part };
    let step = by * steering.radius;
    let ahead = unit(place.heading);
    match way / 2 {
        0 => SteerPlace { at: place.at + ahead * step, ..*place },
        1 => SteerPlace { at: place.at + Vector::<2>::new(-ahead.y, ahead.x) * step, ..*place },
        _ => SteerPlace { heading: wrapped(place.heading + by), ..*place },
    }
}

/// Leads the track through another place if that costs less; whether it does.
fn replace(
    track: &mut ArcTrack,
    index: usize,
    to: &SteerPlace,
    part: f64,
    steering: &Steering,
    words: &mut Vec<Word>,
    probe: &Probe<'_>,
) -> Result<bool, Spent> {
    let span = index.saturating_sub(2)..(index + 2).min(track.words.len());
    let old = cost_of(&track.words[span.clone()], steering);
    let most = old - WORTH * part * steering.radius;
    let (from, next) = (track.places[index - 1], track.places[index + 1]);
    let is_last = index + 1 == track.words.len();
    let pair = [track.words[index - 1], track.words[index]];
    if (to.at - from.at).norm() + (next.at - to.at).norm() >= most {
        return Ok(false);
    }
    let Some(first) = best_word((&from, to), false, (steering, most), words, probe)? else {
        return Ok(false);
    };
    let left = most - first.cost;
    let Some(second) = best_word((to, &next), is_last, (steering, left), words, probe)? else {
        return Ok(false);
    };
    track.words[index - 1] = first;
    track.words[index] = second;
    if cost_of(&track.words[span], steering) >= most {
        track.words[index - 1] = pair[0];
        track.words[index] = pair[1];
        return Ok(false);
    }
    track.places[index] = *to;
    Ok(true)
}
