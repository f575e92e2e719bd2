//! Free arcs about corners, kept from one search to the next.

use super::disc::FreeArc;
use crate::free_space::floor::NONE;

/// The free arcs about corners that have been looked at. They are kept from one search to the
/// next; a search that finds some draws from its budget what making them has drawn.
#[derive(Debug, Default)]
pub(super) struct ArcMemo {
    /// For which radius they are; `None`: for the last search alone.
    pub(super) radius: Option<f64>,
    /// Counts searches.
    pub(super) search: u32,
    pub(super) at: Vec<CornerArcs>,
    pub(super) arcs: Vec<FreeArc>,
}

/// Where the arcs of a vertex are.
#[derive(Debug, Clone, Copy)]
pub(super) struct CornerArcs {
    /// Index of the first; `NONE` if they have not been made.
    pub(super) first: u32,
    pub(super) count: u32,
    /// Steps that they took.
    pub(super) steps: u32,
    /// The last search that looked at them.
    pub(super) search: u32,
}

impl ArcMemo {
    const UNKNOWN: CornerArcs = CornerArcs { first: NONE, count: 0, steps: 0, search: 0 };

    /// Begins a search; with a radius, for arcs that depend on it alone.
    pub(super) fn begin(&mut self, vertices: usize, radius: Option<f64>) {
        let keeps = radius.is_some() && self.radius == radius && self.at.len() == vertices;
        self.search = self.search.wrapping_add(1);
        if !keeps || self.search == 0 {
            self.search = 1;
            self.arcs.clear();
            self.at.clear();
            self.at.resize(vertices, Self::UNKNOWN);
        }
        self.radius = radius;
    }

    pub(super) fn bytes(&self) -> usize {
        self.at.capacity() * size_of::<CornerArcs>() + self.arcs.capacity() * size_of::<FreeArc>()
    }
}
