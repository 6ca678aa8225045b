//! Errors of measures. A change below the error does not count.

use bevy_ecs::prelude::*;

use clastic_components::measure::{NamedMeasures, Quantity};
use clastic_components::observation::Measures;
use clastic_systems::measures::stress::stress_error;

/// Error of a measure. A strain is a sum of increments over a length, and has round-off of this
/// size; a stress has the error that `acceptance.residual` allows.
pub(super) fn error_of(world: &mut World, name: &str) -> f64 {
    let measures = world.resource::<Measures>();
    let stress = match name {
        "axial_strain" | "lateral_strain" => return STRAIN_ERROR,
        "axial_stress" => measures.axial_stress.clone(),
        "lateral_stress" => measures.lateral_stress.clone(),
        _ => {
            let named = world.resource::<NamedMeasures>();
            let found = named.list.iter().find(|(measure, _)| measure == name);
            match found.and_then(|(_, quantity)| quantity.as_ref()) {
                Some(Quantity::Strain(_) | Quantity::VolumetricStrain) => return STRAIN_ERROR,
                Some(Quantity::Stress(stress)) => Some(stress.clone()),
                _ => None,
            }
        }
    };
    let error = stress.map(|stress| world.run_system_cached_with(stress_error, stress));
    error.and_then(Result::ok).unwrap_or(0.0)
}

/// Round-off of a strain.
const STRAIN_ERROR: f64 = 1e-12;
