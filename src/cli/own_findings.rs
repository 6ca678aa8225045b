//! Mistakes that only this program finds in a valid scene.

use bevy_app::App;

use crate::run::plugin::Provided;
use crate::scene::Finding;
use crate::scene::format::{Quantity, Scene, Stage, WallControl};
use crate::text::spans::join;
use crate::text::suggest;

/// The remedy where a program has no plugin at all.
const OWN_PROGRAM: &str = "run the scene in a program of your own (ARCHITECTURE.md, Extending)";

/// Finds walls, stages and measures that a scene leaves to an embedding program, and that the
/// plugins of this program do not provide. Such a wall would stand still without a message.
pub fn own_findings(scene: &Scene, app: &App) -> Vec<Finding> {
    let provided = app.world().resource::<Provided>();
    let stages: Vec<&str> = provided.stages.iter().copied().collect();
    let measures: Vec<&str> = provided.measures().collect();
    let mut findings = Vec::new();
    for (i, stage) in scene.stages.iter().enumerate() {
        if let Stage::Custom(stage) = stage {
            let what = ("a kind of stage", "give a `Load`, `Compact` or `Cement`, or");
            findings.extend(missing(format!("stages[{i}].kind"), &stage.kind, what, &stages));
        }
        let Some(stage) = stage.load() else { continue };
        let custom = stage.walls.iter().filter(|(_, control)| **control == WallControl::Custom);
        findings.extend(custom.filter(|_| !provided.walls).map(|(name, _)| {
            Finding::new(
                join(&format!("stages[{i}].walls"), name),
                "`Custom` leaves the wall to a system of an embedding program, and the `clastic` program has none",
                format!(
                    "give it `Fixed`, `Displacement`, `Velocity`, `Force` or `Stress`, or {OWN_PROGRAM}"
                ),
            )
        }));
    }
    for (i, measure) in scene.measures.iter().enumerate() {
        if let Quantity::Custom(kind) = &measure.of {
            let what = ("a measure", "leave it out, or");
            findings.extend(missing(format!("measures[{i}].of[0]"), kind, what, &measures));
        }
    }
    findings
}

/// Finds a name that is not among those that plugins have `provided`.
fn missing(
    path: String,
    name: &str,
    (what, instead): (&str, &str),
    provided: &[&str],
) -> Option<Finding> {
    let kinds = if what == "a measure" { "measures" } else { "kinds" };
    let (message, help) = match provided {
        _ if name.trim().is_empty() || provided.contains(&name) => return None,
        [] => (
            format!(
                "`{name}` is {what} that a plugin of an embedding program provides, and the \
                 `clastic` program has none"
            ),
            format!("{instead} {OWN_PROGRAM}"),
        ),
        _ => (
            format!("`{name}` is {what} that no plugin of this program provides"),
            suggest::help(name, provided, &format!("{kinds} of its plugins")),
        ),
    };
    Some(Finding::new(path, message, help))
}
