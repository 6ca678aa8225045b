//! A saved state as a scene uses it: its particles, and the names that the scene may use.

use std::collections::BTreeSet;
use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use glam::DVec2;

use clastic_components::body::{BodyId, Group, Probe};
use clastic_components::cell::PeriodicCell;
use clastic_components::particle::{MaterialIndex, Particle};
use clastic_systems::gather_bodies::PERIODIC_CELL;
use clastic_systems::state::{StateError, WorldState};

use super::files::read_at_most;
use super::format::{Cell, Scene, Specimen, Wall};
use super::stored::{ReadError, StoredMembrane, StoredParticle, StoredSpecimen, StoredState};
use crate::saved::{SavedError, SavedState};
use crate::tables::Tables;

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

fn stored(saved: SavedState) -> Result<StoredSpecimen, SavedError> {
    let names: Vec<&String> = saved.materials.iter().map(|(name, _)| name).collect();
    let (rows, indices) = rows(&saved.world, "position", &names)?;
    let (walls, membranes) = (saved.walls_now()?, saved.membranes()?);
    let rigid = saved.rigid_groups()?;
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
        Ok(Self {
            walls,
            gives_walls: false,
            membranes,
            cell: match world.bytes(PERIODIC_CELL) {
                Some(_) => {
                    let cell: PeriodicCell = world.get(PERIODIC_CELL)?;
                    Some(Cell { size: (cell.width, cell.height), tilt: cell.tilt })
                }
                None => None,
            },
            gives_cell: false,
            rigid,
            groups: groups.into_iter().collect(),
            probes: probes.collect(),
            saved,
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
