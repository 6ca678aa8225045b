//! `clastic list`: scenes that can be run by name.

use crate::scene::load;
use crate::scene::shown::label;

use super::exit::{Exit, Failure, say};
use super::resolve::{SCENES, scenes};

/// Lists the scenes with their titles.
pub fn list() -> Result<Exit, Failure> {
    let scenes = scenes().map_err(|error| Failure {
        exit: Exit::Files,
        message: format!("./{SCENES}: {error}; go to another directory, or give `run` a path"),
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
