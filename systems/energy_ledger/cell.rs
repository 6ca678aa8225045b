//! The body of a periodic cell in the ledger.

use clastic_components::body::Ramp;
use clastic_components::cell::{CellControl, PeriodicCell};
use clastic_components::contact::BodyTable;
use clastic_components::increment::{ClasticAnalysis, ClasticProgress};

/// The cell after the displacement of its body (m, m, rad).
pub fn deformed(bodies: &BodyTable, moved: Option<[f64; 3]>) -> Option<PeriodicCell> {
    let cell = bodies.cell?;
    Some(moved.map_or(cell, |moved| cell.deformed(moved, bodies.mean_radius)))
}

/// Loads of the body in the whole increment that was just committed: the stresses of the controls
/// on the area at its start. Zero along an imposed strain and without a cell.
pub fn loads(
    bodies: &BodyTable,
    analysis: &ClasticAnalysis,
    progress: &ClasticProgress,
) -> [Ramp; 3] {
    let Some(cell) = &bodies.cell else { return [Ramp::default(); 3] };
    let start = ClasticProgress { done: progress.done - progress.fraction, ..progress.clone() };
    let factors = cell.loads_of_controls(bodies.mean_radius, analysis.thickness);
    [0, 1, 2].map(|k| match cell.controls[k] {
        CellControl::Imposed(_) => Ramp::default(),
        CellControl::Stress { from, to } => start.ramp(from, to).times(factors[k]),
    })
}
