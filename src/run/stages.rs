//! Changes of stages: ends and beginnings.

use bevy_ecs::prelude::*;

use clastic_components::increment::ClasticProgress;
use clastic_systems::measures::strain::take_reference;
use clastic_systems::stepping::IncrementDue;

use super::plugin::{BeginStage, EndStage, Provided};
use super::resolve_measures::{of_nothing, resolve_measures, select_groups};
pub use super::script::{Collapse, CollapsedBy, EndedBy, Outcome, Script, StageEnd, Step};
use super::{
    cement, compact, key_results, load, load_refusals, membranes, pour, remove, save, until,
};
use crate::scene::format::Stage;
use crate::text::diagnostic::within;

/// The stage that begins, runs or ends.
#[derive(Resource, Clone, Debug)]
pub struct CurrentStage(pub Stage);

/// Ends finished stages and begins the next ones, up to a stage that needs an increment or to the
/// end of the run. Exclusive, because it runs schedules.
pub(crate) fn change_stages(world: &mut World) {
    let due = loop {
        let script = world.resource::<Script>();
        if script.outcome.is_some() {
            break false;
        }
        let progress = world.resource::<ClasticProgress>();
        let Some(stage) = script.stage(progress.stage).cloned() else {
            let outcome = match script.collapse.clone() {
                Some(collapse) => Outcome::Collapsed(collapse),
                None => Outcome::Completed,
            };
            world.resource_mut::<Script>().outcome = Some(outcome);
            break false;
        };
        // A stage is refused before it changes anything, so that a resumed run with a corrected
        // stage begins it anew. It may lack a plugin in its middle too, in a resumed run.
        let begun = script.begun;
        let own = format!("stages[{}]", progress.stage);
        let mut lacks = world.resource::<Provided>().missing(&script.scene).into_iter();
        let lacks = lacks.find(|f| within(&f.path, "measures") || within(&f.path, &own));
        let lacks = lacks.map(|finding| finding.to_string());
        let is_reference = progress.stage == script.reference_stage();
        let why = lacks.or_else(|| if begun { None } else { refusal(world, &stage) });
        let why = why.or_else(|| if begun || !is_reference { None } else { of_nothing(world) });
        if let Some(why) = why {
            let stage = stage.name().to_owned();
            let message = format!("stage `{stage}` cannot begin: {why}");
            world.resource_mut::<Script>().outcome = Some(Outcome::Refused { stage, message });
            break false;
        }
        if !begun {
            begin(world, stage);
            continue;
        }
        if !world.resource::<ClasticProgress>().is_over() {
            break true;
        }
        end(world, stage);
    };
    world.insert_resource(IncrementDue(due));
}

/// Why a stage cannot begin.
fn refusal(world: &mut World, stage: &Stage) -> Option<String> {
    match stage {
        Stage::Load(_) | Stage::Pour(_) => load_refusals::refusal(world, stage.load()?),
        Stage::Remove(stage) => remove::refusal(world, stage),
        Stage::Compact(stage) => compact::refusal(world, stage),
        Stage::Save(_) => save::refusal(world),
        Stage::Cement(stage) => cement::refusal(world, stage),
        Stage::Custom(_) => None,
    }
}

fn begin(world: &mut World, stage: Stage) {
    let &ClasticProgress { increment, stage: index, time, .. } = world.resource();
    let stage_name = stage.name().to_owned();
    let begun = ClasticProgress { increment, stage: index, time, stage_name, ..Default::default() };
    world.insert_resource(begun);
    let mut script = world.resource_mut::<Script>();
    script.begun = true;
    script.ends.push(StageEnd { stage: stage.name().to_owned(), ..StageEnd::default() });
    script.peak = 0.0;
    script.speed = None;
    script.stop = false;
    let is_reference = index == script.reference_stage();
    until::begin(world, &stage);
    world.insert_resource(CurrentStage(stage));
    world.run_schedule(BeginStage);
    select_groups(world);
    resolve_measures(world);
    if is_reference {
        membranes::renew(world);
        let _ = world.run_system_cached(take_reference);
        key_results::start_from_state(world);
    }
}

fn end(world: &mut World, stage: Stage) {
    let missed = until::missed(world, &stage);
    world.insert_resource(CurrentStage(stage));
    world.run_schedule(EndStage);
    world.resource_mut::<ClasticProgress>().stage += 1;
    let mut script = world.resource_mut::<Script>();
    script.begun = false;
    if let Some(end) = script.ends.last_mut()
        && end.ended_by.is_none()
    {
        (end.ended_by, end.stop) = (Some(EndedBy::AllIncrements), missed);
    }
    if let Some(end) = script.ends.last().cloned() {
        world.write_message(end.clone());
        world.trigger(end);
    }
}

/// Begins a stage of a built-in kind. Exclusive, because it adds and removes walls and bonds.
pub(super) fn begin_built_in(world: &mut World) {
    match world.resource::<CurrentStage>().0.clone() {
        Stage::Compact(stage) => compact::begin(world, &stage),
        Stage::Cement(stage) => {
            cement::cement(world, &stage);
            key_results::count_bonds(world);
        }
        Stage::Save(stage) => save::save(world, &stage),
        Stage::Remove(stage) => remove::remove(world, &stage),
        Stage::Load(stage) => load::begin(world, &stage),
        Stage::Pour(stage) => pour::begin(world, &stage),
        Stage::Custom(stage) => {
            load::set_up(world, stage.analysis, stage.gravity, stage.increments);
        }
    }
}

/// Ends a stage of a built-in kind. Exclusive, because a compaction changes every body.
pub(super) fn end_built_in(world: &mut World) {
    match world.resource::<CurrentStage>().0 {
        Stage::Compact(_) => compact::end(world),
        Stage::Load(_) | Stage::Pour(_) => load::end(world),
        Stage::Cement(_) | Stage::Custom(_) | Stage::Save(_) | Stage::Remove(_) => {}
    }
}
