//! Changes to valid inputs: the same seed gives the same changes.

use fastrand::Rng;

/// The longest input made, bytes.
const MOST_BYTES: usize = 1 << 16;

/// Numbers at which programs go wrong.
const NUMBERS: [u64; 16] = [
    0,
    1,
    2,
    1 << 31,
    1 << 32,
    1 << 63,
    u64::MAX,
    u64::MAX - 1,
    f64::NAN.to_bits(),
    f64::INFINITY.to_bits(),
    f64::NEG_INFINITY.to_bits(),
    (-0.0_f64).to_bits(),
    5e-324_f64.to_bits(),
    1e-300_f64.to_bits(),
    1e155_f64.to_bits(),
    f64::MAX.to_bits(),
];

/// The same, including invalid text.
const WORDS: [&str; 20] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "1e-9",
    "1e-320",
    "1e15",
    "1e155",
    "1e308",
    "1e999",
    "65536",
    "18446744073709551616",
    "0.1",
    "null",
    "[]",
    "{}",
    "\"\"",
    "true",
    "\"safest\"",
];

/// `input` with one to four changes, some of which take parts from `other`.
pub(crate) fn mutated(random: &mut Rng, input: &[u8], other: &[u8], text: bool) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..random.usize(1..=4) {
        if text && random.u8(..4) > 0 {
            change_text(random, &mut bytes);
        } else {
            change_bytes(random, &mut bytes, other);
        }
    }
    bytes.truncate(MOST_BYTES);
    bytes
}

fn change_bytes(random: &mut Rng, bytes: &mut Vec<u8>, other: &[u8]) {
    if bytes.is_empty() {
        bytes.extend_from_slice(other);
        return;
    }
    let at = random.usize(..bytes.len());
    match random.u8(..9) {
        0 => bytes[at] ^= 1 << random.u8(..8),
        1 => bytes[at] = random.choice([0, 1, 2, 0x7f, 0x80, 0xff]).unwrap_or_default(),
        2 | 3 => {
            let number = random.choice(NUMBERS).unwrap_or_default().to_le_bytes();
            overwrite(bytes, at / 8 * 8, &number);
        }
        4 => {
            let small = random.u32(..6).to_le_bytes();
            overwrite(bytes, at / 4 * 4, &small);
        }
        5 => drop(bytes.drain(range(random, at, bytes.len()))),
        6 => {
            let part = bytes[range(random, at, bytes.len())].to_vec();
            let to = random.usize(..=bytes.len());
            bytes.splice(to..to, part);
        }
        7 => {
            let from = random.usize(..=other.len());
            bytes.truncate(at);
            bytes.extend_from_slice(&other[from..]);
        }
        _ => bytes.truncate(at),
    }
}

fn overwrite(bytes: &mut [u8], at: usize, with: &[u8]) {
    let length = with.len().min(bytes.len() - at);
    bytes[at..at + length].copy_from_slice(&with[..length]);
}

/// From `at` on: some bytes, rarely many.
fn range(random: &mut Rng, at: usize, length: usize) -> std::ops::Range<usize> {
    let most = random.choice([8, 64, 4096]).unwrap_or_default();
    at..at + random.usize(1..=most.min(length - at))
}

/// Puts another word in place of a number or a word, or doubles what stands between commas.
fn change_text(random: &mut Rng, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        return;
    }
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-._".contains(byte);
    let at = random.usize(..bytes.len());
    let Some(from) = bytes[at..].iter().position(is_word).map(|offset| at + offset) else { return };
    let length = bytes[from..].iter().position(|byte| !is_word(byte));
    let to = length.map_or(bytes.len(), |length| from + length);
    if random.u8(..4) > 0 {
        let word = random.choice(WORDS).unwrap_or_default();
        bytes.splice(from..to, word.bytes());
    } else {
        let end = bytes[to..].iter().position(|byte| *byte == b',').map_or(to, |at| to + at);
        let part = [b",", &bytes[from..end]].concat();
        bytes.splice(end..end, part);
    }
}
