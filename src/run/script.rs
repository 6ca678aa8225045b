//! The script of a run: its stages, where the run stands among them, and how each ended.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::scene::format::{Scene, Stage, Stop};
use crate::scene::shown::label;

/// The scene's stages and where the run stands among them.
#[derive(Resource, Clone, Debug)]
pub struct Script {
    /// The scene.
    pub scene: Scene,
    /// Whether the stage at [`Progress::stage`](clastic_components::increment::Progress::stage) has begun.
    pub begun: bool,
    /// Maximum speed of a particle after the last increment of the stage, m/s.
    pub speed: Option<f64>,
    /// Axial stress of the maximum magnitude in the stage so far, Pa.
    pub peak: f64,
    /// The first collapse.
    pub collapse: Option<Collapse>,
    /// How the run ended, once it has.
    pub outcome: Option<Outcome>,
    /// The stages so far and how they ended; that under way is the last.
    pub ends: Vec<StageEnd>,
    /// Whether the stage is to end with this increment: set by systems in
    /// [`StageSystems::Stop`](super::plugin::StageSystems::Stop).
    pub stop: bool,
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
            stop: false,
        }
    }

    /// The stage at an index; `None` past the last one.
    #[must_use]
    pub fn stage(&self, index: usize) -> Option<&Stage> {
        self.scene.stages.get(index)
    }

    /// Index of the stage at whose start strains are zero.
    #[must_use]
    pub fn reference_stage(&self) -> usize {
        let name = self.scene.measures.reference_stage.as_ref();
        name.and_then(|name| self.scene.stages.iter().position(|s| s.name() == name))
            .unwrap_or(self.scene.stages.len().saturating_sub(1))
    }
}

/// What one run of [`Advance`](clastic_systems::stepping::Advance) did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// An increment ended; [`Observation`](clastic_components::observation::Observation) holds its record.
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
    /// Nothing goes on any more, for a reason that is not the specimen's: an increment could not be
    /// written, or a plugin has inserted [`Halted`](clastic_systems::stepping::Halted).
    Halted(
        /// What happened.
        String,
    ),
    /// A stage could not begin as the scene says. All increments before it are committed.
    Refused {
        /// The stage.
        stage: String,
        /// What is wrong with it, and what would be right.
        message: String,
    },
}
