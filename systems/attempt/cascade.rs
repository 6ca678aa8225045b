//! Judge: with `cascade`, bonds that reached a limit break within the increment, and it is solved
//! again without them until no more break.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::increment::{Progress, RuptureRules};
use clastic_components::program::{ConeProgram, ConeSolution};

use crate::rupture_bonds::find_ruptures;

/// Collects the ruptures of a converged attempt and asks for another one if there are new ones.
pub fn judge(
    rules: Res<RuptureRules>,
    progress: Res<Progress>,
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut attempt: ResMut<Attempt>,
) {
    if attempt.settling.is_some() {
        return;
    }
    let broken: Vec<_> = attempt.ruptures.iter().map(|r| r.bond).collect();
    let mut found =
        find_ruptures(&rules, progress.increment, &bodies, &contacts.0, &program, &solution);
    found.retain(|r| !broken.contains(&r.bond));
    if found.is_empty() {
        return;
    }
    attempt.ruptures.extend(found);
    let Some(cap) = rules.cascade else { return };
    if attempt.cascade_rounds >= cap {
        // What reached its limit in the last round breaks without another solve.
        attempt.capped = true;
    } else {
        attempt.cascade_rounds += 1;
        attempt.capped = false;
        attempt.openings.clear();
        attempt.coulomb_passes = 0;
        attempt.corrector_passes = 0;
        attempt.verdict = Verdict::Again;
    }
}
