//! Cuts the tree of fronts into branches, which know nothing of each other, and the trunk that they grow
//! from: branches can be worked on at once.
//!
//! The cut follows from the pattern alone, not from the number of threads, and what branches leave for
//! the trunk is added up in their order: results are the same bytes on any number of threads.

use super::merge::Group;

/// Below so many bodies it does not pay to hand anything to another thread.
const FEWEST: usize = 1000;
/// Cuts that are tried after the best one so far.
const TRIES: usize = 12;

/// Work of a branch, and what its subtrees grow from.
type Share = (f64, Vec<usize>);

/// The columns at the feet of the subtrees of every branch, four at most; none where it does not pay. The
/// two halves of the list are about as much work, and so are the branches.
pub fn cut(rows: &[Vec<u32>], groups: &[Option<Group>], roots: &[usize]) -> Vec<Vec<usize>> {
    if groups.len() < FEWEST {
        return Vec::new();
    }
    // Children come before their parents.
    let (mut own, mut whole) = (vec![0.0; groups.len()], vec![0.0; groups.len()]);
    for (k, group) in groups.iter().enumerate() {
        let Some(group) = group else { continue };
        own[k] = work(group.pivots.len(), rows[k].len());
        whole[k] = own[k] + group.children.iter().map(|c| whole[*c]).sum::<f64>();
    }
    let mut feet = roots.to_vec();
    let mut trunk = 0.0;
    let (mut best, mut least, mut tries) = (Vec::new(), f64::INFINITY, 0);
    while tries <= TRIES {
        feet.sort_by(|a, b| whole[*b].total_cmp(&whole[*a]).then(a.cmp(b)));
        let branches = share_out(&feet, &whole);
        // On two threads and on four.
        let [w, x, y, z] = [0, 1, 2, 3].map(|k| branches[k].0);
        let time = (trunk + (w + x).max(y + z)) + (trunk + w);
        tries += 1;
        if time < least {
            (best, least, tries) = (branches.into(), time, 0);
        }
        // The heaviest subtree loses its foot to the trunk.
        let Some(group) = feet.first().and_then(|foot| groups[*foot].as_ref()) else { break };
        trunk += own[feet[0]];
        feet.swap_remove(0);
        feet.extend(&group.children);
    }
    let branches: Vec<_> =
        best.into_iter().map(|(_, feet)| feet).filter(|feet| !feet.is_empty()).collect();
    if branches.len() < 2 { Vec::new() } else { branches }
}

/// Gives every subtree, the heaviest first, to the branch with the least work; the branch with the most
/// comes first, and that with the least next.
fn share_out(feet: &[usize], whole: &[f64]) -> [Share; 4] {
    let mut branches: [Share; 4] = Default::default();
    for &foot in feet {
        branches.sort_by(|a, b| a.0.total_cmp(&b.0));
        branches[0].0 += whole[foot];
        branches[0].1.push(foot);
    }
    branches.sort_by(|a, b| b.0.total_cmp(&a.0));
    branches[1..].rotate_right(1);
    branches
}

/// Work that a front is: multiplications, and numbers to be moved, which take several times as long.
fn work(pivots: usize, rows: usize) -> f64 {
    let (width, below) = (3.0 * pivots as f64, 3.0 * rows as f64);
    let multiplications = width * (width * width / 3.0 + width * below + below * below);
    let numbers = width * (width + below) + below * below;
    multiplications + 4.0 * numbers
}
