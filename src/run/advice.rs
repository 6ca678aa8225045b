//! What to say about an increment that could not be solved, and what to try.

use bevy_ecs::prelude::*;

use clastic_components::attempt::IncrementStatus;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind, Progress};
use clastic_components::program::ConeSolution;

use super::compact;
use crate::scene::format::Stage;

/// A solution whose greatest residual is below this is a good one, if not as good as was asked for.
const GOOD: f64 = 1e-6;

/// The complaint about an increment that ended as `status`, with its place and a remedy.
pub fn with_advice(
    world: &mut World,
    stage: &Stage,
    status: IncrementStatus,
    complaint: &str,
) -> String {
    let increment = world.resource::<Progress>().increment;
    let name = stage.name();
    let dynamic = matches!(world.resource::<Analysis>().kind, AnalysisKind::Dynamic { .. });
    let mut advice = String::new();
    if let Some(worst) = nearly(world).filter(|_| status == IncrementStatus::Stalled) {
        advice = format!("a greater `acceptance.residual` ({worst:.1e} was reached), ");
    }
    advice += &match (status, stage) {
        (IncrementStatus::Locked, Stage::Compact(stage)) => {
            let reached = compact::reached(world, stage).map_or(String::new(), |(height, porosity)| {
                format!(": at a height of {height:.4e} m, a porosity of {porosity:.4}")
            });
            format!(
                "a greater height or porosity as the target (the packing is jammed before this \
                 one{reached}), a smaller step"
            )
        }
        (IncrementStatus::Locked, _) => {
            "a stiffness for the contacts, or a wall that is free to give way".to_owned()
        }
        _ if dynamic => "a smaller `dt`, a greater `acceptance.halvings`".to_owned(),
        _ => {
            "smaller increments (more `increments`, smaller displacements), a greater `acceptance.halvings`, \
             or, if grains are thrown, walls that hold the specimen or a greater `acceptance.throw`"
                .to_owned()
        }
    };
    format!("increment {increment} of stage `{name}`: {complaint}; try: {advice}")
}

/// Greatest residual of the best solution of the increment, if it is a good one that
/// `acceptance.residual` alone keeps from being accepted.
fn nearly(world: &World) -> Option<f64> {
    let worst = world.resource::<ConeSolution>().residuals.worst();
    let accepted = world.resource::<Acceptance>().residual;
    (worst > accepted && worst <= GOOD).then_some(worst)
}
