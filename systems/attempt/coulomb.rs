//! Judge: does the solution satisfy Coulomb's law?

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::findings::Sliding;
use clastic_components::increment::Acceptance;

use crate::places::worst_place;
use crate::solved::SolvedTables;

/// Rejects a solution whose residual under Coulomb's law is above the [bound](Sliding::bound). In
/// statics the motion is then followed, and in dynamics the time step is halved.
pub fn judge(
    sliding: Res<Sliding>,
    acceptance: Res<Acceptance>,
    tables: SolvedTables,
    mut attempt: ResMut<Attempt>,
) {
    if sliding.lost {
        let solved = tables.get();
        attempt.verdict = Verdict::TooFar(format!(
            "no solution of Coulomb's law was found: the residual of the best one is {:.1e}{}; the \
             bound is {:.0e}",
            solved.solution.residuals.worst(),
            worst_place(solved),
            Sliding::bound(&acceptance)
        ));
    }
}
