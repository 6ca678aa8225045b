//! The order of elimination: approximate minimum degree on the graph of bodies and interactions.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use crate::adjacency::Adjacency;

/// The place of every body in an order.
pub fn places(order: &[usize]) -> Vec<usize> {
    let mut places = vec![0; order.len()];
    for (place, &body) in order.iter().enumerate() {
        places[body] = place;
    }
    places
}

/// Bodies in the order of elimination (Amestoy, Davis and Duff 1996); `None` if faer refuses the
/// pattern.
pub fn minimum_degree(neighbours: &Adjacency) -> Option<Vec<usize>> {
    let n = neighbours.bodies();
    if n == 0 {
        return Some(Vec::new());
    }
    let (starts, neighbours) = (neighbours.starts(), neighbours.entries());
    let pattern = SymbolicSparseColMatRef::<usize>::new_checked(n, n, starts, None, neighbours);
    let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(n, neighbours.len()));
    let stack = MemStack::new(&mut memory);
    amd::order(&mut forward, &mut inverse, pattern, amd::Control::default(), stack).ok()?;
    Some(forward)
}
