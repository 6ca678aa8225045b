//! Cuts the tree of fronts into branches, which are independent of each other, and the trunk from
//! which they grow: several threads can work on the branches at once.
//!
//! The cut follows from the pattern alone, not from the number of threads, and the updates of the
//! branches for the trunk are added in their order: any number of threads gives the same bytes.

use super::merge::Group;

/// Minimum number of bodies of a matrix with branches: for less, handing out the work costs more
/// than it saves.
const MIN_BODIES: usize = 1000;
/// Number of cuts without improvement that end the search for the best one.
const MAX_TRIES: usize = 12;

/// Work of a branch, and the feet of its subtrees.
type Share = (f64, Vec<usize>);

/// The columns at the feet of the subtrees of every branch: at most four branches, none if they do
/// not pay. The branches have about equal work, and so have the two halves of the list.
pub fn cut(rows: &[Vec<u32>], groups: &[Option<Group>], roots: &[usize]) -> Vec<Vec<usize>> {
    if groups.len() < MIN_BODIES {
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
    let (mut best, mut minimum, mut tries) = (Vec::new(), f64::INFINITY, 0);
    while tries <= MAX_TRIES {
        feet.sort_by(|a, b| whole[*b].total_cmp(&whole[*a]).then(a.cmp(b)));
        let branches = share_out(&feet, &whole);
        // Time on two threads plus time on four.
        let [w, x, y, z] = [0, 1, 2, 3].map(|k| branches[k].0);
        let time = (trunk + (w + x).max(y + z)) + (trunk + w);
        tries += 1;
        if time < minimum {
            (best, minimum, tries) = (branches.into(), time, 0);
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

/// Gives every subtree, the heaviest first, to the branch with the minimum work. In the result the
/// branch with the maximum work comes first, and the one with the minimum work second.
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

/// Work of a front: multiplications, and four times the numbers that are moved. Moving a number
/// takes several times as long as a multiplication.
fn work(pivots: usize, rows: usize) -> f64 {
    let (width, below) = (3.0 * pivots as f64, 3.0 * rows as f64);
    let multiplications = width * (width * width / 3.0 + width * below + below * below);
    let numbers = width * (width + below) + below * below;
    multiplications + 4.0 * numbers
}
