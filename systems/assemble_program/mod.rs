//! Assembly of the cone program: balance rows of bodies, interactions, expected magnitudes.

pub mod balance;
pub mod cell;
pub mod groups;
pub mod interactions;
pub mod known_pairs;
pub mod regularise;
pub mod scales;
pub mod taut;
pub mod turning;
pub mod underconstrained;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use clastic_components::attempt::Attempt;
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::contact_history::DraftHistory;
use clastic_components::findings::{Centre, Corrections, EventSearch, Impacts, Pushed};
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_components::loads::TrialLoads;
use clastic_components::material::Materials;
use clastic_cone::program::ConeProgram;

use crate::impacts::rebounds::{assemble_rebounds, has_restitution};
use crate::links;
use crate::rupture::bonds::lift_strengths;
use crate::schedule::{AttemptIncrement, AttemptSystems, lap};

/// Adds [`assemble_interactions`] and [`balance_bodies`].
pub struct AssembleProgramPlugin;

impl Plugin for AssembleProgramPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ConeProgram>();
        app.init_resource::<Materials>().init_resource::<Impacts>().add_systems(
            AttemptIncrement,
            (
                assemble_interactions.in_set(AttemptSystems::Assemble),
                (
                    balance_bodies,
                    assemble_rebounds.run_if(has_restitution),
                    lap(|t| &mut t.assemble),
                )
                    .chain()
                    .in_set(AttemptSystems::Balance),
            ),
        );
    }
}

/// Tables of the trial.
#[derive(SystemParam)]
pub struct Trial<'w> {
    bodies: Res<'w, BodyTable>,
    contacts: Res<'w, ContactTable>,
    history: Res<'w, DraftHistory>,
    loads: Res<'w, TrialLoads>,
    progress: Res<'w, ClasticProgress>,
    attempt: Res<'w, Attempt>,
}

/// Settings on which the program depends.
#[derive(SystemParam)]
pub struct Settings<'w> {
    materials: Res<'w, Materials>,
    analysis: Res<'w, ClasticAnalysis>,
    acceptance: Res<'w, Acceptance>,
}

/// What the judges have found in earlier attempts.
#[derive(SystemParam)]
pub struct Found<'w> {
    corrections: Res<'w, Corrections>,
    pushed: Res<'w, Pushed>,
    search: Res<'w, EventSearch>,
    centre: Res<'w, Centre>,
}

/// Fills the rest of [`ConeProgram`]: a balance row for every degree of freedom on which an
/// interaction acts, expected magnitudes, and the weights of bodies that nothing holds.
pub fn balance_bodies(
    trial: Trial,
    settings: Settings,
    found: Found,
    mut program: ResMut<ConeProgram>,
) {
    let Trial { bodies, contacts, history, attempt, .. } = &trial;
    balance::assemble(&trial, &settings, &found, &mut program);
    if known_pairs::leave_out(bodies, &contacts.0, &mut program) {
        // The bodies of these contacts may have no other interaction, and then their motion is
        // known.
        balance::assemble(&trial, &settings, &found, &mut program);
    }
    if settings.analysis.kind == AnalysisKind::Static && attempt.motion().is_none() {
        cell::hold_one(bodies, &history.0, &mut program);
    }
    program.scales = scales::estimate(&trial, &settings, &program);
    regularise::regularise(&trial, &settings, &found, &mut program);
}

/// Fills the interactions of [`ConeProgram`]: one per contact, then one per link, then the ties of
/// taut bonds.
pub fn assemble_interactions(
    trial: Trial,
    settings: Settings,
    found: Found,
    mut program: ResMut<ConeProgram>,
) {
    let program = &mut *program;
    let Trial { bodies, progress, .. } = &trial;
    program.cell =
        bodies.cell.map(|cell| cell.in_program(bodies.positions.len(), bodies.mean_radius));
    interactions::assemble(&trial, &settings, &found, program);
    let fraction = progress.fraction;
    links::assemble(bodies, &settings.analysis, fraction, &mut program.interactions);
    taut::assemble(&trial, &settings, &found, program);
    let interactions = &mut program.interactions;
    if found.search.active && trial.attempt.effort().is_some() {
        lift_strengths(&trial.contacts.0, interactions);
    }
    cell::set_images(bodies, interactions);
    turning::carry(&trial, &found, interactions);
    let guess = &found.corrections.guesses.last;
    groups::join(bodies, settings.analysis.kind.theta_of_step(), guess, interactions);
}
