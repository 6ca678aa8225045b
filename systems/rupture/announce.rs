//! Tells the app which bonds have broken, once the increment stays.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::bond::{BondBroken, Rupture};
use clastic_components::observation::Observation;

use crate::identities::IdentityTable;
use crate::stepping::{AdvanceIncrement, AdvanceSystems};

/// Adds [`announce_ruptures`].
pub struct AnnounceRupturesPlugin;

impl Plugin for AnnounceRupturesPlugin {
    fn build(&self, app: &mut App) {
        // Bevy keeps messages until the second update, with `FixedUpdate` that of a whole frame,
        // however many increments were made between them.
        app.add_message::<Rupture>()
            .add_systems(AdvanceIncrement, announce_ruptures.in_set(AdvanceSystems::Announce));
    }
}

/// Writes a [`Rupture`] message and triggers [`BondBroken`] for every rupture of the increment.
pub fn announce_ruptures(
    record: Res<Observation>,
    identities: Res<IdentityTable>,
    mut messages: MessageWriter<Rupture>,
    mut commands: Commands,
) {
    for rupture in &record.ruptures {
        messages.write(*rupture);
        let entities = [rupture.a, rupture.b].map(|id| identities.body(id));
        if let (Some(bond), [Some(a), Some(b)]) = (identities.bond(rupture.bond), entities) {
            commands.trigger(BondBroken { bond, bodies: [a, b], rupture: *rupture });
        }
    }
}
