//! A periodic cell, its controls, and what a scene with one may not have.

use std::fmt::Arguments;

use clastic_systems::detect_contacts::periodic::pairs_within;
use glam::DVec2;

use crate::run::cell::at_start;
use crate::scene::format::{Analysis, Cell, CellTarget, Compact, CompactRest, CompactTarget, Load};
use crate::scene::format::{Scene, Sizes, Specimen, Stage};
use crate::scene::spans::join;

use super::Context;
use super::findings::Findings;

/// Minimum size of a cell, in maximum diameters. A contact may then be as long as two of them
/// before there could be another between the same particles.
const MIN_SIZE: f64 = 4.0;

pub(super) fn check(findings: &mut Findings) {
    let context = findings.context;
    let scene = context.scene;
    let Some(cell) = &scene.cell else { return without(scene, findings) };
    let fine = findings.positive(format_args!("cell.size[0]"), cell.size.0, "a width in m")
        & findings.positive(format_args!("cell.size[1]"), cell.size.1, "a height in m");
    findings.finite(format_args!("cell.tilt"), cell.tilt, "a length in m");
    let radius = max_radius(context);
    if let (true, Some(radius)) = (fine && findings.is_sure_of("specimen"), radius) {
        let needed = MIN_SIZE * 2.0 * radius;
        if cell.size.0.min(cell.size.1) < needed {
            let help = format!(
                "at least {MIN_SIZE} times the maximum diameter, {needed:?} m, so that two particles \
                 touch once only"
            );
            findings.add(format_args!("cell.size"), "too small a cell", &help);
        }
    }
    if fine {
        images(cell, findings);
    }
    let help = "leave it out: a periodic cell has no";
    let of_state = context.state();
    if let Some(i) = scene.walls.iter().position(|wall| wall.present)
        && !context.takes_walls()
    {
        let help = "leave it out, or write `present: false` and add it once a `Remove` stage has ended the \
                    cell (`open_cell: true`)";
        findings.add(format_args!("walls[{i}]"), "a wall in a periodic cell", help);
    }
    if scene.gravity != (0.0, 0.0) {
        let help = format!("{help} bottom that would carry a weight");
        findings.add(format_args!("gravity"), "gravity in a periodic cell", &help);
    }
    for (name, material) in &scene.materials {
        if material.contact.restitution > 0.0 {
            let path = join("materials", name);
            let help = "leave it out; `theta` of the analysis sets the rebound";
            let path = format_args!("{path}.contact.restitution");
            findings.add(path, "a restitution in a periodic cell", help);
        }
    }
    let is_dynamic = |load: &Load| load.analysis.unwrap_or(scene.analysis) != Analysis::Static;
    let mut in_cell = scene.stages.iter().take_while(|stage| !opens(stage)).filter_map(Stage::load);
    if scene.output.energy && in_cell.any(is_dynamic) {
        let help = "leave it out, or make all loading stages static; the measures `KineticEnergy` and \
                    `ElasticEnergy` are defined in both";
        let what = "an energy ledger of a periodic cell with dynamic stages";
        findings.add(format_args!("output.energy"), what, help);
    }
    if let Some(state) = of_state.filter(|state| !state.gives_cell) {
        let (what, help) = match state.cell {
            Some(_) => {
                ("the state has a periodic cell already", "leave it out: the run continues in it")
            }
            None => (
                "a state without a periodic cell",
                "start from the state of a run with a cell, or leave `cell` out",
            ),
        };
        findings.add(format_args!("cell"), what, help);
    }
    let mut is_open = false;
    for (i, stage) in scene.stages.iter().enumerate() {
        let path = format_args!("stages[{i}]");
        if is_open {
            let help =
                "leave it out, or end the cell later: an earlier stage has `open_cell: true`";
            outside(path, stage, help, findings);
        } else {
            inside(path, stage, findings);
        }
        is_open |= opens(stage);
    }
}

/// Checks that particles do not overlap across the sides of the cell by more than half a radius, as they
/// do where it is smaller than the grid on which they are drawn.
fn images(cell: &Cell, findings: &mut Findings) {
    let context = findings.context;
    let scene = context.scene;
    let is_known = match scene.specimen {
        Specimen::State { .. } => false,
        Specimen::File { .. } => context.specimen.is_some(),
        _ => true,
    };
    if !is_known || !findings.is_sound("specimen") || !findings.is_sound("cell") {
        return;
    }
    let seeds = context.at_start();
    let (places, radii): (Vec<_>, Vec<_>) = seeds.iter().map(|s| (s.position, s.radius)).unzip();
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
        findings.add(format_args!("cell.size"), message, help);
    }
}

/// Whether a stage ends the cell.
fn opens(stage: &Stage) -> bool {
    matches!(stage, Stage::Remove(stage) if stage.open_cell)
}

fn without(scene: &Scene, findings: &mut Findings) {
    if !findings.is_sure_of("cell") {
        return;
    }
    for (i, stage) in scene.stages.iter().enumerate() {
        let help = match scene.specimen {
            Specimen::State { .. } => "leave it out: the state has none, or its cell has ended",
            _ => "add `cell: (size: (WIDTH, HEIGHT))` to the scene",
        };
        outside(format_args!("stages[{i}]"), stage, help, findings);
    }
}

/// Checks a stage in the cell.
fn inside(path: Arguments, stage: &Stage, findings: &mut Findings) {
    match stage {
        Stage::Compact(stage) => compact(path, stage, findings),
        Stage::Load(stage) => load(path, stage, findings),
        Stage::Remove(stage) if stage.keep_tractions => {
            let help = "leave it out: a periodic cell has no loads of particles; end it before (`open_cell`)";
            findings.add(
                format_args!("{path}.keep_tractions"),
                "tractions in a periodic cell",
                help,
            );
        }
        Stage::Cement(_) | Stage::Save(_) | Stage::Remove(_) => {}
        Stage::Pour(_) | Stage::Custom(_) => {
            let help = "use `Load`, `Compact`, `Cement`, `Remove` and `Save`";
            findings.add(path, "this stage does not support a periodic cell", help);
        }
    }
}

/// Checks a stage without a cell. `help` says how to have one.
fn outside(path: Arguments, stage: &Stage, help: &str, findings: &mut Findings) {
    match stage {
        Stage::Load(stage) if stage.cell.is_some() => {
            findings.add(format_args!("{path}.cell"), "no periodic cell", help);
        }
        Stage::Remove(stage) if stage.open_cell => {
            findings.add(format_args!("{path}.open_cell"), "no periodic cell", help);
        }
        Stage::Compact(stage) => {
            for (field, wall) in [("wall", &stage.wall), ("base", &stage.base)] {
                if wall.is_empty() && findings.is_sure_of_part(format_args!("{path}.{field}")) {
                    let message = format!("missing field `{field}`");
                    let help = format!("add `{field}: ...`");
                    findings.add(format_args!("{path}.{field}"), message, &help);
                }
            }
        }
        _ => {}
    }
}

fn compact(path: Arguments, stage: &Compact, findings: &mut Findings) {
    for (field, wall) in [("wall", &stage.wall), ("base", &stage.base)] {
        if !wall.is_empty() {
            let help = "leave it out: a periodic cell is compacted from all sides";
            findings.add(format_args!("{path}.{field}"), "a wall in a periodic cell", help);
        }
    }
    if matches!(stage.target, CompactTarget::Height(_)) {
        let help = "write `target: Porosity(...)` or `target: Jammed`";
        findings.add(format_args!("{path}.target"), "a height in a periodic cell", help);
    }
    if stage.rest == CompactRest::Still {
        let help = "leave it out: particles move with the cell";
        findings.add(format_args!("{path}.rest"), "`Still` in a periodic cell", help);
    }
}

fn load(path: Arguments, stage: &Load, findings: &mut Findings) {
    if stage.gravity.is_some_and(|gravity| gravity != (0.0, 0.0)) {
        let help = "leave it out: a periodic cell has no bottom that would carry a weight";
        findings.add(format_args!("{path}.gravity"), "gravity in a periodic cell", help);
    }
    if !stage.add_walls.is_empty() {
        let help = "add it once a `Remove` stage has ended the cell (`open_cell: true`)";
        findings.add(format_args!("{path}.add_walls[0]"), "a wall in a periodic cell", help);
    }
    if !stage.particles.is_empty() {
        let help = "leave them out: nothing would carry their reactions";
        findings.add(format_args!("{path}.particles"), "controls in a periodic cell", help);
    }
    if !stage.rigid.is_empty() {
        let help = "leave them out";
        findings.add(format_args!("{path}.rigid"), "rigid groups in a periodic cell", help);
    }
    if !stage.membranes.is_empty() {
        let help = "leave them out: a periodic cell has no outermost grains; write \
                    `cell: (xx: Stress(...))`";
        findings.add(format_args!("{path}.membranes"), "membranes in a periodic cell", help);
    }
    let Some(control) = &stage.cell else { return };
    for (field, target) in [("xx", control.xx), ("yy", control.yy)] {
        if control.is_by_mean() && target.is_some() {
            let help = "give `xx` and `yy`, or `mean` and `difference`";
            let message = format!("{field} beside the mean of xx and yy");
            findings.add(format_args!("{path}.cell.{field}"), message, help);
        }
    }
    let normal = [("xx", control.xx), ("yy", control.yy), ("mean", control.mean)];
    let others = [("difference", control.difference), ("shear", control.shear)];
    for (field, target) in normal.into_iter().chain(others) {
        let path = format_args!("{path}.cell.{field}[0]");
        match target {
            Some(CellTarget::Strain(strain)) if field == "shear" => {
                findings.finite(path, strain, "a shear strain");
            }
            Some(CellTarget::Strain(strain)) if field == "difference" => {
                findings.finite(path, strain, "a difference of strains");
            }
            Some(CellTarget::Strain(strain)) => {
                let allowed = |strain: f64| strain.is_finite() && strain < 1.0;
                findings.number(path, strain, allowed, "a strain below 1");
            }
            Some(CellTarget::Stress(stress)) => {
                findings.finite(path, stress, "a stress in Pa");
            }
            Some(CellTarget::Fixed) | None => {}
        }
    }
}

/// Maximum radius of the specimen, if known.
fn max_radius(context: &Context) -> Option<f64> {
    let stored = context.specimen;
    Some(match &context.scene.specimen {
        Specimen::Particles(list) => list.iter().map(|p| p.radius).fold(0.0, f64::max),
        Specimen::Lattice { radius, .. } => *radius,
        Specimen::Packing { sizes, .. } => match sizes {
            Sizes::Equal { radius } => *radius,
            Sizes::Uniform { radius } => radius.1,
            Sizes::LogNormal { limits, .. } => limits.1,
            Sizes::Sieve { passing } => 0.5 * passing.last()?.0,
        },
        Specimen::File { .. } => stored?.rows.iter().map(|p| p.r).fold(0.0, f64::max),
        Specimen::State { .. } => return None,
    })
}
