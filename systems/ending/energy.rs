//! The error of the energy of a time step that has the geometry of its start.
//!
//! With theta = 1/2 the scheme keeps the energy of the motion that its program describes. The turn
//! of normals and the misfit of gaps and slips do work during the step that no balance accounts
//! for, in each step with the same sign: a pendulum doubles its energy in a few swings. Where
//! friction and impacts dissipate ten times as much in the same step, this error does not matter.

use super::geometry::Ending;
use crate::solved::Solved;
use clastic_cone::program::{ConeProgram, Interaction};

/// Maximum error over the energy that friction and impacts dissipate. At 1 a hopper of elastic
/// grains in steps of half a period of a contact gains twice the energy that its grains have fallen
/// by, at 0.1 it loses 2 % of it.
const ACCEPTED: f64 = 0.1;
/// Maximum error of the energy of a step over the kinetic and the elastic energy. It is systematic:
/// 10 000 steps add up to 1e-7.
const MAX_ERROR: f64 = 1e-11;
/// Work, over that of the maximum force along a mean radius, which does not count: the tolerance of
/// the solver leaves as much. It counts where bodies turn back and have no kinetic energy.
const NO_WORK: f64 = 1e-13;

/// Maximum error over the kinetic and the elastic energy, beyond what the step dissipates, with
/// which passes that do not converge may end. The tolerance of the solver leaves as much in a
/// packing near rest, and in steps beyond the range of the passes a gas gains a hundredth and more.
const MAX_STALLED_ERROR: f64 = 1e-6;

/// Work that the geometry of the start does wrongly: over the work that is accepted, and over the
/// maximum with which a step may end. `work` is that of the maximum force along a mean radius, J.
pub fn errors(solved: Solved, ending: &Ending, work: f64) -> [f64; 2] {
    let Solved { program, solution, .. } = solved;
    let u = &solution.displacements;
    let of_turns: f64 = u.iter().zip(&ending.loads).map(|(u, r)| dot(u, r).abs()).sum();
    let (mut of_misfits, mut taken, mut energy) = (0.0, 0.0, 0.0);
    for (k, (c, f)) in program.interactions.iter().zip(&solution.forces).enumerate() {
        let e = program.kinematics(c, u);
        let compliance = [c.normal_compliance, c.tangential_compliance, c.rolling_compliance];
        let is_bond = c.limits.has_strength();
        let gives_way = [false, c.limits.slides(f), c.limits.rolls(f)];
        for (i, misfit) in ending.misfits[k].into_iter().enumerate() {
            of_misfits += (f[i] * misfit).abs();
            // What a spring stores besides: at an impact its force may vanish where its misfit does not.
            if compliance[i] > 0.0 && !gives_way[i] {
                let answer = misfit / compliance[i];
                let is_open = i == 0 && !is_bond;
                let answer = if is_open { answer.max(-f[0]) } else { answer };
                of_misfits += 0.5 * compliance[i] * answer * answer;
            } else if compliance[i] == 0.0 && is_bond && !gives_way[i] {
                // The next step moves the bodies of a rigid bond back against their inertia.
                of_misfits += 0.5 * inertia(program, c) * misfit * misfit;
            }
        }
        for i in 0..3 {
            energy += 0.5 * compliance[i] * f[i] * f[i];
            if gives_way[i] || (compliance[i] == 0.0 && !is_bond) {
                taken += (f[i] * e[i]).abs();
            }
        }
    }
    for (body, u) in program.bodies.iter().zip(u) {
        for (k, free) in body.free() {
            energy += 0.5 * free.inertia * u[k] * u[k];
        }
    }
    let wrong = of_turns + of_misfits + ending.by_closing;
    let no_work = NO_WORK * work;
    let accepted = (ACCEPTED * taken).max(MAX_ERROR * energy + no_work);
    let at_most = taken.max(MAX_STALLED_ERROR * energy + no_work);
    [accepted, at_most].map(|allowed| if wrong > 0.0 { wrong / allowed } else { 0.0 })
}

/// Inertia of the lighter of the two bodies of an interaction, kg/s^2; 0 if neither can move.
fn inertia(program: &ConeProgram, c: &Interaction) -> f64 {
    let bodies = [c.a, c.b].map(|i| &program.bodies[i as usize]);
    let inertias = bodies.iter().flat_map(|body| body.free().filter(|(k, _)| *k < 2));
    inertias.map(|(_, free)| free.inertia).reduce(f64::min).unwrap_or(0.0)
}

fn dot(x: &[f64; 3], y: &[f64; 3]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}
