//! Writes a run into its directory, increment by increment.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::attempt::IncrementStatus;
use clastic_components::energy::EnergyLedger;
use clastic_components::identity::Identities;
use clastic_components::increment::Progress;
use clastic_components::observation::{Observation, Timings};
use clastic_systems::gather_bodies::gather_bodies;
use clastic_systems::schedule::PROGRESS;

use super::atomic::{sync, write_atomic, write_durable};
use super::avalanches::{self, Avalanche};
use super::checkpoint::{Checkpoint, ResumeError};
use super::csv_file::CsvFile;
use super::key_results::{KeyResults, Phase, Results};
use super::mechanism::Mechanism;
use super::run_record::{CLASTIC_VERSION, OutcomeRecord, Resumed, RunFacts, RunRecord};
use super::snapshot::Snapshot;
use super::{
    OutputError, directory, dump, events, frames, history, plots, porosity, states, timings,
};
use crate::run::stages::Script;
use crate::run::state::{StateError, capture};
use crate::run::{Outcome, StageEnd};
use crate::scene::format::{Bond, Contact, Record, Scene, Stage};
use crate::scene::{LoadedScene, StoredParticle};

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

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The outcome that the engine reports.
    Finished(Outcome),
    /// The user or the system stopped the run after a whole increment.
    Interrupted,
}

/// Writer of a run directory during the run.
#[derive(Resource, Debug)]
pub struct RunWriter {
    directory: PathBuf,
    dump_programs: Vec<u64>,
    dump_in_stages: Vec<(String, u64)>,
    checkpoint_every: u32,
    scene: Scene,
    scene_text: String,
    reference_stage: usize,
    facts: RunFacts,
    record: RunRecord,
    probes: Vec<String>,
    history: CsvFile,
    events: CsvFile,
    avalanches: CsvFile,
    timings: CsvFile,
    state: WriterState,
    /// Whole files that must be on the disk before the next checkpoint.
    fresh: Vec<PathBuf>,
    /// Increment of the last checkpoint.
    saved: Option<u64>,
    /// Seconds spent on checkpoints since the last row of the timings.
    saving: f64,
}

/// Length of a file that is kept whole.
const WHOLE: u64 = u64::MAX;

/// State of the output between two increments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WriterState {
    /// Lengths of the history, the events, the avalanches and the timings, bytes.
    lengths: [u64; 4],
    results: KeyResults,
    /// The current avalanche.
    avalanche: Option<Avalanche>,
    /// The state after the last increment, until the reference stage begins.
    prepared: Option<Prepared>,
    /// Moment of the prepared specimen, if it has been written.
    specimen: Option<String>,
    /// State at the start of the reference stage.
    start: Snapshot,
    /// State at the peak so far, with its caption.
    peak: Option<(Snapshot, String)>,
}

impl WriterState {
    /// Keeps all timings, whose length is another in every run.
    pub(super) fn keep_timings(&mut self) {
        self.lengths[3] = WHOLE;
    }

    /// Existing files that are written once and not rewritten at the end of the run.
    fn files(&self) -> Vec<&str> {
        let mut files = Vec::new();
        if self.specimen.is_some() {
            files.push(directory::SPECIMEN);
        }
        if self.results.has_mechanism() {
            files.extend([directory::MECHANISM, plots::MECHANISM]);
        }
        files
    }
}

/// A specimen that waits for the reference stage. Its reference lengths exist only after the first
/// increment of that stage, which moves the particles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Prepared {
    rows: Vec<StoredParticle>,
    snapshot: Snapshot,
}

impl Prepared {
    fn of(world: &mut World) -> Self {
        Self { rows: frames::specimen_rows(world), snapshot: Snapshot::take(world) }
    }
}

impl RunWriter {
    /// Begins the output of a scene. `world` is the state before the first stage.
    ///
    /// # Errors
    /// If the directory is in use, or cannot be written.
    pub fn create(
        options: RunOptions,
        loaded: &LoadedScene,
        world: &mut World,
    ) -> Result<Self, OutputError> {
        let reference_stage = Script::new(&loaded.scene).reference_stage();
        // This precedes all removals, because the stored specimen may lie in this directory.
        let facts = RunFacts::new(loaded, &options.overrides)?;
        let record = RunRecord::new(loaded, &facts, reference_stage);
        let dir = options.directory.as_path();
        let history = directory::claim(dir, options.force)?;
        make_frames(dir, &loaded.scene)?;
        record.write(&dir.join(directory::RUN))?;
        write_atomic(&dir.join(directory::SCENE), &loaded.text)?;
        let probes = history::probes(&loaded.scene);
        let mut header = history::header(&probes);
        if loaded.scene.output.energy {
            header.extend(history::ENERGY_COLUMNS.map(str::to_owned));
        }
        let history = CsvFile::begin(dir.join(directory::HISTORY), history, header)?;
        let events = CsvFile::create(dir.join(directory::EVENTS), events::COLUMNS)?;
        let avalanches = CsvFile::create(dir.join(directory::AVALANCHES), avalanches::COLUMNS)?;
        let timings = CsvFile::create(dir.join(directory::TIMINGS), timings::COLUMNS)?;
        // A world without increments has no tables yet. Gathering them does not change the run.
        let _ = world.run_system_cached(gather_bodies);
        let prepared = Prepared::of(world);
        let state = WriterState {
            lengths: [&history, &events, &avalanches, &timings].map(CsvFile::length),
            results: KeyResults::new(is_rigid(&loaded.scene))
                .with_stiffness(maximum_stiffness(&loaded.scene) / loaded.scene.thickness),
            avalanche: None,
            start: prepared.snapshot.clone(),
            prepared: Some(prepared),
            specimen: None,
            peak: None,
        };
        let fresh = vec![dir.join(directory::SCENE)];
        let mut writer = Self {
            directory: options.directory,
            dump_programs: options.dump_programs,
            dump_in_stages: options.dump_in_stages,
            checkpoint_every: options.checkpoint_every,
            scene: plots::as_drawn(&loaded.scene),
            scene_text: loaded.text.clone(),
            reference_stage,
            facts,
            record,
            probes,
            history,
            events,
            avalanches,
            timings,
            state,
            fresh,
            saved: None,
            saving: 0.0,
        };
        if writer.checkpoint_every > 0 {
            writer.save(world)?;
        }
        Ok(writer)
    }

    /// Continues the output of a run from its checkpoint. All output after the checkpoint is
    /// dropped. `loaded` is the scene with `settings` applied. `every` replaces the distance
    /// between checkpoints.
    ///
    /// # Errors
    /// If the directory is in use, has changed, or cannot be written.
    pub fn resume(
        directory: &Path,
        checkpoint: Checkpoint,
        loaded: &LoadedScene,
        settings: &[String],
        every: Option<u32>,
    ) -> Result<Self, ResumeError> {
        let increment = checkpoint.increment;
        let [history, events, avalanches, timings] = checkpoint.output.lengths;
        let open = |name: &str, length| {
            let path = directory.join(name);
            let whole = || fs::metadata(&path).map_or(0, |file| file.len());
            CsvFile::open(path.clone(), if length == WHOLE { whole() } else { length })
        };
        let mut history = open(directory::HISTORY, history)?;
        if !history.lock() {
            return Err(OutputError::InUse(directory.to_owned()).into());
        }
        let mut events = open(directory::EVENTS, events)?;
        let mut avalanches = open(directory::AVALANCHES, avalanches)?;
        let mut timings = open(directory::TIMINGS, timings)?;

        // Every step from here on can be repeated, so a process that is killed between two of them
        // can resume again.
        let scene_file = directory.join(directory::SCENE);
        write_durable(&scene_file, &checkpoint.scene)?;
        let mut next = checkpoint;
        next.every = every.unwrap_or(next.every);
        let is_changed = !settings.is_empty() || next.scene != loaded.text;
        if is_changed || next.clastic_version != CLASTIC_VERSION {
            next.clastic_version = CLASTIC_VERSION.to_owned();
            next.facts.resumed.push(Resumed {
                after_increment: increment,
                clastic_version: CLASTIC_VERSION.to_owned(),
                settings: settings.to_vec(),
            });
            next.scene_before = Some(std::mem::replace(&mut next.scene, loaded.text.clone()));
            next.write(directory)?;
            write_durable(&scene_file, &next.scene)?;
        }
        let kept = states::kept_before(&loaded.scene, &next.world);
        let mut there = next.output.files();
        there.extend(kept.iter().map(String::as_str));
        directory::rewind(directory, increment, &there)?;
        make_frames(directory, &loaded.scene)?;
        let reference_stage = Script::new(&loaded.scene).reference_stage();
        let mut record = RunRecord::new(loaded, &next.facts, reference_stage);
        record.write(&directory.join(directory::RUN))?;
        record.increments = states::increments(&next.world);
        for file in [&mut history, &mut events, &mut avalanches, &mut timings] {
            file.cut()?;
        }
        Ok(Self {
            directory: directory.to_owned(),
            dump_programs: next.dump_programs,
            dump_in_stages: next.dump_in_stages,
            checkpoint_every: next.every,
            scene: plots::as_drawn(&loaded.scene),
            scene_text: next.scene,
            reference_stage,
            facts: next.facts,
            record,
            probes: history::probes(&loaded.scene),
            history,
            events,
            avalanches,
            timings,
            state: next.output,
            fresh: Vec::new(),
            saved: Some(increment),
            saving: 0.0,
        })
    }

    /// Writes the results of the increment that has just ended.
    ///
    /// # Errors
    /// If a file cannot be written. Everything written before stays complete.
    pub fn record(&mut self, world: &mut World) -> Result<(), OutputError> {
        let clock = Instant::now();
        let observation = world.resource::<Observation>().clone();
        let progress = world.resource::<Progress>().clone();
        let increment = observation.increment;
        self.history.is_there()?;
        self.write_kept(world)?;
        let undecided = matches!(observation.status, IncrementStatus::Undecided);
        if undecided {
            // The checkpoint precedes the failed row, so that a resumed run with other settings
            // repeats the increment.
            self.save(world)?;
        }
        for rupture in &observation.ruptures {
            self.events.push(events::row(rupture, &observation.stage))?;
        }
        if let Some((row, bonds)) = Avalanche::follow(&mut self.state.avalanche, world) {
            self.avalanches.push(row)?;
            self.state.results.see_avalanche(bonds);
        }
        let due = Due::of(&self.scene, world);
        if due.row {
            let mut row = history::row(&observation, &self.probes);
            if let Some(ledger) = world.get_resource::<EnergyLedger>() {
                row = row.numbers(history::energies(ledger));
            }
            self.history.push(row)?;
        }
        self.record.increments += 1;

        let compacting = matches!(self.scene.stages.get(progress.stage), Some(Stage::Compact(_)));
        if progress.stage >= self.reference_stage {
            self.begin_reference(world)?;
        } else {
            self.state.prepared = Some(Prepared::of(world));
        }
        if compacting && progress.is_over() {
            let packing = Prepared::of(world);
            let moment = format!("at the end of the compaction `{}`", observation.stage);
            self.write_specimen(&packing, moment)?;
            if progress.stage >= self.reference_stage {
                // The scene has no loading stage, so its result is the packing.
                self.state.results.set_porosity(porosity::in_box(&packing.snapshot));
            }
        }
        let phase = match (compacting, progress.stage >= self.reference_stage) {
            (true, _) => Phase::Preparation,
            (false, false) => Phase::Loading,
            (false, true) => Phase::Reference,
        };
        self.state.results.see_bonds(world.resource::<Identities>().next().bond as usize);
        let counts = self.state.results.observe(&observation, phase);
        if counts && self.scene.output.plots {
            self.state.peak = Some((Snapshot::take(world), caption(&observation)));
        }
        self.write_mechanism(world)?;
        if due.frame {
            self.write_frame(&Snapshot::take(world), &observation)?;
        }
        let in_stage = world.resource::<Script>().ends.last().map_or(0, |end| end.increments);
        let dumped = |(stage, n): &(String, u64)| *stage == observation.stage && *n == in_stage;
        if self.dump_programs.contains(&increment) || self.dump_in_stages.iter().any(dumped) {
            let path = directory::program(&self.directory, increment);
            dump::write_program(&path, world)?;
            self.is_fresh(path);
        }
        let timings = world.resource::<Timings>();
        if due.row {
            let output = clock.elapsed().as_secs_f64() + std::mem::take(&mut self.saving);
            self.timings.push(timings::row(increment, timings, output))?;
        }
        let every = u64::from(self.checkpoint_every);
        if every > 0 && increment.is_multiple_of(every) && !undecided {
            let clock = Instant::now();
            self.save(world)?;
            self.saving += clock.elapsed().as_secs_f64();
        }
        Ok(())
    }

    /// Writes the states that stages have kept since the last increment.
    fn write_kept(&mut self, world: &mut World) -> Result<(), OutputError> {
        for path in states::write_kept(&self.directory, world)? {
            self.is_fresh(path);
        }
        Ok(())
    }

    /// Writes a frame and its picture.
    fn write_frame(&mut self, now: &Snapshot, at: &Observation) -> Result<(), OutputError> {
        let path = directory::frame(&self.directory, at.increment);
        frames::write_frame(&path, now)?;
        if self.scene.output.plots
            && let Some(picture) =
                plots::specimen::svg(now, &self.state.start, &self.scene.title, &caption(at))
        {
            let path = path.with_extension("svg");
            write_atomic(&path, picture)?;
            self.is_fresh(path);
        }
        self.is_fresh(path);
        Ok(())
    }

    /// Writes a checkpoint.
    fn save(&mut self, world: &mut World) -> Result<(), OutputError> {
        let checkpoint = self.checkpoint(world)?;
        checkpoint.write(&self.directory)?;
        self.saved = Some(checkpoint.increment);
        Ok(())
    }

    /// A checkpoint, after everything on which it depends is on the disk.
    fn checkpoint(&mut self, world: &mut World) -> Result<Checkpoint, OutputError> {
        // The rows and files on which a checkpoint depends must reach the disk before it.
        for path in self.fresh.drain(..) {
            sync(&path).map_err(OutputError::at(&path))?;
        }
        let rows = [&self.history, &self.events, &self.avalanches, &self.timings];
        for file in rows {
            file.sync()?;
        }
        self.state.lengths = rows.map(CsvFile::length);
        let invalid = |error: StateError| io::Error::other(error);
        let world = capture(world)
            .map_err(invalid)
            .map_err(OutputError::at(&self.directory.join(directory::CHECKPOINT)))?;
        let increment = world
            .get::<Progress>(PROGRESS)
            .map_err(invalid)
            .map_err(OutputError::at(&self.directory.join(directory::CHECKPOINT)))?
            .increment;
        Ok(Checkpoint {
            clastic_version: CLASTIC_VERSION.to_owned(),
            increment,
            scene: self.scene_text.clone(),
            scene_before: None,
            facts: self.facts.clone(),
            every: self.checkpoint_every,
            dump_programs: self.dump_programs.clone(),
            dump_in_stages: self.dump_in_stages.clone(),
            output: self.state.clone(),
            world,
        })
    }

    /// Increments whose cone program is dumped.
    #[must_use]
    pub fn dump_programs(&self) -> &[u64] {
        &self.dump_programs
    }

    /// Increments of stages whose cone program is dumped.
    #[must_use]
    pub fn dump_in_stages(&self) -> &[(String, u64)] {
        &self.dump_in_stages
    }

    /// Moment of `specimen.csv`; `None` if the file does not exist.
    #[must_use]
    pub fn specimen(&self) -> Option<&str> {
        self.state.specimen.as_deref()
    }

    /// Increment of the last checkpoint, from which a resumed run continues; `None` without a
    /// checkpoint.
    #[must_use]
    pub fn saved(&self) -> Option<u64> {
        self.saved
    }

    /// Ends the output: final particles, outcome, key results, pictures.
    ///
    /// # Errors
    /// If something cannot be written.
    pub fn finish(&mut self, world: &mut World, ending: &Ending) -> Result<Results, OutputError> {
        let dir = self.directory.clone();
        self.write_kept(world)?;
        let made = world.resource::<Progress>().increment;
        let goes_on = world.resource::<Script>().outcome.is_none();
        let interrupted = goes_on && *ending == Ending::Interrupted && self.saved != Some(made);
        // The checkpoint precedes a refused stage, which can begin after its settings are changed.
        let refused = matches!(ending, Ending::Finished(Outcome::Refused { .. }));
        if interrupted || refused {
            self.save(world)?;
        }
        let ended = matches!(ending, Ending::Finished(Outcome::Completed | Outcome::Collapsed(_)));
        if ended {
            // The avalanche of a specimen that collapsed in one is still open here.
            self.checkpoint(world)?.of_the_end().write_as(&dir, directory::FINAL_CHECKPOINT)?;
        }
        let last = Snapshot::take(world);
        frames::write_frame(&dir.join(directory::FINAL_PARTICLES), &last)?;
        states::write_final(&dir, world)?;
        let observation = world.resource::<Observation>();
        let (stage, increment) = (observation.stage.clone(), observation.increment);
        let caption = caption(observation);
        let outcome = match ending {
            Ending::Finished(outcome) => Some(outcome),
            Ending::Interrupted => None,
        };
        // The avalanche of an interrupted run continues after it is resumed.
        if let (Some(_), Some(avalanche)) = (outcome, self.state.avalanche.take()) {
            let (row, bonds) = avalanche.ended(None);
            self.avalanches.push(row)?;
            self.state.results.see_avalanche(bonds);
        }
        let results = self.state.results.results();
        self.record.outcome = OutcomeRecord::new(outcome, stage, increment);
        self.record.stages = world.resource::<Script>().ends.clone();
        self.record.capped_increments = self.record.stages.iter().map(|end| end.capped).sum();
        self.record.specimen_csv = self.state.specimen.clone();
        if self.record.outcome.message.is_none() {
            let warnings: Vec<_> =
                self.record.stages.iter().filter_map(StageEnd::warning).collect();
            self.record.outcome.message = Some(warnings.join("; ")).filter(|m| !m.is_empty());
        }
        self.record.results = results.clone();
        // The pictures come last, so that the numbers are complete if a picture fails.
        self.record.write(&dir.join(directory::RUN))?;
        if self.scene.output.plots {
            let history = plots::history::History::read(&dir.join(directory::HISTORY))?;
            plots::curves(&dir, &self.scene.title, &history)?;
            plots::specimens(
                &dir,
                &self.scene.title,
                &self.state.start,
                [
                    (plots::SPECIMEN_PEAK, self.state.peak.as_ref().map(|(s, c)| (s, c.as_str()))),
                    (plots::SPECIMEN, Some((&last, caption.as_str()))),
                ],
            )?;
        }
        if ended {
            // The checkpoint is removed last, because a run with a checkpoint counts as not ended.
            directory::remove_if_there(&dir.join(directory::CHECKPOINT))?;
        }
        Ok(results)
    }

    /// Writes the prepared specimen once, after the first increment of the reference stage.
    fn begin_reference(&mut self, world: &World) -> Result<(), OutputError> {
        let Some(prepared) = self.state.prepared.take() else { return Ok(()) };
        let stage = self.scene.stages.get(self.reference_stage).map_or("", |s| s.name());
        let moment =
            format!("at the start of the reference stage `{stage}`, before its first increment");
        self.write_specimen(&prepared, moment)?;
        self.state.results.set_porosity(porosity::porosity(world, &prepared.snapshot));
        self.state.start = prepared.snapshot;
        Ok(())
    }

    fn write_specimen(&mut self, prepared: &Prepared, moment: String) -> Result<(), OutputError> {
        let path = self.directory.join(directory::SPECIMEN);
        self.state.specimen = Some(moment);
        frames::write_specimen(&path, &prepared.rows)?;
        self.is_fresh(path);
        Ok(())
    }

    /// Writes the mechanism if the increment was the first collapse.
    fn write_mechanism(&mut self, world: &mut World) -> Result<(), OutputError> {
        let Some(mechanism) = Mechanism::of(world) else { return Ok(()) };
        if !self.state.results.see_mechanism(mechanism.record) {
            return Ok(());
        }
        let path = self.directory.join(directory::MECHANISM);
        mechanism.write(&path)?;
        self.is_fresh(path);
        if self.scene.output.plots {
            let observation = world.resource::<Observation>();
            let caption = format!(
                "mechanism of the collapse in increment {} of stage {}",
                observation.increment, observation.stage
            );
            let title = &self.scene.title;
            let now = Snapshot::take(world);
            if let Some(svg) = plots::mechanism::svg(&mechanism, &now, title, &caption) {
                let path = self.directory.join(plots::MECHANISM);
                write_atomic(&path, svg)?;
                self.is_fresh(path);
            }
        }
        Ok(())
    }

    fn is_fresh(&mut self, path: PathBuf) {
        if self.checkpoint_every > 0 {
            self.fresh.push(path);
        }
    }
}

fn make_frames(directory: &Path, scene: &Scene) -> Result<(), OutputError> {
    let frames = |record: &Record| record.frames_every > Some(0) || !record.frames.is_empty();
    if scene.output.frames_every > 0 || scene.stages.iter().filter_map(Stage::record).any(frames) {
        let path = directory.join(directory::FRAMES);
        fs::create_dir_all(&path).map_err(OutputError::at(&path))?;
    }
    Ok(())
}

/// Output that is due after the increment that has just ended.
struct Due {
    row: bool,
    frame: bool,
}

impl Due {
    fn of(scene: &Scene, world: &World) -> Self {
        let progress = world.resource::<Progress>();
        let observation = world.resource::<Observation>();
        let end = world.resource::<Script>().ends.last();
        let n = end.map_or(0, |end| end.increments);
        let over = progress.is_over() || end.is_some_and(|end| end.ended_by.is_some());
        let record = scene.stages.get(progress.stage).and_then(Stage::record);
        let record = record.cloned().unwrap_or_default();
        // Increments that are not solved are always written.
        let plain = observation.status == IncrementStatus::Solved;
        let every = |count, every: u32| every > 0 && u64::is_multiple_of(count, every.into());
        let regular = match record.frames_every {
            Some(frames_every) => every(n, frames_every),
            None => every(observation.increment, scene.output.frames_every),
        };
        Self {
            // A state within an avalanche is no equilibrium.
            row: !observation.in_avalanche && (over || !plain || every(n, record.every)),
            frame: regular || record.frames.iter().any(|frame| u64::from(*frame) == n),
        }
    }
}

fn caption(o: &Observation) -> String {
    let strain =
        o.axial_strain.map(|e| format!(", axial strain {:.3} % (contraction positive)", 100.0 * e));
    format!("increment {} of stage {}{}", o.increment, o.stage, strain.unwrap_or_default())
}

/// Maximum normal stiffness of the contacts and bonds of a scene, N/m; 0 if none is elastic.
fn maximum_stiffness(scene: &Scene) -> f64 {
    let of_walls = scene.walls.iter().map(|wall| (&wall.contact, wall.bond.as_ref()));
    let of_materials = scene.materials.values().map(|m| (&m.contact, m.bond.as_ref()));
    of_walls
        .chain(of_materials)
        .flat_map(|(contact, bond)| {
            [contact.normal_stiffness, bond.and_then(|bond| bond.normal_stiffness)]
        })
        .flatten()
        .fold(0.0, f64::max)
}

/// Whether nothing in a scene is elastic.
fn is_rigid(scene: &Scene) -> bool {
    let rigid = |c: &Contact| c.normal_stiffness.is_none() && c.tangential_stiffness.is_none();
    let rigid_bond = |bond: Option<&Bond>| {
        bond.is_none_or(|b| b.normal_stiffness.is_none() && b.tangential_stiffness.is_none())
    };
    scene.walls.iter().all(|wall| rigid(&wall.contact) && rigid_bond(wall.bond.as_ref()))
        && scene.materials.values().all(|m| rigid(&m.contact) && rigid_bond(m.bond.as_ref()))
}

#[cfg(test)]
mod tests {
    use std::error::Error;
    use std::path::Path;

    use clastic_cone::clarabel::Clarabel;
    use clastic_cone::dump::Dump;
    use clastic_cone::program::SolveStatus;
    use clastic_cone::solver::ConeSolver;

    use super::*;
    use crate::run::{Simulation, Step};
    use crate::scene::from_str;

    const SCENE: &str = r#"(
        version: 1,
        title: "two disks pulled apart",
        rupture: (order: OneRound),
        materials: { "m": (
            contact: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6),
            bond: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6, cohesion: 4.0e3, tensile_strength: 2.0e3),
        ) },
        specimen: Particles([
            (position: (0.0, 0.0), radius: 6.0e-3),
            (position: (12.0e-3, 0.0), radius: 6.0e-3, probe: "pulled"),
        ]),
        bonds: [(a: 0, b: 1)],
        stages: [Load(name: "pull", increments: 4, particles: [
            (select: Index([0]), x: Held, y: Held, rotation: Held),
            (select: Index([1]), x: Displacement(1.0e-6), y: Held, rotation: Held),
        ])],
        output: (frames_every: 2),
    )"#;

    fn run(directory: &Path, stop_after: u64) -> Result<Results, Box<dyn Error>> {
        let loaded = from_str(SCENE, Path::new("elsewhere/two.ron"), Path::new(""), &[])?;
        let mut simulation = Simulation::new(&loaded.scene, None);
        let options = RunOptions {
            directory: directory.to_owned(),
            dump_programs: vec![3],
            ..Default::default()
        };
        let mut writer = RunWriter::create(options, &loaded, simulation.world_mut())?;
        for _ in 0..stop_after {
            if let Step::Finished(outcome) = simulation.step() {
                return Ok(writer.finish(simulation.world_mut(), &Ending::Finished(outcome))?);
            }
            writer.record(simulation.world_mut())?;
        }
        Ok(writer.finish(simulation.world_mut(), &Ending::Interrupted)?)
    }

    /// Names and contents of all files except the timings.
    fn files(directory: &Path) -> Result<Vec<(String, String)>, Box<dyn Error>> {
        let mut all = Vec::new();
        for directory in [directory.to_owned(), directory.join(directory::FRAMES)] {
            for entry in fs::read_dir(directory)? {
                let path = entry?.path();
                if path.is_file() && !path.ends_with(directory::TIMINGS) {
                    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    all.push((name, String::from_utf8_lossy(&fs::read(path)?).into_owned()));
                }
            }
        }
        all.sort();
        Ok(all)
    }

    #[test]
    fn two_runs_leave_the_same_bytes() -> Result<(), Box<dyn Error>> {
        let parent = tempfile::tempdir()?;
        let (first, second) = (parent.path().join("1"), parent.path().join("2"));
        let results = run(&first, u64::MAX)?;
        run(&second, u64::MAX)?;
        assert_eq!(results.bonds_broken.tension, 1);
        let written = files(&first)?;
        assert_eq!(written, files(&second)?);
        let names: Vec<_> = written.iter().map(|(name, _)| name.as_str()).collect();
        let expected = [
            "avalanches.csv",
            "events.csv",
            "final_checkpoint.bin",
            "final_particles.csv",
            "final_state.npz",
            "frame_000002.csv",
            "frame_000002.svg",
            "frame_000004.csv",
            "frame_000004.svg",
            "history.csv",
            "probes.svg",
            "program_000003.json",
            "run.json",
            "scene.ron",
            "specimen.csv",
            "specimen.svg",
        ];
        assert_eq!(names, expected);
        let here = parent.path().to_string_lossy();
        assert!(
            written.iter().all(|(_, text)| !text.contains(&*here) && !text.contains("elsewhere"))
        );
        Ok(())
    }

    #[test]
    fn a_dumped_program_reads_back_and_has_the_dumped_solution() -> Result<(), Box<dyn Error>> {
        let parent = tempfile::tempdir()?;
        run(parent.path(), u64::MAX)?;
        let path = directory::program(parent.path(), 3);
        let Dump { program, solution: dumped, .. } = dump::read_program(&path)?;
        assert_eq!(dumped.status, SolveStatus::Solved);
        let solution = Clarabel::default().solve(&program)?;
        for (f, g) in solution.forces.iter().zip(&dumped.forces) {
            assert!((f[0] - g[0]).abs() <= 1e-9 * g[0].abs(), "{f:?} {g:?}");
        }
        let other = fs::read_to_string(&path)?.replacen("version 2", "version 1", 1);
        fs::write(&path, other)?;
        assert!(dump::read_program(&path).is_err());
        Ok(())
    }

    #[test]
    fn a_stage_says_what_is_recorded() -> Result<(), Box<dyn Error>> {
        let parent = tempfile::tempdir()?;
        let set = ["stages.pull.record=(every: 3, frames_every: 0, frames: [1, 4])".to_owned()];
        let loaded = from_str(SCENE, Path::new("two.ron"), Path::new(""), &set)?;
        let mut simulation = Simulation::new(&loaded.scene, None);
        let options = RunOptions { directory: parent.path().to_owned(), ..Default::default() };
        let mut writer = RunWriter::create(options, &loaded, simulation.world_mut())?;
        while simulation.step() == Step::Increment {
            writer.record(simulation.world_mut())?;
        }
        writer.finish(simulation.world_mut(), &Ending::Finished(Outcome::Completed))?;
        let written = |name: &str| fs::read_to_string(parent.path().join(name));
        // Every third increment, and the last.
        for file in [directory::HISTORY, directory::TIMINGS] {
            let text = written(file)?;
            let rows: Vec<_> = text.lines().filter_map(|line| line.split(',').next()).collect();
            assert_eq!(rows, ["increment", "3", "4"], "{file}");
        }
        let names: Vec<_> = files(parent.path())?.into_iter().map(|(name, _)| name).collect();
        let frames: Vec<_> = names.iter().filter(|name| name.starts_with("frame_")).collect();
        let expected =
            ["frame_000001.csv", "frame_000001.svg", "frame_000004.csv", "frame_000004.svg"];
        assert_eq!(frames, expected);
        // The record contains the rupture in between all the same.
        let record: serde_json::Value = serde_json::from_str(&written(directory::RUN)?)?;
        assert_eq!(record["increments"], 4);
        assert_eq!(record["results"]["bonds_broken"]["tension"], 1);
        assert_eq!(record["stages"][0]["ended_by"], "all_increments");
        Ok(())
    }

    #[test]
    fn an_interrupted_run_is_complete_up_to_there() -> Result<(), Box<dyn Error>> {
        let parent = tempfile::tempdir()?;
        run(parent.path(), 2)?;
        let history = fs::read_to_string(parent.path().join(directory::HISTORY))?;
        assert_eq!(history.lines().count(), 3);
        let record = fs::read_to_string(parent.path().join(directory::RUN))?;
        let record: serde_json::Value = serde_json::from_str(&record)?;
        assert_eq!(record["outcome"]["status"], "interrupted");
        assert_eq!(record["increments"], 2);
        assert_eq!(record["results"]["bonds_intact"], 1);
        Ok(())
    }

    #[test]
    fn the_stored_specimen_reads_back_to_the_bit() -> Result<(), Box<dyn Error>> {
        let parent = tempfile::tempdir()?;
        run(parent.path(), 1)?;
        let stored = crate::scene::specimen_file::read(&parent.path().join(directory::SPECIMEN))?;
        let disks: Vec<_> = stored.rows.iter().map(|row| (row.x, row.y, row.r)).collect();
        assert_eq!(disks, [(0.0, 0.0, 6.0e-3), (12.0e-3, 0.0, 6.0e-3)]);
        Ok(())
    }
}
