//! Caption of a picture of an increment.

use clastic_components::observation::Observation;

/// Increment, stage and axial strain.
#[must_use]
pub fn caption(o: &Observation) -> String {
    let strain =
        o.axial_strain.map(|e| format!(", axial strain {:.3} % (contraction positive)", 100.0 * e));
    format!("increment {} of stage {}{}", o.increment, o.stage, strain.unwrap_or_default())
}
