//! What crosses from the engine to the drawing: plain data of one committed state.

mod loads;
mod series;

pub use loads::{Load, forget_loads, set_load, settle_loads};
pub use series::{Column, Series, columns, row};

use bevy::ecs::prelude::*;
use clastic::components::increment::{AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic::components::observation::Observation;
use clastic::frames::Frame;
use clastic::run::script::Script;
use clastic::systems::stepping::{ClasticRunning, StoppedBy};

/// A committed state of a world, as it is drawn.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Disks, pairs, walls and membranes.
    pub frame: Frame,
    /// Title of the scene; empty without one.
    pub title: String,
    /// Number of the stage, from 1, and of all stages; 0 without a scene.
    pub stage: [usize; 2],
    /// Increments of the stage that are done, and all of them.
    pub done: [f64; 2],
    /// Whether strains and fields count from an earlier stage than this one, or from its start.
    pub is_test: bool,
    /// Time step, s; `None` in static analysis.
    pub time_step: Option<f64>,
    /// Whether increments follow, and why not.
    pub motion: Motion,
    /// Intact bonds.
    pub bonds: usize,
    /// Bonds that broke in tension, shear and rolling.
    pub broken: [usize; 3],
    /// Names and units of the measures.
    pub columns: Vec<Column>,
    /// Their values, in the same order; `None` where one is not defined.
    pub row: Vec<Option<f64>>,
    /// Loads and motions that can be changed.
    pub loads: Vec<Load>,
    /// Increment of the state that was kept.
    pub kept: Option<u64>,
    /// Answer to the last order, where there is one.
    pub answer: String,
}

/// Whether a world goes on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Motion {
    /// It makes increments.
    Runs,
    /// It waits for an order.
    #[default]
    Paused,
    /// It has stopped by itself, for this reason.
    Stopped(String),
}

impl Picture {
    /// Takes a picture of a world whose tables are up to date, as they are after an increment.
    ///
    /// # Panics
    /// If the world lacks `ClasticPlugins`.
    pub fn take(world: &mut World) -> Self {
        let frame = Frame::take(world);
        let progress = world.resource::<ClasticProgress>().clone();
        let script = world.get_resource::<Script>();
        let stages = script.map_or(0, |script| script.scene.stages.len());
        let observation = world.resource::<Observation>();
        Self {
            title: script.map_or_else(String::new, |script| script.scene.title.clone()),
            stage: [(progress.stage + 1).min(stages), stages],
            done: [progress.done, progress.total],
            is_test: script
                .is_some_and(|script| script.begun && progress.stage >= script.reference_stage()),
            time_step: match world.resource::<ClasticAnalysis>().kind {
                AnalysisKind::Dynamic { dt, .. } => Some(dt),
                AnalysisKind::Static | AnalysisKind::Compaction { .. } => None,
            },
            motion: match *world.resource::<ClasticRunning>() {
                ClasticRunning::Always | ClasticRunning::Times(_) => Motion::Runs,
                ClasticRunning::Paused => Motion::Paused,
                ClasticRunning::Stopped(by) => Motion::Stopped(words(by).to_owned()),
            },
            bonds: observation.bonds,
            broken: observation.broken,
            columns: columns(world),
            row: row(world, &frame),
            loads: loads::loads(world),
            kept: None,
            answer: String::new(),
            frame,
        }
    }

    /// Value of a measure.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        let k = self.columns.iter().position(|column| column.name == name)?;
        self.row.get(k).copied().flatten()
    }
}

fn words(by: StoppedBy) -> &'static str {
    match by {
        StoppedBy::Collapsed => "collapsed",
        StoppedBy::Undecided => "increment undecided",
        StoppedBy::Halted => "halted",
        StoppedBy::Completed => "all stages have ended",
        StoppedBy::Refused => "the next stage cannot begin",
    }
}
