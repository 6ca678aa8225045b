//! Orders the fronts, children before parents and branches before the trunk, and gives all their
//! numbers a place.

use super::branches;
use super::dense::kept_rows;
use super::fronts::{Branch, Front, Fronts};
use super::merge::{Group, NONE, columns, merge};
use crate::adjacency::Adjacency;

/// The fronts of bodies with these neighbours, eliminated in this order or in one that gives the
/// same fill.
pub fn fronts(order: &[usize], neighbours: &Adjacency) -> Fronts {
    in_parts(order, neighbours, branches::cut)
}

/// As [`fronts`], with all fronts in the trunk.
pub fn fronts_in_one(order: &[usize], neighbours: &Adjacency) -> Fronts {
    in_parts(order, neighbours, |_, _, _| Vec::new())
}

/// The fronts, with branches on the feet that `cut` finds.
fn in_parts(
    order: &[usize],
    neighbours: &Adjacency,
    cut: impl Fn(&[Vec<u32>], &[Option<Group>], &[usize]) -> Vec<Vec<usize>>,
) -> Fronts {
    let n = order.len();
    let (column_rows, parents) = columns(order, neighbours);
    let (column_rows, groups) = (&column_rows[..], &merge(&column_rows, &parents)[..]);
    let roots: Vec<usize> = (0..n).filter(|k| parents[*k] == NONE).collect();
    let branches = cut(column_rows, groups, &roots);
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
    // Fronts without a number are those of the trunk.
    layout.fronts.trunk = layout.lay_out(&roots);
    let Layout { mut fronts, columns, .. } = layout;
    let mut place = vec![0; n];
    for &column in columns.iter().filter_map(|c| groups[*c].as_ref()).flat_map(|g| &g.pivots) {
        place[column as usize] = fronts.order.len() as u32;
        fronts.order.push(order[column as usize]);
    }
    // Rows are eliminated after their front: all have places only now.
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

/// The fronts that are laid out so far.
struct Layout<'a> {
    column_rows: &'a [Vec<u32>],
    groups: &'a [Option<Group>],
    fronts: Fronts,
    /// The column that stands for the group of every front.
    columns: Vec<usize>,
    /// The front of every group, by its column; `NONE` if it has none yet.
    number: Vec<usize>,
}

impl Layout<'_> {
    /// Lays out the subtrees on these feet, without the fronts that are laid out already.
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
            // Its children have the last updates in their stack; those of branches are in other
            // stacks.
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

    /// Columns of the groups above these feet with their depth, children before parents.
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

/// Finds the rows of a front in its parent, and the number of them that are pivots there.
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

/// Makes all places count from the start of their branch.
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
