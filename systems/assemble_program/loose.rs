//! Regularisation of bodies without stiffness.
//!
//! The displacement of a static body with too few stiff interactions (a rattler, a loose cluster)
//! is not determined. It gets a proximal term, which selects the smallest displacement. Loose
//! bodies are found by counting constraints. Bodies with fewer constraints than degrees of freedom
//! are removed repeatedly. Every connected cluster of the remaining bodies must be held by the
//! ground against translation and rotation. The weight is the fraction
//! [`Acceptance::regularisation`] of force scale over displacement scale, so that its force on a
//! body that is pushed after all stays far below the tolerance. The residuals count this force as
//! an error of the balance.

use glam::DVec2;

use clastic_components::attempt::{Effort, Mode};
use clastic_components::contact::{Bodies, Contact, ContactHistory};
use clastic_components::findings::{Bearing, Centre, Restraints};
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind};
use clastic_components::motion::Motion;
use clastic_cone::program::{ConeProgram, Dof, Interaction};

use clastic_cone::adjacency::Adjacency;

/// First weight in a repeated attempt. It applies to every body, and its centre follows the
/// solution until no force of the regularisation remains in the balance. The weight decreases by
/// this factor with every move of the centre, so that a motion without bound becomes visible.
const WEIGHT_OF_RETRY: f64 = 1e-6;
const FALL: f64 = 0.1;

/// Sets the proximal weights of the program.
pub fn regularise(
    bodies: &Bodies,
    contacts: &[Contact],
    history: &ContactHistory,
    analysis: &Analysis,
    acceptance: &Acceptance,
    mode: &Mode,
    restraints: &Restraints,
    centre: &Centre,
    program: &mut ConeProgram,
) {
    if analysis.kind != AnalysisKind::Static {
        return;
    }
    if let Mode::Motion(motion) = mode {
        return give_inertia(motion, program);
    }
    let retry = *mode == Mode::Equilibrium(Effort::Regularised);
    let mut loose = if retry {
        vec![true; program.bodies.len()]
    } else {
        find_loose(bodies, contacts, history, program)
    };
    // Counting misses mechanisms whose constraints are in the wrong places. Bodies without load in
    // the last increment, or in a rejected solution of this one, may be part of a mechanism.
    let bearing = |i: usize| restraints.bearing.get(i).copied().unwrap_or_default();
    if !history.0.is_empty() {
        let forces = history.0.iter().map(|m| (m.a, m.b, m.p.abs().max(m.q.abs())));
        for (i, loaded) in find_loaded(bodies.particles, forces).into_iter().enumerate() {
            loose[i] |= !loaded && bearing(i) != Bearing::Load;
        }
        // A group without load on any member is such a body.
        for group in &bodies.groups {
            loose[group.body as usize] |= group.members.iter().all(|i| loose[*i as usize]);
        }
    }
    for (i, loose) in loose.iter_mut().enumerate() {
        *loose |= bearing(i) == Bearing::Nothing;
    }
    let unit = program.scales.force / program.scales.displacement;
    let usual = if retry {
        (WEIGHT_OF_RETRY * FALL.powf(f64::from(centre.moves))).max(acceptance.regularisation)
    } else {
        acceptance.regularisation
    };
    let weight = unit * usual;
    let length = program.scales.length;
    for (i, body) in program.bodies.iter_mut().enumerate().filter(|(i, _)| loose[*i]) {
        for (k, dof) in body.dofs.iter_mut().enumerate() {
            if let Dof::Free(free) = dof {
                free.proximal = if k < 2 { weight } else { weight * length * length };
                free.reference = centre.place.get(i).map_or(0.0, |c| c[k]);
            }
        }
    }
}

/// Sets the inertia of a step of a motion, in place of the proximal term. The balance of the
/// committed equilibrium does not contain it.
fn give_inertia(motion: &Motion, program: &mut ConeProgram) {
    for (i, body) in program.bodies.iter_mut().enumerate() {
        for (k, dof) in body.dofs.iter_mut().enumerate() {
            if let Dof::Free(free) = dof {
                (free.proximal, free.reference) = motion.inertia(i, k);
            }
        }
    }
}

/// Forces below this fraction of the maximum force count as zero.
const MIN_LOAD: f64 = 1e-6;

/// Whether each particle carries more than `MIN_LOAD` of the maximum force. `forces` are in N, by
/// pairs of bodies.
pub fn find_loaded(
    particles: usize,
    forces: impl Iterator<Item = (u32, u32, f64)> + Clone,
) -> Vec<bool> {
    let threshold = MIN_LOAD * forces.clone().map(|f| f.2).fold(0.0, f64::max);
    let mut loaded = vec![false; particles];
    for (a, b, _) in forces.filter(|f| f.2 > threshold) {
        for body in [a as usize, b as usize].into_iter().filter(|b| *b < particles) {
            loaded[body] = true;
        }
    }
    loaded
}

/// Whether an interaction is stiff at the start of the increment: a bond, or a closed contact.
/// `pair` are the rows of its bodies in the memory.
fn is_stiff(c: &Interaction, (a, b): (u32, u32), history: &ContactHistory) -> bool {
    c.limits.has_strength() || c.offset <= 0.0 || history.get(a, b).is_some_and(|m| m.p > 0.0)
}

fn free_dofs(program: &ConeProgram, body: usize) -> usize {
    program.bodies[body].dofs.iter().filter(|d| matches!(d, Dof::Free(_))).count()
}

/// Flags every body that needs regularisation.
pub fn find_loose(
    bodies: &Bodies,
    contacts: &[Contact],
    history: &ContactHistory,
    program: &ConeProgram,
) -> Vec<bool> {
    let n = program.bodies.len();
    // In the program a member of a rigid group has the row of the group.
    let pair = |k: usize, c: &Interaction| contacts.get(k).map_or((c.a, c.b), |x| (x.a, x.b));
    let stiff: Vec<&Interaction> = program
        .interactions
        .iter()
        .enumerate()
        .filter(|(k, c)| is_stiff(c, pair(*k, c), history))
        .map(|(_, c)| c)
        .collect();
    let held = |c: &Interaction| {
        1 + usize::from(c.limits.has_shear()) + usize::from(c.limits.has_rolling())
    };
    let adjacency = Adjacency::new(n, stiff.iter().map(|c| [c.a as usize, c.b as usize]));
    let mut constraints = vec![0; n];
    for c in &stiff {
        for body in [c.a as usize, c.b as usize] {
            constraints[body] += held(c);
        }
    }
    let mut loose = vec![false; n];
    let mut freedom: Vec<usize> = (0..n).map(|i| free_dofs(program, i)).collect();
    // The cell is no body that could be loose.
    if let Some(cell) = &program.cell {
        freedom[cell.body as usize] = 0;
    }
    let mut queue: Vec<usize> = (0..n).filter(|i| constraints[*i] < freedom[*i]).collect();
    while let Some(i) = queue.pop() {
        if std::mem::replace(&mut loose[i], true) {
            continue;
        }
        for &k in adjacency.of(i) {
            let c = stiff[k];
            let j = if c.a as usize == i { c.b } else { c.a } as usize;
            constraints[j] = constraints[j].saturating_sub(held(c));
            if !loose[j] && constraints[j] < freedom[j] {
                queue.push(j);
            }
        }
    }
    for cluster in clusters(program, &stiff, &loose, &freedom) {
        // One particle is held, and what is periodic does not turn.
        let is_held = |i: &usize| program.bodies[*i].dofs[..2].iter().all(is_fixed);
        if program.cell.is_some() && cluster.iter().any(is_held) {
            continue;
        }
        hold_cluster(bodies, program, &stiff, &adjacency, &freedom, &cluster, &mut loose);
    }
    loose
}

fn is_fixed(dof: &Dof) -> bool {
    matches!(dof, Dof::Fixed(_))
}

/// Connected clusters of bodies with free degrees of freedom.
fn clusters(
    program: &ConeProgram,
    stiff: &[&Interaction],
    loose: &[bool],
    freedom: &[usize],
) -> Vec<Vec<usize>> {
    let n = program.bodies.len();
    let mut parent: Vec<usize> = (0..n).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    let takes_part = |i: usize| !loose[i] && freedom[i] > 0;
    for c in stiff {
        let (a, b) = (c.a as usize, c.b as usize);
        if takes_part(a) && takes_part(b) {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            // The smaller index becomes the root, so that clusters are ordered by their first body.
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut members = vec![Vec::new(); n];
    for i in (0..n).filter(|i| takes_part(*i)) {
        members[root(&mut parent, i)].push(i);
    }
    members.retain(|m| !m.is_empty());
    members
}

/// Flags the bodies of a cluster that need regularisation: none if the ground holds the cluster,
/// its loaded walls if they suffice, else all.
fn hold_cluster(
    bodies: &Bodies,
    program: &ConeProgram,
    stiff: &[&Interaction],
    adjacency: &Adjacency,
    freedom: &[usize],
    cluster: &[usize],
    loose: &mut [bool],
) {
    let first_group = bodies.positions.len() - bodies.group_count;
    let is_wall = |i: usize| (bodies.particles..first_group).contains(&i);
    let walls: Vec<usize> = cluster.iter().copied().filter(|i| is_wall(*i)).collect();
    let unknowns = 3 + walls.len();
    let centre = cluster.iter().map(|i| bodies.positions[*i]).sum::<DVec2>() / cluster.len() as f64;
    let extent = cluster
        .iter()
        .map(|i| bodies.positions[*i].distance(centre))
        .fold(bodies.mean_radius, f64::max);
    let mut gram = vec![vec![0.0; unknowns]; unknowns];
    let mut add = |row: &[f64]| {
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
            let mut row = vec![0.0; unknowns];
            match dof {
                Dof::Free(_) => continue,
                Dof::Fixed(_) if k < 2 => {
                    row[..3].copy_from_slice(&along(if k == 0 { DVec2::X } else { DVec2::Y }));
                }
                // A group whose rotation is imposed does not turn with the cluster.
                Dof::Fixed(_) if i >= first_group => row[2] = 1.0,
                // A disk without a rotation row turns freely and does not hold the cluster.
                Dof::Fixed(_) => continue,
            }
            add(&row);
        }
        for &k in adjacency.of(i) {
            let c = stiff[k];
            let first = c.a as usize == i;
            let other = if first { c.b } else { c.a } as usize;
            let wall = walls.iter().position(|w| *w == other);
            if wall.is_none() && freedom[other] > 0 {
                continue;
            }
            let mut normal = vec![0.0; unknowns];
            let (direction, arm) =
                if first { (c.normal, c.normal_arm_a) } else { (-c.normal, c.normal_arm_b) };
            normal[..3].copy_from_slice(&along(direction));
            normal[2] += arm / extent;
            if let Some(w) = wall {
                normal[3 + w] = -direction.dot(program.bodies[other].axis);
            }
            add(&normal);
            if c.limits.has_shear() {
                let (tangent, arm) =
                    if first { (c.normal.perp(), c.arm_a) } else { (-c.normal.perp(), c.arm_b) };
                let mut slip = vec![0.0; unknowns];
                slip[..3].copy_from_slice(&along(tangent));
                slip[2] += arm / extent;
                // A wall that is no line may be pushed along its axis by friction as well.
                if let Some(w) = wall {
                    slip[3 + w] = -tangent.dot(program.bodies[other].axis);
                }
                add(&slip);
            }
            if c.limits.has_rolling() {
                let mut roll = vec![0.0; unknowns];
                roll[2] = bodies.mean_radius / extent;
                add(&roll);
            }
        }
    }
    if full_rank(gram.clone()) {
        return;
    }
    for (w, &wall) in walls.iter().enumerate() {
        gram[3 + w][3 + w] += 1.0;
        loose[wall] = true;
    }
    if !full_rank(gram) {
        for &i in cluster {
            loose[i] = true;
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
