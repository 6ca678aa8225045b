//! Factors on gravity and strength in the course of a loading stage.

use bevy_ecs::prelude::*;

use clastic_components::increment::{ClasticAnalysis, ClasticProgress};
use clastic_components::wall::WallTable;

use super::script::Script;
use crate::scene::format::Stage;

/// Sets gravity and strength to those at the end of the attempt, in a stage with factors on them.
pub(super) fn scale(
    script: Option<Res<Script>>,
    progress: Res<ClasticProgress>,
    mut analysis: ResMut<ClasticAnalysis>,
) {
    let Some(script) = script else { return };
    let Some(load) = script.stage(progress.stage).and_then(Stage::load) else { return };
    if load.scale.gravity.is_none() && load.scale.strength.is_none() {
        return;
    }
    let dt = analysis.kind.dt();
    let factor = |points: &Option<Vec<(f64, f64)>>| {
        let Some(points) = points else { return 1.0 };
        let table = WallTable(points.iter().map(|(s, factor)| [*s, *factor, 0.0]).collect());
        table.next(&progress, dt)[0].at(progress.fraction)
    };
    let (x, y) = load.gravity.unwrap_or(script.scene.gravity);
    analysis.gravity = factor(&load.scale.gravity) * glam::DVec2::new(x, y);
    analysis.strength = factor(&load.scale.strength);
}
