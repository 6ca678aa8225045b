//! What plugins provide to scenes: kinds of stages, measures, and systems that drive walls.

use std::collections::{BTreeMap, BTreeSet};

use bevy_app::App;
use bevy_ecs::prelude::*;

use clastic_components::measure::{NamedMeasures, Quantity, Readings};

use crate::scene::{Finding, format as scene};
use crate::text::suggest;

/// Reads the measure of a plugin.
type Read = Box<dyn Fn(&World) -> Option<f64> + Send + Sync>;

/// What the plugins of a program provide. A scene that needs more is refused.
#[derive(Resource, Default)]
pub struct Provided {
    /// Kinds of `Custom` stages.
    pub stages: BTreeSet<&'static str>,
    /// Whether walls with the control `Custom` are driven. Otherwise the command line refuses
    /// scenes with such walls, which would stand still.
    pub walls: bool,
    /// Measures by name.
    measures: BTreeMap<&'static str, Read>,
}

impl Provided {
    /// The names of the measures.
    pub fn measures(&self) -> impl Iterator<Item = &'static str> {
        self.measures.keys().copied()
    }

    /// What a scene leaves to plugins and none provides: kinds of stages, and measures.
    pub fn missing(&self, scene: &scene::Scene) -> Vec<Finding> {
        let (stages, measures): (Vec<_>, Vec<_>) =
            (self.stages.iter().copied().collect(), self.measures().collect());
        let kinds = scene.stages.iter().enumerate().filter_map(|(i, stage)| match stage {
            scene::Stage::Custom(stage) => {
                missing(format!("stages[{i}].kind"), &stage.kind, "kind of stage", &stages)
            }
            _ => None,
        });
        let of_measures =
            scene.measures.iter().enumerate().filter_map(|(i, measure)| match &measure.of {
                scene::Quantity::Custom(kind) => {
                    missing(format!("measures[{i}].of[0]"), kind, "measure", &measures)
                }
                _ => None,
            });
        kinds.chain(of_measures).collect()
    }
}

/// The remedy where a program has no plugin at all.
pub(crate) const OWN_PROGRAM: &str =
    "run the scene in a program of your own (ARCHITECTURE.md, Extending)";

/// Finds a name that is not among those that plugins have `provided`.
fn missing(path: String, name: &str, what: &str, provided: &[&str]) -> Option<Finding> {
    if name.trim().is_empty() || provided.contains(&name) {
        return None;
    }
    let message = format!("`{name}` is a {what} that no plugin of this program provides");
    let help = match provided {
        [] => format!("leave it out, or {OWN_PROGRAM}"),
        _ => suggest::help(name, provided, "those of its plugins"),
    };
    Some(Finding::new(path, message, help))
}

/// Registers what a plugin provides to scenes.
pub trait Provide {
    /// Registers a kind of stage. The plugin has systems in
    /// [`StageSystems::Custom`](super::plugin::StageSystems::Custom) that begin and end such stages.
    fn provide_stage(&mut self, kind: &'static str) -> &mut Self;

    /// Registers a measure: a scene refers to it by `Custom(name)`. It is read from the resource
    /// `R` after every increment, before the systems of
    /// [`StageSystems::Stop`](super::plugin::StageSystems::Stop). Without the resource, or with
    /// `None`, it is not defined.
    fn provide_measure<R: Resource>(
        &mut self,
        name: &'static str,
        read: impl Fn(&R) -> Option<f64> + Send + Sync + 'static,
    ) -> &mut Self;

    /// Registers that the plugin has systems in
    /// [`ControlSystems::Custom`](clastic_systems::schedule::ControlSystems::Custom) that drive
    /// walls with the control `Custom`.
    fn provide_walls(&mut self) -> &mut Self;
}

impl Provide for App {
    fn provide_stage(&mut self, kind: &'static str) -> &mut Self {
        provided(self).stages.insert(kind);
        self
    }

    fn provide_measure<R: Resource>(
        &mut self,
        name: &'static str,
        read: impl Fn(&R) -> Option<f64> + Send + Sync + 'static,
    ) -> &mut Self {
        let read = move |world: &World| world.get_resource::<R>().and_then(&read);
        provided(self).measures.insert(name, Box::new(read));
        self
    }

    fn provide_walls(&mut self) -> &mut Self {
        provided(self).walls = true;
        self
    }
}

fn provided(app: &mut App) -> Mut<'_, Provided> {
    app.world_mut().get_resource_or_init()
}

/// Run condition: the scene has measures of plugins.
pub(super) fn has_measures(named: Res<NamedMeasures>) -> bool {
    named.list.iter().any(|(_, quantity)| matches!(quantity, Some(Quantity::Custom(_))))
}

/// Reads the measures of plugins. Exclusive, because they may be any resource.
pub(super) fn read_measures(world: &mut World) {
    let (named, provided) = (world.resource::<NamedMeasures>(), world.resource::<Provided>());
    let read = |(_, quantity): &(String, Option<Quantity>)| match quantity {
        Some(Quantity::Custom(kind)) => {
            let reading = provided.measures.get(kind.as_str()).and_then(|read| read(world));
            Some(reading.filter(|reading| reading.is_finite()))
        }
        _ => None,
    };
    let found: Vec<Option<Option<f64>>> = named.list.iter().map(read).collect();
    let mut readings = world.resource_mut::<Readings>();
    for (out, found) in readings.0.iter_mut().zip(found) {
        *out = found.unwrap_or(*out);
    }
}
