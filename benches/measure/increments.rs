//! Size of the increment: whole curves at a quarter to eight times the increment, over seeds.

use crate::chart::{Chart, Line};
use clastic::components::attempt::IncrementStatus;
use clastic::components::body::{BodyOrigin, BodyPosition};
use clastic::components::increment::ClasticProgress;
use clastic::components::observation::Observation;
use clastic::components::wall::WallName;
use clastic::output::frames::specimen_rows;
use clastic::run::key_results::{KeyResults, Phase};
use clastic::run::{Outcome, Simulation, Step};
use clastic::scene::format::{Compact, CompactTarget, RuptureOrder, Scene, Sizes, Specimen, Stage};
use clastic::scene::{LoadedScene, StoredSpecimen};

use crate::clock::time;
use crate::rigs::{Scenes, scale_increments};
use crate::table::{Part, Table};
use crate::{BenchError, Extent};

/// Sizes of the increment, over that of the scene; the first is the reference.
const FACTORS: [f64; 6] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0];

/// A test: rig, strains at which the stress is read, and its specimens by seed.
struct Test {
    name: &'static str,
    strains: [f64; 2],
    /// The order in which bonds break.
    order: RuptureOrder,
    prepare: fn(&Scenes, bool, u64) -> Result<LoadedScene, BenchError>,
}

const TESTS: [Test; 4] = [
    uniaxial_test("uniaxial", RuptureOrder::OneRound),
    uniaxial_test("uniaxial, events", RuptureOrder::Events),
    biaxial_test("biaxial", RuptureOrder::OneRound),
    biaxial_test("biaxial, events", RuptureOrder::Events),
];

const fn uniaxial_test(name: &'static str, order: RuptureOrder) -> Test {
    Test { name, strains: [1e-3, 2e-3], order, prepare: uniaxial }
}

const fn biaxial_test(name: &'static str, order: RuptureOrder) -> Test {
    Test { name, strains: [2e-3, 1e-2], order, prepare: biaxial }
}

/// Values of a curve.
struct Curve {
    points: Vec<(f64, f64)>,
    seconds: f64,
    increments: usize,
    /// Modulus, first crack, stress at two strains, peak, strain at the peak.
    values: [Option<f64>; 6],
}

/// Names of the values, in order.
const VALUES: [&str; 6] = [
    "modulus",
    "first crack",
    "stress at first strain",
    "stress at second strain",
    "peak",
    "strain at peak",
];

/// Runs this part.
///
/// # Errors
/// Where a scene is not there, or a run does not come far enough.
pub fn run(scenes: &Scenes, extent: Extent) -> Result<Part, BenchError> {
    let seeds = if extent == Extent::Quick { 2 } else { 5 };
    let full = extent == Extent::Full;
    let mut runs = Table::new(
        "increments",
        "Whole curves by size of the increment and seed",
        &[
            "test",
            "seed",
            "factor",
            "increments",
            "time_s",
            "modulus_pa",
            "first_crack_pa",
            "stress_1_pa",
            "stress_2_pa",
            "peak_pa",
            "strain_at_peak",
        ],
    );
    runs.in_summary = false;
    let mut errors = Table::new(
        "increments_errors",
        "Change against a quarter of the increment, per cent: mean over the seeds (maximum)",
        &[
            "test",
            "factor",
            "time_s",
            "modulus",
            "first_crack",
            "stress_1",
            "stress_2",
            "peak",
            "strain_at_peak",
        ],
    );
    let mut charts = Vec::new();
    let quick = extent == Extent::Quick;
    for test in TESTS.iter().filter(|test| !quick || test.order == RuptureOrder::OneRound) {
        let mut curves: Vec<Vec<Curve>> = Vec::new();
        for seed in 1..=seeds {
            let mut prepared = (test.prepare)(scenes, full, seed)?;
            prepared.scene.rupture.order = test.order;
            let mut of_seed = Vec::new();
            for factor in FACTORS {
                let mut loaded = prepared.clone();
                scale_increments(&mut loaded.scene, factor)?;
                let curve = curve(&loaded, test)?;
                let mut row = vec![
                    test.name.into(),
                    (seed as usize).into(),
                    factor.into(),
                    curve.increments.into(),
                    curve.seconds.into(),
                ];
                row.extend(curve.values.map(Into::into));
                runs.rows.push(row);
                of_seed.push(curve);
            }
            curves.push(of_seed);
        }
        for (k, factor) in FACTORS.into_iter().enumerate() {
            let mean_time = curves.iter().map(|c| c[k].seconds).sum::<f64>() / curves.len() as f64;
            let mut row = vec![test.name.into(), factor.into(), mean_time.into()];
            row.extend((0..VALUES.len()).map(|v| change(&curves, k, v).into()));
            errors.rows.push(row);
        }
        if let Some(first) = curves.into_iter().next() {
            let name = test.name.replace(", ", "_").replace(' ', "_");
            charts.push((format!("increments_{name}"), chart(test, first)));
        }
    }
    let text = format!(
        "Packings of {seeds} seeds, {} disks, each compacted once and then loaded in increments \
        of 0.25 to 8 times those of the scenes ({} axial strain). Runs end where the stress has \
        fallen to 40 % of its peak (uniaxial), or at 3 % strain (biaxial, lateral stress 200 \
        kPa). Stresses are interpolated linearly at the axial strains {:?} (uniaxial) and {:?} \
        (biaxial). The biaxial confinement always has five increments, and the first bond breaks \
        there. With `events` an increment ends where the next bond reaches its limit. The modulus \
        is the tangent of the first increment. The first crack is the stress of the increment in \
        which the first bond broke. Empty cells: the value was not reached, for example where one \
        increment goes beyond the peak.",
        if full { "7380 and 6160" } else { "400" },
        "0.005 % and 0.074 %",
        TESTS[0].strains,
        TESTS[2].strains,
    );
    Ok(Part { name: "increments", text, tables: vec![errors, runs], charts })
}

/// Mean over the seeds of the change of a value in per cent, and the maximum.
fn change(curves: &[Vec<Curve>], k: usize, value: usize) -> String {
    let changes: Vec<f64> = curves
        .iter()
        .filter_map(|of_seed| {
            let (now, reference) = (of_seed[k].values[value]?, of_seed[0].values[value]?);
            (reference != 0.0).then(|| 100.0 * (now / reference - 1.0))
        })
        .collect();
    if k == 0 || changes.is_empty() {
        return String::new();
    }
    let mean = changes.iter().sum::<f64>() / changes.len() as f64;
    let maximum = changes.iter().copied().reduce(|a, b| if b.abs() > a.abs() { b } else { a });
    format!("{mean:+.2} ({:+.2})", maximum.unwrap_or(0.0))
}

fn chart(test: &Test, curves: Vec<Curve>) -> Chart {
    let lines = FACTORS.iter().zip(curves).map(|(factor, curve)| Line {
        name: format!("{factor} x"),
        points: curve.points.iter().map(|(e, s)| (100.0 * e, 1e-6 * s)).collect(),
    });
    Chart {
        title: format!("Size of the increment: {}, first seed", test.name),
        caption: "compression positive".to_owned(),
        x: "axial strain, %".to_owned(),
        y: "axial stress, MPa".to_owned(),
        lines: lines.collect(),
    }
}

/// Runs a test.
fn curve(loaded: &LoadedScene, test: &Test) -> Result<Curve, BenchError> {
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let mut results = KeyResults::new(false);
    let mut points = vec![];
    let mut increments = 0;
    let last = loaded.scene.stages.last().map_or("", |stage| stage.name()).to_owned();
    let (seconds, outcome) = time(|| {
        loop {
            if let Step::Finished(outcome) = simulation.step() {
                return outcome;
            }
            let record = simulation.world().resource::<Observation>();
            let is_solved =
                matches!(record.status, IncrementStatus::Solved | IncrementStatus::Capped);
            if !is_solved || record.in_avalanche {
                continue;
            }
            let reference = record.stage == last;
            results.observe(record, if reference { Phase::Reference } else { Phase::Loading });
            if let (true, Some(e), Some(s)) = (reference, record.axial_strain, record.axial_stress)
            {
                points.push((e, s));
                increments += 1;
            }
        }
    });
    // The increment at which the run stalls depends on the size of the increments; the earlier ones
    // count.
    if let (Outcome::Undecided { message, .. } | Outcome::Refused { message, .. }, true) =
        (&outcome, points.is_empty())
    {
        return Err(BenchError::Run(message.clone()));
    }
    let r = results.results();
    let at = |strain: f64| {
        let k = points.iter().position(|p| p.0 >= strain)?;
        let (e1, s1) = points[k];
        let (e0, s0) = if k > 0 { points[k - 1] } else { return None };
        Some(s0 + (s1 - s0) * (strain - e0) / (e1 - e0))
    };
    let values = [
        r.youngs_modulus_pa,
        r.first_crack_stress_pa,
        at(test.strains[0]),
        at(test.strains[1]),
        r.peak_stress_pa,
        r.strain_at_peak,
    ];
    Ok(Curve { points, seconds, increments, values })
}

/// `uniaxial.ron` or `uniaxial_small.ron`, compacted, with the seed of packing and agitation.
fn uniaxial(scenes: &Scenes, full: bool, seed: u64) -> Result<LoadedScene, BenchError> {
    let (packing, compaction) =
        (format!("specimen.seed={seed}"), format!("stages.compact.seed={seed}"));
    let name = if full { "uniaxial" } else { "uniaxial_small" };
    let sets = [packing.as_str(), &compaction, "stages.load.stop=[StressDrop(0.4)]"];
    prepared(scenes.load(name, &sets)?)
}

/// `biaxial_50kPa.ron` or `biaxial_small.ron` on a packing of its own, of 400 or 6160 disks.
fn biaxial(scenes: &Scenes, full: bool, seed: u64) -> Result<LoadedScene, BenchError> {
    let mut loaded = scenes.biaxial(full, &["stages.load.stop=[Above(\"axial_strain\", 0.03)]"])?;
    let (count, columns, spacing) = if full { (6160, 47, 10.1e-3) } else { (400, 12, 10.08e-3) };
    loaded.scene.specimen = Specimen::Packing {
        count,
        columns,
        spacing,
        origin: (0.0, 0.0),
        sizes: Sizes::Uniform { radius: (3.0e-3, 5.0e-3) },
        seed,
        material: None,
    };
    loaded.specimen = None;
    let height = f64::from(count.div_ceil(columns)) * spacing;
    move_top(&mut loaded.scene, height);
    let compact = Compact {
        name: "compact".to_owned(),
        wall: "top".to_owned(),
        base: "bottom".to_owned(),
        target: CompactTarget::Porosity(0.21),
        by: Default::default(),
        step: 2.0e-3,
        agitation: 0.1,
        seed,
        stop: Vec::new(),
        record: Default::default(),
    };
    loaded.scene.stages.insert(0, Stage::Compact(compact));
    prepared(loaded)
}

fn move_top(scene: &mut Scene, height: f64) {
    for wall in scene.walls.iter_mut().filter(|wall| wall.name == "top") {
        (wall.start.1, wall.end.1) = (height, height);
    }
}

/// A scene whose packing has been compacted: without the compaction, its walls where it left
/// them.
fn prepared(mut loaded: LoadedScene) -> Result<LoadedScene, BenchError> {
    let compactions =
        loaded.scene.stages.iter().take_while(|stage| matches!(stage, Stage::Compact(_))).count();
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    loop {
        if let Step::Finished(outcome) = simulation.step() {
            return Err(BenchError::Run(format!("no packing: {outcome:?}")));
        }
        let progress = simulation.world().resource::<ClasticProgress>();
        if progress.stage + 1 == compactions && progress.done >= progress.total {
            break;
        }
    }
    let rows = specimen_rows(simulation.world().resource(), simulation.world().resource());
    let world = simulation.world_mut();
    let mut walls = world.query::<(&WallName, &BodyPosition, &BodyOrigin)>();
    for (name, now, start) in walls.iter(world) {
        let way = now.0 - start.0;
        for wall in loaded.scene.walls.iter_mut().filter(|wall| wall.name == name.0) {
            for end in [&mut wall.start, &mut wall.end] {
                *end = (end.0 + way.x, end.1 + way.y);
            }
        }
    }
    loaded.scene.stages.drain(..compactions);
    loaded.scene.specimen = Specimen::File { path: "packing.csv".to_owned(), material: None };
    loaded.specimen = Some(StoredSpecimen::of(rows));
    Ok(loaded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prepared_packing_is_that_of_the_scene() -> Result<(), BenchError> {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let scenes = Scenes::new(&root.join("scenes"));
        let stress = |loaded: &LoadedScene, stage: &str| {
            let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
            loop {
                assert_eq!(simulation.step(), Step::Increment);
                let record = simulation.world().resource::<Observation>();
                if record.stage == stage {
                    return record.axial_stress;
                }
            }
        };
        let whole = stress(&scenes.load("uniaxial_small", &[])?, "load").unwrap_or(f64::NAN);
        let prepared = stress(&uniaxial(&scenes, false, 1)?, "load").unwrap_or(f64::NAN);
        assert!((whole - prepared).abs() <= 1e-9 * whole, "{whole} {prepared}");
        Ok(())
    }
}
