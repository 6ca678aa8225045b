//! Begins or continues the output of a run.

use std::fs;
use std::path::Path;
use std::time::Instant;

use bevy_ecs::prelude::*;

use clastic_systems::gather_bodies::gather_bodies;

use super::atomic::{write_atomic, write_durable};
use super::avalanches::{self, CurrentAvalanche};
use super::checkpoint::{Checkpoint, WHOLE};
use super::csv_file::CsvFile;
use super::found::Found;
use super::frames::{self, FrameMoments};
use super::prepared::{Prepared, PreparedSpecimen};
use super::run_directory::{RunDirectory, RunOptions, Tables};
use super::run_record::{CLASTIC_VERSION, Resumed, RunFacts, RunRecord};
use super::save::{is_last_increment, keep_last, save};
use super::wanted::Wanted;
use super::{OutputError, ResumeError, directory, events, history, names, states, timings};
use crate::run::stages::Script;
use crate::scene::LoadedScene;
use crate::scene::format::Scene;

/// Begins the output of a scene. `world` is the state before the first stage, and has
/// [`OutputPlugin`](super::OutputPlugin). Inserts [`RunDirectory`] and the resources that follow
/// the run: `PreparedSpecimen`, `CurrentAvalanche`.
///
/// ```
/// use clastic::output::{self, Ending, OutputPlugin, RunOptions};
/// use clastic::prelude::*;
/// use clastic::scene::load;
///
/// # let directory = std::env::temp_dir().join(format!("clastic_{}", std::process::id()));
/// let loaded = load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tension.ron").as_ref(), &[])?;
/// let mut simulation = Simulation::with_plugins(&loaded.scene, None, OutputPlugin);
/// let options = RunOptions { directory: directory.clone(), ..Default::default() };
/// output::begin(simulation.world_mut(), options, &loaded)?;
/// let outcome = simulation.run();
/// let results = output::finish(simulation.world_mut(), &Ending::Finished(outcome))?;
/// assert_eq!(results.bonds_broken.tension, 1);
/// assert!(directory.join("history.csv").exists());
/// # std::fs::remove_dir_all(directory)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the directory is in use, or cannot be written.
pub fn begin(
    world: &mut World,
    options: RunOptions,
    loaded: &LoadedScene,
) -> Result<(), OutputError> {
    let reference_stage = Script::new(&loaded.scene).reference_stage();
    // This precedes all removals, because the stored specimen may lie in this directory.
    let facts = RunFacts::new(loaded, &options.overrides)?;
    let record = RunRecord::new(loaded, &facts, reference_stage);
    let dir = options.directory.as_path();
    let history_file = directory::claim(dir, options.force)?;
    make_frames(dir, &loaded.scene)?;
    record.write(&dir.join(names::RUN))?;
    write_atomic(&dir.join(names::SCENE), &loaded.text)?;
    let probes = history::probes(&loaded.scene);
    let tables = Tables {
        history: CsvFile::begin(
            dir.join(names::HISTORY),
            history_file,
            history::columns(&loaded.scene),
        )?,
        events: CsvFile::create(dir.join(names::EVENTS), events::COLUMNS)?,
        avalanches: CsvFile::create(dir.join(names::AVALANCHES), avalanches::COLUMNS)?,
        timings: CsvFile::create(dir.join(names::TIMINGS), timings::COLUMNS)?,
    };
    let fresh = vec![dir.join(names::SCENE)];
    // A world without increments has no tables yet. Gathering them does not change the run.
    let _ = world.run_system_cached(gather_bodies);
    let prepared = Prepared::take(world);
    let frames = FrameMoments::take(world, false);
    world.insert_resource(frames);
    world.insert_resource(PreparedSpecimen { waiting: Some(prepared), written: None });
    world.insert_resource(CurrentAvalanche::default());
    world.insert_resource(Found::default());
    let saves = options.checkpoint_every > 0;
    insert(
        world,
        RunDirectory {
            options,
            scene_text: loaded.text.clone(),
            facts,
            record,
            probes,
            tables,
            fresh,
            saved: None,
            saving: 0.0,
            clock: Instant::now(),
        },
    );
    if saves {
        save(world)?;
    }
    Ok(())
}

/// Continues the output of a run from its checkpoint. All output after the checkpoint is dropped.
/// `world` is the restored state and has [`OutputPlugin`](super::OutputPlugin). `loaded` is the
/// scene with `settings` applied. `every` replaces the number of increments between checkpoints.
///
/// # Errors
/// If the directory is in use, has changed, or cannot be written.
pub fn resume(
    world: &mut World,
    directory: &Path,
    checkpoint: Checkpoint,
    loaded: &LoadedScene,
    settings: &[String],
    every: Option<u32>,
) -> Result<(), ResumeError> {
    let increment = checkpoint.increment;
    let [history, events, avalanches, timings] = checkpoint.lengths;
    let open = |name: &str, length| {
        let path = directory.join(name);
        let whole = || fs::metadata(&path).map_or(0, |file| file.len());
        CsvFile::open(path.clone(), if length == WHOLE { whole() } else { length })
    };
    let history = open(names::HISTORY, history)?;
    if !history.lock() {
        return Err(OutputError::InUse(directory.to_owned()).into());
    }
    let mut tables = Tables {
        history,
        events: open(names::EVENTS, events)?,
        avalanches: open(names::AVALANCHES, avalanches)?,
        timings: open(names::TIMINGS, timings)?,
    };

    // Every step from here on can be repeated, so a process that is killed between two of them
    // can resume again.
    let scene_file = directory.join(names::SCENE);
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
    let mut there = whole_files(world);
    there.extend(kept.iter().map(String::as_str));
    let has_begun = world.resource::<PreparedSpecimen>().waiting.is_none();
    there.extend(frames::kept(directory, increment, has_begun));
    directory::rewind(directory, increment, &there)?;
    make_frames(directory, &loaded.scene)?;
    let reference_stage = Script::new(&loaded.scene).reference_stage();
    let mut record = RunRecord::new(loaded, &next.facts, reference_stage);
    record.write(&directory.join(names::RUN))?;
    record.increments = states::increments(&next.world);
    tables.cut()?;
    let _ = world.run_system_cached(gather_bodies);
    let frames = FrameMoments::take(world, has_begun);
    world.insert_resource(frames);
    let options = RunOptions {
        directory: directory.to_owned(),
        force: false,
        overrides: Vec::new(),
        dump_programs: next.dump_programs,
        dump_in_stages: next.dump_in_stages,
        checkpoint_every: next.every,
    };
    insert(
        world,
        RunDirectory {
            options,
            scene_text: next.scene,
            facts: next.facts,
            record,
            probes: history::probes(&loaded.scene),
            tables,
            fresh: Vec::new(),
            saved: Some(increment),
            saving: 0.0,
            clock: Instant::now(),
        },
    );
    // A run that was interrupted after its last increment has no other.
    if world.run_system_cached(is_last_increment).unwrap_or(false) {
        keep_last(world)?;
    }
    Ok(())
}

fn insert(world: &mut World, run: RunDirectory) {
    world.insert_resource(run);
    world.init_resource::<Wanted>();
}

/// Existing files that are written once and not rewritten at the end of the run.
fn whole_files<'a>(world: &World) -> Vec<&'a str> {
    let mut files = Vec::new();
    if world.resource::<PreparedSpecimen>().written.is_some() {
        files.push(names::SPECIMEN);
    }
    if world.resource::<Found>().has_mechanism() {
        files.push(names::MECHANISM);
    }
    files
}

fn make_frames(directory: &Path, scene: &Scene) -> Result<(), OutputError> {
    if scene.asks_for_frames() || frames::ARE_ARRAYS {
        let path = directory.join(names::FRAMES);
        fs::create_dir_all(&path).map_err(OutputError::at(&path))?;
    }
    Ok(())
}
