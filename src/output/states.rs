//! Systems: saved states of a run, those of its `Save` stages, and the one at its end.

use std::path::Path;

use bevy_ecs::prelude::*;

use clastic_components::increment::ClasticProgress;
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::WorldState;

use super::atomic::write_atomic;
use super::run_directory::RunDirectory;
use super::{OutputError, directory};
use crate::run::save::SavedStates;
use crate::run::state::{SCRIPT, ScriptState};
use crate::saved;
use crate::scene::format::{Scene, Stage};
use crate::tables::Tables;

/// Writes the states that stages have kept since the last increment. Exclusive, because it runs at
/// the end of the output as well.
pub fn write_kept(world: &mut World) -> Result<(), OutputError> {
    let Some(mut kept) = world.get_resource_mut::<SavedStates>() else { return Ok(()) };
    let kept = std::mem::take(&mut kept.0);
    let mut run = world.resource_mut::<RunDirectory>();
    for (name, tables) in kept {
        let path = run.path(&name);
        write(&path, &tables)?;
        run.is_fresh(path);
    }
    Ok(())
}

/// Writes the state at the end of a run. A program without the feature `npz` writes none.
pub fn write_final(world: &mut World) -> Result<(), OutputError> {
    if !cfg!(feature = "npz") {
        return Ok(());
    }
    let path = world.resource::<RunDirectory>().path(directory::FINAL_STATE);
    write(&path, &saved::save(world).map_err(OutputError::at(&path))?)
}

fn write(path: &Path, tables: &Tables) -> Result<(), OutputError> {
    let bytes = tables.encode().map_err(OutputError::at(path))?;
    write_atomic(path, bytes)
}

/// Files of `Save` stages that had begun in a state.
pub fn kept_before(scene: &Scene, state: &WorldState) -> Vec<String> {
    let progress = state.get::<ClasticProgress>(PROGRESS).map_or(0, |progress| progress.stage);
    let begun = state.get::<ScriptState>(SCRIPT).is_ok_and(|script| script.begun);
    let stages = scene.stages.iter().take(progress + usize::from(begun));
    stages
        .filter_map(|stage| match stage {
            Stage::Save(save) => Some(save.file()),
            _ => None,
        })
        .collect()
}

/// Number of increments that a run has made. A run that starts from a saved state numbers its
/// increments from those before.
pub fn increments(state: &WorldState) -> u64 {
    let script = state.get::<ScriptState>(SCRIPT);
    script.map_or(0, |script| script.ends.iter().map(|end| end.rows).sum())
}
