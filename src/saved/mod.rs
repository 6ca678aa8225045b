//! Saved states: bodies, bonds and forces at one moment, as documented arrays in a `.npz` file from
//! which another scene starts. See `docs/outputs.md` for the arrays.
//!
//! A saved state is the state of a world ([`WorldState`]) without the place of the run in its
//! stages. Everything that later increments depend on is in it to the bit: a run in two pieces
//! leaves the same rows as a run in one. State that other plugins register travels as the bytes
//! that they encode, in arrays named `plugin.NAME`.

mod bonds;
pub(crate) mod cell;
mod columns;
mod contacts;
mod controls;
mod groups;
mod membranes;
mod particles;
mod progress;
mod wall_controls;
mod wall_laws;
mod walls;

use bevy_ecs::prelude::*;

use clastic_components::body::BodyId;
use clastic_components::increment::ClasticAnalysis;
use clastic_components::material::Materials;
use clastic_systems::gather_bodies::gather_bodies;
use clastic_systems::state::{StateError, WorldState};

use crate::run::state::capture;
use crate::run::walls::WallCatalogue;
use crate::scene::StoredMembrane;
use crate::scene::format::Wall;
use crate::tables::{Array, TableError, Tables};
use columns::{bad, single};

pub use progress::Counts;

/// First word of the array `format`.
const FORMAT: &str = "clastic state";
/// Version of the format, which follows the word. It increases when arrays have changed since a
/// release.
const VERSION: u32 = 1;
/// Prefix of arrays with the state of other plugins.
const PLUGIN: &str = "plugin.";

/// Entries of a [`WorldState`] that a saved state has as arrays.
const AS_ARRAYS: [&[&str]; 8] = [
    &particles::ENTRIES,
    &walls::ENTRIES,
    &groups::ENTRIES,
    &bonds::ENTRIES,
    &contacts::ENTRIES,
    &membranes::ENTRIES,
    &cell::ENTRIES,
    &progress::ENTRIES,
];

/// Entries that a scene which starts from the state has of its own: its place among its stages, its
/// settings, its output, and tables that the next increment makes anew.
const OF_THE_SCENE: [&str; 20] = [
    "analysis",
    "key_results",
    "materials.names",
    "measures.groups",
    "measures.named",
    "measures.path",
    "measures.reference",
    "measures.start",
    "observation",
    "output.avalanche",
    "output.results",
    "output.specimen",
    "rigid_group.at_start",
    "rupture_count",
    "sanity",
    "sanity.untouched",
    "script",
    "until",
    "walls.catalogue",
    "walls.first",
];

/// Why a state cannot be saved or used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SavedError {
    /// The file or one of its arrays is wrong.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The arrays hold another kind of data.
    #[error("not a saved state: {0}")]
    Foreign(String),
    /// The file is of another version of the format.
    #[error(
        "a state of format {0}, and this clastic reads format {VERSION}; save it again with this \
         clastic"
    )]
    Version(String),
    /// A part of the world cannot be encoded or decoded.
    #[error(transparent)]
    State(#[from] StateError),
}

/// A state that was saved.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedState {
    /// State of the world; indices of materials count [`materials`](Self::materials).
    pub world: WorldState,
    /// Names of the materials and their densities, kg/m^3.
    pub materials: Vec<(String, f64)>,
    /// Out-of-plane thickness, m.
    pub thickness: f64,
    /// Walls of the scene as it drew them; `present` says whether each is there now.
    pub walls: Vec<Wall>,
    /// Identity of the first of these walls.
    pub first_wall: u32,
    /// What counts from the start of the first run.
    pub counts: Counts,
}

/// A state as arrays. After an undecided increment it is the state before that increment; a load on
/// its way to a target stays at what it has reached.
///
/// # Errors
/// If a part of the world cannot be encoded.
pub fn save(world: &mut World) -> Result<Tables, SavedError> {
    let state = capture(world)?;
    // Gathering the tables does not change the run.
    let _ = world.run_system_cached(gather_bodies);
    let mut tables = Tables::default();
    tables.put("format", Array::word(&format!("{FORMAT} {VERSION}")));
    let thickness = world.resource::<ClasticAnalysis>().thickness;
    progress::write(&state, thickness, &mut tables)?;
    let materials = world.resource::<Materials>();
    tables.put("materials.name", Array::text(materials.0.iter().map(|m| m.name.clone())));
    let densities = materials.0.iter().map(|m| m.density).collect();
    tables.put("materials.density_kg_m3", Array::f64(densities));
    particles::write(&state, &mut tables)?;
    let catalogue = world.get_resource::<WallCatalogue>().cloned().unwrap_or_default();
    walls::write(&state, &catalogue, &mut tables)?;
    groups::write(&state, &mut tables)?;
    bonds::write(&state, &mut tables)?;
    contacts::write(&state, world, &mut tables)?;
    membranes::write(&state, &mut tables)?;
    cell::write(&state, &mut tables)?;
    for name in state.names() {
        let known = AS_ARRAYS.iter().any(|entries| entries.contains(&name));
        if let Some(bytes) = state.bytes(name).filter(|_| !known && !OF_THE_SCENE.contains(&name)) {
            tables.put(&format!("{PLUGIN}{name}"), Array::u8(bytes.to_vec()));
        }
    }
    Ok(tables)
}

impl SavedState {
    /// Reads a state from its arrays, and checks that they belong together.
    ///
    /// # Errors
    /// If they are no state, or of another version, or contradict each other.
    pub fn read(tables: &Tables) -> Result<Self, SavedError> {
        let format = match tables.text("format", &[]) {
            Ok(format) => format[0].as_str(),
            Err(TableError::Missing(_)) => {
                let what = "no array `format`; give the `.npz` file of a `Save` stage, or the \
                            `final_state.npz` of a run";
                return Err(SavedError::Foreign(what.to_owned()));
            }
            Err(error) => return Err(error.into()),
        };
        match format.strip_prefix(FORMAT).map(str::trim) {
            None => return Err(SavedError::Foreign(format!("it is `{format}`"))),
            Some(version) if version != VERSION.to_string() => {
                return Err(SavedError::Version(version.to_owned()));
            }
            Some(_) => {}
        }
        let mut world = WorldState::default();
        let names = tables.text("materials.name", &[tables.rows("materials.name")?])?;
        let densities = tables.f64("materials.density_kg_m3", &[names.len()])?;
        let materials: Vec<_> = names.iter().cloned().zip(densities.iter().copied()).collect();
        let counts = progress::read(tables, &mut world)?;
        let ids = particles::read(tables, names.len(), &mut world)?;
        let walls = walls::read(tables, counts.next.body, &ids, &mut world)?;
        groups::read(tables, &ids, &walls.ids, &mut world)?;
        let mut bodies = ids;
        bodies.extend(&walls.ids);
        bonds::read(tables, &bodies, counts.next.bond, &mut world)?;
        contacts::read(tables, &mut world)?;
        membranes::read(tables, &walls.ids, &mut world)?;
        cell::read(tables, !walls.ids.is_empty(), &mut world)?;
        for (name, array) in tables.iter() {
            if let Some(entry) = name.strip_prefix(PLUGIN) {
                let bytes = tables.u8(name, &array.shape)?;
                world.set_bytes(entry, bytes.to_vec());
            }
        }
        let thickness = single(tables, "thickness_m")?;
        if !(thickness > 0.0) {
            return Err(bad("thickness_m", format!("{thickness:?}, which is no thickness")));
        }
        let (first_wall, walls) = (walls.first, walls.listed);
        Ok(Self { world, materials, thickness, walls, first_wall, counts })
    }

    /// The membranes, with the names of their walls.
    ///
    /// # Errors
    /// If the entry of the world is of another type.
    pub fn membranes(&self) -> Result<Vec<StoredMembrane>, StateError> {
        membranes::names(&self.world, self.first_wall, &self.walls)
    }

    /// Names of the rigid groups, in the order of identities.
    ///
    /// # Errors
    /// If the world does not have them.
    pub fn rigid_groups(&self) -> Result<Vec<String>, StateError> {
        groups::names(&self.world)
    }

    /// Names of the rigid groups that have walls.
    ///
    /// # Errors
    /// If the world does not have them.
    pub fn groups_with_walls(&self) -> Result<Vec<String>, StateError> {
        let walls = self.world.components::<BodyId, clastic_components::wall::Wall>("wall")?;
        let ids: Vec<BodyId> = walls.into_iter().map(|(id, _)| id).collect();
        groups::with(&self.world, &ids)
    }

    /// The walls of the scene where they are now. Those that are not there are as it drew them.
    ///
    /// # Errors
    /// If the world does not have them.
    pub fn walls_now(&self) -> Result<Vec<Wall>, StateError> {
        walls::now(&self.world, self.first_wall, &self.walls)
    }
}
