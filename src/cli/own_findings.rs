//! Mistakes that only this program finds in a valid scene.

use clastic::scene::Finding;
use clastic::scene::format::{Scene, Stage, WallControl};
use clastic::scene::spans::join;

/// Finds walls that a scene leaves to a system of an embedding program. This program has no such
/// system, so these walls would stand still without a message.
pub fn own_findings(scene: &Scene) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (i, stage) in scene.stages.iter().enumerate() {
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
