//! The schedules of a stage, and the kinds of stages that plugins provide.

use std::collections::BTreeSet;

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;

use crate::scene::format::CustomStage;

/// Begins the [`CurrentStage`](super::stages::CurrentStage): sets controls and `ClasticProgress::total`,
/// which is 0 for a stage without increments.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BeginStage;

/// Ends the [`CurrentStage`](super::stages::CurrentStage).
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EndStage;

/// Sets of [`BeginStage`] and [`EndStage`], and of the end of an increment, in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StageSystems {
    /// Systems of the engine: in [`BeginStage`] and [`EndStage`].
    BuiltIn,
    /// Systems of a plugin for its kinds of stages: in [`BeginStage`] and [`EndStage`].
    Custom,
    /// Stop conditions of a plugin: in
    /// [`AdvanceIncrement`](clastic_systems::stepping::AdvanceIncrement), after the increment. They
    /// set [`Script::stop`](super::script::Script::stop).
    Stop,
}

/// The kinds of `Custom` stages that plugins provide. Stages of other kinds are refused.
#[derive(Resource, Clone, Debug, Default)]
pub struct StageKinds(BTreeSet<&'static str>);

impl StageKinds {
    /// The kinds.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().copied()
    }

    /// Why a stage cannot begin; `None` if a plugin provides its kind.
    pub fn refusal(&self, stage: &CustomStage) -> Option<String> {
        let CustomStage { kind, .. } = stage;
        (!self.0.contains(kind.as_str())).then(|| {
            let known: Vec<_> = self.0.iter().copied().collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            format!("no plugin of this program provides the kind `{kind}`; it provides {known}")
        })
    }
}

/// Registers the kinds of stages that a plugin provides.
pub trait ProvideStage {
    /// Registers a kind of stage. The plugin has systems in [`StageSystems::Custom`] that begin and
    /// end such stages.
    fn provide_stage(&mut self, kind: &'static str) -> &mut Self;
}

impl ProvideStage for App {
    fn provide_stage(&mut self, kind: &'static str) -> &mut Self {
        self.world_mut().get_resource_or_init::<StageKinds>().0.insert(kind);
        self
    }
}
