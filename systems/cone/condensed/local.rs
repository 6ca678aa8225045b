//! Local elimination: bodies that are far out of balance, and their surroundings, are brought to
//! balance with all others held before the next global step.
//!
//! After a rupture a few contacts out of thousands change their state, and a cluster that came loose
//! sends the global direction far off; the one global step length then serves one cluster per
//! factorisation. Each cluster on its own is a small problem. It is solved to the end: what is left
//! would be the residual of the whole program after the next step, if all but a few clusters are elastic.
//! (Nonlinear elimination, or nonlinearly preconditioned Newton: Cai and Keyes 2002.)

use super::matrix::{BodyMatrix, places};
use super::newton::{self, Goal};
use super::parallel::in_parallel;
use super::scaled::{Local, Scaled};
use super::settings::LocalSettings;
use crate::adjacency::Adjacency;

/// Walls touch bodies everywhere: elimination leaves them where they are.
pub(super) fn is_crowded(adjacency: &Adjacency, settings: &LocalSettings, body: usize) -> bool {
    adjacency.of(body).len() > settings.max_interactions
}

/// Brings the bodies that are furthest out of balance, and those that are `fast` (none if it is empty),
/// to balance; returns whether any moved.
pub(super) fn eliminate(
    program: &Scaled,
    adjacency: &Adjacency,
    settings: &LocalSettings,
    gradient: &[[f64; 3]],
    e: &[[f64; 2]],
    fast: &[bool],
    u: &mut [[f64; 3]],
) -> bool {
    let unbalance: Vec<f64> =
        gradient.iter().map(|g| g.iter().fold(0.0_f64, |m, g| m.max(g.abs()))).collect();
    let greatest = unbalance.iter().copied().fold(0.0, f64::max);
    let n = unbalance.len();
    let mobile = |i: usize| program.free[i].contains(&true) && !is_crowded(adjacency, settings, i);
    let wanted = |i: usize| unbalance[i] > settings.share * greatest || fast.get(i) == Some(&true);
    let mut inside = vec![false; n];
    let mut list: Vec<usize> = (0..n).filter(|i| wanted(*i) && mobile(*i)).collect();
    for i in &list {
        inside[*i] = true;
    }
    let joined = |k: usize, i: usize| {
        let l = &program.locals[k];
        let bonded = l.count == 3 && l.right[2] > 0.0;
        let near = bonded || e[k][0] - l.linear[0] > -settings.max_gap;
        near.then(|| if l.bodies[0] == i { l.bodies[1] } else { l.bodies[0] })
    };
    let mut first = 0;
    for _ in 0..settings.rings {
        let ring = first..list.len();
        first = ring.end;
        for at in ring {
            for &k in adjacency.of(list[at]) {
                if let Some(j) = joined(k, list[at])
                    && !inside[j]
                    && mobile(j)
                {
                    inside[j] = true;
                    list.push(j);
                }
            }
        }
    }
    list.sort_unstable();
    let mut seen = vec![false; n];
    let mut patches = Vec::new();
    for &seed in &list {
        if std::mem::replace(&mut seen[seed], true) {
            continue;
        }
        let mut members = vec![seed];
        let mut at = 0;
        while at < members.len() {
            for &k in adjacency.of(members[at]) {
                if let Some(j) = joined(k, members[at])
                    && inside[j]
                    && !std::mem::replace(&mut seen[j], true)
                {
                    members.push(j);
                }
            }
            at += 1;
        }
        if members.len() <= settings.max_bodies {
            members.sort_unstable();
            patches.push(members);
        }
    }
    let goal = Goal { relative: settings.goal, absolute: settings.residual * greatest };
    let solutions = {
        let start = &*u;
        let of_patch =
            |members: &Vec<usize>| balance(program, adjacency, settings, members, start, goal);
        let many = patches.iter().map(Vec::len).sum::<usize>() >= settings.min_parallel_bodies;
        if many {
            in_parallel(patches.iter(), of_patch)
        } else {
            patches.iter().map(of_patch).collect()
        }
    };
    let mut moved = false;
    for (i, v) in solutions.into_iter().flatten().flatten() {
        u[i] = v;
        moved = true;
    }
    moved
}

/// Displacements of the `members` with all others held where `start` has them; `None` if nothing finite
/// came of it.
fn balance(
    program: &Scaled,
    adjacency: &Adjacency,
    settings: &LocalSettings,
    members: &[usize],
    start: &[[f64; 3]],
    goal: Goal,
) -> Option<Vec<(usize, [f64; 3])>> {
    let mut used: Vec<usize> = members.iter().flat_map(|i| adjacency.of(*i)).copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut bodies: Vec<usize> = used
        .iter()
        .flat_map(|k| program.locals[*k].bodies)
        .chain(members.iter().copied())
        .collect();
    bodies.sort_unstable();
    bodies.dedup();
    let number = |i: usize| bodies.binary_search(&i).unwrap_or(usize::MAX);
    let of_pair = |k: &usize| program.locals[*k].bodies.map(|i| number(i) as u32).into();
    let pairs: Vec<(u32, u32)> = used.iter().map(of_pair).collect();
    let mut matrix = BodyMatrix::new(bodies.len(), &pairs)?;
    let place = places(matrix.order());
    let number = |i: usize| place[number(i)];
    let bodies: Vec<usize> = matrix.order().iter().map(|k| bodies[*k]).collect();
    let is_member = |i: usize| members.binary_search(&i).is_ok();
    let mut part = Scaled::default();
    for &i in &bodies {
        let free = if is_member(i) { program.free[i] } else { [false; 3] };
        part.free.push(free);
        part.weight.push(program.weight[i]);
        part.right.push(program.right[i]);
        part.known.push(start[i]);
    }
    part.locals = used
        .iter()
        .map(|&k| {
            let mut l = program.locals[k].clone();
            // Who is held is known, like what is fixed.
            for side in (0..2).filter(|side| !is_member(l.bodies[*side])) {
                let rows = std::mem::take(&mut l.rows[side]);
                for (row, u) in rows.iter().zip(&start[l.bodies[side]]) {
                    for f in 0..3 {
                        l.linear[f] -= row[f] * u;
                    }
                }
            }
            Local { bodies: l.bodies.map(number), ..l }
        })
        .collect();
    let from: Vec<[f64; 3]> = bodies.iter().map(|i| start[*i]).collect();
    let result = newton::iterate(&part, &mut matrix, &from, &settings.newton, goal, None);
    if result.iterations == 0 || !result.u.iter().flatten().all(|u| u.is_finite()) {
        return None;
    }
    Some(bodies.into_iter().zip(result.u).filter(|(i, _)| is_member(*i)).collect())
}
