//! Measures of a scene: their readings, and the values that plugins provide.

use std::collections::BTreeMap;

use bevy_app::App;
use bevy_ecs::prelude::*;

use clastic_components::measure::{NamedMeasures, Quantity, Readings};
use clastic_components::observation::{Measures, Observation, StrainMeasure, StressMeasure};
use clastic_systems::measures::kept::kept_reading;

use crate::scene::format as scene;

/// Reads the measure of a plugin.
type Read = Box<dyn Fn(&World) -> Option<f64> + Send + Sync>;

/// The measures that plugins provide, by name.
#[derive(Resource, Default)]
pub struct MeasureKinds(BTreeMap<&'static str, Read>);

impl MeasureKinds {
    /// The names.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.keys().copied()
    }

    /// Why a scene cannot run; `None` if plugins provide all its custom measures.
    #[must_use]
    pub fn refusal(&self, scene: &scene::Scene) -> Option<String> {
        let missing = scene.measures.iter().find_map(|measure| match &measure.of {
            scene::Quantity::Custom(kind) => {
                (!self.0.contains_key(kind.as_str())).then_some((&measure.name, kind))
            }
            _ => None,
        });
        let (name, kind) = missing?;
        let known: Vec<_> = self.names().collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        Some(format!(
            "measure `{name}` cannot be read: no plugin of this program provides the measure `{kind}`; \
             it provides {known}"
        ))
    }
}

/// Registers the measures that a plugin provides.
pub trait ProvideMeasure {
    /// Registers a measure: a scene refers to it by `Custom(name)`. It is read from the resource
    /// `R` after every increment, before the systems of
    /// [`StageSystems::Stop`](super::plugin::StageSystems::Stop). Without the resource, or with
    /// `None`, it is not defined.
    fn provide_measure<R: Resource>(
        &mut self,
        name: &'static str,
        read: impl Fn(&R) -> Option<f64> + Send + Sync + 'static,
    ) -> &mut Self;
}

impl ProvideMeasure for App {
    fn provide_measure<R: Resource>(
        &mut self,
        name: &'static str,
        read: impl Fn(&R) -> Option<f64> + Send + Sync + 'static,
    ) -> &mut Self {
        let read = move |world: &World| world.get_resource::<R>().and_then(&read);
        self.world_mut().get_resource_or_init::<MeasureKinds>().0.insert(name, Box::new(read));
        self
    }
}

/// Reads the measures of plugins. Exclusive, because they may be any resource.
pub(super) fn read_custom(world: &mut World) {
    let wanted: Vec<(usize, String)> = world
        .resource::<NamedMeasures>()
        .list
        .iter()
        .enumerate()
        .filter_map(|(k, (_, quantity))| match quantity {
            Some(Quantity::Custom(kind)) => Some((k, kind.clone())),
            _ => None,
        })
        .collect();
    for (k, kind) in wanted {
        let read = world.resource::<MeasureKinds>().0.get(kind.as_str());
        let reading = read.and_then(|read| read(world)).filter(|reading| reading.is_finite());
        if let Some(out) = world.resource_mut::<Readings>().0.get_mut(k) {
            *out = reading;
        }
    }
}

/// Reading of a measure of the scene after the last increment; `None` if it is not defined.
#[must_use]
pub fn reading(world: &World, name: &str) -> Option<f64> {
    let observation = world.resource::<Observation>();
    match name {
        "axial_strain" => observation.axial_strain,
        "lateral_strain" => observation.lateral_strain,
        "axial_stress" => observation.axial_stress,
        "lateral_stress" => observation.lateral_stress,
        _ => {
            let list = &world.resource::<NamedMeasures>().list;
            let k = list.iter().position(|(measure, _)| measure == name)?;
            world.resource::<Readings>().0.get(k).copied().flatten()
        }
    }
}

/// Reading of a measure of the scene between two increments, from what a saved state has; `None` if
/// it is not defined, or not by that alone.
pub(super) fn kept(world: &mut World, name: &str) -> Option<f64> {
    let measures = world.resource::<Measures>();
    let strain = |measure: &Option<StrainMeasure>, k: usize| {
        Some((Quantity::Strain((*measure)?), Some(measures.reference?[k])))
    };
    let stress = |measure: &Option<StressMeasure>| Some((Quantity::Stress(measure.clone()?), None));
    let (quantity, reference) = match name {
        "axial_strain" => strain(&measures.axial_strain, 0),
        "lateral_strain" => strain(&measures.lateral_strain, 1),
        "axial_stress" => stress(&measures.axial_stress),
        "lateral_stress" => stress(&measures.lateral_stress),
        _ => {
            let named = world.resource::<NamedMeasures>();
            let k = named.list.iter().position(|(measure, _)| measure == name)?;
            let quantity = named.list[k].1.clone()?;
            Some((quantity, named.references.get(k).copied().flatten()))
        }
    }?;
    kept_reading(world, &quantity, reference)
}
