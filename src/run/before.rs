//! What an increment changes even where it is undecided.

use bevy_ecs::prelude::*;

use clastic_components::body::BodyId;
use clastic_components::contact::KeptRows;
use clastic_components::increment::Progress;
use clastic_components::observation::Observation;
use clastic_systems::solve_program::Solver;

/// What an increment changes even where it is undecided, as it was before: the state of an
/// undecided run is the one before that increment.
#[derive(Resource, Clone, Debug, Default)]
pub struct Before {
    /// How far the run had come.
    pub progress: Progress,
    /// The record of the increment before.
    pub observation: Observation,
    /// Memory of the solver.
    pub solver: Vec<[f64; 3]>,
    /// The bodies of its rows.
    pub rows: Vec<BodyId>,
}

/// Takes it down.
pub fn take_down(
    progress: Res<Progress>,
    observation: Res<Observation>,
    solver: Option<Res<Solver>>,
    kept: Res<KeptRows>,
    mut before: ResMut<Before>,
) {
    before.progress.clone_from(&progress);
    before.observation.clone_from(&observation);
    before.rows.clone_from(&kept.ids);
    // Tables of the size of the last increment's: nothing is allocated.
    before.solver.clear();
    if let Some(solver) = solver {
        before.solver.extend_from_slice(solver.0.memory());
    }
}
