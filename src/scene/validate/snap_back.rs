//! `rupture.snap_back`: tests in which one imposed motion goes back, and nothing else loads.

use clastic_components::bond::{Bond, BondId};

use crate::scene::format::{Analysis, Avalanche, Load, Motion, RuptureOrder, Stage, WallControl};

use super::Context;
use super::findings::Findings;
use super::standing::{Standing, has_load, loads_group, loads_particles};

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
    let mut bonded = !scene.bonds.is_empty() || has_stored_bonds(context);
    let mut standing = Standing::at_start(context);
    for (i, stage) in scene.stages.iter().enumerate() {
        match stage {
            Stage::Cement(_) => bonded = true,
            Stage::Load(stage) => {
                let before = standing.clone();
                standing.follow(stage);
                if bonded {
                    of_stage(context, (i, stage), &before, &standing, findings);
                }
            }
            Stage::Pour(stage) => standing.follow(&stage.load),
            _ => {}
        }
    }
}

/// Whether the scene starts from a state with bonds.
fn has_stored_bonds(context: &Context) -> bool {
    let state = context.specimen.and_then(|stored| stored.state.as_ref());
    let saved = state.and_then(|state| state.saved.as_ref());
    let bonds = saved.map(|saved| saved.world.components::<BondId, Bond>("bond"));
    bonds.and_then(Result::ok).is_some_and(|bonds| !bonds.is_empty())
}

/// Checks a stage with bonds, before which the loads `before` act; those that its entries of walls
/// and membranes set are in `standing`.
fn of_stage(
    context: &Context,
    (i, stage): (usize, &Load),
    before: &Standing,
    standing: &Standing,
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
    for name in &standing.walls {
        let is_here = stage.walls.contains_key(name);
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
    let moves = |motion: Motion| match motion {
        Motion::Free | Motion::Held => false,
        Motion::Displacement(u) | Motion::Velocity(u) => u != 0.0,
    };
    for (k, c) in stage.particles.iter().enumerate() {
        if loads_particles(c) {
            refuse(&format!("{stage_path}.particles[{k}]"), "with loads on particles");
        }
        if [c.x, c.y, c.rotation].into_iter().any(moves) || c.affine.is_some() {
            driven.push(format!("particles[{k}]"));
        }
    }
    for (name, c) in &stage.rigid {
        if loads_group(c) {
            refuse(&format!("{stage_path}.rigid.{name}"), "with a load on a rigid group");
        }
        if [c.x, c.y, c.rotation].into_iter().any(moves) {
            driven.push(format!("rigid.{name}"));
        }
    }
    for origin in before.kept_by_particles(stage) {
        refuse(&stage_path, &format!("with loads that particles keep from {origin}"));
    }
    for name in before.kept_by_groups(stage) {
        refuse(&stage_path, &format!("with the load that rigid group `{name}` keeps"));
    }
    for name in &standing.membranes {
        let is_here = stage.membranes.contains_key(name);
        let own = format!("{stage_path}.membranes.{name}");
        let path = if is_here { &own } else { &stage_path };
        refuse(path, &format!("with membrane `{name}`"));
    }
    if scene.cell.is_some() {
        refuse("cell", "with a periodic cell");
    }
    if let [first, second, ..] = &driven[..] {
        let what = format!("with a second imposed motion: `{first}` moves too");
        refuse(&format!("{stage_path}.{second}"), &what);
    }
}
