//! From stage to stage: what begins, what ends, and how the run ends.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, IncrementStatus};
use clastic_components::body::Velocity;
use clastic_components::bond::Rupture;
use clastic_components::increment::Progress;
use clastic_components::observation::{Measures, Observation};
use clastic_systems::record::take_reference;
use clastic_systems::schedule::{ControlWalls, Increment};
use clastic_systems::solve_program::Solver;

use super::{cement, compact, load};
use crate::scene::format::{Scene, Stage, Stop};

/// The scene's stages and where the run stands among them.
#[derive(Resource, Clone, Debug)]
pub struct Script {
    /// The scene.
    pub scene: Scene,
    /// Whether the stage at [`Progress::stage`] has begun.
    pub begun: bool,
    /// Greatest speed of a particle after the last increment of the stage, m/s.
    pub speed: Option<f64>,
    /// Greatest axial stress of the stage so far, Pa.
    pub peak: f64,
    /// The first collapse: stage and increment.
    pub collapse: Option<(String, u64)>,
    /// How the run ended, once it has.
    pub outcome: Option<Outcome>,
}

impl Script {
    /// The script of a scene, before its first stage.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self {
            scene: scene.clone(),
            begun: false,
            speed: None,
            peak: 0.0,
            collapse: None,
            outcome: None,
        }
    }

    /// Index of the stage at whose start strains are zero.
    #[must_use]
    pub fn reference_stage(&self) -> usize {
        let name = self.scene.measures.reference_stage.as_ref();
        name.and_then(|name| self.scene.stages.iter().position(|s| s.name() == name))
            .unwrap_or(self.scene.stages.len().saturating_sub(1))
    }
}

impl Stage {
    /// Name of the stage.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Compact(s) => &s.name,
            Self::Cement(s) => &s.name,
            Self::Load(s) => &s.name,
        }
    }
}

/// What an increment changes even where it stalls, as it was before: the state of a stalled run is
/// the one before that increment.
#[derive(Resource, Clone, Debug, Default)]
pub struct Before {
    /// How far the run had come.
    pub progress: Progress,
    /// The record of the increment before.
    pub observation: Observation,
    /// Memory of the solver.
    pub solver: Vec<[f64; 3]>,
}

impl Before {
    fn take(world: &mut World) {
        let mut before = world.remove_resource::<Self>().unwrap_or_default();
        before.progress.clone_from(world.resource::<Progress>());
        before.observation.clone_from(world.resource::<Observation>());
        // Tables of the size of the last increment's: nothing is allocated.
        before.solver.clear();
        if let Some(solver) = world.get_resource::<Solver>() {
            before.solver.extend_from_slice(solver.0.memory());
        }
        world.insert_resource(before);
    }
}

/// What one call of [`advance`] did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// An increment ended; [`Observation`] holds its record.
    Increment,
    /// There is nothing left to do.
    Finished(Outcome),
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All stages ran to their end.
    Completed,
    /// All stages ran, and in one of them the specimen collapsed: a result.
    Collapsed {
        /// The first stage that ended so.
        stage: String,
        /// Its last increment.
        increment: u64,
    },
    /// An increment could not be solved; nothing of it was committed.
    Stalled {
        /// The increment.
        increment: u64,
        /// Which residual, and what to try.
        message: String,
    },
}

/// Takes the world on to the end of the next increment.
pub fn advance(world: &mut World) -> Step {
    loop {
        let script = world.resource::<Script>();
        if let Some(outcome) = &script.outcome {
            return Step::Finished(outcome.clone());
        }
        let stage = world.resource::<Progress>().stage;
        let Some(stage) = script.scene.stages.get(stage).cloned() else {
            let outcome = match script.collapse.clone() {
                Some((stage, increment)) => Outcome::Collapsed { stage, increment },
                None => Outcome::Completed,
            };
            world.resource_mut::<Script>().outcome = Some(outcome);
            continue;
        };
        if !script.begun {
            begin(world, &stage);
        }
        let progress = world.resource::<Progress>();
        if progress.done >= progress.total {
            end(world, &stage);
            continue;
        }
        Before::take(world);
        // Nobody else calls `Messages::update` where no app runs.
        world.resource_mut::<Messages<Rupture>>().update();
        world.run_schedule(Increment);
        after_increment(world, &stage);
        return Step::Increment;
    }
}

fn begin(world: &mut World, stage: &Stage) {
    {
        let mut progress = world.resource_mut::<Progress>();
        progress.stage_name = stage.name().to_owned();
        progress.done = 0.0;
        progress.total = 0.0;
        progress.fraction = 1.0;
        let index = progress.stage;
        let mut script = world.resource_mut::<Script>();
        script.begun = true;
        script.peak = 0.0;
        script.speed = None;
        if index == script.reference_stage() {
            world.resource_mut::<Measures>().reference_stage = index;
        }
    }
    match stage {
        Stage::Compact(s) => compact::begin(world, s),
        Stage::Cement(s) => cement::cement(world, s),
        Stage::Load(s) => load::begin(world, s),
    }
    load::resolve_measures(world);
    let (index, reference) =
        (world.resource::<Progress>().stage, world.resource::<Script>().reference_stage());
    if index == reference {
        let _ = world.run_system_cached(take_reference);
    }
    world.run_schedule(ControlWalls);
}

fn end(world: &mut World, stage: &Stage) {
    if let Stage::Compact(_) = stage {
        compact::end(world);
    }
    world.resource_mut::<Progress>().stage += 1;
    world.resource_mut::<Script>().begun = false;
}

/// Looks at how the increment ended and at the stage's stop conditions.
fn after_increment(world: &mut World, stage: &Stage) {
    let (status, complaint) = {
        let attempt = world.resource::<Attempt>();
        (attempt.status, attempt.complaint.clone())
    };
    let increment = world.resource::<Progress>().increment;
    let over = match status {
        IncrementStatus::Solved | IncrementStatus::Capped => stopped(world, stage),
        IncrementStatus::Collapsed => {
            let mut script = world.resource_mut::<Script>();
            script.collapse.get_or_insert((stage.name().to_owned(), increment));
            true
        }
        IncrementStatus::Locked | IncrementStatus::Stalled => {
            let message = complaint_with_advice(world, stage, status, &complaint);
            world.resource_mut::<Script>().outcome = Some(Outcome::Stalled { increment, message });
            return;
        }
    };
    if over {
        let mut progress = world.resource_mut::<Progress>();
        progress.done = progress.total;
    }
}

fn complaint_with_advice(
    world: &World,
    stage: &Stage,
    status: IncrementStatus,
    complaint: &str,
) -> String {
    let increment = world.resource::<Progress>().increment;
    let name = stage.name();
    let advice = match (status, stage) {
        (IncrementStatus::Locked, Stage::Compact(_)) => {
            "the packing is jammed before its target: aim for a greater height or porosity, or a smaller step"
        }
        (IncrementStatus::Locked, _) => {
            "rigid bodies are forced into each other: give the contacts a stiffness or free a wall"
        }
        _ => {
            "smaller increments (more `increments`, smaller displacements), a greater `acceptance.halvings`, \
             or, if grains are thrown, walls that hold the specimen"
        }
    };
    format!("increment {increment} of stage `{name}`: {complaint}; try: {advice}")
}

/// Whether a stop condition of the stage is met.
fn stopped(world: &mut World, stage: &Stage) -> bool {
    let Stage::Load(load) = stage else { return false };
    let observation = world.resource::<Observation>();
    let (strain, stress) = (observation.axial_strain, observation.axial_stress);
    let time = world.resource::<Progress>().time;
    let mut velocities = world.query::<&Velocity>();
    let greatest = velocities.iter(world).map(|v| v.0.length()).fold(0.0, f64::max);
    let mut script = world.resource_mut::<Script>();
    let last = script.speed.replace(greatest);
    if let Some(stress) = stress {
        script.peak = script.peak.max(stress);
    }
    let peak = script.peak;
    load.stop.iter().any(|stop| match *stop {
        // Strains are sums of increments: the last bits must not cost one more of them.
        Stop::AxialStrain(limit) => strain
            .is_some_and(|e| if limit < 0.0 { e <= limit + 1e-12 } else { e >= limit - 1e-12 }),
        Stop::StressDrop(fraction) => stress.is_some_and(|s| peak > 0.0 && s < fraction * peak),
        Stop::Time(limit) => time >= limit * (1.0 - 1e-12),
        // What begins to fall is slow too: at rest nothing gets faster.
        Stop::Rest(speed) => greatest < speed && last.is_some_and(|last| greatest <= last),
    })
}
