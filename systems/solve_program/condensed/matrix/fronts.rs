//! What of the factorisation depends on the pattern only: fronts, their order, and where everything lies.
//!
//! A front is a group of bodies that are eliminated together, its pivots, and the bodies that they
//! are then coupled with, its rows. It is the trapezoid of the factor below its pivots, dense, and
//! the update that eliminating them leaves for the rows. Fronts form a tree: all rows of a front
//! are pivots or rows of its parent (Duff and Reid 1983; Liu 1992).

use std::cmp::Reverse;
use std::ops::Range;

use super::branches;
use super::dense::{LANES, kept_rows};
use super::ordering::places;

/// Fronts are merged with their parent, with zeros in the factor, as long as there are at most so
/// many pivots and so great a part of the trapezoid is zero: less to do for each, and wider
/// columns (Ashcraft and Grimes 1989). Measured, as the fastest of eight.
const MERGED: [(usize, f64); 3] = [(2, 0.5), (8, 0.2), (32, 0.05)];

const NONE: usize = usize::MAX;

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

/// A group of bodies that may still become part of its parent.
#[derive(Default)]
pub struct Group {
    /// Its columns.
    pub pivots: Vec<u32>,
    /// Groups whose parent it is.
    pub children: Vec<usize>,
    /// Blocks of its trapezoid that are zero.
    zeros: usize,
}

impl Fronts {
    /// The fronts of bodies with these neighbours (`starts`, `neighbours`: compressed rows),
    /// eliminated in this order or one that gives the same fill.
    pub fn new(order: &[usize], starts: &[usize], neighbours: &[usize]) -> Self {
        let (rows, parents) = columns(order, starts, neighbours);
        let groups = merge(&rows, &parents);
        layout(order, &rows, &parents, &groups)
    }

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
    fn within(&self, branch: &Branch, place: usize) -> usize {
        if place < branch.places.end {
            place - branch.places.start
        } else {
            branch.places.len() + place - self.trunk.places.start
        }
    }
}

/// Of every column of the factor its rows below the diagonal and its parent in the elimination tree.
fn columns(order: &[usize], starts: &[usize], neighbours: &[usize]) -> (Vec<Vec<u32>>, Vec<usize>) {
    let n = order.len();
    let place = places(order);
    let mut rows: Vec<Vec<u32>> = Vec::with_capacity(n);
    let mut children = vec![Vec::new(); n];
    let mut parents = vec![NONE; n];
    let mut seen = vec![NONE; n];
    for k in 0..n {
        let mut list = Vec::new();
        let own = &neighbours[starts[order[k]]..starts[order[k] + 1]];
        let of_children = children[k].iter().flat_map(|c: &usize| rows[*c].iter());
        for j in own.iter().map(|i| place[*i]).chain(of_children.map(|j| *j as usize)) {
            if j > k && std::mem::replace(&mut seen[j], k) != k {
                list.push(j as u32);
            }
        }
        list.sort_unstable();
        if let Some(&parent) = list.first() {
            parents[k] = parent as usize;
            children[parent as usize].push(k);
        }
        rows.push(list);
    }
    (rows, parents)
}

/// Groups of columns, each under its last one; `None` for a column that is in the group of another.
fn merge(rows: &[Vec<u32>], parents: &[usize]) -> Vec<Option<Group>> {
    let mut children = vec![Vec::new(); rows.len()];
    for (k, &parent) in parents.iter().enumerate().filter(|(_, p)| **p != NONE) {
        children[parent].push(k);
    }
    let mut groups: Vec<Option<Group>> = Vec::with_capacity(rows.len());
    for (k, mut candidates) in children.into_iter().enumerate() {
        let mut group = Group { pivots: vec![k as u32], ..Group::default() };
        candidates.sort_by_key(|c| (Reverse(rows[*c].len()), *c));
        for c in candidates {
            let Some(child) = &mut groups[c] else { continue };
            let added = group.pivots.len() + rows[k].len() - rows[c].len();
            let pivots = child.pivots.len() + group.pivots.len();
            let zeros = child.zeros + group.zeros + child.pivots.len() * added;
            let blocks = pivots * (pivots + 1) / 2 + pivots * rows[k].len();
            let few = |(most, part)| pivots <= most && zeros as f64 <= part * blocks as f64;
            if zeros == 0 || MERGED.into_iter().any(few) {
                child.pivots.append(&mut group.pivots);
                group.pivots = std::mem::take(&mut child.pivots);
                group.children.append(&mut child.children);
                group.zeros = zeros;
                groups[c] = None;
            } else {
                group.children.push(c);
            }
        }
        groups.push(Some(group));
    }
    groups
}

/// Puts children before parents and branches before the trunk, and finds a place for everything.
fn layout(
    order: &[usize],
    column_rows: &[Vec<u32>],
    parents: &[usize],
    groups: &[Option<Group>],
) -> Fronts {
    let n = order.len();
    let roots: Vec<usize> = (0..n).filter(|k| parents[*k] == NONE).collect();
    let branches = branches::cut(column_rows, groups, &roots);
    let mut layout = Layout {
        column_rows,
        groups,
        fronts: Fronts {
            order: Vec::with_capacity(n),
            list: Vec::new(),
            branches: Vec::new(),
            trunk: Branch::default(),
            rows: Vec::new(),
            in_parent: Vec::new(),
            children: Vec::new(),
        },
        columns: Vec::new(),
        number: vec![NONE; n],
    };
    for feet in &branches {
        let branch = layout.lay_out(feet);
        layout.fronts.branches.push(branch);
    }
    // Branches have their numbers: what is left is the trunk.
    layout.fronts.trunk = layout.lay_out(&roots);
    let Layout { mut fronts, columns, .. } = layout;
    let mut place = vec![0; n];
    for &column in columns.iter().filter_map(|c| groups[*c].as_ref()).flat_map(|g| &g.pivots) {
        place[column as usize] = fronts.order.len() as u32;
        fronts.order.push(order[column as usize]);
    }
    // Rows are eliminated after their front: only now do all have their places.
    for front in &fronts.list {
        let rows = &mut fronts.rows[front.rows.clone()];
        for row in &mut *rows {
            *row = place[*row as usize];
        }
        rows.sort_unstable();
    }
    fronts.in_parent = vec![0; fronts.rows.len()];
    for parent in 0..fronts.list.len() {
        for child in fronts.list[parent].children.clone() {
            let child = fronts.children[child] as usize;
            fronts.list[child].inside = find_in_parent(&mut fronts, child, parent);
        }
    }
    count_within_branches(&mut fronts);
    fronts
}

/// What grows while fronts are laid out.
struct Layout<'a> {
    column_rows: &'a [Vec<u32>],
    groups: &'a [Option<Group>],
    fronts: Fronts,
    /// The column under which the group of every front is.
    columns: Vec<usize>,
    /// The front of every group that has one already.
    number: Vec<usize>,
}

impl Layout<'_> {
    /// Lays out the subtrees on these feet, without what is laid out already.
    fn lay_out(&mut self, feet: &[usize]) -> Branch {
        let first_front = self.fronts.list.len();
        let first_place = self.fronts.list.last().map_or(0, |front| front.pivots.end);
        let (mut place, mut factor_len) = (first_place, 0);
        let (mut used, mut update_len) = ([0; 2], [0; 2]);
        for (column, depth) in self.postorder(feet) {
            let Some(group) = &self.groups[column] else { continue };
            let fronts = &mut self.fronts;
            let first_child = fronts.children.len();
            fronts.children.extend(group.children.iter().map(|c| self.number[*c] as u32));
            let first_row = fronts.rows.len();
            let [mine, theirs] = [depth % 2, 1 - depth % 2];
            let (pivots, rows) = (group.pivots.len(), self.column_rows[column].len());
            let kept: usize = (0..pivots).map(|k| 3 * kept_rows(pivots + rows, k)).sum();
            let front = Front {
                pivots: place..place + pivots,
                rows: first_row..first_row + rows,
                inside: 0,
                children: first_child..fronts.children.len(),
                factor: factor_len..factor_len + kept,
                update: used[mine],
                odd: mine == 1,
            };
            // It takes the updates of its children, which are the last ones in their stack; those of
            // branches are in other stacks.
            let mut children = fronts.children[first_child..].iter().map(|c| *c as usize);
            if let Some(child) = children.find(|c| *c >= first_front) {
                used[theirs] = fronts.list[child].update;
            }
            used[mine] += front.update_len();
            update_len[mine] = update_len[mine].max(used[mine]);
            factor_len += kept;
            place += pivots;
            fronts.rows.extend(&self.column_rows[column]);
            self.number[column] = fronts.list.len();
            self.columns.push(column);
            fronts.list.push(front);
        }
        let fronts = first_front..self.fronts.list.len();
        Branch { fronts, places: first_place..place, factor_len, update_len }
    }

    /// Groups above these feet with their depth, children before parents.
    fn postorder(&self, feet: &[usize]) -> Vec<(usize, usize)> {
        let mut order = Vec::new();
        let is_new = |column: usize| self.number[column] == NONE;
        for &foot in feet.iter().filter(|foot| is_new(**foot)) {
            let mut path = vec![(foot, 0)];
            while let Some((column, next)) = path.last_mut() {
                let children = self.groups[*column].as_ref().map_or(&[][..], |g| &g.children);
                if let Some(&child) = children.get(*next) {
                    *next += 1;
                    if is_new(child) {
                        path.push((child, 0));
                    }
                } else {
                    order.push((*column, path.len() - 1));
                    path.pop();
                }
            }
        }
        order
    }
}

/// Finds the rows of a front in its parent, and how many of them are pivots there.
fn find_in_parent(fronts: &mut Fronts, child: usize, parent: usize) -> usize {
    let parent = &fronts.list[parent];
    let below = &fronts.rows[parent.rows.clone()];
    let (mut inside, mut at) = (0, 0);
    for k in fronts.list[child].rows.clone() {
        let row = fronts.rows[k];
        let start = if (row as usize) < parent.pivots.end {
            inside += 1;
            3 * (row as usize - parent.pivots.start)
        } else {
            at += below[at..].partition_point(|r| *r < row);
            parent.width() + 3 * at
        };
        fronts.in_parent[k] = start as u32;
    }
    inside
}

/// Takes away from all places of a branch what comes before it.
fn count_within_branches(fronts: &mut Fronts) {
    let within = |fronts: &Fronts, branch: &Branch| {
        let rows = branch.fronts.clone().flat_map(|k| fronts.list[k].rows.clone());
        rows.map(|k| fronts.within(branch, fronts.rows[k] as usize) as u32).collect::<Vec<_>>()
    };
    // Rows lie front by front.
    fronts.rows = fronts.parts().flat_map(|branch| within(fronts, branch)).collect();
    let branches = std::mem::take(&mut fronts.branches);
    for branch in branches.iter().chain([&fronts.trunk]) {
        let first = branch.places.start;
        for front in &mut fronts.list[branch.fronts.clone()] {
            front.pivots = front.pivots.start - first..front.pivots.end - first;
        }
    }
    fronts.branches = branches;
}
