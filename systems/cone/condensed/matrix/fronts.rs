//! The data of a factorisation that depend on the pattern only: fronts, their order, and the places
//! of their numbers.
//!
//! A front has pivots, a group of bodies that are eliminated together, and rows, the bodies that
//! are coupled with them. Its numbers are a dense trapezoid, the columns of the factor at its
//! pivots, and an update, which the elimination of the pivots adds to the rows. Fronts form a tree:
//! all rows of a front are pivots or rows of its parent (Duff and Reid 1983; Liu 1992).

use std::ops::Range;

use super::dense::LANES;

/// One front. Places of bodies count from the first body of its branch in [`Fronts::order`].
pub struct Front {
    /// Places of the pivots.
    pub pivots: Range<usize>,
    /// Range of its rows in [`Fronts::rows`] and [`Fronts::in_parent`].
    pub rows: Range<usize>,
    /// Number of its rows that are pivots of its parent: its first rows.
    pub inside: usize,
    /// Range of its children in [`Fronts::children`].
    pub children: Range<usize>,
    /// Range of its trapezoid in the factor of its branch.
    pub factor: Range<usize>,
    /// Start of its update in a stack of its branch; `odd` selects one of the two stacks.
    pub update: usize,
    /// Whether its depth in the tree is odd, so that parent and child use different stacks.
    pub odd: bool,
}

impl Front {
    /// Columns of the trapezoid, three a pivot.
    pub fn width(&self) -> usize {
        3 * self.pivots.len()
    }

    /// Rows of a column of the update, with padding.
    pub fn bottom(&self) -> usize {
        (3 * self.rows.len()).next_multiple_of(LANES)
    }

    /// Rows of a column of the trapezoid, with padding for pieces of [`LANES`] that begin anywhere.
    pub fn height(&self) -> usize {
        (3 * self.bodies() + LANES - 1).next_multiple_of(LANES)
    }

    /// Numbers in the trapezoid.
    pub fn panel_len(&self) -> usize {
        self.height() * self.width()
    }

    /// Its pivots and rows.
    pub fn bodies(&self) -> usize {
        self.pivots.len() + self.rows.len()
    }

    /// Numbers in the update: a square, whose lower triangle is used.
    pub fn update_len(&self) -> usize {
        self.bottom() * 3 * self.rows.len()
    }
}

/// A branch of the tree, or the trunk.
#[derive(Default)]
pub struct Branch {
    /// Its fronts.
    pub fronts: Range<usize>,
    /// Its bodies in the order of elimination.
    pub places: Range<usize>,
    /// Numbers in its factor, without the triangles of the pivots.
    pub factor_len: usize,
    /// Maximum number of numbers in each of its two stacks of updates.
    pub update_len: [usize; 2],
}

/// All fronts, children before their parents.
pub struct Fronts {
    /// Bodies in the order of their elimination.
    pub order: Vec<usize>,
    /// The fronts.
    pub list: Vec<Front>,
    /// Branches, in the order of elimination.
    pub branches: Vec<Branch>,
    /// The trunk, after all branches.
    pub trunk: Branch,
    /// Places of the rows of all fronts, ascending within each. In a branch they count from its
    /// first body, and bodies of the trunk follow those of the branch.
    pub rows: Vec<u32>,
    /// For every row, the start of its three numbers in a column of the parent's trapezoid.
    pub in_parent: Vec<u32>,
    /// The children of all fronts: the fronts whose updates a front takes.
    pub children: Vec<u32>,
}

impl Fronts {
    /// Branches and trunk.
    pub fn parts(&self) -> impl Iterator<Item = &Branch> {
        self.branches.iter().chain([&self.trunk])
    }

    /// Start of the block of a pivot and a body that is eliminated later, in the trapezoid of the
    /// front of the pivot. Places are those in [`order`](Self::order).
    pub fn target(&self, branch: &Branch, front: &Front, pivot: usize, other: usize) -> usize {
        let [pivot, other] = [pivot, other].map(|place| self.within(branch, place));
        let row = if other < front.pivots.end {
            3 * (other - front.pivots.start)
        } else {
            let rows = &self.rows[front.rows.clone()];
            front.width() + 3 * rows.partition_point(|r| (*r as usize) < other)
        };
        3 * (pivot - front.pivots.start) * front.height() + row
    }

    /// The place of a body as its branch counts: its own bodies first, then those of the trunk.
    pub fn within(&self, branch: &Branch, place: usize) -> usize {
        if place < branch.places.end {
            place - branch.places.start
        } else {
            branch.places.len() + place - self.trunk.places.start
        }
    }
}
