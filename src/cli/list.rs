//! `clastic list`: the scenes in `./scenes`.

use clastic::scene::load;

use super::exit::{Exit, Failure, say};
use super::resolve::{SCENES, scenes};

/// Lists the scenes with their titles.
pub fn list() -> Result<Exit, Failure> {
    let paths = scenes().map_err(|error| Failure {
        exit: Exit::Files,
        message: format!(
            "{SCENES}: {error}; go to a directory that has scenes, or give `run` a path"
        ),
    })?;
    let names: Vec<_> = paths
        .iter()
        .map(|path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned())
        .collect();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    for (path, name) in paths.iter().zip(&names) {
        let title = load(path, &[]).map_or_else(
            |_| format!("(not sound; see `clastic check {name}`)"),
            |loaded| loaded.scene.title,
        );
        say(format_args!("{name:width$}  {title}"))?;
    }
    Ok(Exit::Ok)
}
