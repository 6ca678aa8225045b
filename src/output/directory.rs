//! The run directory: its path, whether it is free, and the names of its files.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use super::OutputError;
use super::atomic::PART;

/// Version, scene and its hash, settings, outcome, key results, conventions.
pub const RUN: &str = "run.json";
/// The scene as run, overrides applied.
pub const SCENE: &str = "scene.ron";
/// One row per increment.
pub const HISTORY: &str = "history.csv";
/// One row per rupture.
pub const EVENTS: &str = "events.csv";
/// One row per avalanche.
pub const AVALANCHES: &str = "avalanches.csv";
/// Wall-clock times; all other files have equal bytes in every run.
pub const TIMINGS: &str = "timings.csv";
/// The prepared specimen, in the format of stored specimens.
pub(crate) const SPECIMEN: &str = "specimen.csv";
/// All particles at the end, in the format of stored specimens.
pub const FINAL_PARTICLES: &str = "final_particles.csv";
/// The state at the end.
pub const FINAL_STATE: &str = "final_state.npz";
/// The mechanism of the first collapse.
pub const MECHANISM: &str = "mechanism.csv";
/// The state between two increments, if requested or if a run stops early.
pub const CHECKPOINT: &str = "checkpoint.bin";
/// The state of a run that has ended, from which more stages or increments continue.
pub const FINAL_CHECKPOINT: &str = "final_checkpoint.bin";
/// Curves, animation and key results as a page, written at the end.
pub const REPORT: &str = "report.html";
/// Directory of the frames.
pub const FRAMES: &str = "frames";
/// Frame before the first increment of the reference stage.
pub(crate) const FRAME_START: &str = "start.npz";
/// Frame at the peak.
pub(crate) const FRAME_PEAK: &str = "peak.npz";
/// Frame at the end.
pub(crate) const FRAME_END: &str = "end.npz";

/// Files of the end of a run.
const OF_THE_END: [&str; 4] = [FINAL_PARTICLES, FINAL_STATE, FINAL_CHECKPOINT, REPORT];

/// Frames of moments that have no number.
pub(super) const OF_MOMENTS: [&str; 3] = [FRAME_START, FRAME_PEAK, FRAME_END];

/// Default directory for the results of a scene: `runs/<name of the scene>`.
pub fn default_directory(scene: &Path) -> PathBuf {
    Path::new("runs").join(scene.file_stem().unwrap_or("scene".as_ref()))
}

/// Path of a dumped program.
pub fn program(directory: &Path, increment: u64) -> PathBuf {
    directory.join(format!("program_{increment:06}.json"))
}

/// Prepares `directory` for a run. It must be empty or absent unless `force` is given. `force`
/// removes the files of an earlier run and nothing else. Returns the history, open, locked and empty.
/// While it is open, no other run can claim the directory.
///
/// # Errors
/// [`OutputError::InUse`] if another run is writing there, whose files are then unchanged.
/// [`OutputError::Exists`] if the directory is not empty and `force` is not given.
pub fn claim(directory: &Path, force: bool) -> Result<File, OutputError> {
    fs::create_dir_all(directory).map_err(OutputError::at(directory))?;
    let path = directory.join(HISTORY);
    if !force && !entries(directory)?.is_empty() {
        let used = File::open(&path).is_ok_and(|history| !lock(&history));
        let error = if used { OutputError::InUse } else { OutputError::Exists };
        return Err(error(directory.to_owned()));
    }
    // The file that carries the lock is neither removed nor replaced, because two runs that begin
    // simultaneously must lock one file.
    let history = open_lock(&path)?;
    if !lock(&history) {
        return Err(OutputError::InUse(directory.to_owned()));
    }
    // A directory that was given by mistake may contain other files, so only known names are
    // removed.
    remove_files(directory, |name| is_ours(name) && name != HISTORY)?;
    remove_frames(directory, |_| true, &OF_MOMENTS)?;
    history.set_len(0).map_err(OutputError::at(&path))?;
    Ok(history)
}

/// Opens a file that carries a lock. It is made if it is not there, and keeps its content.
pub(crate) fn open_lock(path: &Path) -> Result<File, OutputError> {
    let mut open = OpenOptions::new();
    let file = open.read(true).write(true).create(true).truncate(false).open(path);
    file.map_err(OutputError::at(path))
}

/// Locks a file while it is open. Returns whether it was unlocked.
pub fn lock(file: &File) -> bool {
    // On a file system without locks no other run can hold one.
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}

/// Removes the files that a run wrote after `increment` and does not continue: the files of its
/// end, later frames and programs, and incomplete files. It also removes the prepared specimen and
/// the mechanism of a collapse, unless they are among the files `there`, which existed at that
/// increment.
pub(super) fn rewind(directory: &Path, increment: u64, there: &[&str]) -> Result<(), OutputError> {
    remove_files(directory, |name| {
        let of_the_end = !there.contains(&name)
            && (OF_THE_END.contains(&name)
                || [SPECIMEN, MECHANISM].contains(&name)
                || is_saved_state(name));
        let later = numbered(name, "program_", ".json").is_some_and(|n| n > increment);
        let part = name.strip_suffix(PART).is_some_and(is_ours);
        of_the_end || later || part
    })?;
    let gone: Vec<_> = OF_MOMENTS.into_iter().filter(|name| !there.contains(name)).collect();
    remove_frames(directory, |number| number > increment, &gone)
}

/// Removes frames by number, those of the named moments, and incomplete frames.
fn remove_frames(
    directory: &Path,
    which: impl Fn(u64) -> bool,
    moments: &[&str],
) -> Result<(), OutputError> {
    let frames = directory.join(FRAMES);
    if !frames.is_dir() {
        return Ok(());
    }
    remove_files(&frames, |name| {
        let part = name.strip_suffix(PART);
        let number_of = |extension| numbered(part.unwrap_or(name), "frame_", extension);
        let number = [".csv", ".svg", ".npz"].into_iter().find_map(number_of);
        let of_moment = match part {
            Some(name) => OF_MOMENTS.contains(&name),
            None => moments.contains(&name),
        };
        of_moment || number.is_some_and(|number| part.is_some() || which(number))
    })
}

fn remove_files(directory: &Path, which: impl Fn(&str) -> bool) -> Result<(), OutputError> {
    for name in entries(directory)?.iter().filter(|name| which(name)) {
        let path = directory.join(name);
        fs::remove_file(&path).map_err(OutputError::at(&path))?;
    }
    Ok(())
}

/// Names of the files of a directory.
pub(crate) fn entries(directory: &Path) -> Result<Vec<String>, OutputError> {
    let entries = fs::read_dir(directory).map_err(OutputError::at(directory))?;
    let names = entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    names.collect::<io::Result<_>>().map_err(OutputError::at(directory))
}

/// Content of the `run.json` of a directory.
///
/// # Errors
/// If the file does not exist or cannot be read.
pub fn record(directory: &Path) -> Result<serde_json::Value, OutputError> {
    let path = directory.join(RUN);
    let text = match fs::read_to_string(&path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Err(OutputError::NoRun(directory.to_owned()));
        }
        text => text.map_err(OutputError::at(&path))?,
    };
    serde_json::from_str(&text).map_err(OutputError::at(&path))
}

/// Removes a file if it exists.
pub(crate) fn remove_if_there(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(OutputError::at(path)(error)),
        _ => Ok(()),
    }
}

fn is_ours(name: &str) -> bool {
    let name = name.strip_suffix(PART).unwrap_or(name);
    [RUN, SCENE, HISTORY, EVENTS, AVALANCHES, TIMINGS, SPECIMEN, MECHANISM, CHECKPOINT]
        .contains(&name)
        || OF_THE_END.contains(&name)
        || is_saved_state(name)
        || numbered(name, "program_", ".json").is_some()
}

/// Whether a file is the state of a `Save` stage.
fn is_saved_state(name: &str) -> bool {
    name.starts_with("state_") && name.ends_with(".npz")
}

/// The number in a name.
fn numbered(name: &str, prefix: &str, suffix: &str) -> Option<u64> {
    let digits = name.strip_prefix(prefix)?.strip_suffix(suffix)?;
    digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_not_written_over_without_force() -> Result<(), Box<dyn std::error::Error>> {
        let parent = tempfile::tempdir()?;
        let dir = parent.path().join("a/b");
        drop(claim(&dir, false)?);
        assert!(claim(&dir, false).is_err_and(|e| e.to_string().contains("--force")));
        fs::create_dir(dir.join(FRAMES))?;
        for path in [
            dir.join(RUN),
            dir.join("notes.txt"),
            dir.join(FRAMES).join("frame_000007.csv"),
            program(&dir, 1),
        ] {
            fs::write(path, "")?;
        }
        let refused = claim(&dir, false);
        let message = refused.err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains("a/b") && message.contains("--force"), "{message}");
        assert!(dir.join(RUN).exists());
        let history = claim(&dir, true)?;
        let mut left = entries(&dir)?;
        left.sort();
        assert_eq!(left, [FRAMES, HISTORY, "notes.txt"]);
        assert!(entries(&dir.join(FRAMES))?.is_empty());

        // Now the directory is in use: other runs cannot claim it, with or without force, and
        // change nothing.
        fs::write(dir.join(RUN), "of the first")?;
        for force in [false, true] {
            assert!(claim(&dir, force).is_err_and(|e| e.to_string().contains("still writing")));
        }
        assert_eq!(fs::read_to_string(dir.join(RUN))?, "of the first");
        drop(history);
        claim(&dir, true)?;
        assert!(!dir.join(RUN).exists());
        Ok(())
    }

    #[test]
    fn a_file_in_the_way_is_named() -> Result<(), Box<dyn std::error::Error>> {
        let parent = tempfile::tempdir()?;
        let file = parent.path().join("taken");
        fs::write(&file, "")?;
        assert!(claim(&file, true).is_err_and(|e| e.to_string().contains("taken")));
        Ok(())
    }

    #[test]
    fn default_directory_is_named_after_the_scene() {
        assert_eq!(default_directory(Path::new("scenes/uniaxial.ron")), Path::new("runs/uniaxial"));
    }
}
