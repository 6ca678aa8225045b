//! Resource: the run directory, with its open tables.

use std::path::{Path, PathBuf};
use std::time::Instant;

use bevy_ecs::prelude::*;

use clastic_components::observation::Observation;

use super::OutputError;
use super::atomic::sync;
use super::checkpoint::Checkpoint;
use super::csv_file::CsvFile;
use super::drive::PeakForce;
use super::run_record::{CLASTIC_VERSION, RunFacts, RunRecord};
use crate::run::WorldState;

/// Options of the output.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// The run directory.
    pub directory: PathBuf,
    /// Whether an earlier run in the directory may be overwritten.
    pub force: bool,
    /// Settings that were applied to the scene, for `run.json`.
    pub overrides: Vec<String>,
    /// Increments of the run whose cone program is dumped.
    pub dump_programs: Vec<u64>,
    /// Increments of stages, by name, whose cone program is dumped.
    pub dump_in_stages: Vec<(String, u64)>,
    /// Number of increments between checkpoints. 0 writes one only if the run stops before its end.
    pub checkpoint_every: u32,
}

/// The run directory. [`begin`](super::begin) and [`resume`](super::resume) insert it;
/// [`OutputPlugin`](super::OutputPlugin) writes to it.
#[derive(Resource, Debug)]
pub struct RunDirectory {
    /// Its path, the increments to dump, and the number of increments between checkpoints.
    pub(super) options: RunOptions,
    /// Text of the scene.
    pub(super) scene_text: String,
    /// Facts about the run.
    pub(super) facts: RunFacts,
    /// Content of `run.json`.
    pub(super) record: RunRecord,
    /// Names of the probes, in the order of the columns.
    pub(super) probes: Vec<String>,
    /// Tables that grow during the run.
    pub(super) tables: Tables,
    /// Whole files that must be on the disk before the next checkpoint.
    pub(super) fresh: Vec<PathBuf>,
    /// Increment of the last checkpoint.
    pub(super) saved: Option<u64>,
    /// Seconds spent on checkpoints since the last row of the timings.
    pub(super) saving: f64,
    /// Start of the output of the last increment.
    pub(super) clock: Instant,
}

/// Tables that grow during a run.
#[derive(Debug)]
pub(super) struct Tables {
    pub history: CsvFile,
    pub events: CsvFile,
    pub avalanches: CsvFile,
    pub timings: CsvFile,
}

impl Tables {
    /// Drops the rows that were written after the checkpoint.
    pub fn cut(&mut self) -> Result<(), OutputError> {
        for table in [&mut self.history, &mut self.events, &mut self.avalanches, &mut self.timings]
        {
            table.cut()?;
        }
        Ok(())
    }

    fn all(&self) -> [&CsvFile; 4] {
        [&self.history, &self.events, &self.avalanches, &self.timings]
    }
}

impl RunDirectory {
    /// Peak of the force of a run without an axial stress, once the run has ended.
    pub fn peak_force(&self) -> Option<&PeakForce> {
        self.record.peak_force.as_ref()
    }

    /// Path of the directory.
    pub fn directory(&self) -> &Path {
        &self.options.directory
    }

    /// Increments whose cone program is dumped.
    pub fn dump_programs(&self) -> &[u64] {
        &self.options.dump_programs
    }

    /// Increments of stages whose cone program is dumped.
    pub fn dump_in_stages(&self) -> &[(String, u64)] {
        &self.options.dump_in_stages
    }

    /// Increment of the last checkpoint, from which a resumed run continues; `None` without a
    /// checkpoint.
    pub fn saved(&self) -> Option<u64> {
        self.saved
    }

    /// Path of a file.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.options.directory.join(name)
    }

    /// Whether the program of an increment is dumped, which is the `in_stage`th of its stage.
    pub(super) fn is_dumped(&self, at: &Observation, in_stage: u64) -> bool {
        let of_stage = |(stage, n): &(String, u64)| *stage == at.stage && *n == in_stage;
        self.options.dump_programs.contains(&at.increment)
            || self.options.dump_in_stages.iter().any(of_stage)
    }

    /// Notes that a whole file was written.
    pub(super) fn is_fresh(&mut self, path: PathBuf) {
        if self.options.checkpoint_every > 0 {
            self.fresh.push(path);
        }
    }

    /// Writes a checkpoint of the state after `increment`.
    pub(super) fn save(&mut self, increment: u64, world: WorldState) -> Result<(), OutputError> {
        self.checkpoint(increment, world)?.write(self.directory())?;
        self.saved = Some(increment);
        Ok(())
    }

    /// A checkpoint of the state after `increment`.
    pub(super) fn checkpoint(
        &mut self,
        increment: u64,
        world: WorldState,
    ) -> Result<Checkpoint, OutputError> {
        // The rows and files on which a checkpoint depends must reach the disk before it.
        for path in self.fresh.drain(..) {
            sync(&path).map_err(OutputError::at(&path))?;
        }
        for table in self.tables.all() {
            table.sync()?;
        }
        Ok(Checkpoint {
            clastic_version: CLASTIC_VERSION.to_owned(),
            increment,
            scene: self.scene_text.clone(),
            scene_before: None,
            facts: self.facts.clone(),
            every: self.options.checkpoint_every,
            dump_programs: self.options.dump_programs.clone(),
            dump_in_stages: self.options.dump_in_stages.clone(),
            lengths: self.tables.all().map(CsvFile::length),
            world,
        })
    }
}
