//! Finds sleeping bodies: bodies that need not move, because the forces of the last increment still
//! balance them and obey all limits.
//!
//! In dynamics whole clusters of touching bodies rest while others move: a pile on the ground that
//! grows from above, an island in a large scene. A cluster sleeps if zero displacement with the
//! forces of the last increment solves its rows with a residual below that of a solver.
//!
//! A cluster wakes without further rules. A body that comes near is a contact that joins it to
//! moving bodies. Residuals of its balance add up in the velocities, and residuals of its limits in
//! the gaps, until they exceed the threshold. Imposed slip adds up in neither, so that any slip
//! wakes it. In a periodic cell no body sleeps.
//!
//! Only programs with inertia have sleeping bodies. In statics all displacements may vanish, and
//! relative to them the round-off of a gap is not small.

use super::settings::DEFAULT_RESIDUAL;
use crate::adjacency::Adjacency;
use crate::program::{ConeProgram, ProgramBody, SlidingLaw};
use crate::residuals::Units;

/// Maximum residual of sleeping bodies: so small that it does not count beside that of the others.
const MAX_RESIDUAL: f64 = 0.01 * DEFAULT_RESIDUAL;

/// Which bodies sleep; `None` if none does. `moved` are the displacements of the last solution, the
/// unit of displacements.
pub fn find(program: &ConeProgram, moved: &[[f64; 3]]) -> Option<Vec<bool>> {
    let forces = &program.last_forces;
    if forces.is_empty() || !program.is_dynamic() || program.cell.is_some() {
        return None;
    }
    let units = Units::of(program, forces, moved);
    let still = program.imposed();
    let free: Vec<bool> = program.bodies.iter().map(ProgramBody::is_free).collect();
    let mut rests = free.clone();
    let mut known_rest = true;
    let no_force = [0.0; 3];
    for (c, f) in program.interactions.iter().zip(forces.iter().chain(std::iter::repeat(&no_force)))
    {
        let e = program.kinematics(c, &still);
        let left = units.of_interaction(SlidingLaw::Associated, c, &e, f);
        if left.worst() <= MAX_RESIDUAL && e[1] == 0.0 && e[2] == 0.0 {
            continue;
        }
        let [a, b] = [c.a as usize, c.b as usize];
        known_rest &= free[a] || free[b];
        (rests[a], rests[b]) = (false, false);
    }
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(forces, &mut rows);
    for (i, body) in program.bodies.iter().enumerate().filter(|(i, _)| free[*i]) {
        let left = units.of_balance(body, &rows[i], &[0.0; 3], 1.0);
        let slow = body.free().filter(|(_, free)| free.inertia > 0.0).all(|(k, free)| {
            let length = if k < 2 { 1.0 } else { units.length };
            let motion = (free.load - rows[i][k]) / free.inertia * length;
            motion.abs() <= MAX_RESIDUAL * units.displacement
        });
        if !(left.worst() <= MAX_RESIDUAL && slow) {
            rests[i] = false;
        }
    }
    if !rests.contains(&true) {
        return None;
    }
    wake_neighbours(program, &free, &mut rests);
    (rests.contains(&true) && (known_rest || rests != free)).then_some(rests)
}

/// Wakes all bodies of every cluster with a body that is awake.
fn wake_neighbours(program: &ConeProgram, free: &[bool], rests: &mut [bool]) {
    let both_free = program.interactions.iter().map(|c| (c.a, c.b));
    let pairs: Vec<_> = both_free.filter(|(a, b)| free[*a as usize] && free[*b as usize]).collect();
    let neighbours = Adjacency::of_neighbours(rests.len(), &pairs);
    let mut awake: Vec<usize> = (0..rests.len()).filter(|i| free[*i] && !rests[*i]).collect();
    while let Some(i) = awake.pop() {
        for &j in neighbours.of(i) {
            if std::mem::replace(&mut rests[j], false) {
                awake.push(j);
            }
        }
    }
}
