//! The attempts at one increment, and the judges that accept, extend or reject them.
//!
//! Judges run in the order in which [`AttemptPlugin`] adds them, each only if no judge before it
//! has objected; a step of a motion passes only some of them. [`bonds::collect`] then lets the
//! bonds on a limit break, unless a judge has chosen which break.
//! [`findings`](clastic_components::findings) keep what judges find until the increment is
//! committed. Only judges set a verdict, and [`mod@next`] alone maps it to the next action.
//!
//! Attempts work on the tables that were gathered when the increment began. Entities are written
//! only when an attempt is committed, so a failed one changes nothing.

pub mod closed_pairs;
pub mod closing_mechanism;
pub mod converged;
pub mod coulomb;
pub mod loose_grains;
pub mod motion;
pub mod next;
pub mod rest;
mod run;
mod slip;
pub mod through_walls;
pub mod too_far;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::energy::MotionEnergies;
use clastic_components::findings::{
    AddedPairs, Centre, Corrections, EventSearch, Pushed, Reached, Ruptures,
};
use clastic_components::increment::{
    Acceptance, ClasticAnalysis, ClasticProgress, FrictionLaw, RuptureRules,
};
use clastic_cone::program::{ConeSolution, SolveStatus};

pub use self::run::run_attempts;
use crate::ending;
use crate::impacts::rebounds::has_restitution;
use crate::impacts::{push_out, reached};
use crate::motion_settings::MotionSettings;
use crate::rigid_groups::{carry_members, has_groups};
use crate::rupture::{bonds, dense, events};
use crate::schedule::{AttemptIncrement, AttemptSystems, Increment, IncrementSystems};

/// Adds [`run_attempts`] and the judges.
pub struct AttemptPlugin;

impl Plugin for AttemptPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Attempt>()
            .init_resource::<MotionSettings>()
            .init_resource::<AddedPairs>()
            .init_resource::<Ruptures>()
            .init_resource::<Corrections>()
            .init_resource::<ending::Stiffness>()
            .init_resource::<Pushed>()
            .init_resource::<Reached>()
            .init_resource::<Centre>()
            .init_resource::<EventSearch>()
            .init_resource::<MotionEnergies>()
            .init_resource::<Acceptance>()
            .init_resource::<ClasticAnalysis>()
            .init_resource::<FrictionLaw>()
            .init_resource::<RuptureRules>()
            .init_resource::<ClasticProgress>()
            .add_systems(Increment, run_attempts.in_set(IncrementSystems::Attempts))
            .add_systems(
                AttemptIncrement,
                (
                    converged::judge,
                    coulomb::judge.run_if(sound),
                    motion::judge_length.run_if(in_motion),
                    events::judge.run_if(in_equilibrium).run_if(events::searches).run_if(unbiased),
                    closed_pairs::judge.run_if(sound),
                    ending::judge.run_if(in_equilibrium),
                    too_far::judge.run_if(in_equilibrium),
                    // The certificate belongs to the program, in which members of groups have no
                    // motion.
                    carry_members.run_if(has_groups).run_if(impossible),
                    closing_mechanism::judge.run_if(impossible),
                    loose_grains::judge.run_if(impossible),
                    through_walls::judge.run_if(in_motion),
                    rest::judge.run_if(in_motion),
                    push_out::judge.run_if(in_equilibrium),
                    reached::judge.run_if(has_restitution).run_if(in_equilibrium),
                    through_walls::judge.run_if(in_equilibrium),
                    dense::judge.run_if(in_equilibrium).run_if(dense::is_dense),
                    bonds::collect
                        .run_if(in_equilibrium)
                        .run_if(not(events::searches))
                        .run_if(not(dense::is_dense)),
                )
                    .chain()
                    .in_set(AttemptSystems::Judge),
            );
    }
}

/// Run condition: no judge has objected so far.
fn sound(attempt: Res<Attempt>) -> bool {
    attempt.verdict == Verdict::Sound
}

/// Run condition: an equilibrium is sought, and no judge has objected so far.
fn in_equilibrium(attempt: Res<Attempt>) -> bool {
    attempt.verdict == Verdict::Sound && attempt.effort().is_some()
}

/// Run condition: a motion is followed, and no judge has objected so far.
fn in_motion(attempt: Res<Attempt>) -> bool {
    attempt.verdict == Verdict::Sound && attempt.motion().is_some()
}

/// Run condition: the program of an equilibrium, or of a proof, is infeasible.
fn impossible(attempt: Res<Attempt>) -> bool {
    attempt.verdict == Verdict::Impossible && attempt.motion().is_none()
}

/// Run condition: regularisation leaves no error in the solution. `converged` accepts one with such
/// an error where it throws a grain, which `too_far` rejects.
fn unbiased(solution: Res<ConeSolution>) -> bool {
    solution.status == SolveStatus::Solved
}
