//! Key results that are found while a run is written.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::contact_history::ContactHistory;
use clastic_components::increment::ClasticProgress;

use crate::run::key_results::{MechanismRecord, Results};
use crate::run::stages::Script;

/// A packing that was not jammed: it settled in the first increment after its compaction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Settled {
    /// Porosity after the compaction, of the box around the disks, or of the periodic cell.
    pub porosity_before: f64,
    /// The same after the first increment that followed.
    pub porosity_after: f64,
}

/// Key results that only a run with output has. They do not belong to
/// [`KeyResults`](crate::run::key_results::KeyResults), because output must not change the state of
/// a run.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Porosity at the start of the reference stage.
    pub porosity: Option<f64>,
    /// Whether the platens [span](super::platens) more or less than the specimen there.
    pub overhang: bool,
    /// How a packing settled, the last one if several did.
    pub settled: Option<Settled>,
    /// The first collapse that has a mechanism.
    pub mechanism: Option<MechanismRecord>,
    /// Number of avalanches.
    pub avalanches: usize,
    /// Number of bonds broken in the largest one.
    pub largest_avalanche: usize,
    /// Largest normal force of a contact from the reference stage on, N.
    pub largest_force: f64,
}

/// Follows the largest force of the test. Forces of a preparation may have no meaning.
pub(super) fn see_forces(
    contacts: Res<ContactHistory>,
    progress: Res<ClasticProgress>,
    script: Res<Script>,
    mut found: ResMut<Found>,
) {
    if progress.stage >= script.reference_stage() {
        let forces = contacts.0.iter().map(|contact| contact.p.abs());
        found.largest_force = forces.fold(found.largest_force, f64::max);
    }
}

impl Found {
    /// Adds these results to those of the run. `pours` says whether grains pour in.
    pub fn complete(&self, mut results: Results, pours: bool) -> Results {
        if self.porosity.is_some() {
            results.not_defined.remove("porosity");
        } else if pours {
            results.not_defined.insert("porosity".to_owned(), POURED.to_owned());
        }
        if self.overhang {
            let r = &mut results;
            let moduli = [
                ("youngs_modulus_pa", &mut r.youngs_modulus_pa),
                ("youngs_modulus_secant_half_peak_pa", &mut r.youngs_modulus_secant_half_peak_pa),
                ("poissons_ratio", &mut r.poissons_ratio),
                ("friction_angle_rad", &mut r.friction_angle_rad),
            ];
            for (name, result) in moduli {
                if result.take().is_some() {
                    r.not_defined.insert(name.to_owned(), NOT_SPANNED.to_owned());
                }
            }
        }
        Results {
            porosity: self.porosity,
            mechanism: self.mechanism,
            avalanches: self.avalanches,
            largest_avalanche: self.largest_avalanche,
            ..results
        }
    }
}

/// Why a test whose platens do not span the specimen has neither modulus nor friction angle.
const NOT_SPANNED: &str = "the area of an average stress, or the length of a stress of walls times their distance, \
                           is not the area of the specimen, so that the stress is not that of the specimen";

/// Why a scene in which grains pour in has no porosity.
const POURED: &str = "grains pour in, and the box around grains that fall is no specimen; measure \
                      `Porosity` of a region";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::key_results::KeyResults;

    #[test]
    fn a_porosity_that_was_found_is_not_called_undefined() {
        let results = || KeyResults::new(false).results();
        let found = Found { porosity: Some(0.2), ..Found::default() };
        assert!(Found::default().complete(results(), false).not_defined.contains_key("porosity"));
        let complete = found.complete(results(), false);
        assert_eq!(complete.porosity, Some(0.2));
        assert!(!complete.not_defined.contains_key("porosity"));
        let poured = Found::default().complete(results(), true);
        assert!(poured.not_defined["porosity"].contains("region"), "{poured:?}");
    }
}
