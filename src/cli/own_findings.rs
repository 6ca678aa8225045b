//! Mistakes that only this program finds in a valid scene.

use bevy_app::App;

use crate::run::plugin::{OWN_PROGRAM, Provided};
use crate::scene::Finding;
use crate::scene::format::{Scene, WallControl};
use crate::text::spans::join;

/// Finds walls, stages and measures that a scene leaves to an embedding program, and that the
/// plugins of this program do not provide. Such a wall would stand still without a message.
pub fn own_findings(scene: &Scene, app: &App) -> Vec<Finding> {
    let provided = app.world().resource::<Provided>();
    let mut findings = provided.missing(scene);
    for (i, stage) in scene.stages.iter().enumerate().filter(|_| !provided.walls) {
        let walls = stage.load().into_iter().flat_map(|load| &load.walls);
        let custom = walls.filter(|(_, control)| **control == WallControl::Custom);
        findings.extend(custom.map(|(name, _)| {
            let message = "`Custom` leaves the wall to an embedding program, and no plugin of this one drives it";
            let help =
                format!("give it `Fixed`, `Displacement`, `Force` or `Stress`, or {OWN_PROGRAM}");
            Finding::new(join(&format!("stages[{i}].walls"), name), message, help)
        }));
    }
    findings
}
