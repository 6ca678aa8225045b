//! State that persists from one increment to the next. The plugin that owns it registers it.
//!
//! A [`WorldState`] contains all registered state as bytes under names, so that the state of
//! plugins of an embedding program is stored and restored as well. It contains no `Entity`: bodies
//! and bonds appear by identity. Tables that every increment rebuilds (contacts, program, solution)
//! are not state. Settings are not state either.
//!
//! ```
//! use bevy_app::App;
//! use bevy_ecs::prelude::*;
//! use clastic_systems::state::{RegisterState, WorldState};
//! use serde::{Deserialize, Serialize};
//!
//! #[derive(Resource, Serialize, Deserialize)]
//! struct Temperature(f64);
//!
//! let mut app = App::new();
//! app.register_resource::<Temperature>("my_plugin.temperature");
//! app.insert_resource(Temperature(291.0));
//! let state = WorldState::capture(app.world_mut())?;
//!
//! let mut other = App::new();
//! other.register_resource::<Temperature>("my_plugin.temperature");
//! state.restore(other.world_mut())?;
//! assert_eq!(other.world().resource::<Temperature>().0, 291.0);
//! # Ok::<(), clastic_systems::state::StateError>(())
//! ```

mod registry;

use bevy_ecs::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use clastic_components::body::BodyId;
use clastic_components::bond::BondId;

use crate::identities::{NEXT_IDENTITIES, go_back};

use registry::{Entry, registered};
pub use registry::{Identity, RegisterState, StateOf};

/// Why a state cannot be captured or restored.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StateError {
    /// No plugin has registered this entry of the state.
    #[error(
        "the state has an entry `{0}`, which no plugin of this program registers; add the plugin that \
         the run was made with"
    )]
    Unknown(String),
    /// An entry cannot be encoded or decoded.
    #[error("entry `{name}` of the state: {what}")]
    Encoding {
        /// The entry.
        name: String,
        /// What is wrong with it.
        what: String,
    },
    /// The state has no such entry.
    #[error("the state has no entry `{0}`")]
    Missing(String),
    /// The world has bodies or bonds, with which those of the state would be mixed.
    #[error(
        "the world is not empty (bodies: {bodies}, bonds: {bonds}); restore the state in a new \
         world, or `rewind` the world from which it was captured"
    )]
    Occupied {
        /// Number of its bodies.
        bodies: usize,
        /// Number of its bonds.
        bonds: usize,
    },
    /// The settings of the world contradict an entry.
    #[error("entry `{name}` of the state: {what}")]
    Unsuitable {
        /// The entry.
        name: String,
        /// What differs, and what to do.
        what: String,
    },
}

/// The state of a world between two increments.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorldState {
    entries: Vec<(String, Vec<u8>)>,
}

impl WorldState {
    /// The state of a world in which no increment is under way.
    ///
    /// # Errors
    /// If an entry cannot be encoded.
    pub fn capture(world: &mut World) -> Result<Self, StateError> {
        let mut entries = Vec::new();
        for Entry { name, capture, .. } in registered(world) {
            if let Some(bytes) = capture(world).map_err(|error| encoding(name, &error))? {
                entries.push((name.to_owned(), bytes));
            }
        }
        Ok(Self { entries })
    }

    /// Restores the state in a world without bodies and bonds. Its plugins and the names of its
    /// materials must be those of the captured world. Other settings, as the laws of the materials,
    /// may differ. Systems in `Startup` run at the first update, after this call: they must not
    /// spawn the specimen once more.
    ///
    /// # Errors
    /// If the world has bodies or bonds, if an entry is not registered or contradicts the settings
    /// of the world: the world is then unchanged. If an entry cannot be decoded: the world must
    /// then not be used.
    pub fn restore(&self, world: &mut World) -> Result<(), StateError> {
        expect_empty(world)?;
        self.check(world)?;
        self.put(world)
    }

    /// Restores the state in the world that was captured, whatever has happened there since: bodies
    /// and bonds that have come since then go, those that have gone come back, as other entities,
    /// and so do components and resources that are registered.
    ///
    /// # Errors
    /// If an entry is not registered or contradicts the settings of the world: the world is then
    /// unchanged. If an entry cannot be decoded: the world must then not be used.
    pub fn rewind(&self, world: &mut World) -> Result<(), StateError> {
        self.check(world)?;
        if self.bytes(NEXT_IDENTITIES).is_some() {
            go_back(world, self.get(NEXT_IDENTITIES)?);
        }
        for Entry { name, forget, .. } in registered(world) {
            if self.bytes(name).is_none() {
                forget(world);
            }
        }
        world.flush();
        self.put(world)
    }

    /// Checks that every entry is registered, and that it suits the settings of the world.
    fn check(&self, world: &mut World) -> Result<(), StateError> {
        let registered = registered(world);
        for (name, bytes) in &self.entries {
            let Some(entry) = registered.iter().find(|entry| entry.name == name) else {
                return Err(StateError::Unknown(name.clone()));
            };
            if let Some(what) = (entry.check)(world, bytes).map_err(|e| encoding(name, &e))? {
                return Err(StateError::Unsuitable { name: name.clone(), what });
            }
        }
        Ok(())
    }

    /// Restores the entries in the order of this registry, whatever that of the captured world was.
    fn put(&self, world: &mut World) -> Result<(), StateError> {
        for Entry { name, restore, .. } in registered(world) {
            if let Some(bytes) = self.bytes(name) {
                restore(world, bytes).map_err(|error| encoding(name, &error))?;
                world.flush();
            }
        }
        Ok(())
    }

    /// Replaces the value of an entry.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn set<T: Serialize>(&mut self, name: &str, value: &T) -> Result<(), StateError> {
        self.set_bytes(name, postcard::to_stdvec(value).map_err(|error| encoding(name, &error))?);
        Ok(())
    }

    /// Keeps the entries whose names satisfy a condition.
    pub fn retain(&mut self, mut keep: impl FnMut(&str) -> bool) {
        self.entries.retain(|(name, _)| keep(name));
    }

    /// Value of an entry: a resource as it is, or components as `Vec<(I, T)>` by identity.
    ///
    /// # Errors
    /// If it is missing or is of another type.
    pub fn get<T: DeserializeOwned>(&self, name: &str) -> Result<T, StateError> {
        let bytes = self.bytes(name).ok_or_else(|| StateError::Missing(name.to_owned()))?;
        postcard::from_bytes(bytes).map_err(|error| encoding(name, &error))
    }

    /// Components of one type by identity; empty if no entity has one.
    ///
    /// # Errors
    /// If the entry is of another type.
    pub fn components<I: Identity, T: DeserializeOwned>(
        &self,
        name: &str,
    ) -> Result<Vec<(I, T)>, StateError> {
        if self.bytes(name).is_none() { Ok(Vec::new()) } else { self.get(name) }
    }

    /// Names of the entries, in the order of the registry.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|(name, _)| name.as_str())
    }

    /// Adds an entry as it is encoded.
    pub fn set_bytes(&mut self, name: &str, bytes: Vec<u8>) {
        match self.entries.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = bytes,
            None => self.entries.push((name.to_owned(), bytes)),
        }
    }

    /// An entry as it is encoded; `None` if it does not exist.
    pub fn bytes(&self, name: &str) -> Option<&[u8]> {
        self.entries.iter().find(|(known, _)| known == name).map(|(_, bytes)| bytes.as_slice())
    }
}

/// Checks that a state can be restored in the world: it has no bodies and no bonds.
///
/// # Errors
/// The numbers of its bodies and bonds.
pub fn expect_empty(world: &mut World) -> Result<(), StateError> {
    let bodies = world.query::<&BodyId>().iter(world).count();
    let bonds = world.query::<&BondId>().iter(world).count();
    if bodies + bonds == 0 { Ok(()) } else { Err(StateError::Occupied { bodies, bonds }) }
}

/// Takes the entities away whose component satisfies a condition.
pub(crate) fn despawn_if<T: Component>(world: &mut World, goes: impl Fn(&T) -> bool) {
    let mut all = world.query::<(Entity, &T)>();
    let gone = all.iter(world).filter(|(_, component)| goes(component));
    let gone: Vec<Entity> = gone.map(|(entity, _)| entity).collect();
    for entity in gone {
        world.despawn(entity);
    }
}

fn encoding(name: &str, error: &postcard::Error) -> StateError {
    StateError::Encoding { name: name.to_owned(), what: error.to_string() }
}
