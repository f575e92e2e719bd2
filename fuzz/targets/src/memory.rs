//! Bytes as headers and cells.

/// The first `count` bytes, followed by zeros if there are fewer; and the rest, in whole cells.
pub(crate) fn split(bytes: &[u8], count: usize) -> (Vec<u8>, Vec<u8>) {
    let (head, rest) = bytes.split_at(count.min(bytes.len()));
    let mut head = head.to_vec();
    head.resize(count, 0);
    (head, rest[..rest.len() / 8 * 8].to_vec())
}
