//! Factors on gravity and strength in the course of a loading stage.

use bevy_ecs::prelude::*;

use clastic_components::increment::{ClasticAnalysis, ClasticProgress};
use clastic_components::wall::WallTable;

use super::script::Script;
use crate::scene::format::{Load, Scale, Stage};

/// Run condition: the stage has factors on gravity or strength.
pub(super) fn is_scaled(script: Option<Res<Script>>, progress: Res<ClasticProgress>) -> bool {
    script.is_some_and(|script| scaled(&script, &progress).is_some())
}

fn scaled<'a>(script: &'a Script, progress: &ClasticProgress) -> Option<&'a Load> {
    let load = script.stage(progress.stage).and_then(Stage::load)?;
    let Scale { gravity, strength, .. } = &load.scale;
    (gravity.is_some() || strength.is_some()).then_some(load)
}

/// Sets gravity and strength to those at the end of the attempt.
pub(super) fn scale(
    script: Res<Script>,
    progress: Res<ClasticProgress>,
    mut analysis: ResMut<ClasticAnalysis>,
) {
    let Some(load) = scaled(&script, &progress) else { return };
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
