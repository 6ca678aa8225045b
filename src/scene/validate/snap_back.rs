//! `rupture.snap_back`: tests in which one imposed motion goes back, and nothing else loads.

use std::collections::BTreeSet;

use crate::scene::format::{
    Analysis, Avalanche, Load, Motion, ParticleControl, RuptureOrder, Stage, WallControl,
};

use super::Context;
use super::findings::Findings;

const HELP: &str = "leave `snap_back` out, or load with one imposed displacement alone";

pub(super) fn check(context: &Context, findings: &mut Findings) {
    let scene = context.scene;
    let rupture = &scene.rupture;
    if !rupture.snap_back {
        return;
    }
    let path = format_args!("rupture.snap_back");
    if rupture.order != RuptureOrder::Events {
        let message = format!("no effect with `order: {:?}`", rupture.order);
        findings.add(path, message, "give `order: Events`, or leave `snap_back` out");
    }
    if matches!(rupture.avalanche, Avalanche::Gradual | Avalanche::Dynamic) {
        let message = format!("does not go with `avalanche: {:?}`", rupture.avalanche);
        let help = "leave one of the two out: the motion goes back before an avalanche begins";
        findings.add(path, message, help);
    }
    if !findings.is_sure_of("stages") {
        return;
    }
    let mut bonded = !scene.bonds.is_empty();
    let mut loaded = BTreeSet::new();
    for (i, stage) in scene.stages.iter().enumerate() {
        match stage {
            Stage::Cement(_) => bonded = true,
            Stage::Load(stage) => {
                follow_loads(stage, &mut loaded);
                if bonded {
                    of_stage(context, i, stage, &loaded, findings);
                }
            }
            Stage::Pour(stage) => follow_loads(&stage.load, &mut loaded),
            _ => {}
        }
    }
}

/// Walls that carry a load from the stage on.
fn follow_loads<'a>(stage: &'a Load, loaded: &mut BTreeSet<&'a str>) {
    for name in &stage.remove_walls {
        loaded.remove(name.as_str());
    }
    for (name, control) in &stage.walls {
        if has_load(control) {
            loaded.insert(name);
        } else {
            loaded.remove(name.as_str());
        }
    }
}

fn has_load(control: &WallControl) -> bool {
    matches!(control, WallControl::Force(_) | WallControl::Stress { .. } | WallControl::Lid { .. })
}

/// Checks a stage with bonds.
fn of_stage(
    context: &Context,
    i: usize,
    stage: &Load,
    loaded: &BTreeSet<&str>,
    findings: &mut Findings,
) {
    let scene = context.scene;
    let path = format_args!("stages[{i}]");
    if stage.analysis.unwrap_or(scene.analysis) != Analysis::Static {
        let help = "leave `snap_back` out, or make the stage static";
        findings.add(path, "`rupture.snap_back` in a dynamic stage", help);
        return;
    }
    if stage.gravity.unwrap_or(scene.gravity) != (0.0, 0.0) {
        findings.add(path, "`rupture.snap_back` in a stage with gravity", HELP);
    }
    if let Some(name) = loaded.first() {
        let message = format!("`rupture.snap_back` with a load on wall `{name}`");
        findings.add(path, message, HELP);
    }
    let loads_grains = |c: &ParticleControl| c.force.is_some() || c.moment.is_some();
    let loads_groups = stage.rigid.values().any(|c| c.force.is_some() || c.moment.is_some());
    if stage.particles.iter().any(loads_grains) || loads_groups {
        findings.add(path, "`rupture.snap_back` with loads on particles", HELP);
    }
    if stage.cell.is_some() || scene.cell.is_some() {
        findings.add(path, "`rupture.snap_back` with a periodic cell", HELP);
    }
    if !stage.membranes.is_empty() {
        findings.add(path, "`rupture.snap_back` with a membrane", HELP);
    }
    let mut driven = Vec::new();
    for (name, control) in &stage.walls {
        match control {
            WallControl::Displacement(x, y) if (*x, *y) == (0.0, 0.0) => {}
            WallControl::Displacement(..) => driven.push(format!("wall `{name}`")),
            WallControl::Fixed => {}
            other if has_load(other) => {}
            _ => {
                let path = format_args!("stages[{i}].walls.{name}");
                let help = "give a `Displacement`, or leave `rupture.snap_back` out";
                findings.add(path, "a motion that cannot go back", help);
            }
        }
    }
    let moves = |motion: Motion| !matches!(motion, Motion::Free | Motion::Held);
    for (k, c) in stage.particles.iter().enumerate() {
        if [c.x, c.y, c.rotation].into_iter().any(moves) || c.affine.is_some() {
            driven.push(format!("`particles[{k}]`"));
        }
    }
    for (name, c) in &stage.rigid {
        if [c.x, c.y, c.rotation].into_iter().any(moves) {
            driven.push(format!("rigid group `{name}`"));
        }
    }
    if driven.len() > 1 {
        let message =
            format!("`rupture.snap_back` with several imposed motions: {}", driven.join(", "));
        findings.add(path, message, HELP);
    }
}
