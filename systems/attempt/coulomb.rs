//! Judge: does the solution satisfy Coulomb's law?

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::BodyTable;
use clastic_components::findings::Sliding;
use clastic_cone::program::{ConeProgram, ConeSolution};

use crate::places::worst_place;

/// Rejects a solution whose residual under Coulomb's law is above the [bound](Sliding::BOUND). In
/// statics the motion is then followed, and in dynamics the time step is halved.
pub fn judge(
    sliding: Res<Sliding>,
    bodies: Res<BodyTable>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut attempt: ResMut<Attempt>,
) {
    if sliding.lost {
        attempt.verdict = Verdict::TooFar(format!(
            "no solution of Coulomb's law was found: the residual of the best one is {:.1e}{}; the \
             bound is {:.0e}",
            solution.residuals.worst(),
            worst_place(&bodies, &program, &solution),
            Sliding::BOUND
        ));
    }
}
