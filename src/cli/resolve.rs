//! Scenes by name: the file of an argument, and `clastic list`.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::scene::{load, shipped};
use crate::text::shown::label;
use crate::text::suggest;

use super::exit::{Exit, Failure, say};

/// Directory of scenes that can be run by name.
pub const SCENES: &str = "scenes";

/// Path of a scene: a file, with or without its `.ron`, or the name of a scene in [`SCENES`] or of
/// a shipped scene. A directory is never taken for a scene.
///
/// # Errors
/// If there is no such scene; the message says where it was looked for.
pub fn resolve(scene: &Path) -> Result<PathBuf, Failure> {
    if scene.exists() && !scene.is_dir() {
        return Ok(scene.to_owned());
    }
    let with_extension = scene.with_extension("ron");
    if scene.extension().is_none() && with_extension.is_file() {
        return Ok(with_extension);
    }
    let name = scene.to_string_lossy();
    let fail = |message| Err(Failure::new(Exit::Files, message));
    if scene.components().count() != 1 {
        return fail(format!("no scene `{}`: no such file", label(&name)));
    }
    let stem = name.strip_suffix(".ron").unwrap_or(&name);
    let path = Path::new(SCENES).join(format!("{stem}.ron"));
    if path.is_file() {
        return Ok(path);
    }
    if let Some(path) = shipped::path(stem) {
        return Ok(path);
    }
    let known = scenes().unwrap_or_default();
    let help = suggest::nearest(stem, known.keys().map(String::as_str)).map_or_else(
        || "`clastic list` shows the scenes that have a name".to_owned(),
        |near| format!("did you mean `{near}`?"),
    );
    fail(format!(
        "no scene `{}`: no such file here, none in ./{SCENES}, and clastic ships none of that name; {help}",
        label(&name)
    ))
}

/// Scenes that can be run by name: those in [`SCENES`], and the shipped scenes with other names.
///
/// # Errors
/// If [`SCENES`] cannot be read.
pub fn scenes() -> io::Result<BTreeMap<String, PathBuf>> {
    let shipped = shipped::names().filter_map(|name| Some((name.to_owned(), shipped::path(name)?)));
    let mut scenes: BTreeMap<_, _> = shipped.collect();
    let here = match fs::read_dir(SCENES) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(scenes),
        here => here?,
    };
    for entry in here {
        let path = entry?.path();
        if let (Some(name), true) = (path.file_stem(), path.extension() == Some("ron".as_ref())) {
            scenes.insert(name.to_string_lossy().into_owned(), path);
        }
    }
    Ok(scenes)
}

/// Lists the scenes with their titles.
pub fn list() -> Result<Exit, Failure> {
    let scenes = scenes().map_err(|error| {
        let remedy = "go to another directory, or give `run` a path";
        Failure::new(Exit::Files, format_args!("./{SCENES}: {error}; {remedy}"))
    })?;
    let width = scenes.keys().map(|name| name.chars().count()).max().unwrap_or(0);
    for (name, path) in scenes {
        let title = load(&path, &[]).map_or_else(
            |_| format!("(has errors; see `clastic check {name}`)"),
            |loaded| label(&loaded.scene.title),
        );
        say(format_args!("{name:width$}  {title}"))?;
    }
    Ok(Exit::Ok)
}
