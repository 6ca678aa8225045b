//! Writes a run into its directory, increment by increment.

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use bevy_ecs::prelude::*;

use clastic_components::energy::EnergyLedger;
use clastic_components::increment::Progress;
use clastic_components::observation::{Observation, Timings};
use clastic_systems::gather_bodies::gather_bodies;

use super::atomic::write_atomic;
use super::csv_file::CsvFile;
use super::key_results::{KeyResults, Phase, Results};
use super::run_record::{OutcomeRecord, RunRecord};
use super::snapshot::Snapshot;
use super::{OutputError, directory, dump, events, frames, history, plots, porosity, timings};
use crate::run::Outcome;
use crate::run::stages::Script;
use crate::scene::LoadedScene;
use crate::scene::format::{Contact, Scene, Stage};

/// Where and what to write.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// The run directory.
    pub directory: PathBuf,
    /// Whether an earlier run there may be written over.
    pub force: bool,
    /// Settings that were applied to the scene, for the record.
    pub overrides: Vec<String>,
    /// Increments whose cone program is dumped.
    pub dump_programs: Vec<u64>,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// As the engine says.
    Finished(Outcome),
    /// Somebody stopped it after a whole increment.
    Interrupted,
}

/// The run directory of a run under way.
#[derive(Debug)]
pub struct RunWriter {
    options: RunOptions,
    scene: Scene,
    reference_stage: usize,
    record: RunRecord,
    results: KeyResults,
    probes: Vec<String>,
    history: CsvFile,
    events: CsvFile,
    timings: CsvFile,
    /// The state after the last increment, until the reference stage begins.
    prepared: Option<Prepared>,
    /// Start of the reference stage.
    start: Snapshot,
    /// At the peak so far: with its caption.
    peak: Option<(Snapshot, String)>,
}

/// A specimen that waits for the reference stage: only when that has made its first increment do
/// its reference lengths exist, and then the particles have moved.
#[derive(Debug)]
struct Prepared {
    rows: Vec<crate::scene::StoredParticle>,
    snapshot: Snapshot,
}

impl Prepared {
    fn of(world: &mut World) -> Self {
        Self { rows: frames::specimen_rows(world), snapshot: Snapshot::take(world) }
    }
}

impl RunWriter {
    /// Begins the output of a scene whose `world` is before its first stage.
    ///
    /// # Errors
    /// Where the directory is in use, or cannot be written.
    pub fn create(
        options: RunOptions,
        loaded: &LoadedScene,
        world: &mut World,
    ) -> Result<Self, OutputError> {
        let scene = loaded.scene.clone();
        let reference_stage = Script::new(&scene).reference_stage();
        // Before anything is removed: the stored specimen may lie in this very directory.
        let record = RunRecord::new(loaded, &options.overrides, reference_stage)?;
        let dir = options.directory.as_path();
        directory::claim(dir, options.force)?;
        if scene.output.frames_every > 0 {
            let path = dir.join(directory::FRAMES);
            fs::create_dir_all(&path).map_err(OutputError::at(&path))?;
        }
        record.write(&dir.join(directory::RUN))?;
        write_atomic(&dir.join(directory::SCENE), &loaded.text)?;
        let probes = history::probes(&scene);
        let mut header = history::header(&probes);
        if scene.output.energy {
            header.extend(history::ENERGY_COLUMNS.map(str::to_owned));
        }
        let history = CsvFile::create(dir.join(directory::HISTORY), header)?;
        let events = CsvFile::create(dir.join(directory::EVENTS), events::COLUMNS)?;
        let timings = CsvFile::create(dir.join(directory::TIMINGS), timings::COLUMNS)?;
        // Nothing has been gathered in a world without increments; it changes nothing of the run.
        let _ = world.run_system_cached(gather_bodies);
        let prepared = Prepared::of(world);
        Ok(Self {
            results: KeyResults::new(is_rigid(&scene)),
            start: prepared.snapshot.clone(),
            prepared: Some(prepared),
            peak: None,
            options,
            scene,
            reference_stage,
            record,
            probes,
            history,
            events,
            timings,
        })
    }

    /// Writes what there is to say about the increment that has just ended.
    ///
    /// # Errors
    /// Where something cannot be written; everything written before stays whole.
    pub fn record(&mut self, world: &mut World) -> Result<(), OutputError> {
        let clock = Instant::now();
        let observation = world.resource::<Observation>().clone();
        let progress = world.resource::<Progress>().clone();
        let increment = observation.increment;
        for rupture in &observation.ruptures {
            self.events.push(events::row(rupture, &observation.stage))?;
        }
        let mut row = history::row(&observation, &self.probes);
        if let Some(ledger) = world.get_resource::<EnergyLedger>() {
            row = row.numbers(history::energies(ledger));
        }
        self.history.push(row)?;
        self.record.increments += 1;

        let compacting = matches!(self.scene.stages.get(progress.stage), Some(Stage::Compact(_)));
        if progress.stage >= self.reference_stage {
            self.begin_reference(world)?;
        } else {
            self.prepared = Some(Prepared::of(world));
        }
        if compacting && progress.done >= progress.total {
            self.write_specimen(&Prepared::of(world))?;
        }
        let phase = match (compacting, progress.stage >= self.reference_stage) {
            (true, _) => Phase::Preparation,
            (false, false) => Phase::Loading,
            (false, true) => Phase::Reference,
        };
        if self.results.observe(&observation, phase) && self.scene.output.plots {
            self.peak = Some((Snapshot::take(world), caption(&observation)));
        }
        let every = u64::from(self.scene.output.frames_every);
        if every > 0 && increment.is_multiple_of(every) {
            let path = directory::frame(&self.options.directory, increment);
            frames::write_frame(&path, &Snapshot::take(world))?;
        }
        if self.options.dump_programs.contains(&increment) {
            dump::write_program(&directory::program(&self.options.directory, increment), world)?;
        }
        let row =
            timings::row(increment, world.resource::<Timings>(), clock.elapsed().as_secs_f64());
        self.timings.push(row)
    }

    /// Ends the output: last particles, outcome, key results, pictures.
    ///
    /// # Errors
    /// Where something cannot be written.
    pub fn finish(&mut self, world: &mut World, ending: &Ending) -> Result<Results, OutputError> {
        let dir = self.options.directory.clone();
        let last = Snapshot::take(world);
        frames::write_frame(&dir.join(directory::FINAL_PARTICLES), &last)?;
        let observation = world.resource::<Observation>();
        let (stage, increment) = (observation.stage.clone(), observation.increment);
        let caption = caption(observation);
        let outcome = match ending {
            Ending::Finished(outcome) => Some(outcome),
            Ending::Interrupted => None,
        };
        let results = self.results.results();
        self.record.outcome = OutcomeRecord::new(outcome, stage, increment);
        self.record.results = results.clone();
        // The pictures come last: should they fail, the numbers are complete.
        self.record.write(&dir.join(directory::RUN))?;
        if self.scene.output.plots {
            let history = plots::history::History::read(&dir.join(directory::HISTORY))?;
            plots::curves(&dir, &self.scene.title, &history)?;
            plots::specimens(
                &dir,
                &self.scene.title,
                &self.start,
                [
                    (plots::SPECIMEN_PEAK, self.peak.as_ref().map(|(s, c)| (s, c.as_str()))),
                    (plots::SPECIMEN, Some((&last, caption.as_str()))),
                ],
            )?;
        }
        Ok(results)
    }

    /// Once, after the first increment of the reference stage.
    fn begin_reference(&mut self, world: &World) -> Result<(), OutputError> {
        let Some(prepared) = self.prepared.take() else { return Ok(()) };
        self.write_specimen(&prepared)?;
        self.results.set_porosity(porosity::porosity(world, &prepared.snapshot));
        self.start = prepared.snapshot;
        Ok(())
    }

    fn write_specimen(&self, prepared: &Prepared) -> Result<(), OutputError> {
        let path = self.options.directory.join(directory::SPECIMEN);
        frames::write_specimen(&path, &prepared.rows)
    }
}

fn caption(o: &Observation) -> String {
    let strain =
        o.axial_strain.map(|e| format!(", axial strain {:.3} % (contraction positive)", 100.0 * e));
    format!("increment {} of stage {}{}", o.increment, o.stage, strain.unwrap_or_default())
}

/// Whether nothing in a scene is elastic.
fn is_rigid(scene: &Scene) -> bool {
    let rigid = |c: &Contact| c.normal_stiffness.is_none() && c.tangential_stiffness.is_none();
    scene.walls.iter().all(|wall| rigid(&wall.contact))
        && scene.materials.values().all(|m| {
            let bond = m.bond.as_ref();
            rigid(&m.contact)
                && bond.is_none_or(|b| {
                    b.normal_stiffness.is_none() && b.tangential_stiffness.is_none()
                })
        })
}

#[cfg(test)]
mod tests {
    use std::error::Error;
    use std::path::Path;

    use clastic_components::program::SolveStatus;
    use clastic_systems::solve_program::ConeSolver;
    use clastic_systems::solve_program::clarabel::Clarabel;

    use super::*;
    use crate::run::{Simulation, Step};
    use crate::scene::from_str;

    const SCENE: &str = r#"(
        version: 1,
        title: "two disks pulled apart",
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

    /// Names and contents of all files but the timings.
    fn files(directory: &Path) -> Result<Vec<(String, String)>, Box<dyn Error>> {
        let mut all = Vec::new();
        for directory in [directory.to_owned(), directory.join(directory::FRAMES)] {
            for entry in fs::read_dir(directory)? {
                let path = entry?.path();
                if path.is_file() && !path.ends_with(directory::TIMINGS) {
                    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    all.push((name, fs::read_to_string(path)?));
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
            "events.csv",
            "final_particles.csv",
            "frame_000002.csv",
            "frame_000004.csv",
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
        let (program, dumped) = dump::read_program(&path)?;
        assert_eq!(dumped.status, SolveStatus::Solved);
        let solution = Clarabel::default().solve(&program)?;
        for (f, g) in solution.forces.iter().zip(&dumped.forces) {
            assert!((f[0] - g[0]).abs() <= 1e-9 * g[0].abs(), "{f:?} {g:?}");
        }
        let other = fs::read_to_string(&path)?.replacen("version 1", "version 0", 1);
        fs::write(&path, other)?;
        assert!(dump::read_program(&path).is_err());
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
