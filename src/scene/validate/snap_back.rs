//! `rupture.snap_back`: tests in which one imposed motion goes back, and nothing else loads.

use std::collections::BTreeSet;

use crate::scene::format::{Analysis, Avalanche, Load, Motion, RuptureOrder, Stage, WallControl};

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
    let stage_path = format!("stages[{i}]");
    let own = |is_own: bool, field: &str| {
        if is_own { format!("{stage_path}.{field}") } else { field.to_owned() }
    };
    let mut refuse = |path: &str, what: &str| {
        let message = format!("`rupture.snap_back` {what}");
        findings.add(format_args!("{path}"), message, HELP);
    };
    if stage.analysis.unwrap_or(scene.analysis) != Analysis::Static {
        refuse(&own(stage.analysis.is_some(), "analysis"), "in a dynamic stage");
        return;
    }
    if stage.gravity.unwrap_or(scene.gravity) != (0.0, 0.0) {
        refuse(&own(stage.gravity.is_some(), "gravity"), "with gravity");
    }
    for name in loaded {
        let is_here = stage.walls.contains_key(*name);
        let path = if is_here { format!("{stage_path}.walls.{name}") } else { stage_path.clone() };
        refuse(&path, &format!("with a load on wall `{name}`"));
    }
    let mut driven = Vec::new();
    for (name, control) in &stage.walls {
        match control {
            WallControl::Displacement(x, y) if (*x, *y) == (0.0, 0.0) => {}
            WallControl::Displacement(..) => driven.push(format!("walls.{name}")),
            WallControl::Fixed => {}
            other if has_load(other) => {}
            _ => {
                let what = "with a motion that cannot go back: `Displacement` can";
                refuse(&format!("{stage_path}.walls.{name}"), what);
            }
        }
    }
    let moves = |motion: Motion| !matches!(motion, Motion::Free | Motion::Held);
    for (k, c) in stage.particles.iter().enumerate() {
        if c.force.is_some() || c.moment.is_some() {
            refuse(&format!("{stage_path}.particles[{k}]"), "with loads on particles");
        }
        if [c.x, c.y, c.rotation].into_iter().any(moves) || c.affine.is_some() {
            driven.push(format!("particles[{k}]"));
        }
    }
    for (name, c) in &stage.rigid {
        if c.force.is_some() || c.moment.is_some() {
            refuse(&format!("{stage_path}.rigid.{name}"), "with a load on a rigid group");
        }
        if [c.x, c.y, c.rotation].into_iter().any(moves) {
            driven.push(format!("rigid.{name}"));
        }
    }
    if scene.cell.is_some() {
        refuse("cell", "with a periodic cell");
    }
    if !stage.membranes.is_empty() {
        refuse(&format!("{stage_path}.membranes"), "with a membrane");
    }
    if let [first, second, ..] = &driven[..] {
        let what = format!("with a second imposed motion: `{first}` moves too");
        refuse(&format!("{stage_path}.{second}"), &what);
    }
}
