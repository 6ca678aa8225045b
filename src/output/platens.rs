//! Do the platens of a test span its specimen?
//!
//! The platens do the work of stress times strain on the volume of the specimen if the length of the stress
//! times the distance of the platens is its area. Only then is stress over strain a modulus.
//! It is none of a disk between jaws, whose stress is the tension in its middle (twice the area), nor of
//! a beam.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use clastic_components::observation::{MeasureLength, Measures, StrainMeasure, StressMeasure};

use super::porosity::total;
use super::prepared::Prepared;

/// Whether the length of the axial stress times the distance of the platens is nearer to the area of a
/// specimen of this porosity than to twice or half of it. Platens that do not measure both are not judged.
pub(super) fn span(measures: &Measures, start: &Prepared, porosity: f64) -> bool {
    let (
        Some(StrainMeasure::Walls(..)),
        Some(StressMeasure::Walls { length: MeasureLength::Fixed(length), .. }),
        Some([distance, _]),
    ) = (&measures.axial_strain, &measures.axial_stress, measures.reference)
    else {
        return true;
    };
    let area = total(&start.rows) / (1.0 - porosity);
    (FRAC_1_SQRT_2..SQRT_2).contains(&(length * distance / area))
}
