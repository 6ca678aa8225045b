//! Time by stage of an increment and size of its program, by features of the scene.

use std::collections::BTreeMap;
use std::path::Path;

use clastic::cone::program::ConeProgram;
use clastic::output::read_history::History;
use clastic::output::{OutputError, directory, timings};
use clastic::reference;
use clastic::scene::LoadedScene;
use clastic::scene::format::{Load, Particle, Specimen, Stage, WallControl};

use crate::clock::{Repetitions, median};
use crate::rigs::{Scenes, set_motion};
use crate::table::{Cell, Part, Table};
use crate::written::written_run;
use crate::{BenchError, Extent};

/// Number of increments of the last stage, after the first one, over which times are averaged.
const INCREMENTS: u32 = 5;

/// Runs this part. Runs are written below `scratch` and removed again.
///
/// # Errors
/// Where a scene is not there or a file cannot be written.
pub fn run(scenes: &Scenes, extent: Extent, scratch: &Path) -> Result<Part, BenchError> {
    let mut columns = vec![
        "scene",
        "bodies",
        "interactions",
        "force_variables",
        "inertia_variables",
        "balance_rows",
        "limit_rows",
        "solves",
        "iterations",
    ];
    columns.extend(MILLISECONDS);
    columns.extend(["total_ms", "all_but_solve_percent"]);
    let mut table = Table::new(
        "stages",
        "Mean time by stage of an increment, ms, and size of its program",
        &columns,
    );
    let repetitions = match extent {
        Extent::Quick => Repetitions { minimum: 3, maximum: 3, seconds: 0.0 },
        _ => Repetitions { minimum: 1, maximum: 1, seconds: 0.0 },
    };
    for (name, loaded) in variants(scenes, extent > Extent::Quick)? {
        table.rows.push(row(name, &loaded, &scratch.join("stages_run"), &repetitions)?);
    }
    let text = "Means over five increments. The first increment of the stage, with ordering and \
        symbolic analysis of the matrix, does not count. All rows but the first two and \
        the last four are variants of the biaxial scene; `oedometric` has fixed sides. \
        `held`: no wall moves, and the state is that of the last increment. `columns`: \
        40 columns of ten rigid disks on one floor. `output` writes history, events and \
        timings.";
    Ok(Part { name: "stages", text: text.to_owned(), tables: vec![table], charts: Vec::new() })
}

/// Columns of `timings.csv` in ms.
const MILLISECONDS: [&str; 8] = [
    "detect_ms",
    "assemble_ms",
    "solve_ms",
    "update_ms",
    "rupture_ms",
    "walls_ms",
    "record_ms",
    "output_ms",
];

fn variants(scenes: &Scenes, full: bool) -> Result<Vec<(&'static str, LoadedScene)>, BenchError> {
    let increments = format!("stages.load.increments={}", INCREMENTS + 1);
    let biaxial = |sets: &[&str]| {
        let mut all = vec![increments.as_str()];
        all.extend(sets);
        scenes.biaxial(full, &all)
    };
    const NO_ROLLING: [&str; 2] =
        ["materials.sand.contact.rolling_friction=0.0", "materials.sand.bond.rolling_friction=0.0"];
    // Loose disks do not take up 200 kPa from gaps in five increments: between fixed sides instead.
    let without_bonds = |mut loaded: LoadedScene| {
        loaded.scene.stages.retain(|stage| stage.name() == "load");
        loaded
    };
    let mut frictionless = NO_ROLLING.to_vec();
    frictionless.push("materials.sand.contact.friction=0.0");
    let mut held = biaxial(&[])?;
    set_motion(&mut held.scene, "top", 0.0);
    set_motion(&mut held.scene, "bottom", 0.0);
    let mut held_rock = scenes.uniaxial(full, INCREMENTS + 5)?;
    let Some(Stage::Load(load)) = held_rock.scene.stages.last().cloned() else {
        return Err(BenchError::Run("the last stage of the rig loads nothing".to_owned()));
    };
    // Four increments of load, then none.
    let hold = Load {
        name: "hold".to_owned(),
        walls: BTreeMap::new(),
        remove_walls: Vec::new(),
        increments: INCREMENTS + 1,
        ..load
    };
    if let Some(Stage::Load(load)) = held_rock.scene.stages.last_mut() {
        load.increments = 4;
    }
    held_rock.scene.stages.push(Stage::Load(hold));
    Ok(vec![
        ("uniaxial rock (bonds, no rolling)", scenes.uniaxial(full, INCREMENTS + 1)?),
        ("the same, held", held_rock),
        ("biaxial (bonds, friction, rolling)", biaxial(&[])?),
        ("the same, held", held),
        ("no rolling", biaxial(&NO_ROLLING)?),
        ("no bonds, oedometric", without_bonds(biaxial(&[])?)),
        ("no bonds, frictionless, oedometric", without_bonds(biaxial(&frictionless)?)),
        ("dynamic", biaxial(&["stages.load.analysis=Dynamic(dt: 1.0e-3)"])?),
        ("columns at rest, a disk falls", columns(scenes, None)?),
        ("the same, floor driven", columns(scenes, Some(1e-6))?),
        ("one body in contact", scenes.load("incline_rests", &[])?),
        ("one body in flight", scenes.load("bounce", &["stages.drop.increments=90"])?),
    ])
}

/// Forty columns of ten disks at rest on one floor, and a disk that falls beside them. The floor
/// may be driven sideways, m an increment: then nothing is at rest.
fn columns(scenes: &Scenes, driven: Option<f64>) -> Result<LoadedScene, BenchError> {
    let increments = format!("stages.rest.increments={}", 4 * INCREMENTS);
    let mut loaded = scenes.load("stack", &[&increments, "friction_law=Associated"])?;
    let Specimen::Particles(column) = &mut loaded.scene.specimen else {
        return Err(BenchError::Run("the stack is not a list of particles".to_owned()));
    };
    let mut all = Vec::new();
    for k in 0..40 {
        all.extend(column.iter().map(|disk| {
            let place = (disk.position.0 + 0.03 * f64::from(k), disk.position.1);
            Particle { position: place, probe: None, ..disk.clone() }
        }));
    }
    let falling = column[0].clone();
    all.push(Particle { position: (-0.05, 0.2), probe: None, ..falling });
    *column = all;
    loaded.scene.walls[0].end.0 = 1.3;
    if let (Some(u), Some(Stage::Load(load))) = (driven, loaded.scene.stages.last_mut()) {
        load.walls.insert("floor".to_owned(), WallControl::Displacement(u, 0.0));
    }
    Ok(loaded)
}

fn row(
    name: &str,
    loaded: &LoadedScene,
    scratch: &Path,
    repetitions: &Repetitions,
) -> Result<Vec<Cell>, BenchError> {
    let mut runs = Vec::new();
    let mut failed = None;
    median(repetitions, || {
        match measure(loaded, scratch) {
            Ok(run) => runs.push(run),
            Err(error) => failed = Some(error),
        }
        0.0
    });
    if let Some(error) = failed {
        return Err(error);
    }
    // The run with the minimum total: other programs on the machine only add time.
    let total = |times: &[f64]| times.iter().sum::<f64>();
    runs.sort_by(|a, b| total(&a.1).total_cmp(&total(&b.1)));
    let Some((cells, times)) = runs.into_iter().next() else {
        return Err(BenchError::Run(format!("{name}: no run")));
    };
    let sum = total(&times);
    let mut row = vec![name.into()];
    row.extend(cells);
    row.extend(times.iter().map(|t| Cell::from(1e3 * t)));
    row.extend([(1e3 * sum).into(), (100.0 * (1.0 - times[2] / sum)).into()]);
    Ok(row)
}

/// Runs a scene: the size of its last program with the mean of solves and iterations, and mean
/// seconds by stage of the last increments.
fn measure(loaded: &LoadedScene, scratch: &Path) -> Result<(Vec<Cell>, Vec<f64>), BenchError> {
    let simulation = written_run(loaded, scratch)?;
    let times = History::read(&scratch.join(directory::TIMINGS))?;
    let history = History::read(&scratch.join(directory::HISTORY))?;
    std::fs::remove_dir_all(scratch).map_err(OutputError::at(scratch))?;
    let mean = |table: &History, column: &str| {
        let rows = table.column(column);
        let last = &rows[rows.len().saturating_sub(INCREMENTS as usize)..];
        last.iter().flatten().sum::<f64>() / last.len().max(1) as f64
    };
    let program = simulation.world().resource::<ConeProgram>();
    let size = reference::size(program);
    let cells = vec![
        program.bodies.len().into(),
        program.interactions.len().into(),
        size.forces.into(),
        size.inertias.into(),
        size.balance_rows.into(),
        size.limit_rows.into(),
        mean(&history, "solves").into(),
        mean(&history, "solver_iterations").into(),
    ];
    let seconds = timings::COLUMNS[1..=MILLISECONDS.len()]
        .iter()
        .map(|column| mean(&times, column))
        .collect();
    Ok((cells, seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column more in `timings.csv` made the table longer than its header.
    #[test]
    fn columns_are_those_of_the_timings() {
        for (ms, s) in MILLISECONDS.iter().zip(&timings::COLUMNS[1..]) {
            assert_eq!(ms.strip_suffix("_ms"), s.strip_suffix("_s"));
        }
    }
}
