//! Dissipation of interactions in a time step: impulses times the mean of the velocities before and
//! after.

use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::program::ConeProgram;

use super::BookedBody;
use super::interactions::{Part, Tables};
use crate::assemble_program::groups::lost_by_turning;
use crate::solved::Solved;

/// Adds the work of loads and the kinetic energy of a time step of `dt` (s). Returns the
/// displacements by body at the mean of the velocities before and after, in the axes of the body,
/// m, m, rad.
pub(crate) fn book_bodies(
    e: &mut Energies,
    tables: &Tables,
    dt: f64,
    theta: f64,
    moved: &[BookedBody],
) -> Vec<[f64; 3]> {
    let Solved { bodies, program, solution, .. } = tables.solved;
    let analysis = tables.laws.analysis;
    let mut mean = solution.displacements.clone();
    for &BookedBody { row: i, force, rates, .. } in moved {
        if i >= bodies.particles && bodies.group(i).is_some() {
            // The forces on a wall of a group act on the group.
            continue;
        }
        let u = program.bodies[i].to_global(solution.displacements[i]);
        e.external += (0..3).map(|k| force[k] * u[k]).sum::<f64>();
        if let Some(group) = bodies.group_at(i) {
            book_group(e, tables, dt, theta, group, force, &mut mean[i]);
            continue;
        }
        let Some(after) = rates else { continue };
        e.gravity += bodies.masses[i] * analysis.gravity.dot(DVec2::new(u[0], u[1]));
        if analysis.path_theta.is_some() {
            // The balance is that of the program, but the loads do their work along the path.
            let aside = tables.end[i] - bodies.positions[i] - DVec2::new(u[0], u[1]);
            let by_gravity = bodies.masses[i] * analysis.gravity.dot(aside);
            let by_loads = force[0] * aside.x + force[1] * aside.y;
            e.gravity += by_gravity;
            e.external += by_loads;
            e.numerical += by_gravity + by_loads;
        }
        let before = bodies.rates(i);
        for k in 0..3 {
            let mass = bodies.mass_of(i, k);
            let change = after[k] - before[k];
            e.kinetic += 0.5 * mass * change * (after[k] + before[k]);
            if bodies.group(i).is_some() {
                // Loads and drives act on the group.
                continue;
            }
            if bodies.drives[i][k] == BodyDrive::Free {
                mean[i][k] = 0.5 * dt * (before[k] + after[k]);
                let weight = if k < 2 { mass * analysis.gravity[k] } else { 0.0 };
                e.numerical += (force[k] + weight) * (theta - 0.5) * dt * change;
            } else {
                // An imposed velocity holds from the start of the step. Its change is an impulse,
                // which does its work at the mean velocity.
                e.external -= 0.5 * mass * change * change;
            }
        }
    }
    mean
}

/// Adds the work of the drives and loads of a rigid group besides that of its external force. Its
/// kinetic energy is that of its members. Sets its displacement at the mean of the velocities
/// before and after.
fn book_group(
    e: &mut Energies,
    tables: &Tables,
    dt: f64,
    theta: f64,
    group: &GroupRow,
    force: [f64; 3],
    mean: &mut [f64; 3],
) {
    let Solved { bodies, solution, .. } = tables.solved;
    let row = group.body as usize;
    let before = bodies.rates(row);
    let analysis = tables.laws.analysis;
    let mut all = bodies.load_on_group(group, tables.fraction, analysis.gravity);
    let turn = solution.displacements[row][2];
    let mut by_turn = 0.0;
    if group.drives[2] == BodyDrive::Free {
        let [moment, stiffness] = lost_by_turning(bodies, group, tables.fraction, analysis);
        by_turn = moment + stiffness * turn;
        all[2] -= by_turn;
    }
    for k in 0..3 {
        let u = solution.displacements[row][k];
        if group.drives[k] == BodyDrive::Free {
            let after = (u / dt - (1.0 - theta) * before[k]) / theta;
            mean[k] = 0.5 * dt * (before[k] + after);
            let of_members = all[k] - group.loads[k].at(tables.fraction);
            e.numerical += (force[k] + of_members) * (theta - 0.5) * dt * (after - before[k]);
        } else {
            let change = u / dt - before[k];
            e.external -= 0.5 * group.mass_of(k) * change * change;
        }
    }
    // The program has the moment of the weight about a pivot as it is within the step.
    e.turning += turned_work(tables, group) + by_turn * turn;
}

/// Work of the weight and of the loads of the members along their finite rotation, less that along
/// the motion of the program: of second order in the rotation.
pub(super) fn turned_work(tables: &Tables, group: &GroupRow) -> f64 {
    let Solved { bodies, solution, .. } = tables.solved;
    let u = solution.displacements[group.body as usize];
    let mut sum = 0.0;
    for i in bodies.particles_of(group) {
        let lever = bodies.lever(group, i);
        let [x, y, _] = GroupRow::carried_linearly(u, lever);
        let aside = DVec2::from_slice(&solution.displacements[i][..2]) - DVec2::new(x, y);
        let [fx, fy, _] = bodies.loads[i].map(|ramp| ramp.at(tables.fraction));
        let weight = bodies.masses[i] * tables.laws.analysis.gravity;
        sum += (weight + DVec2::new(fx, fy)).dot(aside);
    }
    sum
}

/// Adds the work of an interaction in a time step. `mean` are the displacements by body at the mean
/// of the velocities before and after, in the axes of the body, m, m, rad.
pub fn book(e: &mut Energies, program: &ConeProgram, mean: &[[f64; 3]], part: &Part) {
    let [p, q, tau] = part.forces;
    let moved = program.kinematics(part.law, mean);
    let [normal, shear, rolling] = part.change();
    e.turning -= part.normal[2] - part.normal[1];
    if part.law.rolling_compliance > 0.0 {
        let rolled = tau * part.multipliers.rotation;
        e.rolling += rolled;
        e.numerical += tau * moved[2] - rolled - rolling;
    } else {
        e.rolling += tau * moved[2];
    }
    if part.law.tangential_compliance > 0.0 {
        let slid = q * part.multipliers.slip;
        e.friction += slid;
        e.numerical += q * moved[1] - slid - shear;
    } else {
        e.friction += q * moved[1];
    }
    let rest = p * moved[0] - normal - part.opening();
    if part.law.normal_compliance > 0.0 {
        // Springs dissipate nothing: their misfit where they close or open is an error of the step.
        let opened = part.opened() * part.kinematics[0] / part.law.normal_compliance;
        e.dilation += opened;
        e.numerical += rest - opened;
    } else {
        e.collision += rest;
    }
}
