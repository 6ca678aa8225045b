//! End of a compaction at the packing that is as dense as it gets.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, IncrementStatus};
use clastic_components::increment::ClasticProgress;
use clastic_cone::program::{ConeSolution, SolveStatus};
use clastic_systems::stepping::{IncrementDue, IncrementUndone};

use super::before::Before;
use super::compact::reached;
use super::script::Script;
use crate::scene::format::{Compact, CompactTarget, Stage};

/// Ends a compaction to [`CompactTarget::Jammed`] where even the smallest part of an increment has
/// been proved to be impossible. This increment has committed nothing, and leaves no trace. Whether
/// it has done so.
pub(super) fn ends(world: &mut World, stage: &Stage) -> bool {
    let Stage::Compact(stage @ Compact { target: CompactTarget::Jammed, .. }) = stage else {
        return false;
    };
    let is_undecided = world.resource::<Attempt>().status == IncrementStatus::Undecided;
    if !is_undecided || world.resource::<ConeSolution>().status != SolveStatus::Locked {
        return false;
    }
    let Before { progress, observation, readings, .. } = world.resource::<Before>().clone();
    world.insert_resource(ClasticProgress { done: progress.total, ..progress });
    world.insert_resource(observation);
    world.insert_resource(readings);
    let porosity = reached(world, stage).map(|reached| reached.porosity);
    if let Some(end) = world.resource_mut::<Script>().ends.last_mut() {
        end.jammed_at = porosity;
    }
    world.insert_resource(IncrementDue(false));
    world.insert_resource(IncrementUndone(true));
    true
}
