//! Measures of a scene: their readings, and the errors of these.

use bevy_ecs::prelude::*;

use clastic_components::measure::{NamedMeasures, Quantity, Readings};
use clastic_components::observation::{Measures, Observation, StrainMeasure, StressMeasure};
use clastic_systems::measures::kept::kept_reading;
use clastic_systems::measures::stress::stress_error;

/// Round-off of a strain.
pub(super) const STRAIN_ERROR: f64 = 1e-12;

/// Place of a measure in the list of those that are no axial or lateral strain or stress.
fn place(world: &World, name: &str) -> Option<usize> {
    world.resource::<NamedMeasures>().list.iter().position(|(measure, _)| measure == name)
}

/// Reading of a measure of the scene after the last increment; `None` if it is not defined.
pub fn reading(world: &World, name: &str) -> Option<f64> {
    let observation = world.resource::<Observation>();
    match name {
        "axial_strain" => observation.axial_strain,
        "lateral_strain" => observation.lateral_strain,
        "axial_stress" => observation.axial_stress,
        "lateral_stress" => observation.lateral_stress,
        _ => world.resource::<Readings>().0.get(place(world, name)?).copied().flatten(),
    }
}

/// What a measure of the scene reads, and the distance to which a strain refers, m.
fn quantity(world: &World, name: &str) -> Option<(Quantity, Option<f64>)> {
    let measures = world.resource::<Measures>();
    let strain = |measure: &Option<StrainMeasure>, k: usize| {
        Some((Quantity::Strain((*measure)?), measures.reference.map(|reference| reference[k])))
    };
    let stress = |measure: &Option<StressMeasure>| Some((Quantity::Stress(measure.clone()?), None));
    match name {
        "axial_strain" => strain(&measures.axial_strain, 0),
        "lateral_strain" => strain(&measures.lateral_strain, 1),
        "axial_stress" => stress(&measures.axial_stress),
        "lateral_stress" => stress(&measures.lateral_stress),
        _ => {
            let (named, k) = (world.resource::<NamedMeasures>(), place(world, name)?);
            Some((named.list[k].1.clone()?, named.references.get(k).copied().flatten()))
        }
    }
}

/// Reading of a measure of the scene between two increments, from what a saved state has; `None` if
/// it is not defined, or needs more than that.
pub(super) fn kept(world: &mut World, name: &str) -> Option<f64> {
    let (quantity, reference) = quantity(world, name)?;
    kept_reading(world, &quantity, reference)
}

/// Error of a measure, below which a change does not count. A strain is a sum of increments over a
/// length, and has round-off of this size; a stress has the error that `acceptance.residual` allows.
pub(super) fn error_of(world: &mut World, name: &str) -> f64 {
    match quantity(world, name) {
        Some((Quantity::Strain(_) | Quantity::VolumetricStrain, _)) => STRAIN_ERROR,
        Some((Quantity::Stress(stress), _)) => {
            world.run_system_cached_with(stress_error, stress).unwrap_or(0.0)
        }
        _ => 0.0,
    }
}
