//! `clastic check`: reads a scene and reports its mistakes.

use bevy_app::App;

use crate::run::minerals::specimen;
use crate::run::sanity::{before, heights};
use crate::scene::load_with;
use crate::scene::memory::poured;
use crate::scene::one_round::one_round;
use crate::text::shown::label;

use super::SceneArgs;
use super::exit::{Exit, Failure, say};
use super::memory::fits;
use super::own_findings::own_findings;
use super::resolve::resolve;
use super::summary::{in_one_round, number};

pub fn check(args: &SceneArgs, app: &App) -> Result<Exit, Failure> {
    let further = |scene: &_| own_findings(scene, app);
    let loaded = load_with(&resolve(&args.scene)?, &args.sets, true, further)?;
    fits(&loaded)?;
    let scene = &loaded.scene;
    let poured: f64 = scene.stages.iter().map(|stage| poured(scene, stage)).sum();
    let poured = if poured > 0.0 { format!(" and about {poured} poured") } else { String::new() };
    say(format_args!(
        "ok: {}, {}{poured}, {}, {}",
        label(&scene.title),
        number(specimen(scene, loaded.specimen.as_ref()).len(), "particle"),
        number(scene.walls.len(), "wall"),
        number(scene.stages.len(), "stage"),
    ))?;
    if let Some(reason) = one_round(scene) {
        say(format_args!("note: {}", in_one_round(&reason)))?;
    }
    let sanity = before(scene, loaded.specimen.as_ref());
    if !sanity.line().is_empty() {
        say(format_args!("estimate: {}", sanity.line()))?;
    }
    for height in heights(scene, loaded.specimen.as_ref()) {
        say(format_args!("estimate: {height}"))?;
    }
    for warning in &sanity.warnings {
        say(format_args!("WARNING: {warning}"))?;
    }
    Ok(Exit::Ok)
}
