//! Commits an accepted attempt: moves bodies, updates velocities and contact history, and records
//! the external forces.

mod external_forces;
mod move_bodies;
mod remember_contacts;

use crate::schedule::{Increment, IncrementSystems, lap};
use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use clastic_components::prelude::*;

use crate::assemble_program::regularise::loaded_pairs;
use crate::measures::fragments::fragments;

pub use self::external_forces::external_forces;
pub use self::move_bodies::move_bodies;
pub use self::remember_contacts::{remember_contacts, remembered};

/// Adds the systems of the update.
pub struct UpdateStatePlugin;

impl Plugin for UpdateStatePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Increment,
            (
                external_forces,
                move_bodies,
                remember_contacts,
                remember_set_aside,
                advance_progress,
                lap(|t| &mut t.update),
            )
                .chain()
                .in_set(IncrementSystems::Update),
        );
    }
}

/// Marks particles that the attempts have [`SetAside`], and takes the mark from those on which a
/// force acts again, or all in a dynamic increment.
pub fn remember_set_aside(
    bodies: Res<BodyTable>,
    analysis: Res<ClasticAnalysis>,
    history: Res<ContactHistory>,
    mut commands: Commands,
) {
    if !bodies.set_aside.contains(&true) {
        return;
    }
    // A force from outside acts on the fragment of the particle.
    let fragments = fragments(&bodies);
    let mut touched = vec![false; bodies.particles];
    for (a, b) in loaded_pairs(history.sizes(bodies.mean_radius)) {
        let (a, b) = (fragments[a as usize], fragments.get(b as usize));
        if b != Some(&a) {
            touched[a as usize] = true;
            b.into_iter().for_each(|b| touched[*b as usize] = true);
        }
    }
    for i in (0..bodies.particles).filter(|i| bodies.set_aside[*i]) {
        let mut particle = commands.entity(bodies.entities[i]);
        if analysis.kind == AnalysisKind::Static && !touched[fragments[i] as usize] {
            particle.insert(SetAside);
        } else {
            particle.remove::<SetAside>();
        }
    }
}

/// Adds the committed fraction of the increment to the progress.
pub fn advance_progress(
    analysis: Res<ClasticAnalysis>,
    rules: Res<RuptureRules>,
    search: Res<EventSearch>,
    ruptures: Res<Ruptures>,
    mut progress: ResMut<ClasticProgress>,
) {
    // A released motion ends at rest without the bonds that broke in it.
    let is_settled = match (rules.order, rules.avalanche) {
        (RuptureOrder::Events, Avalanche::Dynamic) => ruptures.on_the_way,
        _ => 0,
    };
    progress.relaxing = search.settles || search.active && ruptures.list.len() > is_settled;
    let fraction = progress.fraction;
    progress.done += fraction;
    if (progress.done - progress.done.round()).abs() < 1e-9 {
        progress.done = progress.done.round();
    }
    if let AnalysisKind::Dynamic { dt, .. } = analysis.kind {
        progress.time += dt * fraction;
    }
}
