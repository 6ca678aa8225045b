//! Underconstrained bodies, found by counting constraints.
//!
//! Bodies with fewer constraints than degrees of freedom are removed repeatedly. The ground must
//! hold every connected cluster of the remaining bodies against translation and rotation.

use glam::DVec2;

use clastic_components::contact::BodyTable;
use clastic_components::contact_history::ContactHistory;
use clastic_cone::adjacency::Adjacency;
use clastic_cone::program::{ConeProgram, Dof, Interaction};

use super::Trial;
use crate::measures::fragments::connected;

/// Whether an interaction is stiff at the start of the increment: a bond, or a closed contact.
/// `pair` are the rows of its bodies in the memory.
fn is_stiff(c: &Interaction, (a, b): (u32, u32), history: &ContactHistory) -> bool {
    c.limits.has_strength() || c.offset <= 0.0 || history.get(a, b).is_some_and(|m| m.p > 0.0)
}

/// Flags every underconstrained body.
pub(super) fn find_underconstrained(trial: &Trial, program: &ConeProgram) -> Vec<bool> {
    let Trial { bodies, contacts, history, .. } = trial;
    let n = program.bodies.len();
    // In the program a member of a rigid group has the row of the group.
    let pair = |k: usize, c: &Interaction| contacts.0.get(k).map_or((c.a, c.b), |x| (x.a, x.b));
    let stiff: Vec<&Interaction> = program
        .interactions
        .iter()
        .enumerate()
        .filter(|(k, c)| is_stiff(c, pair(*k, c), &history.0))
        .map(|(_, c)| c)
        .collect();
    let held = |c: &Interaction| c.limits.forces().into_iter().filter(|has| *has).count();
    let adjacency = Adjacency::new(n, stiff.iter().map(|c| [c.a as usize, c.b as usize]));
    let mut constraints = vec![0; n];
    for c in &stiff {
        for body in [c.a as usize, c.b as usize] {
            constraints[body] += held(c);
        }
    }
    let mut found = vec![false; n];
    let mut freedom: Vec<usize> = program.bodies.iter().map(|body| body.free().count()).collect();
    // The cell cannot lack constraints.
    if let Some(cell) = &program.cell {
        freedom[cell.body as usize] = 0;
    }
    let mut queue: Vec<usize> = (0..n).filter(|i| constraints[*i] < freedom[*i]).collect();
    while let Some(i) = queue.pop() {
        if std::mem::replace(&mut found[i], true) {
            continue;
        }
        for &k in adjacency.of(i) {
            let c = stiff[k];
            let j = if c.a as usize == i { c.b } else { c.a } as usize;
            constraints[j] = constraints[j].saturating_sub(held(c));
            if !found[j] && constraints[j] < freedom[j] {
                queue.push(j);
            }
        }
    }
    for cluster in clusters(program, &stiff, &found, &freedom) {
        // One particle is held, and a periodic cell does not turn.
        let is_held = |i: &usize| program.bodies[*i].free().all(|(k, _)| k == 2);
        if program.cell.is_some() && cluster.iter().any(is_held) {
            continue;
        }
        hold_cluster(bodies, program, &stiff, &adjacency, &freedom, &cluster, &mut found);
    }
    found
}

/// Connected clusters of bodies with free degrees of freedom.
fn clusters(
    program: &ConeProgram,
    stiff: &[&Interaction],
    found: &[bool],
    freedom: &[usize],
) -> Vec<Vec<usize>> {
    let n = program.bodies.len();
    let takes_part = |i: usize| !found[i] && freedom[i] > 0;
    let pairs = stiff.iter().map(|c| (c.a, c.b));
    let pairs = pairs.filter(|(a, b)| takes_part(*a as usize) && takes_part(*b as usize));
    // Clusters are ordered by their first body.
    let mut members = vec![Vec::new(); n];
    for (i, first) in connected(n, pairs).into_iter().enumerate().filter(|(i, _)| takes_part(*i)) {
        members[first as usize].push(i);
    }
    members.retain(|m| !m.is_empty());
    members
}

/// Flags the underconstrained bodies of a cluster: none if the ground holds the cluster, its loaded
/// walls if holding them suffices, otherwise all.
fn hold_cluster(
    bodies: &BodyTable,
    program: &ConeProgram,
    stiff: &[&Interaction],
    adjacency: &Adjacency,
    freedom: &[usize],
    cluster: &[usize],
    found: &mut [bool],
) {
    let is_wall = |i: usize| (bodies.particles..bodies.first_group()).contains(&i);
    let walls: Vec<usize> = cluster.iter().copied().filter(|i| is_wall(*i)).collect();
    let unknowns = 3 + walls.len();
    let centre = cluster.iter().map(|i| bodies.positions[*i]).sum::<DVec2>() / cluster.len() as f64;
    let extent = cluster
        .iter()
        .map(|i| bodies.positions[*i].distance(centre))
        .fold(bodies.mean_radius, f64::max);
    let mut gram = vec![vec![0.0; unknowns]; unknowns];
    // A constraint on the rigid motion of the cluster, and on that of one of its walls.
    let mut add = |motion: [f64; 3], wall: Option<(usize, f64)>| {
        let mut row = vec![0.0; unknowns];
        row[..3].copy_from_slice(&motion);
        if let Some((wall, along)) = wall {
            row[3 + wall] = along;
        }
        for (i, x) in row.iter().enumerate() {
            for (j, y) in row.iter().enumerate() {
                gram[i][j] += x * y;
            }
        }
    };
    for &i in cluster.iter().filter(|i| !is_wall(**i)) {
        let arm = (bodies.positions[i] - centre) / extent;
        // Rigid motion of the cluster along d, at body i.
        let along = |d: DVec2| [d.x, d.y, arm.x * d.y - arm.y * d.x];
        for (k, dof) in program.bodies[i].dofs.iter().enumerate() {
            match dof {
                Dof::Fixed(_) if k < 2 => add(along([DVec2::X, DVec2::Y][k]), None),
                // A group whose rotation is imposed does not turn with the cluster.
                Dof::Fixed(_) if i >= bodies.first_group() => add([0.0, 0.0, 1.0], None),
                // A disk without a rotation row turns freely and does not hold the cluster.
                Dof::Fixed(_) | Dof::Free(_) => {}
            }
        }
        for &k in adjacency.of(i) {
            let c = stiff[k];
            let first = c.a as usize == i;
            let other = if first { c.b } else { c.a } as usize;
            let wall = walls.iter().position(|w| *w == other);
            if wall.is_none() && freedom[other] > 0 {
                continue;
            }
            // A wall that is no line may be pushed along its axis by friction as well.
            let mut hold = |axis: DVec2, [arm_a, arm_b]: [f64; 2]| {
                let (direction, arm) = if first { (axis, arm_a) } else { (-axis, arm_b) };
                let [x, y, turn] = along(direction);
                let of_wall = wall.map(|w| (w, -direction.dot(program.bodies[other].axis)));
                add([x, y, turn + arm / extent], of_wall);
            };
            hold(c.normal, [c.normal_arm_a, c.normal_arm_b]);
            if c.limits.has_shear() {
                hold(c.normal.perp(), [c.arm_a, c.arm_b]);
            }
            if c.limits.has_rolling() {
                add([0.0, 0.0, bodies.mean_radius / extent], None);
            }
        }
    }
    if full_rank(gram.clone()) {
        return;
    }
    for (w, &wall) in walls.iter().enumerate() {
        gram[3 + w][3 + w] += 1.0;
        found[wall] = true;
    }
    if !full_rank(gram) {
        for &i in cluster {
            found[i] = true;
        }
    }
}

/// Whether a Gram matrix has full rank, by elimination with diagonal pivots.
fn full_rank(mut gram: Vec<Vec<f64>>) -> bool {
    let n = gram.len();
    let maximum = (0..n).map(|i| gram[i][i]).fold(0.0, f64::max);
    let mut left: Vec<usize> = (0..n).collect();
    while let Some(k) =
        (0..left.len()).max_by(|a, b| gram[left[*a]][left[*a]].total_cmp(&gram[left[*b]][left[*b]]))
    {
        let pivot = left.swap_remove(k);
        // The pivot is relative to the number of constraints in the sum. A mechanism leaves only
        // round-off.
        if gram[pivot][pivot] <= 1e-10 * maximum {
            return false;
        }
        for &i in &left {
            let factor = gram[i][pivot] / gram[pivot][pivot];
            for j in 0..n {
                let g = gram[pivot][j];
                gram[i][j] -= factor * g;
            }
        }
    }
    maximum > 0.0
}
