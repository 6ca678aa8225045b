//! More increments for a run that has ended.

use clastic_components::increment::Progress;
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::{StateError, WorldState};

use super::script::EndedBy;
use super::state::{SCRIPT, ScriptState};
use crate::scene::format::{Scene, Stage};

/// Takes a run at its end back into its last stage, if `new` gives that stage more increments than
/// `old`. The state is then that of a run of `new` after these increments. A stage that ended
/// early, by a stop or a collapse, stays ended: its loads were set to what they had reached.
///
/// # Errors
/// If the state is not that of a run of a scene.
pub fn reopen(state: &mut WorldState, old: &Scene, new: &Scene) -> Result<(), StateError> {
    let mut progress: Progress = state.get(PROGRESS)?;
    let mut script: ScriptState = state.get(SCRIPT)?;
    let Some(last) = old.stages.len().checked_sub(1) else { return Ok(()) };
    let (Some(old), Some(new)) = (old.stages.get(last), new.stages.get(last)) else {
        return Ok(());
    };
    let streams = match (old, new) {
        (Stage::Load(_), Stage::Load(_)) => true,
        (Stage::Pour(old), Stage::Pour(new)) => {
            old.stream == new.stream && !old.stream.rate.is_over_stage()
        }
        _ => false,
    };
    let (Some(before), Some(after)) = (old.load().filter(|_| streams), new.load()) else {
        return Ok(());
    };
    let is_at_its_end = progress.stage > last && !script.begun;
    let Some(end) = script.ends.last_mut().filter(|_| is_at_its_end) else { return Ok(()) };
    if end.ended_by != Some(EndedBy::AllIncrements)
        || before.name != after.name
        || after.increments <= before.increments
    {
        return Ok(());
    }
    end.ended_by = None;
    script.begun = true;
    progress.stage = last;
    progress.total = f64::from(after.increments);
    state.set(PROGRESS, &progress)?;
    state.set(SCRIPT, &script)
}
