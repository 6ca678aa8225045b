//! Permitted changes in the scene of a run that is resumed.
//!
//! Settings of the solution of later increments, of their output, and of stages that have not begun
//! may change. In the current stage the stop conditions and the motion of walls may change. The
//! number of its increments may change if no load is on its way to a target. All else is fixed by
//! the state: bodies, bonds, laws, references of strains.

use bevy_ecs::prelude::*;

use clastic_components::increment::ClasticProgress;

use super::state::StateView;
use super::wall_controls::motion;
use super::walls::find_walls;
use crate::scene::format::{CellTarget, Load, Scale, Scene, Stage};

/// Changes in `new` that are not permitted when a run under `old` has reached `state`, each with a
/// reason.
pub fn refused(old: &Scene, new: &Scene, state: &StateView) -> Vec<String> {
    let mut refused = Vec::new();
    let mut fixed = |field: &str, same: bool, why: &str| {
        if !same {
            refused.push(format!("`{field}` cannot change: {why}"));
        }
    };
    let bodies = "the run has moved the particles already; start a new run";
    fixed("specimen", old.specimen == new.specimen, bodies);
    fixed("bonds", old.bonds == new.bonds, bodies);
    fixed("walls", old.walls == new.walls, "control them in later stages");
    fixed("cell", old.cell == new.cell, "control it in later stages");
    fixed("materials", old.materials == new.materials, "existing bonds keep their laws");
    fixed("thickness", old.thickness.to_bits() == new.thickness.to_bits(), bodies);
    let own = "stages that have ended used it; give it to later stages";
    fixed("analysis", old.analysis == new.analysis, own);
    fixed("gravity", old.gravity == new.gravity, own);
    fixed("measures", old.measures == new.measures, "the history has a column for each");
    // A run that gets more stages names the reference stage that it had by default.
    let counts_on = old.reference_stage() == new.reference_stage();
    let is_named = old.reference_stage != new.reference_stage;
    fixed("reference_stage", counts_on || !is_named, "strains count from its stage");
    fixed("probes", old.probes == new.probes, "the history has columns for each");
    let why = "the columns of the history and the ledger exist from the start";
    fixed("output.energy", old.output.energy == new.output.energy, why);
    let why = "strains count from the same stage; name it in `reference_stage`";
    fixed("stages", counts_on || is_named, why);

    let index = state.progress.stage;
    for (k, stage) in old.stages.iter().enumerate() {
        let Some(changed) = new.stages.get(k) else {
            let last = index.min(old.stages.len().saturating_sub(1));
            let gone = k < index || (k == last && state.begun);
            fixed(&format!("stages.{}", stage.name()), !gone, "it has begun");
            continue;
        };
        let field = format!("stages.{}", stage.name());
        if k < index || (k == index && state.begun && state.ended) {
            fixed(&field, stage == changed, "it has ended");
        } else if k == index && state.begun {
            let why = match (stage, changed) {
                (Stage::Load(old), Stage::Load(new)) => stage_under_way(old, new, state),
                (Stage::Pour(old), Stage::Pour(new)) if old.stream != new.stream => {
                    Some("it is under way, and later grains must continue its sequence")
                }
                (Stage::Pour(old), Stage::Pour(new))
                    if old.stream.rate.is_over_stage()
                        && old.load.increments != new.load.increments =>
                {
                    Some("it is under way, and its rate is spread over all increments")
                }
                (Stage::Pour(old), Stage::Pour(new)) => {
                    stage_under_way(&old.load, &new.load, state)
                }
                _ => (stage != changed).then_some("it is under way"),
            };
            fixed(&field, why.is_none(), why.unwrap_or_default());
        }
    }
    refused
}

/// Why the current stage cannot continue as the new one; `None` if it can.
fn stage_under_way(old: &Load, new: &Load, state: &StateView) -> Option<&'static str> {
    let mut allowed = new.clone();
    allowed.increments = old.increments;
    allowed.stop.clone_from(&old.stop);
    allowed.record.clone_from(&old.record);
    for (name, control) in &mut allowed.walls {
        if let (Some(before), Some(_)) = (old.walls.get(name), motion(control))
            && motion(before).is_some()
        {
            control.clone_from(before);
        }
    }
    if allowed != *old {
        return Some(
            "it is under way; only its `increments`, `stop`, `record` and motions of walls can change",
        );
    }
    if f64::from(new.increments) < state.progress.done {
        return Some("it is under way and has made more increments already");
    }
    let cell_moves = old.cell.as_deref().is_some_and(|cell| {
        let all = [cell.xx, cell.yy, cell.shear, cell.mean, cell.difference];
        all.into_iter().flatten().any(|target| target != CellTarget::Fixed)
    });
    ((state.ramps || cell_moves || old.scale != Scale::default())
        && old.increments != new.increments)
        .then_some("it is under way, and a load reaches its target at the end of its `increments`")
}

/// Applies the changes of the current stage in `new` to a world that was restored from `state`.
/// [`refused`] must have found none of them.
pub fn apply(world: &mut World, old: &Scene, new: &Scene, state: &StateView) {
    let index = state.progress.stage;
    let load = |scene: &'_ Scene| scene.stages.get(index).and_then(Stage::load).cloned();
    let (Some(old), Some(new)) = (load(old), load(new)) else {
        return;
    };
    // After its last increment a stage goes on if it gets more of them.
    if !state.begun || state.ended || old == new {
        return;
    }
    if old.increments != new.increments {
        world.resource_mut::<ClasticProgress>().total = f64::from(new.increments);
    }
    for (name, wanted) in &new.walls {
        if let (Some(control), true) = (motion(wanted), old.walls.get(name) != Some(wanted)) {
            for wall in find_walls(world, name) {
                world.entity_mut(wall).insert(control);
            }
        }
    }
}
