//! Assembly of the cone program: balance rows of bodies, interactions, expected magnitudes.

pub mod balance;
pub mod interactions;
pub mod loose;
pub mod scales;
pub mod taut;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::attempt::Attempt;
use clastic_components::contact::{Bodies, ContactHistory, Contacts};
use clastic_components::increment::{Acceptance, Analysis, Progress};
use clastic_components::material::Materials;
use clastic_components::program::ConeProgram;

use crate::schedule::{AttemptIncrement, AttemptSystems, lap};

/// Adds [`assemble_program`].
pub struct AssembleProgramPlugin;

impl Plugin for AssembleProgramPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ConeProgram>()
            .init_resource::<ContactHistory>()
            .init_resource::<Materials>()
            .add_systems(
                AttemptIncrement,
                (
                    assemble_program.in_set(AttemptSystems::Assemble),
                    lap(|t| &mut t.assemble)
                        .after(AttemptSystems::AssembleExtra)
                        .before(AttemptSystems::Solve),
                ),
            );
    }
}

/// Residual that is good enough for a step in which grains settle.
const RESIDUAL_OF_SETTLING: f64 = 1e-3;

/// Fills [`ConeProgram`] from the gathered bodies, the contacts and their history.
pub fn assemble_program(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    history: Res<ContactHistory>,
    materials: Res<Materials>,
    analysis: Res<Analysis>,
    acceptance: Res<Acceptance>,
    progress: Res<Progress>,
    attempt: Res<Attempt>,
    mut program: ResMut<ConeProgram>,
) {
    let program = &mut *program;
    interactions::assemble(
        &bodies,
        &contacts.0,
        &history,
        &materials,
        &analysis,
        &attempt,
        &mut program.interactions,
        &mut program.last_forces,
    );
    taut::assemble(&bodies, &contacts.0, &analysis, &attempt, &mut program.interactions);
    balance::assemble(
        &bodies,
        &analysis,
        &progress,
        &program.interactions,
        &attempt.held,
        &mut program.bodies,
    );
    let count = contacts.0.len();
    program.scales =
        scales::estimate(&bodies, &history, &analysis, &progress, &attempt, count, program);
    let usual = Acceptance::default().residual;
    program.tolerance = match acceptance.residual {
        _ if attempt.settling.is_some() => RESIDUAL_OF_SETTLING,
        looser if looser > usual => looser,
        _ => 0.0,
    };
    loose::regularise(&bodies, &history, &analysis, &acceptance, &attempt, program);
}
