//! Balance of patches: a program of its own for each, with all other bodies held.

use super::super::matrix::{BodyMatrix, places};
use super::super::newton::{Goal, Nothing, iterate};
use super::super::parallel::in_parallel;
use super::super::scaled::{Local, Scaled};
use super::super::settings::LocalSettings;
use super::super::spring::Elastic;
use crate::adjacency::Adjacency;

/// Bodies with their displacements.
type Moved = Vec<(usize, [f64; 3])>;

/// Displacements of the bodies of all patches, each in balance with all others held at `u`. Threads
/// share the patches of a program that is worth it.
pub fn balance_all<S: Elastic<F>, const F: usize>(
    program: &Scaled,
    adjacency: &Adjacency,
    settings: &LocalSettings,
    patches: &[Vec<usize>],
    u: &[[f64; 3]],
    goal: Goal,
    is_shared: bool,
) -> Moved {
    let balance =
        |members: &Vec<usize>| balance::<S, F>(program, adjacency, settings, members, u, goal);
    let solutions: Vec<Option<Moved>> = if is_shared {
        in_parallel(patches.iter(), balance)
    } else {
        patches.iter().map(balance).collect()
    };
    solutions.into_iter().flatten().flatten().collect()
}

/// Displacements of the `members` with all others held where `start` has them; `None` if the result
/// is not finite.
fn balance<S: Elastic<F>, const F: usize>(
    program: &Scaled,
    adjacency: &Adjacency,
    settings: &LocalSettings,
    members: &[usize],
    start: &[[f64; 3]],
    goal: Goal,
) -> Option<Moved> {
    let mut used: Vec<usize> = members.iter().flat_map(|i| adjacency.of(*i)).copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut bodies: Vec<usize> = used
        .iter()
        .flat_map(|k| program.pair(&program.locals[*k]))
        .chain(members.iter().copied())
        .collect();
    bodies.sort_unstable();
    bodies.dedup();
    let number = |i: usize| bodies.binary_search(&i).unwrap_or(usize::MAX);
    let of_pair = |k: &usize| program.pair(&program.locals[*k]).map(|i| number(i) as u32).into();
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
    let with_others_held = |&k: &usize| {
        let mut l = program.with_cell_held(&program.locals[k], start);
        for side in (0..2).filter(|side| !is_member(l.bodies[*side])) {
            let rows = std::mem::take(&mut l.rows[side]);
            for (row, u) in rows.iter().zip(&start[l.bodies[side]]) {
                for f in 0..3 {
                    l.linear[f] -= row[f] * u;
                }
            }
        }
        Local { bodies: l.bodies.map(number), ..l }
    };
    part.locals = used.iter().map(with_others_held).collect();
    let from: Vec<[f64; 3]> = bodies.iter().map(|i| start[*i]).collect();
    let result = iterate::<S, F>(&part, &mut matrix, &from, &settings.newton, goal, &mut Nothing);
    if result.iterations == 0 || !result.u.iter().flatten().all(|u| u.is_finite()) {
        return None;
    }
    Some(bodies.into_iter().zip(result.u).filter(|(i, _)| is_member(*i)).collect())
}
