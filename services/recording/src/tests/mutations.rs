//! Changes of every kind to small recordings: each is detected or harmless.

use super::*;

/// The next of a sequence of pseudo-random numbers.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    *state >> 33
}

/// Changes some bytes as disks, transfers and people do.
fn mutate(bytes: &mut Vec<u8>, state: &mut u64) {
    if bytes.is_empty() {
        return;
    }
    let mut below = |most: usize| next(state) as usize % most.max(1);
    let at = below(bytes.len());
    let count = 1 + below(200).min(bytes.len() - at - 1);
    match below(8) {
        0 => bytes[at] ^= 1 << below(8),
        1 => bytes[at] = below(256) as u8,
        2 => bytes[at..at + count].fill(0),
        3 => bytes.truncate(at),
        4 => drop(bytes.drain(at..at + count)),
        5 => {
            let piece = bytes[at..at + count].to_vec();
            let to = below(bytes.len());
            bytes.splice(to..to, piece);
        }
        6 => {
            let to = below(bytes.len() - count);
            bytes.copy_within(at..at + count, to);
        }
        _ => {
            let other = below(bytes.len());
            bytes.swap(at, other);
        }
    }
}

#[test]
fn ten_thousand_changes_are_detected_or_harmless() {
    let compressions = [Compression::None, Compression::Lz4, Compression::Zstd];
    let mut state = 11;
    let (mut detected, mut harmless) = (0, 0);
    for compression in compressions {
        let small = small_with(Options { compression, ..fixed() });
        for round in 0..3_500 {
            let mut bytes = small.bytes.clone();
            if round % 3 == 0 {
                // As a killed recorder leaves it.
                bytes.truncate(small.flushed[3]);
            }
            let before = bytes.clone();
            for _ in 0..=next(&mut state) % 3 {
                mutate(&mut bytes, &mut state);
            }
            let (records, error, summary) = read(&bytes);
            for record in &records {
                let original = &small.records[record.sequence as usize];
                assert_eq!(record, original, "{compression:?}, round {round}");
            }
            assert!(records.is_sorted_by(|a, b| a.sequence < b.sequence), "round {round}");
            match error {
                Some(_) => detected += 1,
                None => {
                    assert_eq!(bytes, before, "{compression:?}, round {round}: not detected");
                    assert!(summary.is_some());
                    harmless += 1;
                }
            }
            if round % 4 == 0 {
                let saved = salvaged(&bytes);
                for record in &saved {
                    assert_eq!(record, &small.records[record.sequence as usize], "round {round}");
                }
                assert!(records.iter().all(|record| saved.contains(record)), "round {round}");
            }
        }
    }
    assert!(detected > 10_000, "{detected} detected, {harmless} harmless");
}
