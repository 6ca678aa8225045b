//! `ScenePlugin`: systems for the stages of a scene, around the increment.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};

use clastic_components::prelude::*;
use clastic_systems::schedule::{
    AttemptIncrement, AttemptSystems, Increment, IncrementSystems, committed,
};
use clastic_systems::state::RegisterState;
use clastic_systems::stepping::{AdvanceIncrement, AdvanceSystems, is_due};

use super::compact::{are_growing, grow, keep_radii};
use super::key_results::{KEY_RESULTS, KeyResults, is_undecided, observe_increment};
use super::pour::{POURED, pour};
#[cfg(feature = "cli")]
pub(crate) use super::provided::OWN_PROGRAM;
pub use super::provided::{Provide, Provided};
use super::provided::{has_measures, read_measures};
use super::resolve_measures::{GROUP_MEMBERS, GroupMembers, select_live_groups};
use super::sanity::{self, SANITY, Sanity, UNTOUCHED, Untouched};
use super::scale::scale;
use super::script::{Script, StageEnd};
use super::stages::{CurrentStage, begin_built_in, change_stages, end_built_in};
use super::state::{Before, SCRIPT, ScriptState, WALL_CATALOGUE, take_down};
use super::stop::{end_increment, end_run};
use super::until::{APPROACH, Approach, forget_halted, is_halted, is_on, keep_state};
use super::walls::WallCatalogue;
use crate::scene::format::Stage;

/// Begins the [`CurrentStage`]: sets controls and `ClasticProgress::total`,
/// which is 0 for a stage without increments.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BeginStage;

/// Ends the [`CurrentStage`].
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EndStage;

/// Sets of [`BeginStage`] and [`EndStage`], and of the end of an increment, in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StageSystems {
    /// Systems of the engine: in [`BeginStage`] and [`EndStage`].
    BuiltIn,
    /// Systems of a plugin for its kinds of stages: in [`BeginStage`] and [`EndStage`].
    Custom,
    /// Stop conditions of a plugin: in [`AdvanceIncrement`], after the increment. They set
    /// [`Script::stop`].
    Stop,
}

/// Run condition: the [`CurrentStage`] is a `Custom` stage of this kind.
pub fn stage_is(kind: &'static str) -> impl FnMut(Option<Res<CurrentStage>>) -> bool + Clone {
    move |stage| matches!(stage.as_deref(), Some(CurrentStage(Stage::Custom(s))) if s.kind == kind)
}

/// Adds the stages of a scene to [`ClasticPlugins`](crate::ClasticPlugins).
/// [`spawn_scene`](super::spawn::spawn_scene) adds the scene. Without a scene this plugin does
/// nothing.
pub struct ScenePlugin;

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        for label in [BeginStage.intern(), EndStage.intern()] {
            app.edit_schedule(label, |schedule| {
                schedule.set_build_settings(ScheduleBuildSettings {
                    ambiguity_detection: LogLevel::Error,
                    hierarchy_detection: LogLevel::Error,
                    ..Default::default()
                });
                schedule.set_executor(SingleThreadedExecutor::new());
                schedule.configure_sets((StageSystems::BuiltIn, StageSystems::Custom).chain());
            });
        }
        let runs_scene = resource_exists::<Script>;
        app.register_component::<BodyId, Group>("group")
            .register_component::<BodyId, WallName>("wall_name")
            .register_resource::<WallCatalogue>(WALL_CATALOGUE)
            // The script resolves the measures, which have these particles.
            .register_resource::<GroupMembers>(GROUP_MEMBERS)
            .register_state::<ScriptState>(SCRIPT)
            .register_state::<Approach>(APPROACH)
            .register_resource::<KeyResults>(KEY_RESULTS)
            .register_resource::<Sanity>(SANITY)
            .register_resource::<Untouched>(UNTOUCHED)
            .register_resource::<Poured>(POURED)
            .add_message::<StageEnd>()
            .init_resource::<Provided>()
            .init_resource::<Before>()
            .add_systems(BeginStage, begin_built_in.in_set(StageSystems::BuiltIn))
            .add_systems(
                AttemptIncrement,
                (grow.run_if(are_growing), scale).chain().before(AttemptSystems::Detect),
            )
            .add_systems(
                Increment,
                keep_radii
                    .after(IncrementSystems::Update)
                    .before(IncrementSystems::Rupture)
                    .run_if(are_growing)
                    .run_if(committed),
            )
            .add_systems(EndStage, end_built_in.in_set(StageSystems::BuiltIn))
            .configure_sets(AdvanceIncrement, StageSystems::Stop.in_set(AdvanceSystems::End))
            .add_systems(
                AdvanceIncrement,
                (
                    (
                        change_stages,
                        keep_state.run_if(is_due).run_if(is_on),
                        // Before systems that read the bodies of the increment.
                        pour.run_if(is_due).run_if(resource_exists::<Poured>),
                        select_live_groups.run_if(is_due),
                        take_down.run_if(is_due),
                    )
                        .chain()
                        .in_set(AdvanceSystems::Begin)
                        .run_if(runs_scene),
                    (observe_increment, sanity::follow, sanity::follow_driven)
                        .run_if(runs_scene)
                        .run_if(not(is_undecided))
                        .in_set(AdvanceSystems::End)
                        .before(StageSystems::Stop),
                    // A checkpoint of the state before an undecided increment comes first.
                    observe_increment
                        .run_if(runs_scene)
                        .run_if(is_undecided)
                        .run_if(is_due)
                        .after(AdvanceSystems::Output),
                    end_run.run_if(runs_scene).after(AdvanceSystems::Output),
                    forget_halted
                        .run_if(is_halted)
                        .after(AdvanceSystems::End)
                        .before(AdvanceSystems::Announce),
                    // Measures are read after all systems of plugins that come before `Stop`.
                    (read_measures.run_if(has_measures), end_increment.run_if(runs_scene))
                        .chain()
                        .in_set(AdvanceSystems::End)
                        .after(StageSystems::Stop),
                ),
            );
    }
}
