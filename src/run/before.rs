//! State that even an undecided increment changes.

use bevy_ecs::prelude::*;

use clastic_components::body::BodyId;
use clastic_components::contact_history::KeptRows;
use clastic_components::increment::ClasticProgress;
use clastic_components::measure::Readings;
use clastic_components::observation::Observation;
use clastic_systems::solve_program::Solver;

/// Copy of the state that even an undecided increment changes, taken before the increment. The
/// state of an undecided run is that before the increment.
#[derive(Resource, Clone, Debug, Default)]
pub struct Before {
    /// Progress of the run.
    pub progress: ClasticProgress,
    /// Record of the previous increment.
    pub observation: Observation,
    /// Readings of the named measures after the previous increment.
    pub readings: Readings,
    /// Memory of the solver.
    pub solver: Vec<[f64; 3]>,
    /// The bodies of its rows.
    pub rows: Vec<BodyId>,
}

/// Copies the state.
pub fn take_down(
    progress: Res<ClasticProgress>,
    observation: Res<Observation>,
    readings: Res<Readings>,
    solver: Option<Res<Solver>>,
    kept: Res<KeptRows>,
    mut before: ResMut<Before>,
) {
    before.progress.clone_from(&progress);
    before.observation.clone_from(&observation);
    before.readings.clone_from(&readings);
    before.rows.clone_from(&kept.ids);
    // The buffer keeps its size between increments, so nothing is allocated.
    before.solver.clear();
    if let Some(solver) = solver {
        before.solver.extend_from_slice(solver.0.memory());
    }
}
