//! Judge: Coulomb's law as a fixed point of the associated one.
//!
//! The associated law opens a sliding contact by `mu |d_t^slip|` and a rolling one by
//! `mu_r r |d_r|` (equation 34 of the paper). Adding that opening to the gap takes it out:
//! `g <- g_0 + mu |d_t^slip| + mu_r r |d_r|` on unbonded contacts, until it no longer changes
//! (De Saxce; Acary and others 2011).

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::Contacts;
use clastic_components::findings::Openings;
use clastic_components::increment::FrictionLaw;
use clastic_components::program::{ConeProgram, ConeSolution};

use crate::solve_program::residuals::{displacement_scale, multipliers};

/// Bounds of the weight of a pass.
const LEAST_WEIGHT: f64 = 0.05;
const GREATEST_WEIGHT: f64 = 4.0;

/// Asks for another pass until the openings stand still or the cap is reached.
pub fn judge(
    law: Res<FrictionLaw>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut state: ResMut<Openings>,
    mut attempt: ResMut<Attempt>,
) {
    let FrictionLaw::Coulomb { tolerance, max_passes } = *law else { return };
    let (mut openings, mut changes) = (Vec::new(), Vec::new());
    let mut change = 0.0_f64;
    let find = |list: &[((u32, u32), f64)], key| {
        list.binary_search_by_key(&key, |o| o.0).map_or(0.0, |k| list[k].1)
    };
    for ((c, f), contact) in program.interactions.iter().zip(&solution.forces).zip(&contacts.0) {
        if c.limits.has_strength() {
            continue;
        }
        let m = multipliers(c, &program.kinematics(c, &solution.displacements), f);
        // Open contacts too: the associated law holds a grain that passes at a distance below its
        // opening, Coulomb's does not.
        let opening = c.limits.friction * m.slip.abs() + c.limits.rolling * m.rotation.abs();
        let key = (contact.a, contact.b);
        let before = state.of(key);
        change = change.max((opening - before).abs());
        if opening > 0.0 || before > 0.0 {
            openings.push((key, before));
            changes.push((key, opening - before));
        }
    }
    state.residual = change / displacement_scale(&program, &solution.displacements);
    if state.residual <= tolerance {
        return;
    }
    if state.passes >= max_passes {
        state.capped = true;
        return;
    }
    // Aitken's weight: below one where passes oscillate, above where they creep.
    let (mut along, mut square) = (0.0, 0.0);
    for (key, new) in &changes {
        let old = find(&state.changes, *key);
        along += old * (new - old);
        square += (new - old) * (new - old);
    }
    let weight = if state.passes > 0 && square > 0.0 {
        (-state.weight * along / square).clamp(LEAST_WEIGHT, GREATEST_WEIGHT)
    } else {
        1.0
    };
    for (opening, (_, change)) in openings.iter_mut().zip(&changes) {
        opening.1 = (opening.1 + weight * change).max(0.0);
    }
    state.weight = weight;
    state.changes = changes;
    state.passes += 1;
    state.list = openings;
    attempt.verdict = Verdict::Again;
}
