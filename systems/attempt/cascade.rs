//! Judge: breaks the bonds that reached a limit. With `AllAtOnce` the increment is solved again
//! without them until no other bond breaks.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::findings::{Corrections, Ruptures};
use clastic_components::increment::{Progress, RuptureOrder, RuptureRules};
use clastic_cone::program::{ConeProgram, ConeSolution};

use crate::rupture_bonds::{Met, find_ruptures};

/// Collects the ruptures of a converged attempt and requests another one if any are new.
pub fn judge(
    rules: Res<RuptureRules>,
    progress: Res<Progress>,
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut ruptures: ResMut<Ruptures>,
    mut corrections: ResMut<Corrections>,
    mut attempt: ResMut<Attempt>,
) {
    let mut found = find_ruptures(
        &rules,
        Met::Slack,
        progress.increment,
        &bodies,
        &contacts.0,
        &program,
        &solution,
    );
    found.retain(|r| !ruptures.has(r.bond));
    if found.is_empty() {
        return;
    }
    ruptures.list.extend(found);
    if rules.order != RuptureOrder::AllAtOnce {
        return;
    }
    if ruptures.rounds >= rules.rounds {
        // Bonds that reach their limits in the last round break without another solve.
        ruptures.capped = true;
    } else {
        ruptures.rounds += 1;
        ruptures.capped = false;
        corrections.passes = 0;
        attempt.verdict = Verdict::Again;
    }
}
