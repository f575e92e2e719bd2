//! The names of free spaces.

use sha2::{Digest as _, Sha256};

use super::{AxisBox, Digest, FreeSpace, Solid, Vector};

impl FreeSpace {
    /// Whether it has nothing but, perhaps, its name.
    pub fn is_name_only(&self) -> bool {
        self.channels.is_none() && self.solids.is_none() && self.bounds.is_none()
    }

    /// Its name: the SHA-256 digest of its canonical outlines, whatever name it gives itself.
    ///
    /// These are, in order: the line `clearway free space 1`; `c`, 1 if the channels are in
    /// travel order or else 0, and the channels, if there are any; `s` and the solids, if there are
    /// any; `b` and the bounds, if there are any. Lists begin with their length as a `u64`. A
    /// box is its least and its greatest corner; a solid is its outline, that of a box in two
    /// dimensions counter-clockwise from its least corner. Points are their coordinates as
    /// `f64`, metres, with no negative zero. A union of boxes is a length of which all bits are set,
    /// then the list of its boxes. All numbers are little-endian.
    pub fn digest(&self) -> Digest {
        let Self { channels, in_order, solids, bounds, named: _ } = self;
        let mut hash = Sha256::new();
        hash.update(b"clearway free space 1\n");
        if let Some(channels) = channels {
            hash.update([b'c', u8::from(*in_order)]);
            hash.update((channels.len() as u64).to_le_bytes());
            channels.iter().for_each(|channel| add_box(&mut hash, channel));
        }
        if let Some(solids) = solids {
            hash.update(b"s");
            hash.update((solids.len() as u64).to_le_bytes());
            solids.iter().for_each(|solid| add_solid(&mut hash, solid));
        }
        if let Some(bounds) = bounds {
            hash.update(b"b");
            add_box(&mut hash, bounds);
        }
        Digest(hash.finalize().into())
    }
}

/// In place of the length of an outline: what follows are boxes.
const UNION: u64 = u64::MAX;

fn add_box(hash: &mut Sha256, sides: &AxisBox) {
    add_point(hash, &sides.min);
    add_point(hash, &sides.max);
}

fn add_solid(hash: &mut Sha256, solid: &Solid) {
    let mut add = |corners: &[Vector]| {
        hash.update((corners.len() as u64).to_le_bytes());
        corners.iter().for_each(|corner| add_point(hash, corner));
    };
    match solid {
        Solid::Polygon(vertices) => add(vertices),
        Solid::Box(AxisBox { min, max }) => match (min.as_slice(), max.as_slice()) {
            ([left, low], [right, high]) => {
                add(&[[*left, *low], [*right, *low], [*right, *high], [*left, *high]]
                    .map(Into::into));
            }
            _ => add(&[*min, *max]),
        },
        Solid::Boxes(boxes) => {
            hash.update(UNION.to_le_bytes());
            hash.update((boxes.len() as u64).to_le_bytes());
            boxes.iter().for_each(|sides| add_box(hash, sides));
        }
    }
}

fn add_point(hash: &mut Sha256, point: &Vector) {
    for coordinate in point.as_slice() {
        hash.update((coordinate + 0.0).to_bits().to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(solid: Solid) -> FreeSpace {
        let bounds = AxisBox { min: [0.0, 0.0].into(), max: [9.0, 6.0].into() };
        FreeSpace { solids: Some(vec![solid]), bounds: Some(bounds), ..FreeSpace::default() }
    }

    /// The digest of the bytes as documented, computed with `sha256sum`.
    #[test]
    fn name_of_a_room_is_pinned() {
        let solid = Solid::Box(AxisBox { min: [1.0, 2.0].into(), max: [3.0, 4.0].into() });
        let expected = "c4eb00e7a950358b545530bad0698b29801177dde28af2ba24ff1aead8a40df5";
        assert_eq!(room(solid).digest().to_string(), expected);
    }

    #[test]
    fn boxes_and_their_outlines_have_the_same_name() {
        let sides = AxisBox { min: [-0.0, 2.0].into(), max: [3.0, 4.0].into() };
        let corners = [[0.0, 2.0], [3.0, 2.0], [3.0, 4.0], [0.0, 4.0]].map(Vector::from);
        let outline = room(Solid::Polygon(corners.to_vec()));
        assert_eq!(room(Solid::Box(sides)).digest(), outline.digest());
        let named = FreeSpace { named: Some(Digest([7; 32])), ..outline.clone() };
        assert_eq!(named.digest(), outline.digest());
        let other = FreeSpace { bounds: None, ..outline.clone() };
        assert_ne!(other.digest(), outline.digest());
    }

    /// The digest of the bytes as documented, computed with `sha256sum`.
    #[test]
    fn name_of_a_union_is_pinned() {
        let sides = |min: [f64; 2], max: [f64; 2]| AxisBox { min: min.into(), max: max.into() };
        let union =
            Solid::Boxes(vec![sides([1.0, 2.0], [3.0, 4.0]), sides([3.0, 2.0], [4.0, 3.0])]);
        let expected = "0fc81cae28c6f81d6d37b8e0a79727121ba1bd144ddafbe740c024a6803c8b91";
        assert_eq!(room(union).digest().to_string(), expected);
    }
}
