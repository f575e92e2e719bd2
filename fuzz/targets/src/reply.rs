//! Parts of replies as a client reads them from shared memory.

use schemas::convert;
use schemas::json;
use schemas::message::{Refusal, Reply, ReplyAssembler, Trajectory};
use schemas::wire::ReplyHeader;

use crate::limits::small_caps;
use crate::memory::split;

/// The most memory that a reply may take here, bytes.
const MOST_BYTES: usize = 1 << 20;

/// Parts of a reply: for each the number of its cells (4 bytes), its header and its cells.
pub fn reply(mut bytes: &[u8]) {
    let mut assembler = ReplyAssembler::with_most_bytes(MOST_BYTES);
    while let Some((count, rest)) = bytes.split_first_chunk() {
        let count = u32::from_le_bytes(*count) as usize;
        let length = size_of::<ReplyHeader>().saturating_add(count.saturating_mul(8));
        let (part, rest) = rest.split_at(length.min(rest.len()));
        bytes = rest;
        let (header, cells) = split(part, size_of::<ReplyHeader>());
        let header: ReplyHeader = bytemuck::pod_read_unaligned(&header);
        let cells: Vec<u64> = bytemuck::pod_collect_to_vec(&cells);
        let Ok(part) = convert::read_part(&header, &cells) else { continue };
        match assembler.push(part) {
            Ok(None) => {}
            Ok(Some(reply)) => {
                check_json(&reply);
                assembler = ReplyAssembler::with_most_bytes(MOST_BYTES);
            }
            Err(_) => assembler = ReplyAssembler::with_most_bytes(MOST_BYTES),
        }
    }
}

fn check_json(reply: &Reply) {
    let text = json::reply_to_json(reply);
    let read = serde_json::from_str::<serde_json::Value>(&text);
    assert!(read.is_ok_and(|value| value.is_object()), "no JSON object: {text}");
}

/// What holds for every reply of a planner.
pub(crate) fn check_reply(reply: &Reply) {
    check_json(reply);
    match &reply.answers {
        Err(refusal) => check_refusal(refusal),
        Ok(answers) => {
            assert!(!answers.is_empty(), "a reply without answers");
            for answer in answers {
                match answer {
                    Err(refusal) => check_refusal(refusal),
                    Ok(trajectory) => check_trajectory(trajectory),
                }
            }
        }
    }
}

fn check_refusal(refusal: &Refusal) {
    assert!(!refusal.message.is_empty(), "{refusal:?}");
}

fn check_trajectory(trajectory: &Trajectory) {
    let most = small_caps().samples;
    assert!(trajectory.samples.len() as u64 <= most, "{} samples", trajectory.samples.len());
    let Trajectory { length, duration, gaps, clearance, bound, free_clearance, .. } = trajectory;
    assert!(length.is_finite() && *length >= 0.0, "length {length}");
    assert!(duration.is_finite() && *duration >= 0.0, "duration {duration}");
    assert!(gaps.iter().all(|gap| gap.is_finite()), "gaps {gaps:?}");
    assert!(!clearance.value.is_nan() && clearance.at.is_finite(), "{clearance:?}");
    assert!(bound.is_none_or(|bound| bound.is_finite() && bound >= 0.0), "bound {bound:?}");
    assert!(!free_clearance.is_some_and(f64::is_nan), "free clearance {free_clearance:?}");
    for leg in &trajectory.legs {
        assert!(leg.length.is_finite() && !leg.clearance.is_nan(), "{leg:?}");
    }
    let mut before = f64::NEG_INFINITY;
    for sample in &trajectory.samples {
        let numbers = sample.position.iter().chain(&sample.velocity);
        let finite = numbers.chain([&sample.heading, &sample.yaw_rate]).all(|n| n.is_finite());
        assert!(finite && sample.t > before, "after {before} s: {sample:?}");
        before = sample.t;
    }
}
