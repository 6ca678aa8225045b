//! The order of elimination: approximate minimum degree on the graph of bodies and interactions.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// The place of every body in an order.
pub fn places(order: &[usize]) -> Vec<usize> {
    let mut places = vec![0; order.len()];
    for (place, &body) in order.iter().enumerate() {
        places[body] = place;
    }
    places
}

/// Neighbours of every body in ascending order: where they start, and their list.
pub fn adjacency(bodies: usize, pairs: &[(u32, u32)]) -> (Vec<usize>, Vec<usize>) {
    let mut lists = vec![Vec::new(); bodies];
    for &(a, b) in pairs {
        lists[a as usize].push(b as usize);
        lists[b as usize].push(a as usize);
    }
    let mut starts = vec![0];
    let mut neighbours = Vec::with_capacity(2 * pairs.len());
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
        neighbours.extend_from_slice(list);
        starts.push(neighbours.len());
    }
    (starts, neighbours)
}

/// Bodies in the order of their elimination (Amestoy, Davis and Duff 1996); `None` if faer refuses
/// the pattern.
pub fn minimum_degree(starts: &[usize], neighbours: &[usize]) -> Option<Vec<usize>> {
    let n = starts.len() - 1;
    if n == 0 {
        return Some(Vec::new());
    }
    let pattern = SymbolicSparseColMatRef::<usize>::new_checked(n, n, starts, None, neighbours);
    let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(n, neighbours.len()));
    let stack = MemStack::new(&mut memory);
    amd::order(&mut forward, &mut inverse, pattern, amd::Control::default(), stack).ok()?;
    Some(forward)
}
