//! Mistakes that only this program finds in a valid scene.

use clastic::scene::Finding;
use clastic::scene::format::{Scene, Stage, WallControl};
use clastic::scene::spans::join;

/// Finds walls and stages that a scene leaves to an embedding program. This program has no system
/// for such walls, which would stand still without a message, and no plugin for such stages.
pub fn own_findings(scene: &Scene) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (i, stage) in scene.stages.iter().enumerate() {
        if let Stage::Custom(stage) = stage {
            findings.push(Finding::new(
                format!("stages[{i}].kind"),
                format!(
                    "`{}` is a kind of stage that a plugin of an embedding program provides, and the \
                     `clastic` program has none",
                    stage.kind
                ),
                "give a `Load`, `Compact` or `Cement`, or run the scene in a program of your own \
                 (ARCHITECTURE.md, Extending)",
            ));
        }
        let Stage::Load(stage) = stage else { continue };
        let custom = stage.walls.iter().filter(|(_, control)| **control == WallControl::Custom);
        findings.extend(custom.map(|(name, _)| {
            Finding::new(
                join(&format!("stages[{i}].walls"), name),
                "`Custom` leaves the wall to a system of an embedding program, and the `clastic` program has none",
                "give it `Fixed`, `Displacement`, `Velocity`, `Force` or `Stress`, or run the scene in a \
                 program of your own (ARCHITECTURE.md, Extending)",
            )
        }));
    }
    findings
}
