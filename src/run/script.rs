//! Script of a run: its stages, the current stage, and how earlier stages ended.

use std::ops::{Deref, DerefMut};

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::scene::format::{Scene, Stage, Stop};
use crate::text::shown::label;

/// Stages of the scene and state of the run among them.
#[derive(Resource, Clone, Debug)]
pub struct Script {
    /// The scene.
    pub scene: Scene,
    /// What of it is part of the state of the run. Its fields read as those of the script.
    pub state: ScriptState,
    /// Outcome of the run, after it has ended.
    pub outcome: Option<Outcome>,
    /// Whether the stage ends with this increment. Systems in
    /// [`StageSystems::Stop`](super::plugin::StageSystems::Stop) set it.
    pub stop: bool,
}

/// State of a [`Script`] apart from its scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScriptState {
    /// Whether the stage at [`ClasticProgress::stage`](clastic_components::increment::ClasticProgress::stage) has
    /// begun.
    pub begun: bool,
    /// Maximum speed of a particle after the last increment of the stage, m/s.
    pub speed: Option<f64>,
    /// Axial stress with the maximum magnitude in the stage so far, Pa.
    pub peak: f64,
    /// The first collapse.
    pub collapse: Option<Collapse>,
    /// Stages so far with their ends. The last one is the current stage.
    pub ends: Vec<StageEnd>,
}

/// Evidence of a collapse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CollapsedBy {
    /// A mechanism proves that no forces within the limits balance the loads.
    Proof,
    /// The motion did not come to rest under constant loads, nor in steps of half the length.
    Motion,
}

/// How a specimen collapsed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Collapse {
    /// Name of the stage.
    pub stage: String,
    /// Increment of the collapse, of which nothing was committed.
    pub increment: u64,
    /// Evidence of the collapse.
    pub by: CollapsedBy,
    /// The evidence in words, with the extent of the motion.
    pub reason: String,
}

/// A stage of a run and how it ended. When it ends, this is a message, and an event for observers.
#[derive(Message, Event, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageEnd {
    /// Name of the stage.
    pub stage: String,
    /// Number of increments of the stage that were made, the last perhaps in part.
    pub increments: u64,
    /// Number of committed and failed parts of increments: what the run counts as increments.
    pub rows: u64,
    /// Number of these with the status `capped`.
    pub capped: u64,
    /// Number of these whose end is out of balance because
    /// [passes](clastic_systems::ending) found none: `geometry` in their `caps`.
    pub unbalanced: u64,
    /// Number of particles that are [set aside](clastic_components::particle::SetAside) after its last
    /// increment.
    pub set_aside: u64,
    /// What ended the stage; `None` for the current stage.
    pub ended_by: Option<EndedBy>,
    /// The stop condition as the scene writes it: the one that was met with [`EndedBy::Stop`], and
    /// with [`EndedBy::AllIncrements`] the first one if none was met, before others an `Until`.
    pub stop: Option<Stop>,
    /// The measure of an `Until` that has passed its value by more than the tolerance.
    pub passed: Option<f64>,
    /// Porosity of the packing that a compaction has left jammed.
    pub jammed_at: Option<f64>,
    /// Share of the number or mass due of a `Pour` that has come, where grains wait for room.
    pub came: Option<f64>,
}

impl StageEnd {
    /// Warning about capped increments and those out of balance, about a measure that has passed
    /// the value on which it should land, about stop conditions that never held, about grains
    /// that have not come, and about particles that are set aside; `None` if the stage has none of
    /// them.
    pub fn warning(&self) -> Option<String> {
        let Self { rows, capped, unbalanced, .. } = self;
        let stage = label(&self.stage);
        let mut all = Vec::new();
        if *capped > 0 {
            let share =
                if capped == rows { format!("all {rows}") } else { format!("{capped} of {rows}") };
            all.push(format!("{share} increments of stage {stage} are capped"));
        }
        if *unbalanced > 0 {
            all.push(format!(
                "{unbalanced} of {rows} increments of stage {stage} end out of balance, where contacts slide \
                 (`geometry` in `caps` of the history, by `imbalance_at_end`); smaller increments may help"
            ));
        }
        if let (Some(Stop::Until(name, value)), Some(passed)) = (&self.stop, self.passed) {
            let name = label(name);
            all.push(format!(
                "stage {stage} ends at {name} = {passed:?}, beyond {value:?}: it jumps there"
            ));
        }
        if let (Some(stop), Some(EndedBy::AllIncrements)) = (&self.stop, self.ended_by) {
            all.push(format!(
                "stage {stage} ended with the last of its increments and did not reach {stop:?}"
            ));
        }
        if let (1, Some(EndedBy::Stop), Some(stop @ (Stop::Above(..) | Stop::Below(..)))) =
            (rows, self.ended_by, &self.stop)
        {
            all.push(format!(
                "stage {stage} ended with its first increment: {stop:?} held by then"
            ));
        }
        if let (Some(came), Some(EndedBy::AllIncrements)) = (self.came, self.ended_by) {
            all.push(format!(
                "stage {stage} ended while grains waited for room: {:.1} % of what was due had come",
                (1000.0 * came).floor() / 10.0
            ));
        }
        if self.set_aside > 0 {
            let (what, their) = match self.set_aside {
                1 => ("1 particle that carries nothing is".to_owned(), "its"),
                n => (format!("{n} particles that carry nothing are"), "their"),
            };
            all.push(format!(
                "at the end of stage {stage} {what} set aside, without {their} weight: no motion brought \
                 {their} fall to rest"
            ));
        }
        (!all.is_empty()).then(|| all.join("; "))
    }
}

/// What ended a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndedBy {
    /// All increments were made, the target of a compaction was reached, or the stage has no
    /// increments.
    AllIncrements,
    /// A stop condition was met.
    Stop,
    /// The specimen collapsed.
    Collapse,
    /// An increment was undecided.
    Undecided,
}

impl Script {
    /// Script of a scene before its first stage.
    pub fn new(scene: &Scene) -> Self {
        Self { scene: scene.clone(), state: ScriptState::default(), outcome: None, stop: false }
    }

    /// The stage at an index; `None` past the last one.
    pub fn stage(&self, index: usize) -> Option<&Stage> {
        self.scene.stages.get(index)
    }

    /// Index of the stage at whose start strains are zero.
    pub fn reference_stage(&self) -> usize {
        self.scene.reference_stage()
    }
}

impl Deref for Script {
    type Target = ScriptState;

    fn deref(&self) -> &ScriptState {
        &self.state
    }
}

impl DerefMut for Script {
    fn deref_mut(&mut self) -> &mut ScriptState {
        &mut self.state
    }
}

/// Result of one run of [`AdvanceIncrement`](clastic_systems::stepping::AdvanceIncrement).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// An increment ended; [`Observation`](clastic_components::observation::Observation) holds its
    /// record.
    Increment,
    /// The run has ended.
    Finished(Outcome),
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All stages ran to their end.
    Completed,
    /// All stages ended, and in at least one of them the specimen collapsed. This is a result.
    Collapsed(
        /// The first collapse.
        Collapse,
    ),
    /// An increment could not be solved, and nothing of it was committed.
    Undecided {
        /// The increment.
        increment: u64,
        /// The residual, and advice.
        message: String,
    },
    /// The run has stopped for another reason than the specimen: an increment could not be written,
    /// or a plugin has inserted [`ClasticHalted`](clastic_systems::stepping::ClasticHalted).
    Halted(
        /// What happened.
        String,
    ),
    /// A stage could not begin as the scene defines it. All previous increments are committed.
    Refused {
        /// The stage.
        stage: String,
        /// The mistake and its remedy.
        message: String,
    },
}
