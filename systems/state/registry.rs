//! The register of state: how each entry is captured and restored.

use std::sync::Arc;

use bevy_app::App;
use bevy_ecs::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use clastic_components::body::BodyId;
use clastic_components::bond::BondId;

use crate::identities::IdentityTable;

/// Encodes an entry; `None` if the world does not have it.
type Capture = Arc<dyn Fn(&mut World) -> Result<Option<Vec<u8>>, postcard::Error> + Send + Sync>;
type Restore = Arc<dyn Fn(&mut World, &[u8]) -> Result<(), postcard::Error> + Send + Sync>;
/// The contradiction between the world and an entry; `None` if they agree.
type Check = Arc<dyn Fn(&World, &[u8]) -> Result<Option<String>, postcard::Error> + Send + Sync>;
/// Removes an entry from the world.
type Forget = fn(&mut World);

#[derive(Clone)]
pub(super) struct Entry {
    pub(super) name: &'static str,
    /// Whether the entry is of components. These are restored first, so that other state can refer
    /// to all bodies and bonds.
    is_component: bool,
    pub(super) capture: Capture,
    pub(super) check: Check,
    pub(super) restore: Restore,
    pub(super) forget: Forget,
}

/// Registered entries: components, then the others, each in the order of registration.
#[derive(Resource, Default)]
pub(crate) struct StateRegistry {
    entries: Vec<Entry>,
}

/// State that is not stored as a resource or component. `take` reads it from a world, and `put`
/// restores it.
pub trait StateOf: Serialize + DeserializeOwned {
    /// Reads the state; `None` if the world does not have it.
    fn take(world: &mut World) -> Option<Self>;
    /// Checks that the settings of the world suit the state, before anything is restored.
    ///
    /// # Errors
    /// What differs, and what to do.
    fn check(&self, _world: &World) -> Result<(), String> {
        Ok(())
    }

    /// Restores the state in a world that contains all bodies and bonds.
    fn put(self, world: &mut World);

    /// Removes the state, for a world that goes back to a time at which it had none.
    fn forget(_world: &mut World) {}
}

/// An identity that names entities in a state.
pub trait Identity: Component + Copy + Ord + Serialize + DeserializeOwned {
    /// The entity that has this identity.
    fn entity(self, identities: &IdentityTable) -> Option<Entity>;
}

impl Identity for BodyId {
    fn entity(self, identities: &IdentityTable) -> Option<Entity> {
        identities.body(self)
    }
}

impl Identity for BondId {
    fn entity(self, identities: &IdentityTable) -> Option<Entity> {
        identities.bond(self)
    }
}

/// Registers state that a [`WorldState`](super::WorldState) contains.
///
/// Checkpoints use these names. They have the form `plugin.what`, so that names of different
/// plugins differ.
///
/// # Panics
/// If the name is registered already.
pub trait RegisterState {
    /// The app whose state is registered.
    fn app(&mut self) -> &mut App;

    /// Registers a resource.
    fn register_resource<T: Resource + Serialize + DeserializeOwned>(
        &mut self,
        name: &'static str,
    ) -> &mut Self {
        let entry = Entry {
            name,
            is_component: false,
            capture: Arc::new(|world| {
                world.get_resource::<T>().map(postcard::to_stdvec).transpose()
            }),
            check: Arc::new(|_, _| Ok(None)),
            restore: Arc::new(|world, bytes| {
                world.insert_resource(postcard::from_bytes::<T>(bytes)?);
                Ok(())
            }),
            forget: |world| {
                world.remove_resource::<T>();
            },
        };
        register(self.app(), entry);
        self
    }

    /// Registers a component of bodies ([`BodyId`]) or bonds ([`BondId`]). Restoring creates
    /// entities for identities that do not exist yet.
    fn register_component<I: Identity, T: Component + Clone + Serialize + DeserializeOwned>(
        &mut self,
        name: &'static str,
    ) -> &mut Self {
        let entry = Entry {
            name,
            is_component: true,
            capture: Arc::new(capture_component::<I, T>),
            check: Arc::new(|_, _| Ok(None)),
            restore: Arc::new(restore_component::<I, T>),
            forget: |world| keep_components::<I, T>(world, &[]),
        };
        register(self.app(), entry);
        self
    }

    /// Registers a part of the world that `take` reads (`None` if the world does not have it) and
    /// `put` restores.
    fn register_part<T: Serialize + DeserializeOwned + 'static>(
        &mut self,
        name: &'static str,
        take: fn(&mut World) -> Option<T>,
        put: fn(T, &mut World),
    ) -> &mut Self {
        register(self.app(), part(name, take, |_, _| Ok(()), put, |_| {}));
        self
    }

    /// Registers any other state.
    fn register_state<S: StateOf + 'static>(&mut self, name: &'static str) -> &mut Self {
        register(self.app(), part(name, S::take, S::check, S::put, S::forget));
        self
    }
}

impl RegisterState for App {
    fn app(&mut self) -> &mut App {
        self
    }
}

fn part<T: Serialize + DeserializeOwned + 'static>(
    name: &'static str,
    take: fn(&mut World) -> Option<T>,
    check: fn(&T, &World) -> Result<(), String>,
    put: fn(T, &mut World),
    forget: Forget,
) -> Entry {
    Entry {
        name,
        is_component: false,
        capture: Arc::new(move |world| take(world).as_ref().map(postcard::to_stdvec).transpose()),
        check: Arc::new(move |world, bytes| Ok(check(&postcard::from_bytes(bytes)?, world).err())),
        restore: Arc::new(move |world, bytes| {
            put(postcard::from_bytes(bytes)?, world);
            Ok(())
        }),
        forget,
    }
}

fn register(app: &mut App, entry: Entry) {
    let mut registry = app.world_mut().get_resource_or_init::<StateRegistry>();
    let name = entry.name;
    let is_new = registry.entries.iter().all(|known| known.name != name);
    assert!(is_new, "state `{name}` is registered twice: give each a name of its own");
    registry.entries.push(entry);
    // A stable sort: entries of one kind stay in the order of registration.
    registry.entries.sort_by_key(|entry| !entry.is_component);
}

fn capture_component<I: Identity, T: Component + Clone + Serialize>(
    world: &mut World,
) -> Result<Option<Vec<u8>>, postcard::Error> {
    let mut rows: Vec<(I, &T)> =
        world.query::<(&I, &T)>().iter(world).map(|(id, value)| (*id, value)).collect();
    if rows.is_empty() {
        return Ok(None);
    }
    rows.sort_unstable_by_key(|(id, _)| *id);
    postcard::to_stdvec(&rows).map(Some)
}

fn restore_component<I: Identity, T: Component + DeserializeOwned>(
    world: &mut World,
    bytes: &[u8],
) -> Result<(), postcard::Error> {
    let rows = postcard::from_bytes::<Vec<(I, T)>>(bytes)?;
    let ids: Vec<I> = rows.iter().map(|(id, _)| *id).collect();
    keep_components::<I, T>(world, &ids);
    for (id, value) in rows {
        let known = id.entity(&world.get_resource_or_init::<IdentityTable>());
        let entity = known.unwrap_or_else(|| world.spawn(id).id());
        world.entity_mut(entity).insert(value);
    }
    Ok(())
}

/// Removes the component from all entities but those with these identities, which are sorted.
fn keep_components<I: Identity, T: Component>(world: &mut World, ids: &[I]) {
    let mut all = world.query_filtered::<(Entity, &I), With<T>>();
    let others = all.iter(world).filter(|(_, id)| ids.binary_search(id).is_err());
    let others: Vec<Entity> = others.map(|(entity, _)| entity).collect();
    for entity in others {
        world.entity_mut(entity).remove::<T>();
    }
}

/// The registered entries of a world.
pub(super) fn registered(world: &mut World) -> Vec<Entry> {
    world.get_resource_or_init::<StateRegistry>().entries.clone()
}
