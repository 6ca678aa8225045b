//! Assembly of the cone program: balance rows of bodies, interactions, expected magnitudes.

pub mod balance;
pub mod cell;
pub mod groups;
pub mod hits;
pub mod interactions;
pub mod known_pairs;
pub mod rebounds;
pub mod regularise;
pub mod scales;
pub mod taut;
pub mod turning;
pub mod underconstrained;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::attempt::Attempt;
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::contact_history::DraftHistory;
use clastic_components::findings::{
    Centre, Corrections, EventSearch, Impacts, Pushed, Restraints, Ruptures,
};
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind, Progress};
use clastic_components::loads::TrialLoads;
use clastic_components::material::Materials;
use clastic_components::release::Release;
use clastic_cone::program::ConeProgram;

use self::interactions::Findings;
use self::rebounds::{assemble_rebounds, has_restitution};
use crate::gradual_release::add_loads;
use crate::rupture_bonds::lift_strengths;
use crate::schedule::{AttemptIncrement, AttemptSystems, lap};

/// Adds [`assemble_program`].
pub struct AssembleProgramPlugin;

impl Plugin for AssembleProgramPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ConeProgram>();
        app.init_resource::<Materials>().init_resource::<Impacts>().add_systems(
            AttemptIncrement,
            (
                (assemble_program, assemble_rebounds.run_if(has_restitution))
                    .chain()
                    .in_set(AttemptSystems::Assemble),
                lap(|t| &mut t.assemble)
                    .after(AttemptSystems::AssembleExtra)
                    .before(AttemptSystems::Solve),
            ),
        );
    }
}

/// Residual at which the solver may stop in a step of a motion. Only the equilibrium after the
/// motion is committed.
const RESIDUAL_OF_MOTION: f64 = 1e-3;

/// Residual at which the solver may stop; 0 means its own default. Loading of bonds to their limits
/// requires the default, because errors could change which bond breaks.
fn tolerance(
    analysis: &Analysis,
    acceptance: &Acceptance,
    attempt: &Attempt,
    bodies: &Bodies,
) -> f64 {
    let is_dynamic = matches!(analysis.kind, AnalysisKind::Dynamic { .. });
    // Solvers aim at this residual by default.
    let usual = Acceptance::default().residual;
    if attempt.motion().is_some() {
        RESIDUAL_OF_MOTION
    } else if is_dynamic && bodies.bonds.is_empty() && acceptance.residual > usual {
        acceptance.residual
    } else {
        0.0
    }
}

/// Fills [`ConeProgram`] from the gathered bodies, the contacts and their history.
pub fn assemble_program(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    history: Res<DraftHistory>,
    materials: Res<Materials>,
    analysis: Res<Analysis>,
    acceptance: Res<Acceptance>,
    progress: Res<Progress>,
    attempt: Res<Attempt>,
    changes: (Res<Ruptures>, Res<Corrections>, Res<Pushed>),
    events: (Res<EventSearch>, Res<Release>),
    restraints: Res<Restraints>,
    centre: Res<Centre>,
    loads: Res<TrialLoads>,
    mut program: ResMut<ConeProgram>,
) {
    let program = &mut *program;
    let history = &history.0;
    let (ruptures, corrections, pushed) = &changes;
    let (search, release) = &events;
    let findings = Findings { ruptures, corrections, pushed };
    let row = bodies.positions.len();
    program.cell = bodies.cell.map(|cell| cell.in_program(row, bodies.mean_radius));
    interactions::assemble(
        &bodies,
        &contacts.0,
        history,
        &materials,
        &analysis,
        findings,
        &mut program.interactions,
        &mut program.last_forces,
    );
    taut::assemble(&bodies, &contacts.0, &analysis, &restraints, &mut program.interactions);
    if search.active && attempt.effort().is_some() {
        lift_strengths(&contacts.0, &mut program.interactions);
    }
    cell::set_images(&bodies, &mut program.interactions);
    turning::carry(&bodies, &contacts.0, corrections, progress.fraction, &mut program.interactions);
    groups::join(&bodies, &mut program.interactions);
    let balance = |program: &mut ConeProgram| {
        balance::assemble(
            &bodies,
            &analysis,
            &progress,
            &program.interactions,
            &loads,
            &mut program.bodies,
        );
    };
    balance(program);
    if known_pairs::leave_out(&bodies, &contacts.0, program) {
        // The bodies of these contacts may have no other interaction, and then their motion is
        // known.
        balance(program);
    }
    add_loads(&bodies, release, search.kept, program);
    if analysis.kind == AnalysisKind::Static && attempt.motion().is_none() {
        cell::hold_one(&bodies, history, program);
    }
    let count = contacts.0.len();
    program.scales = scales::estimate(
        &bodies,
        history,
        &analysis,
        &progress,
        attempt.magnitudes,
        count,
        program,
    );
    program.tolerance = tolerance(&analysis, &acceptance, &attempt, &bodies);
    let mode = &attempt.mode;
    regularise::regularise(
        &bodies,
        &contacts.0,
        history,
        &analysis,
        &acceptance,
        mode,
        &restraints,
        &centre,
        program,
    );
}
