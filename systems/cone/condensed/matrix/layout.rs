//! The order of elimination, approximate minimum degree on the graph of bodies and interactions; the
//! order of the fronts, children before parents and task by task; and a place for all their numbers.

use std::iter::repeat_n;

use super::dense::kept_rows;
use super::fronts::{Front, Fronts, Task};
use super::merge::{Group, columns, merge};
use super::tasks::{cut, parents};
use crate::adjacency::Adjacency;

/// The place of a pair of bodies.
#[derive(Clone, Copy)]
pub(crate) struct PairPlace {
    /// Its place among the pairs of all fronts.
    pub place: usize,
    /// Places of its bodies in the order of elimination.
    pub bodies: [usize; 2],
}

/// The fronts of `bodies` bodies coupled by `pairs`, and the place of every pair.
pub fn of_pairs(bodies: usize, pairs: &[(u32, u32)]) -> (Fronts, Vec<PairPlace>) {
    let neighbours = Adjacency::of_neighbours(bodies, pairs);
    let mut fronts = fronts(&minimum_degree(&neighbours), &neighbours);
    let place = places(&fronts.order);
    let pivots = fronts.list.iter().map(|front| front.pivots.len()).enumerate();
    let of_place: Vec<usize> = pivots.flat_map(|(front, pivots)| repeat_n(front, pivots)).collect();
    let front = |[a, b]: [usize; 2]| of_place[a.min(b)];
    let bodies = |(a, b): &(u32, u32)| [*a, *b].map(|i| place[i as usize]);
    let mut of_pair: Vec<PairPlace> =
        pairs.iter().map(|pair| PairPlace { place: 0, bodies: bodies(pair) }).collect();
    let numbered = of_pair.iter().enumerate().map(|(k, pair)| (front(pair.bodies), k));
    let of_fronts = Adjacency::collect(fronts.list.len(), numbered);
    for (place, &number) in of_fronts.entries().iter().enumerate() {
        let pair = &mut of_pair[number];
        pair.place = place;
        let mut rows = fronts.in_front(front(pair.bodies), pair.bodies);
        rows.sort_unstable();
        fronts.pairs.push(rows.map(|row| row as u32));
    }
    fronts.pair_starts = of_fronts.starts().to_vec();
    (fronts, of_pair)
}

/// The fronts of bodies with these neighbours, eliminated in this order or in one that gives the
/// same fill.
fn fronts(order: &[usize], neighbours: &Adjacency) -> Fronts {
    let n = order.len();
    let column_rows = &columns(order, neighbours)[..];
    let groups = &merge(column_rows)[..];
    let roots: Vec<usize> = (0..n).filter(|k| column_rows[*k].is_empty()).collect();
    let mut layout = Layout {
        order,
        column_rows,
        groups,
        fronts: Fronts::default(),
        place: vec![0; n],
        number: vec![None; n],
    };
    for task in cut(column_rows, groups, &roots) {
        layout.lay_out(&task.feet);
        layout.fronts.sizes.push(task.size);
    }
    let Layout { mut fronts, place, .. } = layout;
    // Rows are eliminated after their front: all have places only now.
    for row in &mut fronts.rows {
        *row = place[*row as usize];
    }
    for front in &fronts.list {
        fronts.rows[front.rows.clone()].sort_unstable();
    }
    fronts.in_parent = vec![0; fronts.rows.len()];
    for parent in 0..fronts.list.len() {
        for child in fronts.list[parent].children.clone() {
            let child = fronts.children[child] as usize;
            fronts.list[child].inside = find_in_parent(&mut fronts, child, parent);
        }
    }
    count_within_tasks(&mut fronts);
    fronts
}

/// The fronts that are laid out so far.
struct Layout<'a> {
    /// Bodies by column.
    order: &'a [usize],
    column_rows: &'a [Vec<u32>],
    groups: &'a [Option<Group>],
    fronts: Fronts,
    /// The place of every column in [`Fronts::order`].
    place: Vec<u32>,
    /// The front of every group that has one already, by its column.
    number: Vec<Option<u32>>,
}

impl Layout<'_> {
    /// Lays out the subtrees on these feet, without the fronts that are laid out already.
    fn lay_out(&mut self, feet: &[usize]) {
        let first_front = self.fronts.list.len();
        let first_place = self.fronts.order.len();
        let (mut used, mut update_len, mut factor_len) = ([0; 2], [0; 2], 0);
        for (column, depth) in self.postorder(feet) {
            let Some(group) = &self.groups[column] else { continue };
            let fronts = &mut self.fronts;
            let first_pivot = fronts.order.len();
            for &pivot in &group.pivots {
                self.place[pivot as usize] = fronts.order.len() as u32;
                fronts.order.push(self.order[pivot as usize]);
            }
            let first_child = fronts.children.len();
            fronts.children.extend(group.children.iter().filter_map(|c| self.number[*c]));
            let first_row = fronts.rows.len();
            let [mine, theirs] = [depth % 2, 1 - depth % 2];
            let (pivots, rows) = (group.pivots.len(), self.column_rows[column].len());
            let kept: usize = (0..pivots).map(|k| 3 * kept_rows(pivots + rows, k)).sum();
            let front = Front {
                pivots: first_pivot..fronts.order.len(),
                rows: first_row..first_row + rows,
                inside: 0,
                children: first_child..fronts.children.len(),
                factor: factor_len..factor_len + kept,
                update: used[mine],
                odd: mine == 1,
            };
            // Its children have the last updates in their stack; those of other tasks are in other
            // stacks.
            let mut children = fronts.children[first_child..].iter().map(|c| *c as usize);
            if let Some(child) = children.find(|c| *c >= first_front) {
                used[theirs] = fronts.list[child].update;
            }
            used[mine] += front.update_len();
            update_len[mine] = update_len[mine].max(used[mine]);
            factor_len += kept;
            fronts.rows.extend(&self.column_rows[column]);
            self.number[column] = Some(fronts.list.len() as u32);
            fronts.list.push(front);
        }
        let fronts = first_front..self.fronts.list.len();
        let places = first_place..self.fronts.order.len();
        self.fronts.tasks.push(Task { fronts, places, beyond: 0..0, factor_len, update_len });
    }

    /// Columns of the groups above these feet with their depth, children before parents.
    fn postorder(&self, feet: &[usize]) -> Vec<(usize, usize)> {
        let mut order = Vec::new();
        let is_new = |column: usize| self.number[column].is_none();
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

/// Makes all places count within their task.
fn count_within_tasks(fronts: &mut Fronts) {
    let above = parents(&fronts.sizes);
    fronts.below = vec![Vec::new(); above.len()];
    for (task, above) in above.iter().enumerate().filter_map(|(k, above)| Some((k, (*above)?))) {
        fronts.below[above].push(task);
    }
    for task in &mut fronts.tasks {
        let rows =
            fronts.list[task.fronts.clone()].iter().flat_map(|f| &fronts.rows[f.rows.clone()]);
        let mut beyond: Vec<u32> =
            rows.copied().filter(|row| *row as usize >= task.places.end).collect();
        beyond.sort_unstable();
        beyond.dedup();
        let start = fronts.beyond.len();
        fronts.beyond.extend(beyond);
        task.beyond = start..fronts.beyond.len();
    }
    let within = |task: &Task, place: &u32| fronts.within(task, *place as usize) as u32;
    let mut beyond_above = Vec::with_capacity(fronts.beyond.len());
    let mut rows = Vec::with_capacity(fronts.rows.len());
    for (task, above) in fronts.tasks.iter().zip(above) {
        if let Some(above) = above {
            let beyond = &fronts.beyond[task.beyond.clone()];
            beyond_above.extend(beyond.iter().map(|place| within(&fronts.tasks[above], place)));
        }
        // Rows lie front by front.
        let of_task =
            fronts.list[task.fronts.clone()].iter().flat_map(|f| &fronts.rows[f.rows.clone()]);
        rows.extend(of_task.map(|place| within(task, place)));
    }
    (fronts.rows, fronts.beyond_above) = (rows, beyond_above);
    for task in &fronts.tasks {
        let first = task.places.start;
        for front in &mut fronts.list[task.fronts.clone()] {
            front.pivots = front.pivots.start - first..front.pivots.end - first;
        }
    }
}

/// The place of every body in an order.
pub fn places(order: &[usize]) -> Vec<usize> {
    let mut places = vec![0; order.len()];
    for (place, &body) in order.iter().enumerate() {
        places[body] = place;
    }
    places
}

/// Bodies in the order of elimination (Amestoy, Davis and Duff 1996).
///
/// # Panics
/// If a neighbour is no body.
pub(crate) fn minimum_degree(neighbours: &Adjacency) -> Vec<usize> {
    let (starts, entries) = (neighbours.starts(), neighbours.entries());
    let order = amd::order(neighbours.bodies(), starts, entries, &amd::Control::default());
    order.expect("neighbours are bodies").0
}
