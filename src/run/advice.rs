//! Advice about an increment that could not be solved: only remedies that were seen to help at
//! least a quarter of the increments with the same finding (docs/reliability.md, "Undecided
//! increments").

use bevy_ecs::prelude::*;

use clastic_components::domain::RESIDUAL;
use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, ConeSolution, SolveStatus};
use clastic_systems::assemble_program::known_pairs::{Forced, forced};

use super::compact;
use crate::scene::format::{Compact, CompactBy, Stage};
use crate::text::shown::label;

/// A solution whose maximum residual is below this is usable, although it misses the tolerance.
const GOOD: f64 = 1e-6;

/// The complaint about an undecided increment, with its place and advice.
pub(crate) fn with_advice(world: &mut World, stage: &Stage, complaint: String) -> String {
    let increment = world.resource::<ClasticProgress>().increment;
    let locked = world.resource::<ConeSolution>().status == SolveStatus::Locked;
    let forced = locked.then(|| forced(world.resource::<ConeProgram>())).flatten();
    let remedies = match stage {
        Stage::Compact(stage) if locked => vec![jammed(world, stage)],
        _ if forced.is_some() => vec![
            "imposed motions that keep the two apart".to_owned(),
            "a stiffness for their contact".to_owned(),
        ],
        _ if locked => vec![
            "a stiffness for the contacts of grains and walls".to_owned(),
            "a wall that gives way under a force".to_owned(),
        ],
        _ => of_equilibrium(world),
    };
    let complaint = match forced {
        Some(pair) => format!("locked: {}", driven_together(world, pair)),
        None => complaint,
    };
    let advice = if remedies.is_empty() {
        String::new()
    } else {
        format!("; try: {}", remedies.join(", or "))
    };
    format!("increment {increment}, in stage `{}`: {complaint}{advice}", label(stage.name()))
}

/// Remedies where forces or motions were not found.
fn of_equilibrium(world: &World) -> Vec<String> {
    let acceptance = world.resource::<Acceptance>();
    let mut remedies = Vec::new();
    let of_coulomb = world.resource::<Sliding>().rejected;
    let worst = of_coulomb.unwrap_or(world.resource::<ConeSolution>().residuals.worst());
    let is_near = if of_coulomb.is_some() { RESIDUAL.has(worst) } else { worst <= GOOD };
    if is_near && worst > acceptance.residual {
        remedies.push(format!("a greater `acceptance.residual` ({worst:.1e} was reached)"));
    }
    if acceptance.turn < Acceptance::default().turn {
        remedies.push("a greater `acceptance.turn`".to_owned());
    }
    if of_coulomb.is_some() {
        remedies.push("`friction_law: Associated`".to_owned());
    }
    if world.resource::<ClasticAnalysis>().kind == AnalysisKind::Static {
        remedies.push(
            "a stage with `analysis: Dynamic(..)` before it, in which the specimen comes to rest \
             under the same loads"
                .to_owned(),
        );
    }
    if world.resource::<ConeProgram>().interactions.iter().any(|c| c.normal_compliance == 0.0) {
        remedies.push("a stiffness for rigid contacts".to_owned());
    }
    remedies
}

/// Remedy for a packing that jams before its target, and what it has reached.
fn jammed(world: &mut World, stage: &Compact) -> String {
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
        "`target: Jammed`, as dense as it gets, or a greater {targets} (the packing is jammed before this \
         one{reached}), or another seed"
    )
}

/// Names two rigid bodies that imposed motions force into each other.
fn driven_together(world: &World, pair: Forced) -> String {
    let bodies = world.resource::<BodyTable>();
    // The last attempt may have been at a fraction of the increment, or at the fraction 0.
    let fraction = world.resource::<ClasticProgress>().fraction;
    let closing = if fraction > 0.0 { pair.closing / fraction } else { pair.closing };
    let overlap = closing - pair.gap;
    format!(
        "{} and {} are rigid and are moved into each other, to an overlap of {overlap:.3e} m",
        bodies.name(pair.a as usize),
        bodies.name(pair.b as usize)
    )
}
