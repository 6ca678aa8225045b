//! Do the platens of a test span its specimen?
//!
//! Platens do the work of stress times strain on the volume of the specimen if the length of their stress times their
//! distance is its area. Only then is stress over strain a modulus, and one stress over another an angle. It is none of
//! a disk between jaws, whose stress is the tension in its middle (twice the area), of a beam, or of a footing.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use bevy_ecs::prelude::Query;
use clastic_components::observation::{
    MeasureArea, MeasureLength, Measures, StrainMeasure, StressMeasure,
};
use clastic_components::wall::Wall;

use super::porosity::{extent, total};
use super::prepared::Prepared;

/// Whether the area for which axial and lateral stress stand, where the scene gives it in numbers, is nearer to
/// that of a specimen of this porosity than to twice or half of it.
pub(super) fn span(
    measures: &Measures,
    walls: &Query<&Wall>,
    Prepared { rows, .. }: &Prepared,
    porosity: f64,
) -> bool {
    let Measures { axial_strain, lateral_strain, axial_stress, lateral_stress, reference } =
        measures;
    let pairs = [(axial_strain, axial_stress), (lateral_strain, lateral_stress)];
    (0..2).zip(pairs).all(|(k, (strain, stress))| {
        let of_stress = match stress {
            Some(StressMeasure::Walls { walls: on, length: MeasureLength::Fixed(length) }) => {
                let normal = on.first().and_then(|wall| walls.get(*wall).ok()).map(Wall::inward);
                let distance = match (strain, reference) {
                    (Some(StrainMeasure::Walls(..)), Some(distances)) => Some(distances[k]),
                    _ => normal.and_then(|normal| extent(rows, normal)),
                };
                distance.map(|distance| length * distance)
            }
            Some(StressMeasure::Average { area: MeasureArea::Fixed(area), .. }) => Some(*area),
            _ => None,
        };
        let area = total(rows) / (1.0 - porosity);
        of_stress.is_none_or(|of_stress| (FRAC_1_SQRT_2..SQRT_2).contains(&(of_stress / area)))
    })
}
