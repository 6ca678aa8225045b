//! From stage to stage: what begins, what ends, and how the run ends.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::attempt::{Attempt, IncrementStatus};
use clastic_components::body::Velocity;
use clastic_components::bond::Rupture;
use clastic_components::increment::Progress;
use clastic_components::observation::{Measures, Observation};
use clastic_components::particle::Particle;
use clastic_cone::program::ConeSolution;
use clastic_systems::record::{axial_stress_error, take_reference};
use clastic_systems::schedule::Increment;
use clastic_systems::solve_program::Solver;

use super::advice::with_advice;
use super::spawn::WallCatalogue;
use super::{cement, compact, load};
use crate::scene::format::{Scene, Stage, Stop};
use crate::scene::shown::label;

/// The scene's stages and where the run stands among them.
#[derive(Resource, Clone, Debug)]
pub struct Script {
    /// The scene.
    pub scene: Scene,
    /// Whether the stage at [`Progress::stage`] has begun.
    pub begun: bool,
    /// Greatest speed of a particle after the last increment of the stage, m/s.
    pub speed: Option<f64>,
    /// Axial stress of the greatest magnitude in the stage so far, Pa.
    pub peak: f64,
    /// The first collapse.
    pub collapse: Option<Collapse>,
    /// How the run ended, once it has.
    pub outcome: Option<Outcome>,
    /// The stages so far and how they ended; that under way is the last.
    pub ends: Vec<StageEnd>,
}

/// What tells that a specimen has collapsed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CollapsedBy {
    /// A mechanism proves that no forces within the limits balance the loads.
    Proof,
    /// The motion found no rest under constant loads, nor did it in steps half as long.
    Motion,
}

/// How a specimen collapsed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Collapse {
    /// The stage.
    pub stage: String,
    /// Its last increment, of which nothing was committed.
    pub increment: u64,
    /// What tells.
    pub by: CollapsedBy,
    /// The same in words, with how far the motion went.
    pub reason: String,
}

impl Collapse {
    /// The collapse that the last increment found.
    fn found(world: &World, stage: &Stage) -> Self {
        let complaint = &world.resource::<Attempt>().complaint;
        let (by, reason) = if world.resource::<ConeSolution>().certificate.is_some() {
            (CollapsedBy::Proof, "no equilibrium exists: a mechanism proves it".to_owned())
        } else {
            let reason =
                format!("{complaint}; the same in steps half as long; no mechanism proves it");
            (CollapsedBy::Motion, reason)
        };
        let increment = world.resource::<Progress>().increment;
        Self { stage: stage.name().to_owned(), increment, by, reason }
    }
}

/// A stage of a run and how it ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageEnd {
    /// Its name.
    pub stage: String,
    /// Increments that it took, those with parts of a whole increment counted one by one.
    pub increments: u64,
    /// Those of them with the status `capped`.
    pub capped: u64,
    /// What ended it; none while it is under way.
    pub ended_by: Option<EndedBy>,
    /// The condition, as the scene writes it; only with [`EndedBy::Stop`].
    pub stop: Option<Stop>,
}

impl StageEnd {
    /// What must be said of it where increments are capped.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let Self { increments, capped, .. } = self;
        let stage = label(&self.stage);
        match *capped {
            0 => None,
            _ if capped == increments => {
                Some(format!("all {increments} increments of stage {stage} are capped"))
            }
            _ => Some(format!("{capped} of {increments} increments of stage {stage} are capped")),
        }
    }
}

/// What ended a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndedBy {
    /// All its increments were made, the target of a compaction is reached, or it has none.
    AllIncrements,
    /// One of its stop conditions held.
    Stop,
    /// The specimen collapsed.
    Collapse,
    /// An increment was undecided.
    Undecided,
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
            ends: Vec::new(),
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
    Collapsed(
        /// The first of them.
        Collapse,
    ),
    /// An increment could not be solved; nothing of it was committed.
    Undecided {
        /// The increment.
        increment: u64,
        /// Which residual, and what to try.
        message: String,
    },
    /// A stage could not begin as the scene says. All increments before it are committed.
    Refused {
        /// The stage.
        stage: String,
        /// What is wrong with it, and what would be right.
        message: String,
    },
}

/// Takes the world on to the end of the next increment.
///
/// # Panics
/// If a particle of the scene was despawned. Particles are numbered from 0 without a gap, and all tables
/// are indexed by these numbers.
pub fn advance(world: &mut World) -> Step {
    loop {
        let script = world.resource::<Script>();
        if let Some(outcome) = &script.outcome {
            return Step::Finished(outcome.clone());
        }
        let stage = world.resource::<Progress>().stage;
        let Some(stage) = script.scene.stages.get(stage).cloned() else {
            let outcome = match script.collapse.clone() {
                Some(collapse) => Outcome::Collapsed(collapse),
                None => Outcome::Completed,
            };
            world.resource_mut::<Script>().outcome = Some(outcome);
            continue;
        };
        if !script.begun {
            // Before anything of the stage is done: who resumes with another stage begins it afresh.
            if let Stage::Load(load) = &stage
                && let Some(message) = load::selects_nothing(world, load)
            {
                let stage = load.name.clone();
                world.resource_mut::<Script>().outcome = Some(Outcome::Refused { stage, message });
                continue;
            }
            begin(world, &stage);
        }
        let progress = world.resource::<Progress>();
        if progress.is_over() {
            end(world, &stage);
            continue;
        }
        assert_no_particle_is_gone(world);
        Before::take(world);
        // Nobody else calls `Messages::update` where no app runs.
        world.resource_mut::<Messages<Rupture>>().update();
        world.run_schedule(Increment);
        after_increment(world, &stage);
        return Step::Increment;
    }
}

/// See [`advance`].
fn assert_no_particle_is_gone(world: &mut World) {
    let Some(catalogue) = world.get_resource::<WallCatalogue>() else { return };
    let expected = catalogue.first as usize;
    let found = world.query_filtered::<(), With<Particle>>().iter(world).count();
    assert!(
        found >= expected,
        "the scene has {expected} particles, and {found} are left in the world: a particle must not be \
         despawned; hold it, or move it away from the others"
    );
}

fn begin(world: &mut World, stage: &Stage) {
    {
        let mut progress = world.resource_mut::<Progress>();
        progress.stage_name = stage.name().to_owned();
        progress.done = 0.0;
        progress.total = 0.0;
        progress.fraction = 1.0;
        progress.tried = 1.0;
        progress.relaxing = false;
        let index = progress.stage;
        let mut script = world.resource_mut::<Script>();
        script.begun = true;
        let name = stage.name().to_owned();
        let end = StageEnd { stage: name, increments: 0, capped: 0, ended_by: None, stop: None };
        script.ends.push(end);
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
}

fn end(world: &mut World, stage: &Stage) {
    if let Stage::Compact(_) = stage {
        compact::end(world);
    }
    world.resource_mut::<Progress>().stage += 1;
    let mut script = world.resource_mut::<Script>();
    script.begun = false;
    if let Some(end) = script.ends.last_mut() {
        end.ended_by.get_or_insert(EndedBy::AllIncrements);
    }
}

/// Looks at how the increment ended and at the stage's stop conditions.
fn after_increment(world: &mut World, stage: &Stage) {
    let (status, complaint) = {
        let attempt = world.resource::<Attempt>();
        (attempt.status, attempt.complaint.clone())
    };
    let increment = world.resource::<Progress>().increment;
    let mut held = None;
    let ended_by = match status {
        IncrementStatus::Solved | IncrementStatus::Capped => {
            if !world.resource::<Observation>().in_avalanche {
                held = stopped(world, stage);
            }
            // A stage does not end before its last avalanche has.
            if world.resource::<Progress>().relaxing {
                held = None;
            }
            held.map(|_| EndedBy::Stop)
        }
        IncrementStatus::Collapsed => {
            let collapse = Collapse::found(world, stage);
            world.resource_mut::<Script>().collapse.get_or_insert(collapse);
            Some(EndedBy::Collapse)
        }
        IncrementStatus::Undecided => {
            let message = with_advice(world, stage, &complaint);
            world.resource_mut::<Script>().outcome =
                Some(Outcome::Undecided { increment, message });
            Some(EndedBy::Undecided)
        }
    };
    if let Some(end) = world.resource_mut::<Script>().ends.last_mut() {
        end.increments += 1;
        end.capped += u64::from(status == IncrementStatus::Capped);
        (end.ended_by, end.stop) = (ended_by, held);
    }
    if matches!(ended_by, Some(EndedBy::Stop | EndedBy::Collapse)) {
        load::end_early(world);
        let mut progress = world.resource_mut::<Progress>();
        progress.done = progress.total;
        progress.relaxing = false;
    }
}

/// The error of the axial stress that `acceptance.residual` allows, Pa.
fn error_of_stress(world: &mut World) -> f64 {
    world.run_system_cached(axial_stress_error).ok().flatten().unwrap_or(0.0)
}

/// The first stop condition of the stage that is met.
fn stopped(world: &mut World, stage: &Stage) -> Option<Stop> {
    let Stage::Load(load) = stage else { return None };
    let observation = world.resource::<Observation>();
    let (strain, stress) = (observation.axial_strain, observation.axial_stress);
    let time = world.resource::<Progress>().time;
    let mut velocities = world.query::<&Velocity>();
    let greatest = velocities.iter(world).map(|v| v.0.length()).fold(0.0, f64::max);
    let mut script = world.resource_mut::<Script>();
    let last = script.speed.replace(greatest);
    if let Some(stress) = stress.filter(|s| s.abs() > script.peak.abs()) {
        script.peak = stress;
    }
    // In a tension test the peak is negative.
    let (peak, sign) = (script.peak.abs(), script.peak.signum());
    load.stop.iter().copied().find(|stop| match *stop {
        // Strains are sums of increments: the last bits must not cost one more of them.
        Stop::AxialStrain(limit) => strain
            .is_some_and(|e| if limit < 0.0 { e <= limit + 1e-12 } else { e >= limit - 1e-12 }),
        // A drop that is no more than the error of the stress may be round-off.
        Stop::StressDrop(fraction) => {
            stress.is_some_and(|s| peak > 0.0 && sign * s < fraction * peak)
                && (1.0 - fraction) * peak > error_of_stress(world)
        }
        Stop::Time(limit) => time >= limit * (1.0 - 1e-12),
        // What begins to fall is slow too: at rest nothing gets faster.
        Stop::Rest(speed) => greatest < speed && last.is_some_and(|last| greatest <= last),
    })
}
