//! Loading stages.

use clastic_components::domain::GRAVITY;

use crate::scene::format::{Load, Motion, ParticleControl, Scale, Stop};

use super::findings::At;
use super::select::select;
use super::stages::record;
use super::wall_controls::{control_of_wall, graph};
use super::{parts, settings, stops};

pub(super) fn load(at: &mut At, stage: &Load) {
    at.at_least_one("increments", stage.increments, "a number");
    settings::analysis(at, stage.analysis);
    scale(at, stage);
    at.vector("gravity", stage.gravity, GRAVITY.what);
    presence(at, "remove_walls", &stage.remove_walls, false);
    presence(at, "add_walls", &stage.add_walls, true);
    for (name, control) in &stage.walls {
        control_of_wall(&mut at.entry("walls", name), name, control, stage.increments);
    }
    for (i, control) in stage.particles.iter().enumerate() {
        control_of_particles(&mut at.item("particles", i), control);
        let diagonal = control.affine.map_or(0.0, |((xx, _), (_, yy))| xx.min(yy));
        let whole = diagonal * f64::from(stage.increments);
        let message = format!(
            "a displacement gradient of {whole:?} over the stage: particles would pass the origin"
        );
        let help = "give that of one increment, and not that of the stage";
        let is_wrong = whole <= -1.0 && stage.stop.is_empty();
        at.refuse(is_wrong, format_args!("particles[{i}].affine"), message, help);
    }
    record(at, &stage.record);
    for (i, n) in stage.record.frames.iter().enumerate() {
        let message = format!("no such increment ({n})");
        let help = format!("the stage has {} of them", stage.increments);
        at.refuse(*n > stage.increments, format_args!("record.frames[{i}]"), message, help);
    }
    let untils = stage.stop.iter().enumerate().filter(|(_, stop)| matches!(stop, Stop::Until(..)));
    for (i, _) in untils.skip(1) {
        let help = "write `Above` or `Below` for all but one";
        at.add(format_args!("stop[{i}]"), "a second `Until` in the stage", help);
    }
    for (i, stop) in stage.stop.iter().enumerate() {
        stops::check(&mut at.item("stop", i), stop);
    }
}

/// Checks the walls that come or go when the stage begins.
fn presence(at: &mut At, field: &str, names: &[String], there: bool) {
    for (i, name) in names.iter().enumerate() {
        let at = &mut at.item(field, i);
        at.wall("", name);
        let index = at.context.walls.iter().position(|wall| wall == name);
        let Some(is_there) = index.and_then(|index| at.present.get_mut(index)) else { continue };
        let before = std::mem::replace(is_there, there);
        if before == there && at.are_sure_of(&["stages", "walls"]) {
            let state = if there { "already" } else { "not" };
            at.add("", format!("wall `{name}` is {state} there"), "leave it out of this list");
        }
    }
}

fn scale(at: &mut At, stage: &Load) {
    let Scale { gravity, strength, loads } = &stage.scale;
    let no_gravity = stage.gravity.unwrap_or(at.context.scene.gravity) == (0.0, 0.0);
    let at = &mut at.field("scale");
    for (field, points) in [("gravity", gravity), ("strength", strength), ("loads", loads)] {
        if let Some(points) = points {
            graph(&mut at.field(field), points, "a factor");
        }
    }
    for (k, (_, factor)) in strength.iter().flatten().enumerate() {
        at.positive(format_args!("strength[{k}][1]"), *factor, "a factor");
    }
    let help = "give the stage or the scene a `gravity`";
    at.refuse(gravity.is_some() && no_gravity, "gravity", "a factor on no gravity", help);
    let Some(loads) = loads else { return };
    let help =
        "give a wall, a particle, a rigid group, a membrane or the cell a load in this stage";
    at.refuse(!stage.has_target() && at.is_sure_of("stages"), "loads", "a factor on no load", help);
    if let Some((_, first)) = loads.first() {
        let what = "0, at which loads are those that the stage begins with";
        at.number("loads[0][1]", *first, |first| first == 0.0, what);
    }
    for (k, (_, factor)) in loads.iter().enumerate().filter(|_| !stage.membranes.is_empty()) {
        let what = "a factor of 0 to 1, as a membrane cannot pull";
        let allowed = |factor| (0.0..=1.0).contains(&factor);
        at.number(format_args!("loads[{k}][1]"), *factor, allowed, what);
    }
}

fn control_of_particles(at: &mut At, control: &ParticleControl) {
    select(&mut at.field("select"), &control.select);
    for (field, wanted, unit) in control.motions() {
        parts::motion(at, field, wanted, unit);
        let is_twice = control.affine.is_some() && field != "rotation" && wanted != Motion::Free;
        let message = format!("{field} is imposed twice");
        at.refuse(is_twice, field, message, "`affine` imposes x and y: leave it out here");
    }
    at.vector("affine[0]", control.affine.map(|rows| rows.0), "a displacement gradient");
    at.vector("affine[1]", control.affine.map(|rows| rows.1), "a displacement gradient");
    parts::load(at, control.force, control.moment);
    let share = |share| (0.0..=1.0).contains(&share);
    at.number("remains", control.remains, share, "a share from 0 to 1");
    let is_given = control.force.is_some() || control.moment.is_some();
    let help = "give the share that remains, or `force` and `moment`";
    at.refuse(control.remains.is_some() && is_given, "remains", "the load is set twice", help);
}
