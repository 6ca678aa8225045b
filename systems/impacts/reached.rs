//! Judge: has an impact of the increment caused others, and do they gain no energy together?
//!
//! The program bounds the closing of a pair that hits nothing by its gap, so that a body which an impact
//! sends against another one would stop there as in a plastic impact. The program is therefore solved
//! again with Newton's law of restitution at these pairs too, as if they touched: all impacts of an
//! increment are simultaneous then, and without friction they gain no energy (Moreau 1988).
//!
//! With friction simultaneous impacts may gain some (Kane and Levinson 1985), and an impulse that lifts bodies
//! against their weight gains what it does not take from the weight within the increment. Each cluster of bodies
//! that carry forces on each other is therefore checked, and solved again with half of its restitution,
//! then with none, until it gains nothing.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Dof, Interaction, ProgramBody};
use clastic_cone::residuals::Carrying;

use super::push_out::residual_overlap;
use crate::measures::fragments::connected;
use crate::solved::{Solved, SolvedTables};

/// Gain of energy of a cluster, over the energy that it exchanges, which does not count: the
/// tolerance of the solver leaves as much.
const NO_GAIN: f64 = 1e-6;
/// Minimum factor of a restitution: a cluster that still gains energy with it has none next.
const LEAST: f64 = 0.5;

/// Adds what the impacts have caused, and requests another solution.
pub fn judge(
    settings: (Res<Acceptance>, Res<ClasticAnalysis>, Res<ClasticProgress>),
    tables: SolvedTables,
    impacts: Res<Impacts>,
    mut reached: ResMut<Reached>,
    mut attempt: ResMut<Attempt>,
) {
    let (acceptance, analysis, progress) = settings;
    let AnalysisKind::Dynamic { dt, .. } = analysis.kind else { return };
    if impacts.hit.is_empty() {
        return;
    }
    let dt = dt * progress.fraction;
    let solved = tables.get();
    let Solved { bodies, program, solution, .. } = solved;
    let carrying = Carrying::new(program, solution);
    let clusters = Clusters::new(program, &carrying);
    let mut struck = vec![false; program.bodies.len()];
    for k in impacts.hit.iter().filter(|k| carrying.is_carrying(**k)) {
        struck[clusters.of(&program.interactions[*k])] = true;
    }
    let touch = residual_overlap(&acceptance, bodies);
    let mut new = Vec::new();
    for (k, (contact, c, f)) in solved.contacts().enumerate() {
        let pair = (contact.a, contact.b);
        let is_rigid = c.normal_compliance == 0.0 && !c.limits.has_strength();
        // What dilation closes is no impact.
        let dilates = solution.law.dilation(c) > 0.0 && c.limits.slides(f);
        let is_known = reached.speed(pair).is_some() || impacts.hit.binary_search(&k).is_ok();
        let may_meet = carrying.is_carrying(k) && struck[clusters.of(c)];
        if may_meet && is_rigid && !is_known && !dilates && contact.gap > touch {
            let speed = (c.offset + f[0] * mobility(program, c)) / dt;
            new.push((pair, speed));
        }
    }
    if !new.is_empty() {
        reached.pairs.extend(new);
        reached.pairs.sort_unstable_by_key(|(pair, _)| *pair);
        attempt.verdict = Verdict::Again;
        return;
    }
    let gains = gains(solved, &clusters, &carrying);
    reached.factors.resize(program.bodies.len(), 1.0);
    for (root, factor) in clusters.root.iter().zip(&mut reached.factors) {
        let cluster = *root as usize;
        if gains[cluster] && struck[cluster] && *factor > 0.0 {
            *factor = if *factor > LEAST { 0.5 * *factor } else { 0.0 };
            attempt.verdict = Verdict::Again;
        }
    }
}

/// Bodies that carry forces on each other. A body that cannot move is a cluster of its own.
struct Clusters {
    /// The first body of the cluster, by body.
    root: Vec<u32>,
    is_free: Vec<bool>,
}

impl Clusters {
    fn new(program: &ConeProgram, carrying: &Carrying) -> Self {
        let is_free: Vec<bool> = program.bodies.iter().map(ProgramBody::is_free).collect();
        let are_free = |c: &Interaction| is_free[c.a as usize] && is_free[c.b as usize];
        let all = program.interactions.iter().enumerate();
        let pairs = all.filter(|(k, c)| carrying.is_carrying(*k) && are_free(c));
        let root = connected(program.bodies.len(), pairs.map(|(_, c)| (c.a, c.b)));
        Self { root, is_free }
    }

    /// The cluster of an interaction: that of the body that can move.
    fn of(&self, c: &Interaction) -> usize {
        let body = if self.is_free[c.a as usize] { c.a } else { c.b };
        self.root[body as usize] as usize
    }
}

/// Closing of a pair, m, that a unit normal force prevents.
fn mobility(program: &ConeProgram, c: &Interaction) -> f64 {
    let of = |body: u32| match &program.bodies[body as usize].dofs[0] {
        Dof::Free(free) if free.inertia > 0.0 => 1.0 / free.inertia,
        _ => 0.0,
    };
    of(c.a) + of(c.b)
}

/// Which clusters gain energy, kinetic and potential. The impulse of a contact does work along the mean of the
/// relative velocities before and after. Bodies move with the velocity after, so that an impulse which
/// changes it by dv also takes half of f dt . dv from the loads f. A single impact gains nothing.
fn gains(solved: Solved, clusters: &Clusters, carrying: &Carrying) -> Vec<bool> {
    let Solved { program, solution, .. } = solved;
    // Motion of the step at the velocity before; with restitution that at the end is u/dt.
    let mut motion_before = solution.displacements.clone();
    // Twice the energy that is lost, and what contacts exchange.
    let n = program.bodies.len();
    let (mut taken, mut exchanged, mut contacts) = (vec![0.0; n], vec![0.0; n], vec![0_u32; n]);
    let moved = motion_before.iter_mut().zip(&solution.displacements);
    for ((body, root), (before, after)) in program.bodies.iter().zip(&clusters.root).zip(moved) {
        for (k, free) in body.free().filter(|(_, free)| free.inertia > 0.0) {
            before[k] = free.momentum / free.inertia;
            taken[*root as usize] += (free.load - free.momentum) * (after[k] - before[k]);
        }
    }
    let all = program.interactions.iter().enumerate();
    for (k, c) in all.filter(|(k, _)| carrying.is_carrying(*k)) {
        let before = program.kinematics(c, &motion_before);
        let after = program.kinematics(c, &solution.displacements);
        let cluster = clusters.of(c);
        contacts[cluster] += 1;
        for (f, (before, after)) in solution.forces[k].iter().zip(before.iter().zip(after)) {
            taken[cluster] += f * (before + after);
            exchanged[cluster] += (f * before).abs() + (f * after).abs();
        }
    }
    let gains = |i: usize| contacts[i] > 1 && taken[i] < -NO_GAIN * exchanged[i];
    (0..taken.len()).map(gains).collect()
}
