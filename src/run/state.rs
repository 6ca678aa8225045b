//! State of a scene in the state of a world: the progress of the run in its stages.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_systems::gather_bodies::gather_bodies;
use clastic_systems::material_names::{MATERIALS, MaterialNames};
use clastic_systems::measures::{NAMED, NamedState};
use clastic_systems::membranes::{MEMBRANES, MembraneStates, renew_shapes};
use clastic_systems::record::OBSERVATION;
use clastic_systems::schedule::PROGRESS;
use clastic_systems::solve_program::{SOLVER_MEMORY, Solver};
use clastic_systems::state::expect_empty;
pub use clastic_systems::state::{StateError, StateOf, WorldState};
use clastic_systems::stepping::EndOfRun;
use clastic_systems::wall_states::{ControlStates, WALL_CONTROL};

use super::resolve_measures::resolve_measures;
pub use super::script::ScriptState;
use super::script::{Outcome, Script};
use super::settings::insert_settings;
use super::spawn::insert_script;
use super::walls::WallCatalogue;
use crate::scene::format::Scene;
use crate::scene::stored_state::rows;
use crate::scene::{StoredSpecimen, StoredState};

/// Name of [`ScriptState`] in a state.
pub(crate) const SCRIPT: &str = "script";
/// Name of the [`WallCatalogue`] in a state.
pub(crate) const WALL_CATALOGUE: &str = "walls.catalogue";

impl StateOf for ScriptState {
    fn take(world: &mut World) -> Option<Self> {
        let script = world.get_resource::<Script>()?;
        let mut state = script.state.clone();
        // Nothing of an undecided increment was committed, so a resumed run tries it again.
        if let Some(end) = state.ends.last_mut().filter(|_| undecided(script)) {
            end.rows -= 1;
            end.ended_by = None;
        }
        Some(state)
    }

    fn put(self, world: &mut World) {
        let Some(mut script) = world.get_resource_mut::<Script>() else { return };
        script.state = self;
        // A state lies between two increments: a run that had ended goes on from there.
        script.outcome = None;
        let begun = script.begun;
        world.resource_mut::<EndOfRun>().0 = None;
        if begun {
            resolve_measures(world);
        }
    }
}

fn undecided(script: &Script) -> bool {
    matches!(script.outcome, Some(Outcome::Undecided { .. }))
}

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
pub(crate) fn take_down(
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

/// State of a world that runs a scene, between two increments. After an undecided increment, of
/// which nothing was committed, it is the state before that increment.
///
/// # Errors
/// If a part of it cannot be encoded.
pub fn capture(world: &mut World) -> Result<WorldState, StateError> {
    let mut state = WorldState::capture(world)?;
    if world.get_resource::<Script>().is_some_and(undecided)
        && let Some(before) = world.get_resource::<Before>()
    {
        state.set(PROGRESS, &before.progress)?;
        state.set(OBSERVATION, &before.observation)?;
        let named = world.resource::<NamedMeasures>();
        if !named.list.is_empty() {
            state.set(NAMED, &NamedState::with(named, &before.readings))?;
        }
        // The failed increment has renumbered the tables that are kept by row.
        let mut rows = KeptRows::of(before.rows.clone());
        let bodies = world.resource::<BodyTable>();
        rows.follow(bodies);
        if rows.is_needed() && !before.solver.is_empty() {
            state.set(SOLVER_MEMORY, &rows.table(&before.solver, bodies.ids.len()))?;
        } else {
            state.set(SOLVER_MEMORY, &before.solver)?;
        }
    }
    Ok(state)
}

/// Restores a world that continues from `state` under the settings of `scene`. The world must have
/// the plugins of the captured world and no bodies.
///
/// # Errors
/// Those of [`WorldState::restore`].
pub fn restore(world: &mut World, scene: &Scene, state: &WorldState) -> Result<(), StateError> {
    expect_empty(world)?;
    let WallCatalogue { first, .. } = state.get(WALL_CATALOGUE)?;
    insert_settings(world, scene, first);
    insert_script(world, scene);
    state.restore(world)?;
    // Readers of the world before the next increment need the tables.
    let _ = world.run_system_cached(gather_bodies);
    let _ = world.run_system_cached(renew_shapes);
    Ok(())
}

/// Goes back to a state of this world, as if no increment had been made since. A scene that has
/// ended goes on from there; an app that has stopped needs another
/// [`ClasticRunning`](clastic_systems::stepping::ClasticRunning).
///
/// # Errors
/// Those of [`WorldState::rewind`].
pub fn rewind(world: &mut World, state: &WorldState) -> Result<(), StateError> {
    state.rewind(world)?;
    let _ = world.run_system_cached(gather_bodies);
    let _ = world.run_system_cached(renew_shapes);
    Ok(())
}

/// The part of a state that is needed to resume a run, before a world exists.
#[derive(Clone, Debug, PartialEq)]
pub struct StateView {
    /// Progress of the run.
    pub progress: ClasticProgress,
    /// Whether the stage at [`ClasticProgress::stage`] has begun.
    pub begun: bool,
    /// Whether a stop or a collapse has ended that stage.
    pub ended: bool,
    /// Whether any load is on its way to a target.
    pub ramps: bool,
    /// Particles before the first stage.
    pub specimen: StoredSpecimen,
}

impl StateView {
    /// Extracts the view from a state.
    ///
    /// # Errors
    /// If the state is not that of a run of a scene.
    pub fn of(state: &WorldState) -> Result<Self, StateError> {
        let controls: ControlStates = state.get(WALL_CONTROL)?;
        let loads = state.components::<BodyId, LoadControl>("load_control")?;
        let membranes = match state.bytes(MEMBRANES) {
            Some(_) => state.get::<MembraneStates>(MEMBRANES)?.0,
            None => Vec::new(),
        };
        let materials: MaterialNames = state.get(MATERIALS)?;
        let names: Vec<&String> = materials.0.iter().collect();
        let (rows, indices) = rows(state, "origin", &names)?;
        // Walls follow the particles that the run had at its start.
        let catalogue: WallCatalogue = state.get(WALL_CATALOGUE)?;
        let taken = (catalogue.inherited.unwrap_or_default(), catalogue.membranes);
        let specimen = StoredSpecimen {
            rows,
            indices: indices.max(catalogue.first.into()),
            groups: Vec::new(),
            state: Some(StoredState::of(state, taken, catalogue.rigid, None)?),
        };
        let script: ScriptState = state.get(SCRIPT)?;
        Ok(Self {
            progress: state.get(PROGRESS)?,
            begun: script.begun,
            ended: script.ends.last().is_some_and(|end| end.ended_by.is_some()),
            ramps: controls.0.iter().any(|(_, control, _)| control.is_ramp())
                || membranes.iter().any(|membrane| membrane.pressure.0 != membrane.pressure.1)
                || loads.iter().any(|(_, load)| load.0.iter().any(|(from, to)| from != to)),
            specimen,
        })
    }
}
