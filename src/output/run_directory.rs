//! Resource: the run directory, with its open tables.

use std::fs::OpenOptions;
use std::path::{Path, PathBuf};
use std::time::Instant;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use super::OutputError;
use super::atomic::write_atomic;
use super::checkpoint::Checkpoint;
use super::csv_file::CsvFile;
use super::history::probes;
use super::run_record::{CLASTIC_VERSION, RunFacts, RunRecord};
use crate::run::WorldState;
use crate::scene::LoadedScene;

/// Options of the output. A checkpoint has those on which the rest of the run depends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunOptions {
    /// The run directory.
    #[serde(skip)]
    pub directory: PathBuf,
    /// Whether an earlier run in the directory may be overwritten.
    #[serde(skip)]
    pub force: bool,
    /// Settings that were applied to the scene, for `run.json`.
    #[serde(skip)]
    pub overrides: Vec<String>,
    /// Number of increments between checkpoints. 0 writes one only if the run stops before its end.
    pub checkpoint_every: u32,
    /// Increments of the run whose cone program is dumped.
    pub dump_programs: Vec<u64>,
    /// Increments of stages, by name, whose cone program is dumped.
    pub dump_in_stages: Vec<(String, u64)>,
}

/// The run directory. [`begin`](super::begin) and [`resume`](super::resume) insert it;
/// [`OutputPlugin`](super::OutputPlugin) writes to it.
#[derive(Resource, Debug)]
pub struct RunDirectory {
    /// Its path, the increments to dump, and the number of increments between checkpoints.
    pub(crate) options: RunOptions,
    pub(super) scene_text: String,
    pub(super) facts: RunFacts,
    /// Content of `run.json`, whole once the run has ended.
    pub(crate) record: RunRecord,
    /// Names of the probes, in the order of the columns.
    pub(super) probes: Vec<String>,
    /// Tables that grow during the run.
    pub(super) tables: Tables,
    /// Whole files that must be on the disk before the next checkpoint.
    pub(super) fresh: Vec<PathBuf>,
    /// Increment of the last checkpoint, from which a resumed run continues.
    pub(crate) saved: Option<u64>,
    /// The checkpoint after the last increment, from which more increments or stages continue.
    pub(super) last: Option<Checkpoint>,
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
    pub fn all(&mut self) -> [&mut CsvFile; 4] {
        [&mut self.history, &mut self.events, &mut self.avalanches, &mut self.timings]
    }
}

impl RunDirectory {
    /// A run directory before its first row.
    pub(super) fn new(
        options: RunOptions,
        scene: &LoadedScene,
        facts: RunFacts,
        record: RunRecord,
        tables: Tables,
    ) -> Self {
        Self {
            options,
            scene_text: scene.text.clone(),
            facts,
            record,
            probes: probes(&scene.scene),
            tables,
            fresh: Vec::new(),
            saved: None,
            last: None,
            saving: 0.0,
            clock: Instant::now(),
        }
    }

    /// Path of the directory.
    pub fn directory(&self) -> &Path {
        &self.options.directory
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.options.directory.join(name)
    }

    /// Writes a whole file.
    pub(super) fn write(
        &mut self,
        path: PathBuf,
        content: impl AsRef<[u8]>,
    ) -> Result<(), OutputError> {
        write_atomic(&path, content)?;
        self.is_fresh(path);
        Ok(())
    }

    /// Notes that a whole file was written.
    pub(super) fn is_fresh(&mut self, path: PathBuf) {
        if self.options.checkpoint_every > 0 {
            self.fresh.push(path);
        }
    }

    /// A checkpoint of the state after `increment`.
    pub(super) fn checkpoint(
        &mut self,
        increment: u64,
        world: WorldState,
    ) -> Result<Checkpoint, OutputError> {
        // The rows and files on which a checkpoint depends must reach the disk before it.
        for path in self.fresh.drain(..) {
            let file = OpenOptions::new().write(true).open(&path);
            file.and_then(|file| file.sync_all()).map_err(OutputError::at(&path))?;
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
            options: self.options.clone(),
            lengths: self.tables.all().map(|table| table.length),
            world,
        })
    }
}
