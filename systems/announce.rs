//! Tells the app which bonds have broken, and which bodies have met if it asks for that, once the
//! increment stays.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;

use crate::identities::IdentityTable;
use crate::state::{RegisterState, StateOf};
use crate::stepping::{AdvanceIncrement, AdvanceSystems};

/// Adds [`announce_ruptures`], and [`announce_collisions`], which costs nothing in an app that has not
/// added the message.
pub struct AnnouncePlugin;

impl Plugin for AnnouncePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<TouchingPairs>().register_state::<TouchingPairs>("touching");
        // Bevy keeps messages until the second update, with `FixedUpdate` that of a whole frame,
        // however many increments were made between them.
        app.add_message::<Rupture>().add_systems(
            AdvanceIncrement,
            (announce_ruptures, announce_collisions.run_if(resource_exists::<Messages<Collision>>))
                .chain()
                .in_set(AdvanceSystems::Announce),
        );
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

/// The pairs that carried a force after the last increment, in ascending order.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TouchingPairs(Vec<(BodyId, BodyId)>);

impl StateOf for TouchingPairs {
    fn take(world: &mut World) -> Option<Self> {
        world.get_resource::<Self>().filter(|pairs| !pairs.0.is_empty()).cloned()
    }

    fn put(self, world: &mut World) {
        world.insert_resource(self);
    }

    fn forget(world: &mut World) {
        world.insert_resource(Self::default());
    }
}

/// Announces the pairs that have begun to carry a force in this increment. A pair with a bond is
/// none of them.
///
/// Each pair is one message [`Collision`], and one event [`BodyHit`] of each of its bodies.
pub fn announce_collisions(
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    history: Res<ContactHistory>,
    progress: Res<ClasticProgress>,
    mut touching: ResMut<TouchingPairs>,
    mut messages: MessageWriter<Collision>,
    mut commands: Commands,
) {
    let mut now = Vec::new();
    for memory in history.0.iter().filter(|memory| memory.p > 0.0) {
        let pair = (memory.a, memory.b);
        if bodies.bonds.binary_search_by_key(&pair, |bond| (bond.a, bond.b)).is_ok() {
            continue;
        }
        let [a, b] = [memory.a, memory.b].map(|row| row as usize);
        let ids = (bodies.ids[a], bodies.ids[b]);
        now.push(ids);
        let contact = contacts.0.binary_search_by_key(&pair, |contact| (contact.a, contact.b));
        if let (Ok(k), Err(_)) = (contact, touching.0.binary_search(&ids)) {
            let collision = Collision {
                increment: progress.increment,
                bodies: [bodies.entities[a], bodies.entities[b]],
                normal: contacts.0[k].normal,
                force: memory.p,
            };
            messages.write(collision);
            let [first, second] = collision.bodies;
            for (body, other) in [(first, second), (second, first)] {
                commands.trigger(BodyHit { body, other, collision });
            }
        }
    }
    // By identity, since rows change when bodies come and go.
    now.sort_unstable();
    touching.0 = now;
}
