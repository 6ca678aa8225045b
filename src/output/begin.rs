//! Begins or continues the output of a run.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use bevy_ecs::prelude::*;

use super::atomic::{durably, write_atomic};
use super::avalanches::{self, CurrentAvalanche};
use super::checkpoint::{Checkpoint, WHOLE};
use super::csv_file::{self, CsvFile, Row};
use super::found::Found;
use super::frames::{self, FrameMoments};
use super::prepared::{Prepared, PreparedSpecimen};
use super::run_directory::{RunDirectory, RunOptions, Tables};
use super::run_record::{CLASTIC_VERSION, Resumed, RunFacts, RunRecord};
use super::save::{is_last_increment, keep_last, save};
use super::{OutputError, directory, events, history, states, timings};
use crate::run::stages::Script;
use crate::scene::LoadedScene;

/// Begins the output of a scene. `world` is the state before the first stage, and has
/// [`OutputPlugin`](super::OutputPlugin). Inserts [`RunDirectory`] and the resources that follow
/// the run: `PreparedSpecimen`, `CurrentAvalanche`.
///
/// ```
/// use clastic::output::{self, OutputPlugin, RunOptions};
/// use clastic::prelude::*;
/// use clastic::scene::load;
///
/// # let directory = std::env::temp_dir().join(format!("clastic_{}", std::process::id()));
/// let loaded = load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tension.ron").as_ref(), &[])?;
/// let mut simulation = Simulation::in_app(clastic::run::app(OutputPlugin), &loaded.scene, None);
/// let options = RunOptions { directory: directory.clone(), ..Default::default() };
/// output::begin(simulation.world_mut(), options, &loaded)?;
/// let outcome = simulation.run();
/// let results = output::finish(simulation.world_mut(), Some(&outcome))?;
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
    // This precedes all removals, because the stored specimen may lie in this directory.
    let facts = RunFacts::new(loaded, &options.overrides)?;
    let record = RunRecord::new(loaded, &facts);
    let dir = options.directory.as_path();
    let history_file = directory::claim(dir, options.force)?;
    make_frames(dir)?;
    record.write(&dir.join(directory::RUN))?;
    write_atomic(&dir.join(directory::SCENE), &loaded.text)?;
    let create = |name: &str, header: Row| CsvFile::create(dir.join(name), header);
    let columns = history::columns(&loaded.scene);
    let header = Row::default().and(columns.iter().map(String::as_str));
    let tables = Tables {
        history: CsvFile::begin(dir.join(directory::HISTORY), history_file, header)?,
        events: create(directory::EVENTS, csv_file::header(&events::COLUMNS))?,
        avalanches: create(directory::AVALANCHES, csv_file::header(&avalanches::COLUMNS))?,
        timings: create(directory::TIMINGS, Row::default().and(timings::COLUMNS))?,
    };
    let fresh = vec![dir.join(directory::SCENE)];
    FrameMoments::begin(world, false);
    let waiting = Some(Prepared::now(world.resource(), world.resource()));
    world.insert_resource(PreparedSpecimen { waiting, written: None });
    world.insert_resource(CurrentAvalanche::default());
    world.insert_resource(Found::default());
    let saves = options.checkpoint_every > 0;
    let run = RunDirectory::new(options, loaded, facts, record, tables);
    world.insert_resource(RunDirectory { fresh, ..run });
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
) -> Result<(), OutputError> {
    let increment = checkpoint.increment;
    let [history, events, avalanches, timings] = checkpoint.lengths;
    let open = |name: &str, length| {
        let path = directory.join(name);
        let whole = || fs::metadata(&path).map_or(0, |file| file.len());
        CsvFile::open(path.clone(), if length == WHOLE { whole() } else { length })
    };
    let history = open(directory::HISTORY, history)?;
    if !directory::lock(&history.file) {
        return Err(OutputError::InUse(directory.to_owned()));
    }
    let mut tables = Tables {
        history,
        events: open(directory::EVENTS, events)?,
        avalanches: open(directory::AVALANCHES, avalanches)?,
        timings: open(directory::TIMINGS, timings)?,
    };

    // Every step from here on can be repeated, so a process that is killed between two of them
    // can resume again.
    let scene_file = directory.join(directory::SCENE);
    let write_scene = |text: &str| durably(&scene_file, |file| file.write_all(text.as_bytes()));
    write_scene(&checkpoint.scene)?;
    let mut next = checkpoint;
    next.options.checkpoint_every = every.unwrap_or(next.options.checkpoint_every);
    let is_changed = !settings.is_empty() || next.scene != loaded.text;
    if is_changed || next.clastic_version != CLASTIC_VERSION {
        next.clastic_version = CLASTIC_VERSION.to_owned();
        next.facts.resumed.push(Resumed {
            after_increment: increment,
            clastic_version: CLASTIC_VERSION.to_owned(),
            settings: settings.to_vec(),
        });
        next.scene_before = Some(std::mem::replace(&mut next.scene, loaded.text.clone()));
        next.write(directory, directory::CHECKPOINT)?;
        write_scene(&next.scene)?;
    }
    let specimen = world.resource::<PreparedSpecimen>();
    let has_begun = specimen.waiting.is_none();
    let files = [
        (directory::SPECIMEN, specimen.written.is_some()),
        (directory::MECHANISM, world.resource::<Found>().mechanism.is_some()),
        (directory::FRAME_START, has_begun),
        (directory::FRAME_PEAK, frames::has_peak(directory, increment)),
    ];
    let states = states::kept_before(world);
    let files = files.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name);
    let there: Vec<_> = files.chain(states.iter().map(String::as_str)).collect();
    directory::rewind(directory, increment, &there)?;
    make_frames(directory)?;
    let mut record = RunRecord::new(loaded, &next.facts);
    record.write(&directory.join(directory::RUN))?;
    // A run that starts from a saved state numbers its increments from those before.
    record.increments = world.resource::<Script>().ends.iter().map(|end| end.rows).sum();
    for table in tables.all() {
        table.cut()?;
    }
    FrameMoments::begin(world, has_begun);
    let options = RunOptions { directory: directory.to_owned(), ..next.options };
    let run = RunDirectory::new(options, loaded, next.facts, record, tables);
    world.insert_resource(RunDirectory { saved: Some(increment), ..run });
    // A run that was interrupted after its last increment has no other.
    if world.run_system_cached(is_last_increment).unwrap_or(false) {
        keep_last(world)?;
    }
    Ok(())
}

fn make_frames(directory: &Path) -> Result<(), OutputError> {
    let path = directory.join(directory::FRAMES);
    fs::create_dir_all(&path).map_err(OutputError::at(&path))
}
