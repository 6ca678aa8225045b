//! Version, analysis, solver and acceptance.

use clastic_components::domain;

use crate::scene::format::{Analysis, Avalanche, FrictionLaw, RuptureOrder, Solver, VERSION};

use super::findings::Findings;

/// More halvings than this make an increment smaller than its round-off.
const MOST_HALVINGS: u32 = 30;

pub(super) fn check(findings: &mut Findings) {
    let scene = findings.context.scene;
    if scene.version != VERSION {
        let message = format!("unknown version ({})", scene.version);
        let help = format!("this build reads version {VERSION}");
        findings.add(format_args!("version"), message, &help);
    }
    findings.within(format_args!("thickness"), scene.thickness, domain::THICKNESS);
    findings.vector(format_args!("gravity"), scene.gravity, domain::GRAVITY.what);
    analysis(format_args!("analysis"), scene.analysis, findings);
    if let FrictionLaw::Coulomb { factorisations } = scene.friction_law {
        let path = format_args!("friction_law.factorisations");
        findings.at_least_one(path, factorisations, "a number");
    }
    let rupture = &scene.rupture;
    findings.within(format_args!("rupture.tolerance"), rupture.tolerance, domain::OVERLOAD);
    findings.within(format_args!("rupture.density"), rupture.density, domain::DENSITY_OF_RUPTURES);
    findings.within(format_args!("rupture.brittleness"), rupture.brittleness, domain::BRITTLENESS);
    if rupture.order != RuptureOrder::Events && rupture.avalanche != Avalanche::default() {
        let message = format!(
            "`{:?}` has no effect: with `order: {:?}` there are no avalanches",
            rupture.avalanche, rupture.order
        );
        let help = "give `order: Events`, or leave `avalanche` out";
        findings.add(format_args!("rupture.avalanche"), message, help);
    }
    if let Solver::Clarabel { tolerance, max_iterations } = scene.solver {
        let allowed = |value| value > 0.0 && value <= 1e-2;
        let what = "a tolerance above 0 and up to 1e-2";
        findings.number(format_args!("solver.tolerance"), tolerance, allowed, what);
        let path = format_args!("solver.max_iterations");
        findings.at_least_one(path, max_iterations, "a number");
    }
    let acceptance = scene.acceptance;
    findings.within(format_args!("acceptance.residual"), acceptance.residual, domain::RESIDUAL);
    findings.within(format_args!("acceptance.turn"), acceptance.turn, domain::TURN);
    if acceptance.halvings > MOST_HALVINGS {
        let message = format!("out of range ({})", acceptance.halvings);
        let help = format!("give a number up to {MOST_HALVINGS}");
        findings.add(format_args!("acceptance.halvings"), message, &help);
    }
}

/// The analysis of the scene or of a stage.
pub(super) fn analysis(path: std::fmt::Arguments, analysis: Analysis, findings: &mut Findings) {
    if let Analysis::Dynamic { dt, theta } = analysis {
        findings.within(format_args!("{path}.dt"), dt, domain::TIME_STEP);
        findings.within(format_args!("{path}.theta"), theta, domain::THETA);
    }
}
