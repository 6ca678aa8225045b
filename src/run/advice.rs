//! Advice about an increment that could not be solved.

use bevy_ecs::prelude::*;

use clastic_components::contact::Bodies;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind, Progress};
use clastic_components::wall::WallName;
use clastic_cone::program::{ConeProgram, ConeSolution, SolveStatus};
use clastic_systems::assemble_program::known_pairs::{Forced, forced};

use super::compact;
use crate::scene::format::{CompactBy, Stage};
use crate::scene::shown::label;

/// A solution whose maximum residual is below this is usable, although it misses the tolerance.
const GOOD: f64 = 1e-6;

/// The complaint about an undecided increment, with its place and advice.
pub fn with_advice(world: &mut World, stage: &Stage, complaint: &str) -> String {
    let increment = world.resource::<Progress>().increment;
    let name = label(stage.name());
    let dynamic = matches!(world.resource::<Analysis>().kind, AnalysisKind::Dynamic { .. });
    let locked = world.resource::<ConeSolution>().status == SolveStatus::Locked;
    let forced = locked.then(|| forced(world.resource::<ConeProgram>())).flatten();
    let mut advice = String::new();
    if let Some(worst) = nearly(world).filter(|_| !locked) {
        advice = format!("a greater `acceptance.residual` ({worst:.1e} was reached), ");
    }
    advice += &match (locked, stage) {
        (true, Stage::Compact(stage)) => {
            let radii = stage.by == CompactBy::Radii;
            let targets = if radii { "porosity" } else { "height or porosity" };
            let reached = compact::reached(world, stage).map_or(String::new(), |reached| {
                let at = if radii {
                    format!("mean radius of {:.4e} m", reached.mean_radius)
                } else {
                    format!("height of {:.4e} m", reached.height)
                };
                format!(": at a {at}, a porosity of {:.4}", reached.porosity)
            });
            format!(
                "a greater {targets} as the target (the packing is jammed before this \
                 one{reached}), a smaller step, another seed"
            )
        }
        (true, _) if forced.is_some() => {
            "imposed motions that keep the two apart, or a stiffness for their contact".to_owned()
        }
        (true, _) => {
            "a stiffness for the contacts, or a wall that is free to give way".to_owned()
        }
        _ if dynamic => "a smaller `dt`, a greater `acceptance.halvings`".to_owned(),
        _ => {
            "a stage with `analysis: Dynamic(..)` before it, in which the specimen comes to rest under the same \
             loads, a greater `acceptance.throw`, or walls that hold the specimen"
                .to_owned()
        }
    };
    let pair = forced.map_or(String::new(), |pair| format!(": {}", driven_together(world, pair)));
    format!("increment {increment}, in stage `{name}`: {complaint}{pair}; try: {advice}")
}

/// Names two rigid bodies that imposed motions force into each other.
fn driven_together(world: &World, pair: Forced) -> String {
    let bodies = world.resource::<Bodies>();
    let body = |row: u32| {
        let wall = bodies.entities.get(row as usize).and_then(|wall| world.get::<WallName>(*wall));
        match wall {
            Some(name) => format!("wall `{}`", name.0),
            None => bodies.name(row as usize),
        }
    };
    // The last attempt may have been at a fraction of the increment, or at the fraction 0.
    let fraction = world.resource::<Progress>().fraction;
    let closing = if fraction > 0.0 { pair.closing / fraction } else { pair.closing };
    let overlap = closing - pair.gap;
    format!(
        "{} and {} are rigid and are moved into each other, to an overlap of {overlap:.3e} m",
        body(pair.a),
        body(pair.b)
    )
}

/// Maximum residual of the best solution of the increment, if this solution is usable and only
/// `acceptance.residual` rejects it.
fn nearly(world: &World) -> Option<f64> {
    let worst = world.resource::<ConeSolution>().residuals.worst();
    let accepted = world.resource::<Acceptance>().residual;
    (worst > accepted && worst <= GOOD).then_some(worst)
}
