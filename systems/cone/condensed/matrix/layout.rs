//! Orders the fronts, children before parents and task by task, and gives all their numbers a
//! place.

use super::dense::kept_rows;
use super::fronts::{Front, Fronts, Task};
use super::merge::{Group, NONE, columns, merge};
use super::ordering::{minimum_degree, places};
use super::schedule::parents;
use super::tasks::cut;
use crate::adjacency::Adjacency;

/// The place of a pair of bodies.
pub struct Placed {
    /// Its number.
    pub pair: u32,
    /// Places of its bodies in the order of elimination.
    pub places: [u32; 2],
    /// Their places among the pivots and rows of the front.
    pub rows: [u32; 2],
}

/// The fronts of `bodies` bodies coupled by `pairs`, and the pairs of every front: those whose first
/// body in the order of elimination is a pivot of it. `None` if faer finds no order.
pub fn of_pairs(bodies: usize, pairs: &[(u32, u32)]) -> Option<(Fronts, Vec<Vec<Placed>>)> {
    let neighbours = Adjacency::of_neighbours(bodies, pairs);
    let fronts = fronts(&minimum_degree(&neighbours)?, &neighbours);
    let place = places(&fronts.order);
    let mut of_place = vec![(0, 0); bodies];
    for (task, of_task) in fronts.tasks.iter().enumerate() {
        for number in of_task.fronts.clone() {
            let pivots = fronts.list[number].pivots.clone();
            of_place[of_task.places.start..][pivots].fill((task, number));
        }
    }
    let mut placed: Vec<Vec<Placed>> = fronts.list.iter().map(|_| Vec::new()).collect();
    for (pair, (a, b)) in (0..).zip(pairs) {
        let places = [*a, *b].map(|i| place[i as usize]);
        let (task, number) = of_place[places[0].min(places[1])];
        let rows = fronts.in_front(&fronts.tasks[task], &fronts.list[number], places);
        let [places, rows] = [places, rows].map(|places| places.map(|place| place as u32));
        placed[number].push(Placed { pair, places, rows });
    }
    Some((fronts, placed))
}

/// The fronts of bodies with these neighbours, eliminated in this order or in one that gives the
/// same fill.
fn fronts(order: &[usize], neighbours: &Adjacency) -> Fronts {
    let n = order.len();
    let (column_rows, above) = columns(order, neighbours);
    let (column_rows, groups) = (&column_rows[..], &merge(&column_rows, &above)[..]);
    let roots: Vec<usize> = (0..n).filter(|k| above[*k] == NONE).collect();
    let mut layout = Layout {
        column_rows,
        groups,
        fronts: Fronts {
            order: Vec::with_capacity(n),
            list: Vec::new(),
            tasks: Vec::new(),
            sizes: Vec::new(),
            below: Vec::new(),
            beyond: Vec::new(),
            beyond_above: Vec::new(),
            rows: Vec::new(),
            in_parent: Vec::new(),
            children: Vec::new(),
        },
        columns: Vec::new(),
        number: vec![NONE; n],
    };
    for task in cut(column_rows, groups, &roots) {
        layout.lay_out(&task.feet);
        layout.fronts.sizes.push(task.size);
    }
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
    count_within_tasks(&mut fronts);
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
    fn lay_out(&mut self, feet: &[usize]) {
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
            // Its children have the last updates in their stack; those of other tasks are in other
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
        let places = first_place..place;
        self.fronts.tasks.push(Task { fronts, places, beyond: 0..0, factor_len, update_len });
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
