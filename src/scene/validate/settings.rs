//! Version, analysis, solver and acceptance.

use crate::scene::format::{Analysis, Avalanche, FrictionLaw, RuptureOrder, Solver, VERSION};

use super::Context;
use super::findings::Findings;

/// More halvings than this make an increment smaller than its round-off.
const MOST_HALVINGS: u32 = 30;

pub(super) fn check(context: &Context, findings: &mut Findings) {
    let scene = context.scene;
    if scene.version != VERSION {
        let message = format!("unknown version ({})", scene.version);
        let help = format!("this build reads version {VERSION}");
        findings.add(format_args!("version"), message, &help);
    }
    findings.positive(format_args!("thickness"), scene.thickness, "a thickness in m");
    findings.vector(format_args!("gravity"), scene.gravity, "an acceleration in m/s^2");
    analysis(format_args!("analysis"), scene.analysis, findings);
    if let FrictionLaw::Coulomb { factorisations } = scene.friction_law {
        let path = format_args!("friction_law.factorisations");
        findings.at_least_one(path, factorisations, "a number");
    }
    let rupture = &scene.rupture;
    let what = "a tolerance between 0 and 0.1";
    let allowed = |value: f64| value > 0.0 && value <= 0.1;
    findings.number(format_args!("rupture.tolerance"), rupture.tolerance, allowed, what);
    let what = "a share of the bonds per relative change of force, above 0";
    findings.number(format_args!("rupture.density"), rupture.density, |value| value > 0.0, what);
    let what = "a multiple of the mean contact force, 0 or more";
    let path = format_args!("rupture.brittleness");
    findings.number(path, rupture.brittleness, |value| value >= 0.0, what);
    if rupture.order != RuptureOrder::Events && rupture.avalanche != Avalanche::default() {
        let message = format!(
            "`{:?}` has no effect: with `order: {:?}` there are no avalanches",
            rupture.avalanche, rupture.order
        );
        let help = "give `order: Events`, or leave `avalanche` out";
        findings.add(format_args!("rupture.avalanche"), message, help);
    }
    if let Some(corrector) = scene.corrector {
        let what = "a tolerance between 0 and 1";
        let allowed = |value| value > 0.0 && value < 1.0;
        findings.number(format_args!("corrector.tolerance"), corrector.tolerance, allowed, what);
        findings.at_least_one(format_args!("corrector.passes"), corrector.passes, "a number");
    }
    let allowed = |value| value > 0.0 && value <= 1e-2;
    if let Solver::Clarabel { tolerance, max_iterations } = scene.solver {
        let what = "a tolerance above 0 and up to 1e-2";
        findings.number(format_args!("solver.tolerance"), tolerance, allowed, what);
        let path = format_args!("solver.max_iterations");
        findings.at_least_one(path, max_iterations, "a number");
    }
    let acceptance = scene.acceptance;
    let what = "a residual above 0 and up to 1e-2";
    findings.number(format_args!("acceptance.residual"), acceptance.residual, allowed, what);
    findings.positive(format_args!("acceptance.turn"), acceptance.turn, "an angle in rad");
    if acceptance.halvings > MOST_HALVINGS {
        let message = format!("out of range ({})", acceptance.halvings);
        let help = format!("give a number up to {MOST_HALVINGS}");
        findings.add(format_args!("acceptance.halvings"), message, &help);
    }
}

/// The analysis of the scene or of a stage.
pub(super) fn analysis(path: std::fmt::Arguments, analysis: Analysis, findings: &mut Findings) {
    if let Analysis::Dynamic { dt, theta } = analysis {
        findings.positive(format_args!("{path}.dt"), dt, "a time step in s");
        let allowed = |theta| theta > 0.0 && theta <= 1.0;
        let what = "a theta above 0 and up to 1";
        findings.number(format_args!("{path}.theta"), theta, allowed, what);
    }
}
