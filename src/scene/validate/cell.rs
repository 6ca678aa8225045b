//! A periodic cell, its controls, and what a scene with one may not have.

use clastic_systems::detect_contacts::periodic::pairs_within;
use glam::DVec2;

use crate::run::cell::at_start;
use crate::scene::format::{
    Analysis, Cell, CellTarget, Compact, CompactTarget, Load, Particle, Specimen, Stage,
};

use super::findings::At;

/// Minimum size of a cell, in maximum diameters. A contact may then be as long as two of them
/// before there could be another between the same particles.
const MIN_SIZE: f64 = 4.0;

pub(super) fn check(at: &mut At) {
    let context = at.context;
    let scene = context.scene;
    let Some(cell) = &scene.cell else { return without(at) };
    let fine = at.positive("cell.size[0]", cell.size.0, "a width in m")
        & at.positive("cell.size[1]", cell.size.1, "a height in m");
    let is_state = matches!(scene.specimen, Specimen::State { .. });
    let is_known = !is_state && context.is_read() && at.are_sound(&["specimen"]);
    let seeds = if is_known { context.at_start() } else { Vec::new() };
    let needed = MIN_SIZE * 2.0 * seeds.iter().map(|seed| seed.radius).fold(0.0, f64::max);
    let is_small = fine && cell.size.0.min(cell.size.1) < needed;
    let help = format!(
        "at least {MIN_SIZE} times the maximum diameter, {needed:?} m, so that two particles touch once only"
    );
    at.refuse(is_small, "cell.size", "too small a cell", help);
    if fine && at.are_sound(&["cell"]) {
        images(at, cell, &seeds);
    }
    if let Some(i) = scene.walls.iter().position(|wall| wall.present)
        && !context.takes_walls()
    {
        let help = "leave it out, or write `present: false` and add it once a `Remove` stage has ended the \
                    cell (`open_cell: true`)";
        at.add(format_args!("walls[{i}]"), "a wall in a periodic cell", help);
    }
    weight(at, Some(scene.gravity));
    for (name, material) in &scene.materials {
        if material.contact.restitution > 0.0 {
            let help = "leave it out; `theta` of the analysis sets the rebound";
            let what = "a restitution in a periodic cell";
            at.entry("materials", name).add("contact.restitution", what, help);
        }
    }
    let is_dynamic = |load: &Load| load.analysis.unwrap_or(scene.analysis) != Analysis::Static;
    let mut in_cell = scene.stages.iter().take_while(|stage| !opens(stage)).filter_map(Stage::load);
    let help = "leave it out, or make all loading stages static; the measures `KineticEnergy` and \
                `ElasticEnergy` are defined in both";
    let what = "an energy ledger of a periodic cell with dynamic stages";
    at.refuse(scene.output.energy && in_cell.any(is_dynamic), "output.energy", what, help);
    if let Some(state) = context.state().filter(|state| !state.gives_cell) {
        let help = "leave it out: the run continues in it";
        at.refuse(state.cell.is_some(), "cell", "the state has a periodic cell already", help);
        let help = "start from the state of a run with a cell, or leave `cell` out";
        at.refuse(state.cell.is_none(), "cell", "a state without a periodic cell", help);
    }
    let mut is_open = false;
    for (i, stage) in scene.stages.iter().enumerate() {
        let at = &mut at.item("stages", i);
        if is_open {
            let help =
                "leave it out, or end the cell later: an earlier stage has `open_cell: true`";
            outside(at, stage, help);
        } else {
            inside(at, stage);
        }
        is_open |= opens(stage);
    }
}

/// Checks that particles do not overlap across the sides of the cell by more than half a radius, as they
/// do where it is smaller than the grid on which they are drawn.
fn images(at: &mut At, cell: &Cell, seeds: &[Particle]) {
    let (places, radii): (Vec<_>, Vec<_>) =
        seeds.iter().map(|s| (DVec2::from(s.position), s.radius)).unzip();
    let periodic = at_start(cell);
    let overlap = |(a, b): (u32, u32)| {
        let (i, j) = (a as usize, b as usize);
        let apart = places[j] - places[i];
        let shift = periodic.shift(apart);
        let gap = (apart + shift).length() - radii[i] - radii[j];
        (shift != DVec2::ZERO).then_some((-gap / radii[i].min(radii[j]), a, b))
    };
    let pairs = pairs_within(&periodic, &places, &radii, 0.0).into_iter().filter_map(overlap);
    let most = pairs.max_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((_, a, b)) = most.filter(|(overlap, ..)| *overlap > 0.5) {
        let message =
            format!("particles {a} and {b} overlap across a side by more than half a radius");
        let help = "give a larger cell: that of a `Packing` is columns times spacing wide, and as high as its rows";
        at.add("cell.size", message, help);
    }
}

/// Whether a stage ends the cell.
fn opens(stage: &Stage) -> bool {
    matches!(stage, Stage::Remove(stage) if stage.open_cell)
}

/// Checks a scene without a cell.
fn without(at: &mut At) {
    let scene = at.context.scene;
    if !at.is_sure_of("cell") {
        return;
    }
    let help = match scene.specimen {
        Specimen::State { .. } => "leave it out: the state has none, or its cell has ended",
        _ => "add `cell: (size: (WIDTH, HEIGHT))` to the scene",
    };
    for (i, stage) in scene.stages.iter().enumerate() {
        outside(&mut at.item("stages", i), stage, help);
    }
}

/// Checks a stage in the cell.
fn inside(at: &mut At, stage: &Stage) {
    match stage {
        Stage::Compact(stage) => compact(at, stage),
        Stage::Load(stage) => load(at, stage),
        Stage::Remove(stage) if stage.keep_tractions => {
            let help = "leave it out: a periodic cell has no loads of particles; end it before (`open_cell`)";
            at.add("keep_tractions", "tractions in a periodic cell", help);
        }
        Stage::Cement(_) | Stage::Save(_) | Stage::Remove(_) => {}
        Stage::Pour(_) | Stage::Custom(_) => {
            let help = "use `Load`, `Compact`, `Cement`, `Remove` and `Save`";
            at.add("", "this stage does not support a periodic cell", help);
        }
    }
}

/// Checks a stage without a cell. `help` says how to have one.
fn outside(at: &mut At, stage: &Stage, help: &str) {
    match stage {
        Stage::Load(stage) if stage.cell.is_some() => at.add("cell", "no periodic cell", help),
        Stage::Remove(stage) if stage.open_cell => at.add("open_cell", "no periodic cell", help),
        Stage::Compact(stage) => {
            for (field, wall) in [("wall", &stage.wall), ("base", &stage.base)] {
                let help = format!("add `{field}: ...`");
                let message = format!("missing field `{field}`");
                at.refuse(wall.is_empty() && at.is_sure(field), field, message, help);
            }
        }
        _ => {}
    }
}

fn compact(at: &mut At, stage: &Compact) {
    for (field, wall) in [("wall", &stage.wall), ("base", &stage.base)] {
        let help = "leave it out: a periodic cell is compacted from all sides";
        at.refuse(!wall.is_empty(), field, "a wall in a periodic cell", help);
    }
    let help = "write `target: Porosity(...)` or `target: Jammed`";
    let what = "a height in a periodic cell";
    at.refuse(matches!(stage.target, CompactTarget::Height(_)), "target", what, help);
}

/// Checks the gravity of the scene or of a stage.
fn weight(at: &mut At, gravity: Option<(f64, f64)>) {
    let help = "leave it out: a periodic cell has no bottom that would carry a weight";
    let what = "gravity in a periodic cell";
    at.refuse(gravity.is_some_and(|gravity| gravity != (0.0, 0.0)), "gravity", what, help);
}

fn load(at: &mut At, stage: &Load) {
    weight(at, stage.gravity);
    let help = "add it once a `Remove` stage has ended the cell (`open_cell: true`)";
    at.refuse(!stage.add_walls.is_empty(), "add_walls[0]", "a wall in a periodic cell", help);
    let help = "leave them out: nothing would carry their reactions";
    at.refuse(!stage.particles.is_empty(), "particles", "controls in a periodic cell", help);
    if !stage.rigid.is_empty() {
        at.add("rigid", "rigid groups in a periodic cell", "leave them out");
    }
    let help =
        "leave them out: a periodic cell has no outermost grains; write `cell: (xx: Stress(...))`";
    at.refuse(!stage.membranes.is_empty(), "membranes", "membranes in a periodic cell", help);
    let Some(control) = &stage.cell else { return };
    let at = &mut at.field("cell");
    for (field, target) in [("xx", control.xx), ("yy", control.yy)] {
        let help = "give `xx` and `yy`, or `mean` and `difference`";
        let message = format!("{field} beside the mean of xx and yy");
        at.refuse(control.is_by_mean() && target.is_some(), field, message, help);
    }
    for (field, target) in control.targets() {
        let number = format_args!("{field}[0]");
        match target {
            Some(CellTarget::Strain(strain)) => match field {
                "shear" => at.finite(number, strain, "a shear strain"),
                "difference" => at.finite(number, strain, "a difference of strains"),
                _ => at.number(number, strain, |strain| strain < 1.0, "a strain below 1"),
            },
            Some(CellTarget::Stress(stress)) => at.finite(number, stress, "a stress in Pa"),
            Some(CellTarget::Fixed) | None => true,
        };
    }
}
