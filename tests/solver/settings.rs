//! The settings of the solvers influence the path to a solution and not the solution.
//!
//! `cargo test --release --test solver settings -- --ignored --nocapture` prints the table of
//! `docs/decisions/001-solver-settings.md`.

use std::fmt::Debug;
use std::sync::{Arc, Mutex};

use clastic::cone::certificate::proves;
use clastic::cone::condensed::{Condensed, CondensedSettings};
use clastic::cone::coulomb::{Coulomb, CoulombSettings, Goal};
use clastic::cone::program::{ConeProgram, ConeSolution, Dof, SolveStatus};
use clastic::cone::residuals::{displacement_scale, force_scale, regularised_residuals};
use clastic::cone::solver::{ConeSolver, MalformedProgram};
use clastic::run::{Simulation, Step};
use clastic::scene;
use clastic::systems::solve_program::Solver;

use crate::common::programs::{KINDS, programs};
use crate::common::settings::{Field, of_condensed, of_coulomb};

/// Maximum residual of an increment where a program does not state another tolerance.
const RESIDUAL: f64 = 1e-8;

/// A program with the tolerance that it is solved with and the memory of the solver before it.
#[derive(Clone)]
struct Posed {
    program: ConeProgram,
    tolerance: f64,
    memory: Vec<[f64; 3]>,
}

/// A solver that stores every n-th program.
struct Recorder {
    inner: Condensed,
    wanted: fn(&ConeProgram) -> bool,
    skip: usize,
    every: usize,
    seen: usize,
    kept: Arc<Mutex<Vec<Posed>>>,
}

impl ConeSolver for Recorder {
    fn solve(
        &mut self,
        program: &ConeProgram,
        tolerance: f64,
    ) -> Result<ConeSolution, MalformedProgram> {
        if (self.wanted)(program) {
            if self.seen >= self.skip && (self.seen - self.skip).is_multiple_of(self.every) {
                let memory = self.inner.memory().to_vec();
                self.kept.lock().unwrap().push(Posed {
                    program: program.clone(),
                    tolerance,
                    memory,
                });
            }
            self.seen += 1;
        }
        self.inner.solve(program, tolerance)
    }
}

/// Programs of a scene of `scenes/`: of those `wanted`, after `skip`, one of `every`, up to
/// `count`.
fn recorded(
    name: &str,
    sets: &[&str],
    wanted: fn(&ConeProgram) -> bool,
    [skip, every, count]: [usize; 3],
) -> Vec<Posed> {
    let path = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let loaded = scene::load(path.as_ref(), &sets).unwrap();
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let kept = Arc::default();
    let recorder = Recorder {
        inner: Condensed::default(),
        wanted,
        skip,
        every,
        seen: 0,
        kept: Arc::clone(&kept),
    };
    simulation.world_mut().insert_resource(Solver(Box::new(recorder)));
    while kept.lock().unwrap().len() < count && simulation.step() == Step::Increment {}
    drop(simulation);
    let mut kept = Arc::into_inner(kept).unwrap().into_inner().unwrap();
    kept.truncate(count);
    kept
}

/// Programs of small random specimens of all kinds, posed one after the other.
fn random(seeds: std::ops::Range<u32>) -> Vec<Posed> {
    let mut posed = Vec::new();
    for kind in KINDS {
        for seed in seeds.clone() {
            let mut solver = Condensed::default();
            for program in programs(kind, seed) {
                let memory = solver.memory().to_vec();
                let _ = solver.solve(&program, 0.0).unwrap();
                posed.push(Posed { program, tolerance: 0.0, memory });
            }
        }
    }
    posed
}

/// Whether a solution is one, or proves that there is none.
fn holds(Posed { program, tolerance, .. }: &Posed, solution: &ConeSolution) -> bool {
    match solution.status {
        SolveStatus::Solved => {
            regularised_residuals(program, solution).worst() <= RESIDUAL.max(*tolerance)
        }
        SolveStatus::Collapsed => solution.certificate.as_ref().is_some_and(proves),
        SolveStatus::Locked => true,
        SolveStatus::Stalled => false,
    }
}

/// The maximum difference of the unique parts of two solutions: forces of elastic contacts over the
/// maximum force, motions of bodies with inertia over the maximum displacement.
fn difference(program: &ConeProgram, a: &ConeSolution, b: &ConeSolution) -> f64 {
    let force = force_scale(program, &a.forces);
    let mut maximum = 0.0_f64;
    for (k, c) in program.interactions.iter().enumerate() {
        for (f, compliance) in [(0, c.normal_compliance), (1, c.tangential_compliance)] {
            if compliance > 0.0 {
                maximum = maximum.max((a.forces[k][f] - b.forces[k][f]).abs() / force);
            }
        }
    }
    let far = displacement_scale(program, &a.displacements);
    for (i, body) in program.bodies.iter().enumerate() {
        for k in 0..2 {
            if matches!(body.dofs[k], Dof::Free(f) if f.inertia > 0.0) {
                let apart = (a.displacements[i][k] - b.displacements[i][k]).abs();
                maximum = maximum.max(apart / far);
            }
        }
    }
    maximum
}

/// Outcome of a set of programs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Outcome {
    /// Programs without a solution and without a proof that there is none.
    failures: u32,
    /// Iterations in all.
    iterations: u32,
    /// Solutions that are not the same bytes as with the defaults.
    changed: u32,
    /// The maximum [`difference`] from the defaults, of programs that are solved with both.
    difference: f64,
}

/// Compares solutions with those of the defaults.
fn outcome(set: &[Posed], solutions: &[ConeSolution], defaults: &[ConeSolution]) -> Outcome {
    let mut out = Outcome::default();
    for (posed, (solution, default)) in set.iter().zip(solutions.iter().zip(defaults)) {
        out.failures += u32::from(!holds(posed, solution));
        out.iterations += solution.iterations;
        out.changed += u32::from(
            solution.forces != default.forces || solution.displacements != default.displacements,
        );
        let solved = |s: &ConeSolution| s.status == SolveStatus::Solved && holds(posed, s);
        if solved(solution) && solved(default) {
            out.difference = out.difference.max(difference(&posed.program, default, solution));
        }
    }
    out
}

/// Solves all programs, each from its memory.
fn solve_all(set: &[Posed], settings: CondensedSettings) -> Vec<ConeSolution> {
    let mut solver = Condensed::new(settings);
    let solve = |posed: &Posed| {
        solver.remember(&posed.memory);
        solver.solve(&posed.program, posed.tolerance).unwrap()
    };
    set.iter().map(solve).collect()
}

/// Solves all programs under Coulomb's law, each from its associated solution.
fn slide_all(
    set: &[Posed],
    starts: &[ConeSolution],
    settings: CoulombSettings,
) -> Vec<ConeSolution> {
    let mut solver = Coulomb::new(settings);
    let goal = Goal { tolerance: 0.9 * RESIDUAL, at_once: false };
    let pairs = set.iter().zip(starts);
    pairs.map(|(p, start)| solver.solve(&p.program, start, goal, 600)).collect()
}

/// The programs that are solved under the associated law, with these solutions.
fn solved(set: &[Posed]) -> (Vec<Posed>, Vec<ConeSolution>) {
    let solutions = solve_all(set, CondensedSettings::default());
    let pairs = set.iter().cloned().zip(solutions);
    pairs.filter(|(posed, s)| s.status == SolveStatus::Solved && holds(posed, s)).unzip()
}

/// Number of fields of settings, by what `Debug` writes of them: `name: number`.
fn leaves(settings: &impl Debug) -> usize {
    let text = format!("{settings:?}");
    let values = text.split(": ").skip(1);
    values.filter(|value| value.starts_with(|c: char| c.is_ascii_digit() || c == '[')).count()
}

/// The lists of fields are complete, and every field of a list is changed by its scaling alone.
#[test]
fn every_field_is_listed() {
    fn check<S: Copy + Debug + Default + PartialEq>(fields: &[Field<S>]) {
        let defaults = S::default();
        assert_eq!(fields.len(), leaves(&defaults));
        let mut seen = Vec::new();
        for (name, scale) in fields {
            let mut settings = defaults;
            scale(&mut settings, 2.0);
            assert_ne!(settings, defaults, "{name}");
            let text = format!("{settings:?}");
            assert!(!seen.contains(&text), "{name} is listed twice");
            seen.push(text);
        }
    }
    check(&of_condensed());
    check(&of_coulomb());
}

/// With half and with double of any field, solutions that count as solved are solutions, and their
/// unique parts agree with those of the defaults to a multiple of the tolerance.
#[test]
fn settings_steer_the_way_and_not_the_solution() {
    let set = random(1..2);
    let defaults = solve_all(&set, CondensedSettings::default());
    assert_eq!(outcome(&set, &defaults, &defaults).failures, 0);
    for (name, scale) in of_condensed() {
        for factor in [0.5, 2.0] {
            let mut settings = CondensedSettings::default();
            scale(&mut settings, factor);
            let solutions = solve_all(&set, settings);
            for (k, (posed, solution)) in set.iter().zip(&solutions).enumerate() {
                let is_stalled = solution.status == SolveStatus::Stalled;
                // A caller may ask for a tolerance above that of the increment, and then judges the
                // residual itself.
                let is_loose = name == "tolerance" && factor > 1.0;
                let case = format!("{name} times {factor}, program {k}");
                assert!(is_stalled || is_loose || holds(posed, solution), "{case}");
            }
        }
    }
}

/// Prints the outcome with half and with double of every field.
fn print_table<S: Copy + Default>(
    set: &[Posed],
    fields: &[Field<S>],
    solve: impl Fn(S) -> Vec<ConeSolution>,
) {
    let defaults = solve(S::default());
    let base = outcome(set, &defaults, &defaults);
    println!("{} programs, {base:?}", set.len());
    for (name, scale) in fields {
        for (factor, word) in [(0.5, "half"), (2.0, "double")] {
            let mut settings = S::default();
            scale(&mut settings, factor);
            let out = outcome(set, &solve(settings), &defaults);
            println!(
                "| `{name}` | {word} | {:+} | {:+} | {} | {:.0e} |",
                i64::from(out.failures) - i64::from(base.failures),
                i64::from(out.iterations) - i64::from(base.iterations),
                out.changed,
                out.difference
            );
        }
    }
}

#[test]
#[ignore = "takes a quarter of an hour, and prints a table"]
fn half_and_double_of_condensed() {
    let elastic = |program: &ConeProgram| {
        program.interactions.len() > 15_000
            && program.interactions.iter().any(|c| c.limits.has_strength())
    };
    let moving = |program: &ConeProgram| program.is_dynamic() && !program.last_forces.is_empty();
    let any = |_: &ConeProgram| true;
    let law = "friction_law=Associated";
    let [tight, loose] = ["acceptance.residual=1e-8", "acceptance.residual=1e-3"].map(|r| [law, r]);
    let mut set = random(1..3);
    println!("random: {} programs", set.len());
    let scenes: [(&str, &[&str], fn(&ConeProgram) -> bool, [usize; 3]); 8] = [
        ("biaxial_small", &[], any, [20, 15, 20]),
        ("uniaxial_small", &[], any, [20, 9, 20]),
        ("uniaxial_rigid_small", &[], any, [1, 1, 10]),
        ("column_collapse_small", &tight, moving, [60, 25, 12]),
        ("column_collapse_small", &loose, moving, [60, 25, 12]),
        ("column_collapse", &tight, moving, [60, 20, 3]),
        ("column_collapse", &loose, moving, [60, 20, 3]),
        ("uniaxial", &[], elastic, [20, 25, 5]),
    ];
    for (name, sets, wanted, places) in scenes {
        let programs = recorded(name, sets, wanted, places);
        println!("{name} {}: {} programs", sets.join(" "), programs.len());
        set.extend(programs);
    }
    print_table(&set, &of_condensed(), |settings| solve_all(&set, settings));
}

#[test]
#[ignore = "takes minutes, and prints a table"]
fn half_and_double_of_coulomb() {
    let moving = |program: &ConeProgram| program.is_dynamic() && !program.last_forces.is_empty();
    let mut set = random(1..2);
    set.extend(recorded(
        "column_collapse_small",
        &["friction_law=Associated", "acceptance.residual=1e-8"],
        moving,
        [60, 50, 4],
    ));
    let (set, starts) = solved(&set);
    print_table(&set, &of_coulomb(), |settings| slide_all(&set, &starts, settings));
}
