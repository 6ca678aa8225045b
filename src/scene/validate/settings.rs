//! Version, named values, analysis, solver and acceptance.

use clastic_components::domain;

use crate::scene::format::{Analysis, Avalanche, FrictionLaw, RuptureOrder, Solver, VERSION};

use super::findings::At;

/// More halvings than this make an increment smaller than its round-off.
const MOST_HALVINGS: u32 = 30;

pub(super) fn check(at: &mut At) {
    let scene = at.context.scene;
    if scene.version != VERSION {
        let message = format!("unknown version ({})", scene.version);
        at.add("version", message, format!("this build reads version {VERSION}"));
    }
    for (name, value) in &scene.values {
        at.entry("let", name).finite("", *value, "a number");
    }
    at.within("thickness", scene.thickness, domain::THICKNESS);
    at.vector("gravity", scene.gravity, domain::GRAVITY.what);
    analysis(at, Some(scene.analysis));
    if let FrictionLaw::Coulomb { factorisations } = scene.friction_law {
        at.at_least_one("friction_law.factorisations", factorisations, "a number");
    }
    let rupture = &scene.rupture;
    at.within("rupture.tolerance", rupture.tolerance, domain::OVERLOAD);
    at.within("rupture.density", rupture.density, domain::DENSITY_OF_RUPTURES);
    at.within("rupture.brittleness", rupture.brittleness, domain::BRITTLENESS);
    if rupture.order != RuptureOrder::Events && rupture.avalanche != Avalanche::default() {
        let message = format!(
            "`{:?}` has no effect: with `order: {:?}` there are no avalanches",
            rupture.avalanche, rupture.order
        );
        let help = "give `order: Events`, or leave `avalanche` out";
        at.add("rupture.avalanche", message, help);
    }
    if let Solver::Clarabel { tolerance, max_iterations } = scene.solver {
        let allowed = |value| value > 0.0 && value <= 1e-2;
        at.number("solver.tolerance", tolerance, allowed, "a tolerance above 0 and up to 1e-2");
        at.at_least_one("solver.max_iterations", max_iterations, "a number");
    }
    let acceptance = scene.acceptance;
    at.within("acceptance.residual", acceptance.residual, domain::RESIDUAL);
    at.within("acceptance.turn", acceptance.turn, domain::TURN);
    if acceptance.halvings > MOST_HALVINGS {
        let message = format!("out of range ({})", acceptance.halvings);
        at.add("acceptance.halvings", message, format!("give a number up to {MOST_HALVINGS}"));
    }
}

/// The analysis of the scene or of a stage.
pub(super) fn analysis(at: &mut At, analysis: Option<Analysis>) {
    if let Some(Analysis::Dynamic { dt, theta }) = analysis {
        at.within("analysis.dt", dt, domain::TIME_STEP);
        at.within("analysis.theta", theta, domain::THETA);
    }
}
