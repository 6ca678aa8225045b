//! Judge: Coulomb's law as a fixed point of the associated one.
//!
//! The associated law opens a sliding contact by `mu |d_t^slip|` and a rolling one by
//! `mu_r r |d_r|` (equation 34 of the paper). Adding that opening to the gap takes it out:
//! `g <- g_0 + mu |d_t^slip| + mu_r r |d_r|` on unbonded contacts, until it no longer changes
//! (De Saxce; Acary and others 2011).

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::Contacts;
use clastic_components::increment::FrictionLaw;
use clastic_components::program::{ConeProgram, ConeSolution};

use crate::solve_program::residuals::{displacement_scale, multipliers};

/// Asks for another pass until the openings stand still or the cap is reached.
pub fn judge(
    law: Res<FrictionLaw>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut attempt: ResMut<Attempt>,
) {
    let FrictionLaw::Coulomb { tolerance, max_passes } = *law else { return };
    if attempt.settling.is_some() {
        return;
    }
    let mut openings = Vec::new();
    let mut change = 0.0_f64;
    for ((c, f), contact) in program.interactions.iter().zip(&solution.forces).zip(&contacts.0) {
        if c.limits.tension > 0.0 || c.limits.cohesion > 0.0 {
            continue;
        }
        let m = multipliers(c, &program.kinematics(c, &solution.displacements), f);
        // Open contacts too: the associated law holds a grain that passes at a distance below its
        // opening, Coulomb's does not.
        let opening = c.limits.friction * m.slip.abs() + c.limits.rolling * m.rotation.abs();
        let key = (contact.a, contact.b);
        let before = attempt
            .openings
            .binary_search_by_key(&key, |o| o.0)
            .map_or(0.0, |k| attempt.openings[k].1);
        change = change.max((opening - before).abs());
        if opening > 0.0 {
            openings.push((key, opening));
        }
    }
    attempt.coulomb_residual = change / displacement_scale(&program, &solution.displacements);
    if attempt.coulomb_residual <= tolerance {
        return;
    }
    if attempt.coulomb_passes >= max_passes {
        attempt.capped = true;
        return;
    }
    attempt.coulomb_passes += 1;
    attempt.openings = openings;
    attempt.verdict = Verdict::Again;
}
