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

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, ProgramCell};

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

/// What the program follows from: the tables of the trial, settings, and what the judges have found
/// in earlier attempts.
#[derive(SystemParam)]
pub struct Trial<'w> {
    bodies: Res<'w, BodyTable>,
    contacts: Res<'w, ContactTable>,
    history: Res<'w, DraftHistory>,
    loads: Res<'w, TrialLoads>,
    progress: Res<'w, ClasticProgress>,
    attempt: Res<'w, Attempt>,
    materials: Res<'w, Materials>,
    analysis: Res<'w, ClasticAnalysis>,
    acceptance: Res<'w, Acceptance>,
    corrections: Res<'w, Corrections>,
    pushed: Res<'w, Pushed>,
    search: Res<'w, EventSearch>,
    centre: Res<'w, Centre>,
}

/// Fills the rest of [`ConeProgram`]: a balance row for every degree of freedom on which an
/// interaction acts, expected magnitudes, and the weights of bodies that nothing holds.
pub fn balance_bodies(trial: Trial, mut program: ResMut<ConeProgram>) {
    let Trial { bodies, contacts, history, attempt, analysis, .. } = &trial;
    balance::assemble(&trial, &mut program);
    if known_pairs::leave_out(bodies, &contacts.0, &mut program) {
        // The bodies of these contacts may have no other interaction, and then their motion is
        // known.
        balance::assemble(&trial, &mut program);
    }
    if analysis.kind == AnalysisKind::Static && attempt.motion().is_none() {
        cell::hold_one(bodies, &history.0, &mut program);
    }
    program.scales = scales::estimate(&trial, &program);
    regularise::regularise(&trial, &mut program);
}

/// Fills the interactions of [`ConeProgram`]: one per contact, then one per link, then the ties of
/// taut bonds.
pub fn assemble_interactions(trial: Trial, mut program: ResMut<ConeProgram>) {
    let program = &mut *program;
    let Trial { bodies, contacts, progress, attempt, analysis, corrections, search, .. } = &trial;
    let (row, arm) = (bodies.positions.len() as u32, bodies.mean_radius);
    program.cell = bodies.cell.map(|_| ProgramCell { body: row, arm });
    interactions::assemble(&trial, program);
    links::assemble(bodies, analysis, progress.fraction, &mut program.interactions);
    taut::assemble(&trial, program);
    let interactions = &mut program.interactions;
    if search.active && attempt.effort().is_some() {
        lift_strengths(&contacts.0, interactions);
    }
    cell::set_images(bodies, interactions);
    turning::carry(&trial, interactions);
    let guess = &corrections.guesses.last;
    groups::join(bodies, analysis.kind.theta_of_step(), guess, interactions);
}
