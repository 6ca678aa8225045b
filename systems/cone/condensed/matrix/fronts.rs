//! What of the factorisation depends on the pattern only: fronts, their order, and where everything lies.
//!
//! A front is a group of bodies that are eliminated together, its pivots, and the bodies that they
//! are then coupled with, its rows. It is the trapezoid of the factor below its pivots, dense, and
//! the update that eliminating them leaves for the rows. Fronts form a tree: all rows of a front
//! are pivots or rows of its parent (Duff and Reid 1983; Liu 1992).

use std::ops::Range;

use super::dense::LANES;

/// One front. Places of bodies are those in [`Fronts::order`], less those before its branch.
pub struct Front {
    /// Places of the pivots.
    pub pivots: Range<usize>,
    /// Where its rows are in [`Fronts::rows`] and [`Fronts::in_parent`].
    pub rows: Range<usize>,
    /// How many of its rows, the first ones, are pivots of its parent.
    pub inside: usize,
    /// Where its children are in [`Fronts::children`].
    pub children: Range<usize>,
    /// Where what is kept of its trapezoid is in the factor of its branch.
    pub factor: Range<usize>,
    /// Where its update starts, in the one of the two stacks of its branch that `odd` tells.
    pub update: usize,
    /// Whether its depth in the tree is odd: updates of parent and child are in different stacks.
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

    /// Rows of the trapezoid, which lies column by column, with padding: pieces of [`LANES`] may begin
    /// anywhere.
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

    /// Numbers in the update, a square of which the lower triangle means something.
    pub fn update_len(&self) -> usize {
        self.bottom() * 3 * self.rows.len()
    }
}

/// Fronts that are worked on together: a branch of the tree, or the trunk.
#[derive(Default)]
pub struct Branch {
    /// Its fronts.
    pub fronts: Range<usize>,
    /// Its bodies in the order of elimination.
    pub places: Range<usize>,
    /// Numbers in its factor, without the triangles of the pivots.
    pub factor_len: usize,
    /// Numbers that its two stacks of updates hold at most.
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
    /// What comes after them.
    pub trunk: Branch,
    /// Places of the rows of all fronts, ascending within each: less those before the branch and, in the
    /// trunk, between branch and trunk.
    pub rows: Vec<u32>,
    /// For every row, where its three numbers start in a column of the parent's trapezoid.
    pub in_parent: Vec<u32>,
    /// Fronts whose updates a front takes.
    pub children: Vec<u32>,
}

impl Fronts {
    /// Branches and trunk.
    pub fn parts(&self) -> impl Iterator<Item = &Branch> {
        self.branches.iter().chain([&self.trunk])
    }

    /// Where the block of a pivot and another body, eliminated later, starts in the trapezoid of the
    /// front of the pivot; places are those in [`order`](Self::order).
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

    /// The place of a body less what lies before the branch, and between it and the trunk.
    pub fn within(&self, branch: &Branch, place: usize) -> usize {
        if place < branch.places.end {
            place - branch.places.start
        } else {
            branch.places.len() + place - self.trunk.places.start
        }
    }
}
