//! `clastic check`: reads a scene and reports its mistakes.

use clastic::run::particles::particles;
use clastic::scene::load_with;
use clastic::scene::shown::label;

use super::SceneArgs;
use super::exit::{Exit, Failure, say};
use super::memory::fits;
use super::own_findings::own_findings;
use super::resolve::resolve;

/// Checks a scene.
pub fn check(args: &SceneArgs) -> Result<Exit, Failure> {
    let loaded = load_with(&resolve(&args.scene)?, &args.sets, own_findings)?;
    fits(&loaded)?;
    let scene = &loaded.scene;
    say(format_args!(
        "ok: {}, {}, {}, {}",
        label(&scene.title),
        number(particles(&scene.specimen, loaded.specimen.as_ref()).len(), "particle"),
        number(scene.walls.len(), "wall"),
        number(scene.stages.len(), "stage"),
    ))?;
    Ok(Exit::Ok)
}

fn number(n: usize, of: &str) -> String {
    format!("{n} {of}{}", if n == 1 { "" } else { "s" })
}
