//! Saved states: bodies, bonds and forces at one moment, in a `.npz` file from which another scene
//! starts. See `docs/outputs.md` for its arrays.
//!
//! A saved state is the state of a world ([`WorldState`]) without the place of the run in its
//! stages. Everything that later increments depend on is in it to the bit, state that other plugins
//! register included: a run in two pieces leaves the same rows as a run in one. The array `state`
//! of the file holds it in encoded form; only this array is read. The other arrays are for numpy.

mod arrays;
mod of_scene;
mod settle;

use bevy_ecs::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use clastic_components::body::BodyId;
use clastic_components::increment::{ClasticAnalysis, ClasticProgress};
use clastic_components::material::Materials;
use clastic_components::wall::Wall as WallLine;
use clastic_systems::gather_bodies::gather_bodies;
use clastic_systems::identities::{NEXT_IDENTITIES, NextIdentities};
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::{StateError, WorldState};

use crate::run::state::capture;
use crate::run::walls::WallCatalogue;
use crate::scene::format::Wall;
use crate::tables::{Array, TableError, Tables};

/// First word of the array `format`.
const FORMAT: &str = "clastic state";
/// Version of the format, which follows the word. It increases when arrays have changed since a
/// release, or types that plugins register as state.
const VERSION: u32 = 1;
/// Array with the encoded state.
const STATE: &str = "state";

/// Entries that a scene which starts from the state has of its own: its place among its stages, its
/// settings, its output, and tables that the next increment makes anew.
const OF_THE_SCENE: [&str; 18] = [
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
    "rupture_count",
    "sanity",
    "sanity.untouched",
    "script",
    "until",
    "walls.catalogue",
];

/// Why a state cannot be saved or used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SavedError {
    /// The file or one of its arrays is wrong.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A part of the world cannot be encoded or decoded.
    #[error(transparent)]
    State(#[from] StateError),
}

/// A state that was saved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Identities of the next body and bond.
    pub next: NextIdentities,
}

/// A state as arrays. After an undecided increment it is the state before that increment; a load on
/// its way to a target stays at what it has reached.
///
/// # Errors
/// If a part of the world cannot be encoded.
pub fn save(world: &mut World) -> Result<Tables, SavedError> {
    let mut state = capture(world)?;
    let progress: ClasticProgress = state.get(PROGRESS)?;
    settle::settle(&mut state, &progress)?;
    state.retain(|name| !OF_THE_SCENE.contains(&name));
    let next: NextIdentities = state.get(NEXT_IDENTITIES)?;
    let thickness = world.resource::<ClasticAnalysis>().thickness;
    let materials = world.resource::<Materials>().0.iter();
    let materials: Vec<_> = materials.map(|m| (m.name.clone(), m.density)).collect();
    let catalogue = world.get_resource::<WallCatalogue>().cloned().unwrap_or_default();
    let lines = state.components::<BodyId, WallLine>("wall")?;
    let is_there = |id| lines.binary_search_by_key(&BodyId(id), |(id, _)| *id).is_ok();
    let first_wall = if catalogue.walls.is_empty() { next.body } else { catalogue.first };
    let mut walls = catalogue.walls.clone();
    for (k, wall) in walls.iter_mut().enumerate() {
        wall.present = is_there(catalogue.first_of(k));
    }

    let mut tables = Tables::default();
    tables.put("format", Array::single(format!("{FORMAT} {VERSION}")));
    tables.put("increment", Array::single(progress.increment));
    tables.put("time_s", Array::single(progress.time));
    tables.put("stage", Array::single(progress.stage_name));
    tables.put("thickness_m", Array::single(thickness));
    tables.put("materials.name", Array::column(materials.iter().map(|(name, _)| name.clone())));
    // Gathering the tables does not change the run.
    let _ = world.run_system_cached(gather_bodies);
    let _ = world.run_system_cached_with(arrays::write, &mut tables);
    let saved = SavedState { world: state, materials, thickness, walls, first_wall, next };
    let bytes = postcard::to_stdvec(&saved).map_err(|error| encoding(&error))?;
    tables.put(STATE, Array::column(bytes));
    Ok(tables)
}

/// Value of an entry of the state, if it has it.
pub(crate) fn find<T: DeserializeOwned>(
    state: &WorldState,
    entry: &str,
) -> Result<Option<T>, StateError> {
    state.bytes(entry).map(|_| state.get(entry)).transpose()
}

fn encoding(error: &postcard::Error) -> TableError {
    TableError::at(STATE, error.to_string())
}

impl SavedState {
    /// Reads a state from its arrays.
    ///
    /// # Errors
    /// If they are no state, or of another version, or damaged.
    pub fn read(tables: &Tables) -> Result<Self, TableError> {
        let foreign = |what: String| Err(TableError::Foreign(what));
        let format: String = match tables.single("format") {
            Err(TableError::Missing(_)) => {
                let what = "not a saved state: no array `format`; give the `.npz` file of a `Save` stage, or the \
                            `final_state.npz` of a run";
                return foreign(what.to_owned());
            }
            format => format?,
        };
        let Some(version) = format.strip_prefix(FORMAT).map(str::trim) else {
            return foreign(format!("not a saved state: it is `{format}`"));
        };
        if version != VERSION.to_string() {
            return foreign(format!(
                "a state of format {version}, and this clastic reads format {VERSION}; save it again with \
                 this clastic"
            ));
        }
        let bytes = tables.values(STATE, &[tables.rows(STATE)?])?;
        postcard::from_bytes(bytes).map_err(|error| encoding(&error))
    }
}
