//! Free arcs about corners, kept from one search to the next.

use super::disc::FreeArc;
use super::pockets::Pockets;
use crate::free_space::floor::{Floor, NONE};

/// Arcs are kept for so many radii: those used last.
const MOST_RADII: usize = 8;

/// The free arcs about corners that have been looked at. They are kept from one search to the
/// next; a search that finds some draws from its budget what making them has drawn.
#[derive(Debug, Default)]
pub(super) struct ArcMemo {
    /// Radius of the disc that they are for; `None`: for the last search alone.
    radius: Option<f64>,
    /// Counts searches.
    search: u32,
    at: Vec<CornerArcs>,
    arcs: Vec<FreeArc>,
    /// Pockets for the radius, once a search has asked for them.
    pockets: Option<Pockets>,
}

/// Where the arcs of a vertex are.
#[derive(Debug, Clone, Copy)]
struct CornerArcs {
    /// Index of the first; `NONE` if they have not been made.
    first: u32,
    count: u32,
    /// Steps that they took.
    steps: u32,
    /// The last search that looked at them.
    search: u32,
}

/// The arcs about a vertex, as far as they are known.
pub(super) enum KnownArcs {
    /// Not made yet.
    Unknown,
    /// Where they are, and the steps to draw for them.
    Known(u32, u32, u64),
}

impl ArcMemo {
    const UNKNOWN: CornerArcs = CornerArcs { first: NONE, count: 0, steps: 0, search: 0 };

    /// Begins a search among so many vertices.
    fn begin(&mut self, vertices: usize) {
        self.search = self.search.wrapping_add(1);
        if self.radius.is_none() || self.at.len() != vertices || self.search == 0 {
            self.search = 1;
            self.pockets = None;
            self.arcs.clear();
            self.at.clear();
            self.at.resize(vertices, Self::UNKNOWN);
        }
    }

    /// The pockets for its radius, which is that of a disc of this width; `None` for the last
    /// search alone.
    pub(super) fn pockets(&mut self, floor: &Floor, width: f64) -> Option<&mut Pockets> {
        self.radius?;
        Some(self.pockets.get_or_insert_with(|| Pockets::find(floor, width)))
    }

    /// The pockets that were asked for.
    pub(super) fn known_pockets(&self) -> Option<&Pockets> {
        self.pockets.as_ref()
    }

    /// What is known about a vertex; a search pays for its arcs once.
    pub(super) fn look_up(&mut self, vertex: u32) -> KnownArcs {
        let known = &mut self.at[vertex as usize];
        if known.first == NONE {
            return KnownArcs::Unknown;
        }
        let is_paid = known.search == self.search;
        known.search = self.search;
        KnownArcs::Known(known.first, known.count, if is_paid { 0 } else { known.steps.into() })
    }

    /// Where new arcs are to be appended.
    pub(super) fn arcs(&mut self) -> &mut Vec<FreeArc> {
        &mut self.arcs
    }

    /// Notes that the arcs from index `first` on are those of a vertex, and took so many steps.
    pub(super) fn note(&mut self, vertex: u32, first: usize, steps: u64) -> (u32, u32) {
        let count = (self.arcs.len() - first) as u32;
        let (first, search) = (first as u32, self.search);
        let steps = u32::try_from(steps).unwrap_or(u32::MAX);
        self.at[vertex as usize] = CornerArcs { first, count, steps, search };
        (first, count)
    }

    pub(super) fn slice(&self, (first, count): (u32, u32)) -> &[FreeArc] {
        &self.arcs[first as usize..][..count as usize]
    }

    fn bytes(&self) -> usize {
        self.at.capacity() * size_of::<CornerArcs>()
            + self.arcs.capacity() * size_of::<FreeArc>()
            + self.pockets.as_ref().map_or(0, Pockets::bytes)
    }
}

/// The memos of several radii.
#[derive(Debug, Default)]
pub(super) struct ArcMemos(Vec<ArcMemo>);

impl ArcMemos {
    /// The memo for a search among so many vertices, moved to the front. With a radius, for arcs
    /// that depend on it alone.
    pub(super) fn begin(&mut self, vertices: usize, radius: Option<f64>) {
        let known = self.0.iter().position(|memo| memo.radius == radius);
        match known {
            Some(index) => self.0[..=index].rotate_right(1),
            None if self.0.len() < MOST_RADII => self.0.insert(0, ArcMemo::default()),
            None => self.0.rotate_right(1),
        }
        let memo = &mut self.0[0];
        if known.is_none() {
            memo.at.clear();
            memo.pockets = None;
            memo.radius = radius;
        }
        memo.begin(vertices);
    }

    /// The one that the search at hand uses.
    pub(super) fn front(&mut self) -> &mut ArcMemo {
        &mut self.0[0]
    }

    /// To be called before a search on another floor.
    pub(super) fn forget(&mut self) {
        self.0.clear();
    }

    pub(super) fn bytes(&self) -> usize {
        self.0.iter().map(ArcMemo::bytes).sum()
    }
}
