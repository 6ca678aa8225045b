//! Membranes in a stage: each is made once, and changed while it is there.

use std::fmt::Arguments;

use clastic_components::domain;

use crate::scene::format::{Load, MembraneControl, Scene, Stage};
use crate::scene::spans::join;
use crate::scene::stored::{StoredMembrane, StoredSpecimen};
use crate::scene::suggest;

use super::findings::Findings;
use super::parts::{face, straight, wall_there};

/// A present membrane, with the walls between which it lies.
pub(super) type Skin = (String, Option<(String, String)>);

/// The membranes of a saved state from which the scene starts with its walls.
pub(super) fn inherited(specimen: Option<&StoredSpecimen>) -> Vec<Skin> {
    taken(specimen).map(|membrane| (membrane.name.clone(), membrane.between.clone())).collect()
}

fn taken(specimen: Option<&StoredSpecimen>) -> impl Iterator<Item = &StoredMembrane> {
    specimen.and_then(StoredSpecimen::gives_walls).into_iter().flat_map(|state| &state.membranes)
}

/// Names of the membranes that the stages of a scene make, and of those that it takes over.
pub(super) fn names<'a>(scene: &'a Scene, specimen: Option<&'a StoredSpecimen>) -> Vec<&'a str> {
    let loads = scene.stages.iter().filter_map(Stage::load);
    let made = loads.flat_map(|load| load.membranes.keys()).map(String::as_str);
    let mut names: Vec<&str> =
        made.chain(taken(specimen).map(|membrane| &*membrane.name)).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Finds membranes where there can be none.
pub(super) fn none(path: Arguments, what: &str, there: &[Skin], findings: &mut Findings) {
    if let [(name, _), ..] = there
        && findings.is_sure_of("stages")
    {
        let help = format!(
            "remove it in a loading stage before: `remove_membranes: [\"{name}\"]`, with walls \
             in its place"
        );
        findings.add(path, format!("{what} with a membrane (`{name}`)"), &help);
    }
}

/// Checks the membranes of a stage; `there` are those that exist, and afterwards those that remain.
pub(super) fn check(path: Arguments, stage: &Load, there: &mut Vec<Skin>, findings: &mut Findings) {
    for (i, name) in stage.remove_membranes.iter().enumerate() {
        if !there.iter().any(|(other, _)| other == name) && findings.is_sure_of("stages") {
            let known: Vec<&str> = there.iter().map(|(name, _)| name.as_str()).collect();
            let help = suggest::help(name, &known, "membranes");
            let path = format_args!("{path}.remove_membranes[{i}]");
            findings.add(path, format!("no membrane `{name}`"), &help);
        }
        there.retain(|(other, _)| other != name);
    }
    for (name, walls) in there.iter() {
        let Some((a, b)) = walls else { continue };
        let gone = |wall: &&String| findings.is_there(wall) == Some(false);
        if let Some(wall) = [a, b].into_iter().find(gone)
            && findings.are_sure_of(&["stages", "walls"])
        {
            let i = stage.remove_walls.iter().position(|other| other == wall).unwrap_or(0);
            let message = format!("membrane `{name}` ends at wall `{wall}`");
            let help = format!("remove the membrane as well: `remove_membranes: [\"{name}\"]`");
            findings.add(format_args!("{path}.remove_walls[{i}]"), message, &help);
        }
    }
    for (name, control) in &stage.membranes {
        let own = join(&format!("{path}.membranes"), name);
        let own = format_args!("{own}");
        let exists = there.iter().any(|(other, _)| other == name);
        let pressure = format_args!("{own}.pressure");
        findings.not_negative(pressure, control.pressure, "a pressure in Pa");
        if exists {
            is_there_already(own, name, control, findings);
        } else {
            made(own, control, findings);
            there.push((name.clone(), control.between.clone()));
        }
    }
}

fn is_there_already(
    path: Arguments,
    name: &str,
    control: &MembraneControl,
    findings: &mut Findings,
) {
    let given = [
        ("between", control.between.is_some()),
        ("sides", control.sides.is_some()),
        ("ball", control.ball.is_some()),
    ];
    for (field, _) in given.iter().filter(|(_, given)| *given) {
        if findings.is_sure_of("stages") {
            let message = format!("membrane `{name}` is there already");
            let help = format!("leave `{field}` out, or remove the membrane first");
            findings.add(format_args!("{path}.{field}"), message, &help);
        }
    }
}

fn made(path: Arguments, control: &MembraneControl, findings: &mut Findings) {
    if let Some(ball) = control.ball {
        findings.within(format_args!("{path}.ball"), ball, domain::RADIUS);
    }
    let Some((a, b)) = &control.between else {
        if control.sides.is_some() {
            let help = "name the two walls between which it lies, `between: (\"bottom\", \"top\")`";
            findings.add(format_args!("{path}.sides"), "sides of a closed membrane", help);
        }
        return;
    };
    let walls = [(0, a), (1, b)].map(|(i, name)| {
        let path = format_args!("{path}.between[{i}]");
        let wall = wall_there(path, name, findings);
        straight(path, wall, "name two straight walls", findings);
        wall
    });
    findings.pair(format_args!("{path}.between"), (a, b), "wall");
    if a != b {
        face(format_args!("{path}.between[1]"), walls, findings);
    }
}
