//! Which file a scene argument means.

use std::fs;
use std::path::{Path, PathBuf};

use super::exit::{Exit, Failure};

/// Directory of the scenes that can be called by name.
pub const SCENES: &str = "scenes";

/// A file, with or without its `.ron`, or the bare name of a scene in [`SCENES`]. A directory that
/// happens to have the name of a scene is no scene.
pub fn resolve(scene: &Path) -> Result<PathBuf, Failure> {
    if scene.exists() && !scene.is_dir() {
        return Ok(scene.to_owned());
    }
    let with_extension = scene.with_extension("ron");
    if scene.extension().is_none() && with_extension.is_file() {
        return Ok(with_extension);
    }
    let name = scene.to_string_lossy();
    if scene.components().count() == 1 {
        let stem = name.strip_suffix(".ron").unwrap_or(&name);
        let path = Path::new(SCENES).join(format!("{stem}.ron"));
        if path.is_file() {
            return Ok(path);
        }
        if let Some(near) = nearest(stem) {
            let message =
                format!("no scene `{name}`, here or in {SCENES}/; did you mean `{near}`?");
            return Err(Failure { exit: Exit::Files, message });
        }
    }
    let message =
        format!("no scene `{name}`, here or in {SCENES}/; `clastic list` shows what is there");
    Err(Failure { exit: Exit::Files, message })
}

/// The scenes in [`SCENES`], by name.
pub fn scenes() -> std::io::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(SCENES)?.map(|entry| Ok(entry?.path()));
    let mut paths = entries.collect::<std::io::Result<Vec<PathBuf>>>()?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "ron"));
    paths.sort();
    Ok(paths)
}

/// The scene whose name is nearest to a misspelt one.
fn nearest(name: &str) -> Option<String> {
    let names = scenes()
        .ok()?
        .into_iter()
        .filter_map(|p| Some(p.file_stem()?.to_string_lossy().into_owned()));
    names
        .map(|candidate| (strsim::damerau_levenshtein(name, &candidate), candidate))
        .filter(|(distance, candidate)| 3 * distance <= candidate.chars().count())
        .min()
        .map(|(_, candidate)| candidate)
}
