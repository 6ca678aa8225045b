//! Stored specimens, and saved states as a scene uses them: their particles, and the names that the
//! scene may use.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;
use clastic_systems::gather_bodies::PERIODIC_CELL;
use clastic_systems::state::{StateError, WorldState};

use super::files::read_at_most;
use super::format::{Cell, Scene, Specimen, Wall};
use crate::saved::{SavedState, find};
use crate::tables::Tables;
use crate::text::diagnostic::SceneErrors;

/// A specimen that is stored in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredSpecimen {
    /// Its particles.
    pub rows: Vec<StoredParticle>,
    /// Number of indices of particles, in use or not: more than rows where particles were taken
    /// away before the state was stored.
    pub indices: u64,
    /// Group of every particle; empty where the file has no column for it.
    pub groups: Vec<Option<String>>,
    /// What a saved state has besides.
    pub state: Option<StoredState>,
}

impl StoredSpecimen {
    /// Particles at rest and free of stress.
    pub fn of(rows: Vec<StoredParticle>) -> Self {
        Self { indices: rows.len() as u64, rows, groups: Vec::new(), state: None }
    }

    /// The state, if the scene takes its walls.
    pub(crate) fn gives_walls(&self) -> Option<&StoredState> {
        self.state.as_ref().filter(|state| state.gives_walls)
    }

    /// Whether these are the particles of a run that is resumed, which its scene has cut already.
    pub(crate) fn is_resumed(&self) -> bool {
        self.state.as_ref().is_some_and(|state| state.saved.is_none())
    }
}

/// A particle of a stored specimen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredParticle {
    /// Centre, m.
    pub x: f64,
    /// Centre, m.
    pub y: f64,
    /// Radius, m.
    pub r: f64,
    /// Material; `None` means the material of the scene's specimen.
    pub material: Option<String>,
}

/// Why a stored specimen cannot be read.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{0}")]
    File(String),
    /// Rows of the file are wrong.
    #[error(transparent)]
    Rows(SceneErrors),
}

/// A membrane of a saved state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredMembrane {
    /// Name.
    pub name: String,
    /// Names of the walls between which it lies; closed around the specimen without.
    pub between: Option<(String, String)>,
}

/// What a saved state has besides its particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredState {
    /// Its walls where the run begins.
    pub walls: Vec<Wall>,
    /// Whether they are the walls of the scene, which lists none.
    pub gives_walls: bool,
    /// Its membranes, which go with its walls: a scene that lists walls of its own has none of
    /// them.
    pub membranes: Vec<StoredMembrane>,
    /// Its periodic cell where the run begins.
    pub cell: Option<Cell>,
    /// Whether it is the cell of the scene, which gives none.
    pub gives_cell: bool,
    /// Names of its groups, in order.
    pub groups: Vec<String>,
    /// Names of the rigid groups that are there where the run begins.
    pub rigid: Vec<String>,
    /// Names under which its particles were recorded, by index.
    pub probes: BTreeMap<String, u32>,
    /// The state; `None` for a run that is resumed, which has a state of its own.
    pub saved: Option<Arc<SavedState>>,
}

/// Maximum size of the file, bytes.
const MAX_BYTES: u64 = 16_000_000_000;

/// Reads a saved state.
pub fn read(path: &Path) -> Result<StoredSpecimen, ReadError> {
    let read = || -> Result<StoredSpecimen, Box<dyn Error>> {
        let bytes = read_at_most(path, MAX_BYTES)?.ok_or("it has more than 16 GB")?;
        Ok(stored(SavedState::read(&Tables::decode(&bytes)?)?)?)
    };
    let refuse = |why| ReadError::File(format!("cannot read `{}`: {why}", path.display()));
    read().map_err(refuse)
}

fn stored(saved: SavedState) -> Result<StoredSpecimen, StateError> {
    let names: Vec<&String> = saved.materials.iter().map(|(name, _)| name).collect();
    let (rows, indices) = rows(&saved.world, "position", &names)?;
    let (walls, membranes) = (saved.walls_now()?, saved.membranes()?);
    let rigid = saved.groups_with(|_| true)?;
    let saved = Arc::new(saved);
    let taken = (walls, membranes);
    let state = StoredState::of(&saved.world, taken, rigid, Some(Arc::clone(&saved)))?;
    Ok(StoredSpecimen { rows, indices, groups: Vec::new(), state: Some(state) })
}

/// The particles of a world's state at the places of an entry, and the number of their indices.
pub(crate) fn rows(
    world: &WorldState,
    entry: &str,
    materials: &[&String],
) -> Result<(Vec<StoredParticle>, u64), StateError> {
    let particles = world.components::<BodyId, Particle>("particle")?;
    let places = world.components::<BodyId, DVec2>(entry)?;
    let indices = world.components::<BodyId, MaterialIndex>("material")?;
    let rows = particles.iter().zip(&indices).filter_map(|((id, particle), (_, index))| {
        let at = places.binary_search_by_key(id, |(id, _)| *id).ok()?;
        let DVec2 { x, y } = places[at].1;
        let material = materials.get(index.0 as usize).map(|name| (*name).clone());
        Some(StoredParticle { x, y, r: particle.radius, material })
    });
    Ok((rows.collect(), particles.last().map_or(0, |(id, _)| u64::from(id.0) + 1)))
}

impl StoredState {
    /// Data of a world's state that a scene needs.
    pub(crate) fn of(
        world: &WorldState,
        (walls, membranes): (Vec<Wall>, Vec<StoredMembrane>),
        rigid: Vec<String>,
        saved: Option<Arc<SavedState>>,
    ) -> Result<Self, StateError> {
        let particles = world.components::<BodyId, Particle>("particle")?;
        let is_particle = |id: &BodyId| particles.binary_search_by_key(id, |(id, _)| *id).is_ok();
        let groups = world.components::<BodyId, Group>("group")?;
        let groups: BTreeSet<_> = groups.into_iter().map(|(_, group)| group.0).collect();
        let probes = world.components::<BodyId, Probe>("probe")?.into_iter();
        let probes = probes.filter(|(id, _)| is_particle(id)).map(|(id, probe)| (probe.0, id.0));
        let cell: Option<PeriodicCell> = find(world, PERIODIC_CELL)?;
        Ok(Self {
            walls,
            membranes,
            cell: cell.map(|cell| Cell { size: (cell.width, cell.height) }),
            rigid,
            groups: groups.into_iter().collect(),
            probes: probes.collect(),
            saved,
            ..Self::default()
        })
    }
}

/// Gives a scene the parts of the state from which it starts: the walls if it lists none, the
/// periodic cell, rigid groups, names of recorded particles that it does not use otherwise, and
/// materials by the names that the scene gives them.
pub(super) fn inherit(scene: &mut Scene, stored: &mut StoredSpecimen) {
    let (Some(state), Specimen::State { materials, .. }) = (&mut stored.state, &scene.specimen)
    else {
        return;
    };
    if state.saved.is_some() {
        for row in &mut stored.rows {
            if let Some(name) = row.material.as_ref().and_then(|name| materials.get(name)) {
                row.material = Some(name.clone());
            }
        }
    }
    scene.rigid_at_start.clone_from(&state.rigid);
    state.gives_walls = scene.walls.is_empty();
    if state.gives_walls {
        scene.walls.clone_from(&state.walls);
    }
    state.gives_cell = scene.cell.is_none();
    if state.gives_cell {
        scene.cell = state.cell;
    }
    for (name, index) in &state.probes {
        if !scene.probes.contains_key(name) && !scene.probes.values().any(|i| i == index) {
            scene.probes.insert(name.clone(), *index);
        }
    }
}
