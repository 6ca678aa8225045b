//! Stages in order: each uses the walls that the earlier ones have left.

use std::collections::BTreeMap;

use clastic_components::domain::GRAVITY;

use crate::scene::format::{
    Analysis, Cement, Compact, CompactBy, CompactTarget, CustomStage, Record, Stage, Stop, Wall,
};

use super::findings::At;
use super::load::load;
use super::parts::{face, straight, wall_there};
use super::select::select;
use super::{carried, materials, membranes, pour, rigid, settings, stops};

/// Maximum number of increments of a compaction.
const MAX_STEPS: f64 = 1e8;

pub(super) fn check(at: &mut At) {
    let context = at.context;
    let scene = context.scene;
    at.names("stages", "name of a stage", &context.stages);
    files(at, &scene.stages);
    let help = "add one, such as Load(name: \"load\", increments: 10)";
    let what = "no stage: nothing would happen";
    at.refuse(scene.stages.is_empty() && at.is_sure_of("stages"), "stages", what, help);
    let at_start = scene.rigid_at_start.iter();
    let mut groups: Vec<_> = at_start.map(|name| rigid::There { name, walls: &[] }).collect();
    let mut skins: Vec<_> = membranes::inherited(context.specimen).cloned().collect();
    let mut stresses = carried::inherited(context.specimen);
    for (i, stage) in scene.stages.iter().enumerate() {
        let at = &mut at.item("stages", i);
        at.stage = i;
        at.analysis = match stage {
            Stage::Compact(_) => Analysis::Static,
            _ => stage.analysis().unwrap_or(scene.analysis),
        };
        match stage {
            Stage::Compact(stage) => {
                let help = "release rigid groups before, or make them after it";
                let what = "a compaction with rigid groups";
                at.refuse(!groups.is_empty() && at.is_sure_of("stages"), "", what, help);
                membranes::none(at, &skins);
                compact(at, stage);
            }
            Stage::Cement(stage) => cement(at, stage),
            Stage::Save(_) | Stage::Load(_) | Stage::Pour(_) => {}
            Stage::Remove(stage) => select(&mut at.field("select"), &stage.select),
            Stage::Custom(stage) => custom(at, stage),
        }
        if let Some(stage) = stage.load() {
            load(at, stage);
            carried::check(at, stage, &mut stresses);
            rigid::check(at, stage, &mut groups);
            membranes::check(at, stage, &mut skins);
        }
        if let Stage::Pour(stage) = stage {
            pour::check(at, stage);
        }
    }
}

/// Checks that every `Save` has a file of its own.
fn files(at: &mut At, stages: &[Stage]) {
    let mut seen: BTreeMap<String, &str> = BTreeMap::new();
    for (i, stage) in stages.iter().enumerate() {
        let Stage::Save(save) = stage else { continue };
        // Some file systems take letters of either case for one.
        let first = seen.insert(save.file().to_lowercase(), &save.name);
        if let Some(first) = first.filter(|first| *first != save.name) {
            let message = format!("the file of stage `{first}` (`{}`)", save.file());
            let help = "give it a name with other letters or digits";
            at.add(format_args!("stages[{i}].name"), message, help);
        }
    }
}

fn compact(at: &mut At, stage: &Compact) {
    let Compact { wall, base, target, step, agitation, .. } = stage;
    let [moving, fixed] = [("wall", wall), ("base", base)].map(|(field, name)| {
        let wall = if name.is_empty() { None } else { wall_there(at, field, name) };
        straight(at, field, wall, "compact between two straight walls");
        wall
    });
    if wall == base && !wall.is_empty() {
        let message = format!("the wall that moves (`{base}`)");
        at.add("base", message, "name the fixed wall opposite");
    } else {
        face(at, "base", (base, wall));
    }
    match *target {
        CompactTarget::Height(_) if stage.by == CompactBy::Radii => {
            at.add("target", "a height, and no wall moves", "write `target: Porosity(...)`");
        }
        CompactTarget::Height(height) => {
            at.positive("target[0]", height, "a height in m");
        }
        CompactTarget::Porosity(porosity) => {
            let allowed = |value| value > 0.0 && value < 1.0;
            at.number("target[0]", porosity, allowed, "a porosity between 0 and 1");
        }
        CompactTarget::Jammed => {}
    }
    for (i, stop) in stage.stop.iter().enumerate() {
        let at = &mut at.item("stop", i);
        if matches!(stop, Stop::Below(..) | Stop::Above(..)) {
            stops::check(at, stop);
        } else {
            let help = "write `Below` or `Above`, with a measure";
            at.add("", "a compaction, which has no stress and no time", help);
        }
    }
    record(at, &stage.record);
    let stepped = at.positive("step", *step, "a step in m") && stage.by == CompactBy::Boundary;
    if let (Some(moving), Some(fixed), true) = (moving, fixed, stepped) {
        // The walls are compared as drawn, whatever their earlier motion.
        let middle = |wall: &Wall| (wall.start.0 + wall.end.0, wall.start.1 + wall.end.1);
        let (a, b) = (middle(moving), middle(fixed));
        let increments = 0.5 * (a.0 - b.0).hypot(a.1 - b.1) / step;
        let message =
            format!("too small a step: {step:?} m takes about {increments:.0e} increments");
        at.refuse(increments > MAX_STEPS, "step", message, "give a greater step in m");
    }
    at.not_negative("agitation", *agitation, "a number of radii");
}

pub(super) fn record(at: &mut At, record: &Record) {
    let at = &mut at.field("record");
    at.at_least_one("every", record.every, "a number of increments");
    for (i, n) in record.frames.iter().enumerate() {
        at.at_least_one(format_args!("frames[{i}]"), *n, "an increment of the stage");
    }
}

fn cement(at: &mut At, stage: &Cement) {
    let scene = at.context.scene;
    at.not_negative("length", stage.length, "a bond length in m");
    // No more disks of one size have a common neighbour.
    let allowed = |bonds| bonds > 0.0 && bonds <= 6.0;
    let what = "a number of bonds of a particle, at most 6";
    at.number("coordination", stage.coordination, allowed, what);
    let message = "one of `length` and `coordination` says how many bonds there are";
    let help = "give `length`, in m, or `coordination`, the mean number of bonds of a particle";
    at.refuse(stage.length.is_some() == stage.coordination.is_some(), "", message, help);
    let help = "cement walls in a stage of its own, by `length`";
    let what = "walls have no coordination";
    at.refuse(stage.walls && stage.coordination.is_some(), "walls", what, help);
    if let Some(of) = &stage.select {
        select(&mut at.field("select"), of);
    }
    materials::bond(&mut at.field("bond"), stage.bond);
    let help = "bond particles, `walls: true`, or both";
    at.refuse(!stage.particles && !stage.walls, "particles", "nothing to bond", help);
    let no_law =
        stage.bond.is_none() && scene.materials.values().all(|material| material.bond.is_none());
    let to_walls = stage.walls
        && (scene.walls.iter().any(|wall| wall.bond.is_some()) || !at.is_sure_of("walls"));
    let help = "add `bond: (...)` to the material that is to be cemented";
    let what = "no material has a bond law";
    at.refuse(no_law && !to_walls && at.is_sure_of("materials"), "", what, help);
}

fn custom(at: &mut At, stage: &CustomStage) {
    let help = "name a kind that a plugin of the program provides";
    at.refuse(stage.kind.is_empty(), "kind", "no kind", help);
    settings::analysis(at, stage.analysis);
    at.vector("gravity", stage.gravity, GRAVITY.what);
    for (name, value) in &stage.values {
        at.entry("values", name).finite("", *value, "a finite number");
    }
    record(at, &stage.record);
}
