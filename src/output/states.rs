//! Systems: saved states of a run, those of its `Save` stages, and the one at its end.

use bevy_ecs::prelude::*;

use clastic_components::increment::ClasticProgress;

use super::atomic::write_atomic;
use super::run_directory::RunDirectory;
use super::{OutputError, directory};
use crate::run::save::SavedStates;
use crate::run::stages::Script;
use crate::saved;
use crate::scene::format::Stage;

/// Writes the states that stages have kept since the last increment. Exclusive, because it runs at
/// the end of the output as well.
pub(crate) fn write_kept(world: &mut World) -> Result<(), OutputError> {
    let Some(mut kept) = world.get_resource_mut::<SavedStates>() else { return Ok(()) };
    let kept = std::mem::take(&mut kept.0);
    let mut run = world.resource_mut::<RunDirectory>();
    for (name, tables) in kept {
        let path = run.path(&name);
        let bytes = tables.encode().map_err(OutputError::at(&path))?;
        run.write(path, bytes)?;
    }
    Ok(())
}

/// Writes the state at the end of a run.
pub(crate) fn write_final(world: &mut World) -> Result<(), OutputError> {
    let path = world.resource::<RunDirectory>().path(directory::FINAL_STATE);
    let tables = saved::save(world).map_err(OutputError::at(&path))?;
    write_atomic(&path, tables.encode().map_err(OutputError::at(&path))?)
}

/// Files of the `Save` stages that have begun.
pub(crate) fn kept_before(world: &World) -> Vec<String> {
    let script = world.resource::<Script>();
    let begun = world.resource::<ClasticProgress>().stage + usize::from(script.begun);
    let file = |stage: &Stage| match stage {
        Stage::Save(save) => Some(save.file()),
        _ => None,
    };
    script.scene.stages.iter().take(begun).filter_map(file).collect()
}
