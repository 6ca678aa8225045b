//! Stages in order: each uses the walls that the earlier ones have left.

use std::collections::BTreeMap;
use std::fmt::Arguments;

use crate::scene::format::{
    Analysis, Cement, Compact, CompactBy, CompactTarget, CustomStage, Load, Motion,
    ParticleControl, Record, Scale, Stage, Stop, Wall,
};
use crate::scene::spans::join;

use super::findings::Findings;
use super::parts::{WALL, face, motion, straight, wall_there};
use super::select::select;
use super::wall_controls::control_of_wall;
use super::{accuracy, carried, membranes, pour, rigid, stops, wall_controls};

/// Maximum number of increments of a compaction.
const MAX_STEPS: f64 = 1e8;

pub(super) fn check(findings: &mut Findings) {
    let context = findings.context;
    let scene = context.scene;
    let names = scene.stages.iter().enumerate();
    let names = names.map(|(i, stage)| (format!("stages[{i}].name"), stage.name()));
    if findings.is_sure_of("stages") {
        findings.unique("name of a stage", names);
    }
    files(&scene.stages, findings);
    if scene.stages.is_empty() && findings.is_sure_of("stages") {
        let help = "add one, such as Load(name: \"load\", increments: 10)";
        findings.add(format_args!("stages"), "no stage: nothing would happen".to_owned(), help);
    }
    let mut groups = rigid::at_start(&scene.rigid_at_start);
    let mut skins = membranes::inherited(context.specimen);
    let mut stresses = carried::inherited(context.specimen);
    for (i, stage) in scene.stages.iter().enumerate() {
        let path = format_args!("stages[{i}]");
        findings.stage = i;
        findings.analysis = match stage {
            Stage::Compact(_) => Analysis::Static,
            _ => stage.analysis().unwrap_or(scene.analysis),
        };
        match stage {
            Stage::Compact(stage) => {
                if !groups.is_empty() && findings.is_sure_of("stages") {
                    let help = "release rigid groups before, or make them after it";
                    findings.add(path, "a compaction with rigid groups", help);
                }
                membranes::none(path, "a compaction", &skins, findings);
                compact(path, stage, findings);
            }
            Stage::Cement(stage) => cement(path, stage, findings),
            Stage::Save(_) => {}
            Stage::Remove(stage) => {
                select(format_args!("{path}.select"), &stage.select, findings);
            }
            Stage::Load(stage) => {
                load(path, stage, findings);
                accuracy::check(path, stage, findings);
                carried::check(path, stage, &mut stresses, findings);
                pour::none_is_full(path, stage, findings);
                rigid::check(path, stage, &mut groups, findings);
                membranes::check(path, stage, &mut skins, findings);
            }
            Stage::Pour(stage) => {
                load(path, &stage.load, findings);
                carried::check(path, &stage.load, &mut stresses, findings);
                rigid::check(path, &stage.load, &mut groups, findings);
                membranes::check(path, &stage.load, &mut skins, findings);
                pour::check(path, stage, findings);
            }
            Stage::Custom(stage) => custom(path, stage, findings),
        }
    }
}

/// Checks that every `Save` has a file of its own.
fn files(stages: &[Stage], findings: &mut Findings) {
    let mut seen: BTreeMap<String, &str> = BTreeMap::new();
    for (i, stage) in stages.iter().enumerate() {
        let Stage::Save(save) = stage else { continue };
        // Some file systems take letters of either case for one.
        let first = seen.insert(save.file().to_lowercase(), &save.name);
        if let Some(first) = first.filter(|first| *first != save.name) {
            let message = format!("the file of stage `{first}` (`{}`)", save.file());
            let help = "give it a name with other letters or digits";
            findings.add(format_args!("stages[{i}].name"), message, help);
        }
    }
}

fn compact(path: Arguments, stage: &Compact, findings: &mut Findings) {
    let Compact { wall, base, target, step, agitation, .. } = stage;
    let mut find = |field: &str, wall: &String| {
        let path = format_args!("{path}.{field}");
        if wall.is_empty() { None } else { wall_there(path, wall, findings) }
    };
    let (moving, fixed) = (find("wall", wall), find("base", base));
    for (field, wall) in [("wall", moving), ("base", fixed)] {
        let help = "compact between two straight walls";
        straight(format_args!("{path}.{field}"), wall, help, findings);
    }
    if wall == base && !wall.is_empty() {
        findings.add(
            format_args!("{path}.base"),
            format!("the wall that moves (`{base}`)"),
            "name the fixed wall opposite",
        );
    } else {
        face(format_args!("{path}.base"), [moving, fixed], findings);
    }
    let target_path = format_args!("{path}.target[0]");
    match *target {
        CompactTarget::Height(_) if stage.by == CompactBy::Radii => {
            let help = "write `target: Porosity(...)`";
            findings.add(format_args!("{path}.target"), "a height, and no wall moves", help);
        }
        CompactTarget::Height(height) => {
            findings.positive(target_path, height, "a height in m");
        }
        CompactTarget::Porosity(porosity) => {
            let allowed = |value| value > 0.0 && value < 1.0;
            findings.number(target_path, porosity, allowed, "a porosity between 0 and 1");
        }
        CompactTarget::Jammed => {}
    }
    for (i, stop) in stage.stop.iter().enumerate() {
        let path = format_args!("{path}.stop[{i}]");
        if matches!(stop, Stop::Below(..) | Stop::Above(..)) {
            stops::check(path, stop, findings);
            stops::never(path, stop, findings);
        } else {
            let help = "write `Below` or `Above`, with a measure";
            findings.add(path, "a compaction, which has no stress and no time", help);
        }
    }
    record(format_args!("{path}.record"), &stage.record, findings);
    let stepped = findings.positive(format_args!("{path}.step"), *step, "a step in m");
    if let (Some(moving), Some(fixed), true) =
        (moving, fixed, stepped && stage.by == CompactBy::Boundary)
    {
        // The walls are compared as drawn, whatever their earlier motion.
        let middle = |wall: &Wall| (wall.start.0 + wall.end.0, wall.start.1 + wall.end.1);
        let (a, b) = (middle(moving), middle(fixed));
        let increments = 0.5 * (a.0 - b.0).hypot(a.1 - b.1) / step;
        if increments > MAX_STEPS {
            let message =
                format!("too small a step: {step:?} m takes about {increments:.0e} increments");
            findings.add(format_args!("{path}.step"), message, "give a greater step in m");
        }
    }
    findings.not_negative(format_args!("{path}.agitation"), *agitation, "a number of radii");
}

fn record(path: Arguments, record: &Record, findings: &mut Findings) {
    findings.at_least_one(format_args!("{path}.every"), record.every, "a number of increments");
    for (i, n) in record.frames.iter().enumerate() {
        findings.at_least_one(format_args!("{path}.frames[{i}]"), *n, "an increment of the stage");
    }
}

fn cement(path: Arguments, stage: &Cement, findings: &mut Findings) {
    if let Some(length) = stage.length {
        findings.not_negative(format_args!("{path}.length"), length, "a bond length in m");
    }
    if let Some(bonds) = stage.coordination {
        // No more disks of one size have a common neighbour.
        let allowed = |bonds: f64| bonds > 0.0 && bonds <= 6.0;
        let path = format_args!("{path}.coordination");
        findings.number(path, bonds, allowed, "a number of bonds of a particle, at most 6");
    }
    if stage.length.is_some() == stage.coordination.is_some() {
        let help = "give `length`, in m, or `coordination`, the mean number of bonds of a particle";
        findings.add(
            path,
            "one of `length` and `coordination` says how many bonds there are",
            help,
        );
    }
    if stage.walls && stage.coordination.is_some() {
        let help = "cement walls in a stage of its own, by `length`";
        findings.add(format_args!("{path}.walls"), "walls have no coordination", help);
    }
    if let Some(of) = &stage.select {
        select(format_args!("{path}.select"), of, findings);
    }
    super::materials::bond(format_args!("{path}.bond"), stage.bond, findings);
    if !stage.particles && !stage.walls {
        let help = "bond particles, `walls: true`, or both";
        findings.add(format_args!("{path}.particles"), "nothing to bond", help);
    }
    let no_law = stage.bond.is_none()
        && findings.context.scene.materials.values().all(|material| material.bond.is_none());
    let to_walls = stage.walls
        && (findings.context.scene.walls.iter().any(|wall| wall.bond.is_some())
            || !findings.is_sure_of("walls"));
    if no_law && !to_walls && findings.is_sure_of("materials") {
        let help = "add `bond: (...)` to the material that is to be cemented";
        findings.add(path, "no material has a bond law", help);
    }
}

fn custom(path: Arguments, stage: &CustomStage, findings: &mut Findings) {
    if stage.kind.is_empty() {
        let help = "name a kind that a plugin of the program provides";
        findings.add(format_args!("{path}.kind"), "no kind".to_owned(), help);
    }
    if let Some(analysis) = stage.analysis {
        super::settings::analysis(format_args!("{path}.analysis"), analysis, findings);
    }
    if let Some(gravity) = stage.gravity {
        findings.vector(format_args!("{path}.gravity"), gravity, "an acceleration in m/s^2");
    }
    for (name, value) in &stage.values {
        findings.finite(format_args!("{path}.values.{name}"), *value, "a finite number");
    }
    record(path, &stage.record, findings);
}

fn scale(path: Arguments, stage: &Load, findings: &mut Findings) {
    let Scale { gravity, strength, loads } = &stage.scale;
    for (field, points) in [("gravity", gravity), ("strength", strength), ("loads", loads)] {
        if let Some(points) = points {
            let path = format_args!("{path}.scale.{field}");
            let points: Vec<_> = points.iter().map(|(s, factor)| (*s, vec![*factor])).collect();
            wall_controls::points_of(path, &points, "a factor", findings);
        }
    }
    for (k, (_, factor)) in strength.iter().flatten().enumerate() {
        findings.positive(format_args!("{path}.scale.strength[{k}][1]"), *factor, "a factor");
    }
    if gravity.is_some() && stage.gravity.unwrap_or(findings.context.scene.gravity) == (0.0, 0.0) {
        let help = "give the stage or the scene a `gravity`";
        findings.add(format_args!("{path}.scale.gravity"), "a factor on no gravity", help);
    }
    if loads.is_some() && !stage.has_target() && findings.is_sure_of("stages") {
        let help =
            "give a wall, a particle, a rigid group, a membrane or the cell a load in this stage";
        findings.add(format_args!("{path}.scale.loads"), "a factor on no load", help);
    }
    if let Some((_, first)) = loads.iter().flatten().next() {
        let what = "0, at which loads are those that the stage begins with";
        let path = format_args!("{path}.scale.loads[0][1]");
        findings.number(path, *first, |first| first == 0.0, what);
    }
    for (k, (_, factor)) in
        loads.iter().flatten().enumerate().filter(|_| !stage.membranes.is_empty())
    {
        let what = "a factor of 0 to 1, as a membrane cannot pull";
        let allowed = |factor: f64| (0.0..=1.0).contains(&factor);
        findings.number(format_args!("{path}.scale.loads[{k}][1]"), *factor, allowed, what);
    }
}

fn load(path: Arguments, stage: &Load, findings: &mut Findings) {
    let context = findings.context;
    findings.at_least_one(format_args!("{path}.increments"), stage.increments, "a number");
    if let Some(analysis) = stage.analysis {
        super::settings::analysis(format_args!("{path}.analysis"), analysis, findings);
    }
    scale(path, stage, findings);
    if let Some(gravity) = stage.gravity {
        findings.vector(format_args!("{path}.gravity"), gravity, "an acceleration in m/s^2");
    }
    for (field, names, there) in
        [("remove_walls", &stage.remove_walls, false), ("add_walls", &stage.add_walls, true)]
    {
        for (i, name) in names.iter().enumerate() {
            let path = format_args!("{path}.{field}[{i}]");
            findings.reference(path, name, WALL, &context.walls);
            let index = context.walls.iter().position(|wall| wall == name);
            let Some(is_there) = index.and_then(|index| findings.present.get_mut(index)) else {
                continue;
            };
            if std::mem::replace(is_there, there) == there
                && findings.are_sure_of(&["stages", "walls"])
            {
                let state = if there { "already" } else { "not" };
                let message = format!("wall `{name}` is {state} there");
                findings.add(path, message, "leave it out of this list");
            }
        }
    }
    for (name, control) in &stage.walls {
        let walls = format!("{path}.walls");
        let control_path = join(&walls, name);
        let control_path = format_args!("{control_path}");
        control_of_wall(control_path, (name, control), stage.increments, findings);
    }
    for (i, control) in stage.particles.iter().enumerate() {
        let path = format_args!("{path}.particles[{i}]");
        control_of_particles(path, control, findings);
    }
    record(format_args!("{path}.record"), &stage.record, findings);
    for (i, n) in stage.record.frames.iter().enumerate() {
        if *n > stage.increments {
            let message = format!("no such increment ({n})");
            let help = format!("the stage has {} of them", stage.increments);
            findings.add(format_args!("{path}.record.frames[{i}]"), message, &help);
        }
    }
    let untils = stage.stop.iter().enumerate().filter(|(_, stop)| matches!(stop, Stop::Until(..)));
    for (i, _) in untils.skip(1) {
        let help = "write `Above` or `Below` for all but one";
        findings.add(format_args!("{path}.stop[{i}]"), "a second `Until` in the stage", help);
    }
    for (i, stop) in stage.stop.iter().enumerate() {
        let path = format_args!("{path}.stop[{i}]");
        stops::check(path, stop, findings);
        stops::never(path, stop, findings);
    }
}

fn control_of_particles(path: Arguments, control: &ParticleControl, findings: &mut Findings) {
    select(format_args!("{path}.select"), &control.select, findings);
    let motions =
        [("x", control.x, "m"), ("y", control.y, "m"), ("rotation", control.rotation, "rad")];
    for (field, wanted, unit) in motions {
        let path = format_args!("{path}.{field}");
        motion(path, wanted, unit, findings);
        if control.affine.is_some() && field != "rotation" && wanted != Motion::Free {
            let message = format!("{field} is imposed twice");
            findings.add(path, message, "`affine` imposes x and y: leave it out here");
        }
    }
    if let Some((x, y)) = control.affine {
        for (i, row) in [x, y].into_iter().enumerate() {
            findings.vector(format_args!("{path}.affine[{i}]"), row, "a displacement gradient");
        }
    }
    if let Some(force) = control.force {
        findings.vector(format_args!("{path}.force"), force, "a force in N");
    }
    if let Some(moment) = control.moment {
        findings.finite(format_args!("{path}.moment"), moment, "a moment in N m");
    }
    if let Some(remains) = control.remains {
        let (path, share) = (format_args!("{path}.remains"), |share| (0.0..=1.0).contains(&share));
        findings.number(path, remains, share, "a share from 0 to 1");
        if control.force.is_some() || control.moment.is_some() {
            let help = "give the share that remains, or `force` and `moment`";
            findings.add(path, "the load is set twice", help);
        }
    }
}
