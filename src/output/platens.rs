//! Do the platens of a test span its specimen?
//!
//! The platens do the work of stress times strain on the volume of the specimen if the length of the stress
//! times the distance of the platens is its area. Only then is stress over strain a modulus.
//! It is none of a disk between jaws, whose stress is the tension in its middle (twice the area), nor of
//! a beam.

use clastic_components::observation::{MeasureLength, Measures, StrainMeasure, StressMeasure};

use super::porosity::total;
use super::prepared::Prepared;

/// Length of the axial stress times the distance of the platens, over the area of a specimen of this
/// porosity. `None` unless both are measured on walls and the length is given.
pub(super) fn spanned(measures: &Measures, start: &Prepared, porosity: f64) -> Option<f64> {
    let (
        Some(StrainMeasure::Walls(..)),
        Some(StressMeasure::Walls { length: MeasureLength::Fixed(length), .. }),
    ) = (&measures.axial_strain, &measures.axial_stress)
    else {
        return None;
    };
    let area = total(&start.rows) / (1.0 - porosity);
    Some(length * measures.reference?[0] / area)
}

/// Whether that is the volume of the specimen: nearer to it than to twice or half of it.
pub(super) fn span(spanned: f64) -> bool {
    (std::f64::consts::FRAC_1_SQRT_2..std::f64::consts::SQRT_2).contains(&spanned)
}
