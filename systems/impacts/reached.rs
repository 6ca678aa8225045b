//! Judge: has an impact of the increment closed other pairs?
//!
//! The program bounds the closing of a pair that hits nothing by its gap, so that a body which an impact
//! sends against another one would stop there as in a plastic impact. The program is therefore solved
//! again with Newton's law of restitution at these pairs too, as if they touched: all impacts of an
//! increment are simultaneous then, and with e = 1 they keep the energy (Moreau 1988).

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::{Impacts, Reached};
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_cone::program::{ConeProgram, ConeSolution, Dof, Interaction};
use clastic_cone::residuals::Carrying;

use super::push_out::residual_overlap;

/// Adds the pairs that an impact has closed, and requests another solution.
pub fn judge(
    settings: (Res<Acceptance>, Res<ClasticAnalysis>, Res<ClasticProgress>),
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    impacts: Res<Impacts>,
    mut reached: ResMut<Reached>,
    mut attempt: ResMut<Attempt>,
) {
    let (acceptance, analysis, progress) = settings;
    let AnalysisKind::Dynamic { dt, .. } = analysis.kind else { return };
    let dt = dt * progress.fraction;
    let carrying = Carrying::new(&program, &solution);
    let struck = struck(&program, &impacts, |k| carrying.is_carrying(k));
    let touch = residual_overlap(&acceptance, &bodies);
    let mut new = Vec::new();
    for (k, (contact, c)) in contacts.0.iter().zip(&program.interactions).enumerate() {
        let pair = (contact.a, contact.b);
        let is_struck = struck[c.a as usize] || struck[c.b as usize];
        let is_rigid = c.normal_compliance == 0.0 && !c.limits.has_strength();
        // What dilation closes is no impact.
        let dilates = solution.law.dilation(c) > 0.0 && c.limits.slides(&solution.forces[k]);
        let is_known = reached.speed(pair).is_some() || impacts.hit.binary_search(&k).is_ok();
        if is_struck
            && is_rigid
            && !is_known
            && !dilates
            && contact.gap > touch
            && carrying.is_carrying(k)
        {
            let by_force = solution.forces[k][0] * mobility(&program, c);
            new.push((pair, (c.offset + by_force) / dt));
        }
    }
    if !new.is_empty() {
        reached.0.extend(new);
        reached.0.sort_unstable_by_key(|(pair, _)| *pair);
        attempt.verdict = Verdict::Again;
    }
}

/// Whether an impact reaches a body, through the contacts that carry.
fn struck(program: &ConeProgram, impacts: &Impacts, carries: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut struck = vec![false; program.bodies.len()];
    let carried: Vec<[usize; 2]> = (0..program.interactions.len())
        .filter(|k| carries(*k))
        .map(|k| [program.interactions[k].a as usize, program.interactions[k].b as usize])
        .collect();
    let ends =
        |k: &usize| [program.interactions[*k].a as usize, program.interactions[*k].b as usize];
    for body in impacts.hit.iter().filter(|k| carries(**k)).flat_map(ends) {
        struck[body] = program.bodies[body].is_free();
    }
    let mut grows = !impacts.hit.is_empty();
    while grows {
        grows = false;
        for [a, b] in &carried {
            for (from, to) in [(*a, *b), (*b, *a)] {
                if struck[from] && !struck[to] && program.bodies[to].is_free() {
                    struck[to] = true;
                    grows = true;
                }
            }
        }
    }
    struck
}

/// Closing of a pair, m, that a unit normal force takes.
fn mobility(program: &ConeProgram, c: &Interaction) -> f64 {
    let of = |body: u32| match &program.bodies[body as usize].dofs[0] {
        Dof::Free(free) if free.inertia > 0.0 => 1.0 / free.inertia,
        _ => 0.0,
    };
    of(c.a) + of(c.b)
}
