//! Two hundred laboratory scenes. A random seed determines every scene, so that nobody chose them
//! by hand. Every scene must run to its end. See `docs/reliability.md`, "Laboratory scenes".
//!
//! ```text
//! cargo test --release --test laboratory                             every eleventh seed
//! cargo test --release --test laboratory -- --ignored --nocapture    all seeds
//! ```
//!
//! Environment variables:
//!
//! - `LABORATORY_SEEDS`: seeds from which `LABORATORY` selects, `0..200` by default. Any other
//!   range gives new scenes of the same kinds
//! - `LABORATORY`: kinds (`biaxial`), seeds (`17`) and ranges of seeds (`10..20`), separated by
//!   commas
//! - `LABORATORY_MAX`: leaves out scenes with more disks
//! - `LABORATORY_THREADS`: scenes that run at the same time, 2 by default
//! - `LABORATORY_WRITE`: a directory that the scenes are written to as RON, for `clastic run`

#[path = "../common/mod.rs"]
mod common;

mod certificate;
mod rigs;
mod run;
mod sample;
mod scenes;
mod table;
mod verdict;

use std::collections::BTreeSet;
use std::fs;
use std::ops::Range;
use std::path::Path;

use clastic::components::observation::Observation;
use clastic::run::{Simulation, Step};
use clastic::scene::format::{Analysis, FrictionLaw};

use scenes::{KINDS, Plan, SCENES};
use verdict::Verdict;

/// Every eleventh seed runs with every `cargo test`. The kinds repeat after 20 seeds; 11 and 20
/// have no common factor, so that these seeds go through all kinds.
const STRIDE: u64 = 11;

/// Maximum number of scenes that may fail in every `cargo test`.
const FAILURES: usize = 0;

#[test]
fn every_eleventh_scene_completes() {
    let plans: Vec<Plan> = (0..SCENES).step_by(STRIDE as usize).map(Plan::new).collect();
    let reports = run::all(&plans, threads());
    table::print(&reports);
    judge(&reports, FAILURES);
}

#[test]
#[ignore = "takes hours"]
fn all_scenes_complete() {
    let seeds = std::env::var("LABORATORY_SEEDS").map_or(0..SCENES, |text| {
        range(&text)
            .unwrap_or_else(|| panic!("LABORATORY_SEEDS={text} is no range such as 200..220"))
    });
    let plans: Vec<Plan> = seeds.map(Plan::new).filter(is_wanted).collect();
    if let Ok(directory) = std::env::var("LABORATORY_WRITE") {
        write(&plans, Path::new(&directory));
    }
    let reports = run::all(&plans, threads());
    table::print(&reports);
    judge(&reports, 0);
}

/// Static scenes with Coulomb's law in which the interior point alone stalls in up to half of the
/// increments: an oedometer, a shear box, a deposition and a slope. The path followed past its
/// turning points solves nearly all.
#[test]
fn coulombs_law_converges_in_nearly_every_increment() {
    let plans: Vec<Plan> = [25, 33, 87, 108].map(Plan::new).into();
    let reports = run::all(&plans, threads());
    judge(&reports, 0);
    for report in &reports {
        assert!(report.coulomb, "seed {}", report.seed);
        let share = report.capped as f64 / report.increments as f64;
        assert!(share <= 0.01, "seed {}: {} capped", report.seed, report.capped);
    }
}

/// A piece that hangs on a platen under a stress goes where the platen goes. It had half a turn of its length to find
/// rest in, as if the platen stood, and the run ended as undecided.
#[test]
fn specimens_that_a_stress_pulls_apart_collapse() {
    let plans: Vec<Plan> = [106, 159, 179, 199].map(Plan::new).into();
    for report in run::all(&plans, threads()) {
        let (seed, reason) = (report.seed, report.verdict.reason());
        assert!(matches!(report.verdict, Verdict::Collapsed { .. }), "seed {seed}: {reason}");
    }
}

/// The bonds of this specimen roll, so that their forces open them: the first guess of the end of an
/// increment missed by half, and every increment took a third solve.
#[test]
fn increments_of_bonds_that_roll_are_solved_twice() {
    let mut simulation = Simulation::new(&common::parse(&Plan::new(121).text), None);
    while simulation.world().resource::<Observation>().bonds == 0 {
        assert_eq!(simulation.step(), Step::Increment);
    }
    for increment in 1..=20 {
        assert_eq!(simulation.step(), Step::Increment);
        let solves = simulation.world().resource::<Observation>().solves;
        assert!(solves <= 2, "{solves} solves in increment {increment}");
    }
}

/// The same seed gives the same scene, and the engine reads all of them without error.
#[test]
fn scenes_are_drawn_from_their_seed_and_read_without_error() {
    for seed in 0..SCENES {
        let plan = Plan::new(seed);
        assert_eq!(plan.text, Plan::new(seed).text);
        let scene = common::parse(&plan.text);
        assert!(!scene.stages.is_empty(), "seed {seed}");
        assert!((100..=2000).contains(&plan.sample.count), "seed {seed}");
    }
    let every_run: BTreeSet<_> =
        (0..SCENES).step_by(STRIDE as usize).map(|seed| Plan::new(seed).kind).collect();
    assert_eq!(every_run.len(), KINDS.len(), "every run has all kinds");
}

/// Near rest the gaps of rigid contacts are thousands of times the displacements of an increment.
/// The interior point started with multipliers of the order of the displacements, which shortened
/// every step: the run was undecided in increment 106.
#[test]
fn a_hopper_near_rest_is_solved_with_a_small_time_step() {
    let mut scene = common::parse(&Plan::new(30).text);
    scene.friction_law = FrictionLaw::Associated;
    scene.analysis = Analysis::Dynamic { dt: 0.002, theta: 1.0 };
    let mut simulation = Simulation::new(&scene, None);
    for increment in 1..=120 {
        assert_eq!(simulation.step(), Step::Increment, "increment {increment}");
        let solves = simulation.world().resource::<Observation>().solves;
        assert!(solves <= 10, "{solves} solves in increment {increment}");
    }
}

fn judge(reports: &[run::Report], accepted: usize) {
    let wrong: Vec<String> = reports
        .iter()
        .filter(|r| matches!(r.verdict, Verdict::Wrong(_)))
        .map(|r| format!("seed {}: {}", r.seed, r.verdict.reason()))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let failed = reports.iter().filter(|r| r.verdict.is_failure()).count();
    assert!(failed <= accepted, "{failed} scenes failed; accepted are {accepted}");
}

fn threads() -> usize {
    number("LABORATORY_THREADS").unwrap_or(2)
}

fn number(name: &str) -> Option<usize> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name}={text} is not a number")))
}

fn is_wanted(plan: &Plan) -> bool {
    let small = number("LABORATORY_MAX").is_none_or(|most| plan.sample.count as usize <= most);
    let named = std::env::var("LABORATORY")
        .map_or(true, |wanted| wanted.split(',').any(|item| selects(item.trim(), plan)));
    small && named
}

/// Whether an item of `LABORATORY` (a seed, a range of seeds, or a kind) selects the scene.
fn selects(item: &str, plan: &Plan) -> bool {
    if let Some(range) = range(item) {
        return range.contains(&plan.seed);
    }
    match item.parse::<u64>() {
        Ok(seed) => seed == plan.seed,
        Err(_) => plan.kind.name().contains(item),
    }
}

/// A range of seeds such as `10..20`.
fn range(text: &str) -> Option<Range<u64>> {
    let (first, end) = text.split_once("..")?;
    Some(first.parse().ok()?..end.parse().ok()?)
}

fn write(plans: &[Plan], directory: &Path) {
    fs::create_dir_all(directory).unwrap();
    for plan in plans {
        let name = format!("{:03}_{}.ron", plan.seed, plan.kind.name().replace(' ', "_"));
        fs::write(directory.join(name), &plan.text).unwrap();
    }
}
