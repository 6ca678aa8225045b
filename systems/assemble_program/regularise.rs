//! Regularisation of bodies without stiffness.
//!
//! The displacement of an [underconstrained](super::underconstrained) static body (a rattler, a
//! cluster that nothing holds) is not determined. It gets a proximal term, which selects the
//! smallest displacement. The weight is the fraction [`Acceptance::regularisation`] of force scale
//! over displacement scale, so that its force on a body that is pushed after all stays far below
//! the tolerance. The residuals count this force as an error of the balance.

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Dof};

use super::Trial;
use super::underconstrained::find_underconstrained;

/// First weight in a repeated attempt. It applies to every body, and its centre follows the
/// solution until no force of the regularisation remains in the balance. The weight decreases by
/// this factor with every move of the centre, so that a motion without bound becomes visible.
const WEIGHT_OF_RETRY: f64 = 1e-6;
const FALL: f64 = 0.1;

/// Maximum number of moves of the centre in an attempt: with the last one the weight has fallen to
/// that of the first attempt.
pub(crate) fn max_moves(acceptance: &Acceptance) -> u32 {
    // A weight at round-off acts no longer.
    let last = acceptance.regularisation.max(f64::EPSILON);
    (last / WEIGHT_OF_RETRY).log(FALL).round().max(1.0) as u32
}

/// Sets the proximal weights of the program.
pub(super) fn regularise(trial: &Trial, program: &mut ConeProgram) {
    let Trial { bodies, attempt, centre, .. } = trial;
    let history = &trial.history.0;
    let least = trial.acceptance.regularisation;
    if trial.analysis.kind != AnalysisKind::Static {
        return;
    }
    if let Mode::Motion(motion) = &attempt.mode {
        return give_inertia(motion, program);
    }
    let retry = attempt.effort() == Some(Effort::Regularised);
    let mut regularised = if retry {
        vec![true; program.bodies.len()]
    } else {
        find_underconstrained(trial, program)
    };
    // Counting misses mechanisms whose constraints are in the wrong places. Bodies without load in
    // the last increment, or in a rejected solution of this one, may be part of a mechanism.
    let bearing = |i: usize| attempt.bearing.get(i).copied().unwrap_or_default();
    if !history.0.is_empty() {
        let sizes = history.sizes(bodies.mean_radius);
        for (i, loaded) in find_loaded(bodies.particles, sizes).into_iter().enumerate() {
            regularised[i] |= !loaded && bearing(i) != Bearing::Load;
        }
        // A group without load on any member is such a body.
        for group in &bodies.groups {
            regularised[group.body as usize] |=
                group.members.iter().all(|i| regularised[*i as usize]);
        }
    }
    let takes_part = |i: usize| regularised[i] || bearing(i) == Bearing::Nothing;
    let unit = program.scales.force / program.scales.displacement;
    let part = if retry { WEIGHT_OF_RETRY * FALL.powf(f64::from(centre.moves)) } else { least };
    let weight = unit * part.max(least);
    let length = program.scales.length;
    for (i, body) in program.bodies.iter_mut().enumerate().filter(|(i, _)| takes_part(*i)) {
        for (k, dof) in body.dofs.iter_mut().enumerate() {
            // An inertia in statics is a stiffness, which determines the displacement.
            if let Dof::Free(free) = dof
                && free.inertia == 0.0
            {
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
pub(crate) const MIN_LOAD: f64 = 1e-6;

/// The pairs of bodies with more than `MIN_LOAD` of the maximum force. `forces` are in N.
pub(crate) fn loaded_pairs(
    forces: impl Iterator<Item = (u32, u32, f64)> + Clone,
) -> impl Iterator<Item = (u32, u32)> {
    let threshold = MIN_LOAD * forces.clone().map(|f| f.2).fold(0.0, f64::max);
    forces.filter(move |f| f.2 > threshold).map(|(a, b, _)| (a, b))
}

/// Whether each particle is in one of these pairs.
pub(crate) fn find_loaded(
    particles: usize,
    forces: impl Iterator<Item = (u32, u32, f64)> + Clone,
) -> Vec<bool> {
    let mut loaded = vec![false; particles];
    for (a, b) in loaded_pairs(forces) {
        for body in [a as usize, b as usize].into_iter().filter(|b| *b < particles) {
            loaded[body] = true;
        }
    }
    loaded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_moves_until_the_weight_is_the_usual_one() {
        let with = |regularisation| Acceptance { regularisation, ..Acceptance::default() };
        assert_eq!(max_moves(&with(1e-9)), 3);
        assert_eq!(max_moves(&with(1e-6)), 1);
        // A weight of zero is never reached.
        assert!(max_moves(&with(0.0)) <= 16);
    }
}
