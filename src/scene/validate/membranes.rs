//! Membranes in a stage: each is made once, and changed while it is there.

use std::f64::consts::FRAC_1_SQRT_2;

use clastic_components::domain;
use clastic_components::membrane::Sides;

use crate::scene::format::{Load, MembraneControl, Scene, Stage, Wall};
use crate::scene::stored_state::{StoredMembrane, StoredSpecimen};

use super::findings::At;
use super::parts::{face, is_known, straight, wall_there};
use super::places::inward;

/// The membranes of a saved state from which the scene starts with its walls.
pub(super) fn inherited(
    specimen: Option<&StoredSpecimen>,
) -> impl Iterator<Item = &StoredMembrane> {
    specimen.and_then(StoredSpecimen::gives_walls).into_iter().flat_map(|state| &state.membranes)
}

/// Names of the membranes that the stages of a scene make, and of those that it takes over.
pub(super) fn names<'a>(scene: &'a Scene, specimen: Option<&'a StoredSpecimen>) -> Vec<&'a str> {
    let loads = scene.stages.iter().filter_map(Stage::load);
    let made = loads.flat_map(|load| load.membranes.keys()).map(String::as_str);
    let mut names: Vec<&str> =
        made.chain(inherited(specimen).map(|membrane| &*membrane.name)).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Finds membranes in a compaction.
pub(super) fn none(at: &mut At, there: &[StoredMembrane]) {
    if let [StoredMembrane { name, .. }, ..] = there
        && at.is_sure_of("stages")
    {
        let help = format!(
            "remove it in a loading stage before: `remove_membranes: [\"{name}\"]`, with walls in its place"
        );
        at.add("", format!("a compaction with a membrane (`{name}`)"), help);
    }
}

/// Checks the membranes of a stage; `there` are those that exist, and afterwards those that remain.
pub(super) fn check(at: &mut At, stage: &Load, there: &mut Vec<StoredMembrane>) {
    for (i, name) in stage.remove_membranes.iter().enumerate() {
        let known = there.iter().map(|membrane| membrane.name.as_str());
        is_known(&mut at.item("remove_membranes", i), name, known, "membrane");
        there.retain(|other| other.name != *name);
    }
    for StoredMembrane { name, between } in there.iter() {
        let Some((a, b)) = between else { continue };
        let gone = |wall: &&String| at.is_there(wall) == Some(false);
        if let Some(wall) = [a, b].into_iter().find(gone)
            && at.are_sure_of(&["stages", "walls"])
        {
            let i = stage.remove_walls.iter().position(|other| other == wall).unwrap_or(0);
            let message = format!("membrane `{name}` ends at wall `{wall}`");
            let help = format!("remove the membrane as well: `remove_membranes: [\"{name}\"]`");
            at.add(format_args!("remove_walls[{i}]"), message, help);
        }
    }
    for (name, control) in &stage.membranes {
        let at = &mut at.entry("membranes", name);
        at.not_negative("pressure", control.pressure, "a pressure in Pa");
        if there.iter().any(|other| other.name == *name) {
            is_there_already(at, name, control);
        } else {
            made(at, name, control);
            there.push(StoredMembrane { name: name.clone(), between: control.between.clone() });
        }
    }
}

fn is_there_already(at: &mut At, name: &str, control: &MembraneControl) {
    let given = [
        ("between", control.between.is_some()),
        ("sides", control.sides.is_some()),
        ("ball", control.ball.is_some()),
    ];
    for (field, is_given) in given {
        let message = format!("membrane `{name}` is there already");
        let help = format!("leave `{field}` out, or remove the membrane first");
        at.refuse(is_given && at.is_sure_of("stages"), field, message, help);
    }
}

fn made(at: &mut At, name: &str, control: &MembraneControl) {
    at.within("ball", control.ball, domain::RADIUS);
    let Some((a, b)) = &control.between else {
        let help = "name the two walls between which it lies, `between: (\"bottom\", \"top\")`";
        at.refuse(control.sides.is_some(), "sides", "sides of a closed membrane", help);
        return;
    };
    let walls = [("between[0]", a), ("between[1]", b)].map(|(field, name)| {
        let wall = wall_there(at, field, name);
        straight(at, field, wall, "name two straight walls");
        wall
    });
    at.pair("between", (a, b), "wall");
    if a != b {
        face(at, "between[1]", (b, a));
    }
    let Some(from) = walls[0].filter(|_| at.are_sure_of(&["stages", "walls"])) else { return };
    let holds = |wall: &&Wall| {
        // A wall on the left of the way has its inside on the right.
        let right = inward(from).perp_dot(inward(wall));
        let right = match control.sides.unwrap_or_default() {
            Sides::Both => right.abs(),
            Sides::Left => -right,
            Sides::Right => right,
        };
        right > FRAC_1_SQRT_2 && wall.shape.is_straight() && at.is_there(&wall.name) == Some(true)
    };
    if let Some(wall) = at.context.scene.walls.iter().find(holds) {
        let message = format!(
            "wall `{}` stays beside membrane `{name}` and would hold its grains",
            wall.name
        );
        at.add("", message, format!("take it away: `remove_walls: [\"{}\"]`", wall.name));
    }
}
