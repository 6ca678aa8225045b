//! Tells an app that asks for it which bodies have met, once the increment stays.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::body::BodyId;
use clastic_components::collision::{BodyHit, Collision};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::contact_history::ContactHistory;
use clastic_components::increment::ClasticProgress;

use crate::stepping::{AdvanceIncrement, AdvanceSystems};

/// Adds [`announce_collisions`]. It costs nothing in an app that has not added the message.
pub struct AnnounceCollisionsPlugin;

impl Plugin for AnnounceCollisionsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            AdvanceIncrement,
            announce_collisions
                .run_if(resource_exists::<Messages<Collision>>)
                .in_set(AdvanceSystems::Announce),
        );
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
    mut touching: Local<Vec<(BodyId, BodyId)>>,
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
        if let (Ok(k), Err(_)) = (contact, touching.binary_search(&ids)) {
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
    *touching = now;
}
