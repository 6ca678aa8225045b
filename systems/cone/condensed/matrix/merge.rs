//! Finds the bodies that are eliminated together: the columns of the factor, and their groups.

use std::cmp::Reverse;

use super::layout::places;
use crate::adjacency::Adjacency;

/// Maximum number of pivots, and maximum part of zeros in the trapezoid, with which a front is
/// merged with its parent. Wider fronts cost zeros in the factor and have less overhead (Ashcraft
/// and Grimes 1989). This is the fastest of eight rules (decision 005).
const MERGED: [(usize, f64); 3] = [(2, 0.5), (8, 0.2), (32, 0.05)];

/// A group of bodies that may still become part of its parent.
#[derive(Default)]
pub struct Group {
    /// Its columns.
    pub pivots: Vec<u32>,
    /// Groups whose parent it is.
    pub children: Vec<usize>,
    /// Number of zero blocks in its trapezoid.
    zeros: usize,
}

/// Rows below the diagonal of every column of the factor. The first is its parent in the elimination
/// tree.
pub fn columns(order: &[usize], neighbours: &Adjacency) -> Vec<Vec<u32>> {
    let n = order.len();
    let place = places(order);
    let mut rows: Vec<Vec<u32>> = Vec::with_capacity(n);
    let mut children = vec![Vec::new(); n];
    let mut seen = vec![n; n];
    for k in 0..n {
        let mut list = Vec::new();
        let own = neighbours.of(order[k]);
        let of_children = children[k].iter().flat_map(|c: &usize| rows[*c].iter());
        for j in own.iter().map(|i| place[*i]).chain(of_children.map(|j| *j as usize)) {
            if j > k && std::mem::replace(&mut seen[j], k) != k {
                list.push(j as u32);
            }
        }
        list.sort_unstable();
        if let Some(&parent) = list.first() {
            children[parent as usize].push(k);
        }
        rows.push(list);
    }
    rows
}

/// Groups of columns, each at the place of its last column; `None` at the places of the others.
pub fn merge(rows: &[Vec<u32>]) -> Vec<Option<Group>> {
    let mut children = vec![Vec::new(); rows.len()];
    for (k, parent) in rows.iter().enumerate().filter_map(|(k, rows)| Some((k, rows.first()?))) {
        children[*parent as usize].push(k);
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
            let few = |(max, part)| pivots <= max && zeros as f64 <= part * blocks as f64;
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

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::super::layout::minimum_degree;
    use super::*;

    /// Order, columns and groups of random graphs: the order is a permutation, the columns have the
    /// fill that elimination on a dense pattern leaves, and every column is in one group.
    #[test]
    fn columns_have_the_fill_of_an_elimination() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for bodies in [1, 2, 5, 12, 30] {
            let n = bodies as u32;
            let mut draw = || (random.next_u32() % n, random.next_u32() % n);
            let pairs: Vec<_> = (0..2 * bodies).map(|_| draw()).filter(|(a, b)| a != b).collect();
            let neighbours = Adjacency::of_neighbours(bodies, &pairs);
            let order = minimum_degree(&neighbours);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..bodies));

            let place = places(&order);
            let mut pattern = vec![vec![false; bodies]; bodies];
            for (a, b) in pairs {
                let [a, b] = [a, b].map(|i| place[i as usize]);
                (pattern[a][b], pattern[b][a]) = (true, true);
            }
            let rows = columns(&order, &neighbours);
            for k in 0..bodies {
                let below: Vec<usize> = (k + 1..bodies).filter(|j| pattern[k][*j]).collect();
                for &i in &below {
                    for &j in &below {
                        pattern[i][j] |= i != j;
                    }
                }
                assert!(rows[k].iter().map(|j| *j as usize).eq(below));
            }
            let mut grouped: Vec<u32> =
                merge(&rows).into_iter().flatten().flat_map(|g| g.pivots).collect();
            grouped.sort_unstable();
            assert!(grouped.into_iter().eq(0..n));
        }
    }
}
