//! Version, named values, analysis, solver and acceptance.

use clastic_components::domain;

use crate::scene::format::{Analysis, Avalanche, Rupture, RuptureOrder, VERSION};

use super::findings::At;

/// More halvings than this make an increment smaller than its round-off.
const MOST_HALVINGS: u32 = 30;

pub(super) fn check(at: &mut At) {
    let scene = at.context.scene;
    let message = format!("unknown version ({})", scene.version);
    let help = format!("this build reads version {VERSION}");
    at.refuse(scene.version != VERSION, "version", message, help);
    for (name, value) in &scene.values {
        at.entry("let", name).finite("", *value, "a number");
    }
    at.within("thickness", scene.thickness, domain::THICKNESS);
    at.vector("gravity", scene.gravity, domain::GRAVITY.what);
    analysis(at, Some(scene.analysis));
    let rupture = &scene.rupture;
    at.within("rupture.density", rupture.density, domain::DENSITY_OF_RUPTURES);
    at.within("rupture.brittleness", rupture.brittleness, domain::BRITTLENESS);
    let Rupture { order, avalanche, .. } = rupture;
    let is_idle = *order != RuptureOrder::Events && *avalanche != Avalanche::default();
    let message =
        format!("`{avalanche:?}` has no effect: with `order: {order:?}` there are no avalanches");
    let help = "give `order: Events`, or leave `avalanche` out";
    at.refuse(is_idle, "rupture.avalanche", message, help);
    let acceptance = scene.acceptance;
    at.within("acceptance.residual", acceptance.residual, domain::RESIDUAL);
    at.within("acceptance.turn", acceptance.turn, domain::TURN);
    let message = format!("out of range ({})", acceptance.halvings);
    let help = format!("give a number up to {MOST_HALVINGS}");
    at.refuse(acceptance.halvings > MOST_HALVINGS, "acceptance.halvings", message, help);
}

pub(super) fn analysis(at: &mut At, analysis: Option<Analysis>) {
    if let Some(Analysis::Dynamic { dt, theta }) = analysis {
        at.within("analysis.dt", dt, domain::TIME_STEP);
        at.within("analysis.theta", theta, domain::THETA);
    }
}
