//! The steps of a followed motion within a static increment.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::program::Dof;

use super::dynamic::turned_work;
use super::interactions::{Before, Tables, book};
use crate::assemble_program::groups;
use crate::contact_laws::Laws;
use crate::solved::Solved;

/// Adds a step before it is applied: with the memory of contacts at its end, the displacements of
/// the bodies (m, m, rad), and the bonds that break in it.
pub(crate) fn book_step(
    world: &mut World,
    history: &ContactHistory,
    moved: &[[f64; 3]],
    broken: &[Rupture],
) {
    let (solved, laws) = (Solved::of(world), Laws::of(world));
    let Solved { bodies, program, solution, .. } = solved;
    let mut e = Energies::default();
    let mut held = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(&solution.forces, &mut held);
    for (i, (body, u)) in program.bodies.iter().zip(&solution.displacements).enumerate() {
        for k in 0..3 {
            e.external += u[k]
                * match &body.dofs[k] {
                    Dof::Free(free) => free.load - free.inertia * u[k],
                    Dof::Fixed(_) => held[i][k],
                };
        }
    }
    for (i, u) in moved.iter().enumerate().take(bodies.particles) {
        e.gravity += bodies.static_weight(i, laws.analysis.gravity).dot(DVec2::new(u[0], u[1]));
    }
    // The loads of the program contain the weight.
    e.external -= e.gravity;
    // The row of a periodic cell follows those of all bodies.
    let end: Vec<DVec2> =
        bodies.positions.iter().zip(moved).map(|(x, u)| *x + DVec2::new(u[0], u[1])).collect();
    let tables = Tables {
        solved,
        laws,
        history,
        fraction: world.resource::<ClasticProgress>().fraction,
        corrections: world.resource(),
        end: &end,
        end_cell: bodies.deformed_cell(moved.get(bodies.positions.len()).copied()),
        // The loads of a step are constant.
        cell_loads: Default::default(),
    };
    let (gravity, fraction) = (laws.analysis.gravity, tables.fraction);
    for turning in groups::turning(bodies, solved.contacts, program, fraction, gravity, &[]) {
        let row = turning.group.body as usize;
        e.external += turned_work(&tables, turning.group);
        if let Dof::Free(_) = program.bodies[row].dofs[2] {
            let turn = solution.displacements[row][2];
            e.external += turning.lost_at(turn) * turn;
        }
    }
    let is_broken = |bond| broken.iter().any(|r| r.bond == bond);
    let before = Before::of(world.resource(), world.resource());
    let stored = book(&mut e, &tables, &before, is_broken, |e, part| {
        e.friction += part.forces[1] * part.multipliers.slip;
        e.rolling += part.forces[2] * part.multipliers.rotation;
    });
    // The remaining energy was removed from the motion: by its implicit steps, by contacts that
    // close (with plastic impact), and by the residual of the step.
    e.numerical = 0.0;
    let mut energies = world.resource_mut::<MotionEnergies>();
    energies.energies += e;
    // The remainder is taken from the sums. Steps that oscillate would accumulate the round-off of
    // each step.
    let left = energies.energies.error();
    energies.energies.motion += left;
    energies.stored = Some(stored);
}
