//! Fuzzing of the solvers: random cone programs, most of them degenerate. None panics or hangs, and
//! nothing counts as solved with a residual above the tolerance, a number that is not finite, or as
//! a collapse without a mechanism that proves it.
//!
//! A case is its number. `CLASTIC_CASES=100000 cargo test --release --test fuzz_solvers` runs more
//! of them. The numbers of cases that once failed are kept in `tests/corpus/programs` and are
//! always replayed.

use std::collections::BTreeSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce;
use clastic::components::attempt::Attempt;
use clastic::components::contact::BodyTable;
use clastic::components::findings::Sliding;
use clastic::components::increment::{Acceptance, ClasticAnalysis, FrictionLaw};
use clastic::cone::certificate::{certificate, proves};
use clastic::cone::condensed::Condensed;
use clastic::cone::program::{
    ConeProgram, ConeSolution, Dof, FreeDof, Interaction, Limits, ProgramBody, Scales, SolveStatus,
};
use clastic::cone::residuals::residuals;
use clastic::reference::Clarabel;
use clastic::systems::solve_program::{Solver, solve_program};
use glam::DVec2;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const CASES: u64 = 1500;
/// Number of programs of which the engine's own solver may leave one undecided.
const MAX_UNDECIDED: u64 = 500;
const LONGEST: Duration = Duration::from_secs(20);
const CORPUS: &str = "tests/corpus/programs/cases.txt";

struct Random(ChaCha8Rng);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n.max(1) as u64) as usize
    }

    fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    /// Uniform in [-1, 1).
    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Ten to a power between two.
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        10_f64.powf(low + 0.5 * (self.unit() + 1.0) * (high - low))
    }

    /// Zero with this probability, else spread over some decades.
    fn or_zero(&mut self, percent: usize, low: f64, high: f64) -> f64 {
        if self.chance(percent) { 0.0 } else { self.decades(low, high) }
    }
}

/// The program of a case. Lengths about 1 cm, forces about 100 N, stiffnesses over five decades or
/// rigid; bodies without contacts, contacts twice, normals in line, no loads, no friction.
fn program(case: u64) -> ConeProgram {
    let mut random = Random(ChaCha8Rng::seed_from_u64(case));
    let r = &mut random;
    let n = 1 + r.below(12);
    let (static_, in_line, at_rest) = (r.chance(60), r.chance(15), r.chance(10));
    let bodies = (0..n)
        .map(|i| {
            let wall = i == 0 || r.chance(15);
            let moved = if r.chance(50) { 0.0 } else { 1e-5 * r.unit() };
            let dof = |r: &mut Random, k: usize| {
                if wall || r.chance(10) {
                    return Dof::Fixed(if k < 2 { moved } else { 0.0 });
                }
                let arm = if k < 2 { 1.0 } else { 0.005 };
                let load = if at_rest || r.chance(30) { 0.0 } else { 100.0 * arm * r.unit() };
                let inertia = if static_ { 0.0 } else { r.or_zero(5, 2.0, 7.0) * arm * arm };
                Dof::Free(FreeDof { load, inertia, ..FreeDof::default() })
            };
            let angle = if r.chance(70) { 0.0 } else { 3.2 * r.unit() };
            ProgramBody { axis: DVec2::from_angle(angle), dofs: [dof(r, 0), dof(r, 1), dof(r, 2)] }
        })
        .collect();
    let mut interactions: Vec<Interaction> = Vec::new();
    for _ in 0..r.below(3 * n + 1) {
        if n < 2 {
            break;
        }
        if r.chance(5)
            && let Some(last) = interactions.last()
        {
            interactions.push(*last);
            continue;
        }
        let a = r.below(n);
        let b = (a + 1 + r.below(n - 1)) % n;
        let bonded = r.chance(40);
        let angle = if in_line { 0.0 } else { 3.2 * r.unit() };
        let strength = |r: &mut Random| if bonded { r.or_zero(20, 0.0, 4.0) } else { 0.0 };
        let rigid = if r.chance(30) { 100 } else { 10 };
        let tangential = r.or_zero(rigid, -8.0, -4.0);
        interactions.push(Interaction {
            normal: DVec2::from_angle(angle),
            arm_a: if r.chance(20) { 0.0 } else { 0.005 },
            arm_b: if r.chance(20) { 0.0 } else { 0.005 },
            offset: if r.chance(50) { 0.0 } else { 1e-5 * r.unit() },
            normal_compliance: r.or_zero(rigid, -8.0, -4.0),
            tangential_compliance: tangential,
            previous_shear: if tangential > 0.0 && r.chance(40) { 10.0 * r.unit() } else { 0.0 },
            limits: Limits::new(
                strength(r),
                if r.chance(30) { 0.0 } else { r.unit().abs() },
                strength(r),
                r.or_zero(60, -4.0, -3.0),
            ),
            ..Interaction::between(a as u32, b as u32)
        });
    }
    ConeProgram {
        bodies,
        interactions,
        scales: Scales { length: 0.005, displacement: 1e-5, force: 100.0 },
        last_forces: Vec::new(),
        cell: None,
    }
}

/// The program of a case with arms of the normal forces, up to ten times as long as those of the
/// shear forces: the bodies are large, and their contacts lie anywhere about their reference
/// points.
fn eccentric(case: u64) -> ConeProgram {
    let mut program = program(case);
    let r = &mut Random(ChaCha8Rng::seed_from_u64(!case));
    for c in &mut program.interactions {
        for arm in [&mut c.normal_arm_a, &mut c.normal_arm_b, &mut c.arm_a, &mut c.arm_b] {
            if r.chance(60) {
                *arm = 0.05 * r.unit();
            }
        }
    }
    program
}

/// The program of a case with springs of rolling at the ends of those of slip, and what they hold
/// from the last increment.
fn sprung(case: u64) -> ConeProgram {
    let mut program = program(case);
    for c in &mut program.interactions {
        c.rolling_compliance = 4e4 * c.tangential_compliance;
        c.previous_moment = 5e-3 * c.previous_shear;
    }
    program
}

/// Solves as the engine does, by its own system.
fn solve(program: &ConeProgram, solver: Solver) -> ConeSolution {
    let mut world = World::new();
    world.insert_resource(program.clone());
    world.insert_resource(Acceptance::default());
    world.insert_resource(solver);
    world.init_resource::<FrictionLaw>();
    world.init_resource::<Sliding>();
    world.init_resource::<ClasticAnalysis>();
    world.init_resource::<BodyTable>();
    world.init_resource::<Attempt>();
    world.init_resource::<ConeSolution>();
    world.run_system_once(solve_program).unwrap();
    world.resource::<ConeSolution>().clone()
}

/// How both solvers end on a program, checked against what they returned.
fn try_program(program: &ConeProgram) -> [ConeSolution; 2] {
    let reference = Solver(Box::new(Clarabel::default()));
    let solvers = [("Condensed", Solver::default()), ("Clarabel", reference)];
    solvers.map(|(name, solver)| {
        let begun = Instant::now();
        let solution = solve(program, solver);
        assert!(begun.elapsed() <= LONGEST, "{name} took {:?}", begun.elapsed());
        match solution.status {
            SolveStatus::Solved => {
                assert_eq!(solution.forces.len(), program.interactions.len(), "{name}");
                assert_eq!(solution.displacements.len(), program.bodies.len(), "{name}");
                let r = residuals(program, &solution);
                assert!(r.worst() <= 1e-8, "{name}: {r:?}");
                let numbers = solution.forces.iter().chain(&solution.displacements).flatten();
                assert!(numbers.copied().all(f64::is_finite), "{name}");
            }
            SolveStatus::Collapsed => {
                let proof = solution.certificate.as_ref().map(|c| &c.mechanism);
                let proof = proof.and_then(|mechanism| certificate(program, mechanism));
                assert!(proof.as_ref().is_some_and(proves), "{name}: {proof:?}");
            }
            SolveStatus::Locked | SolveStatus::Stalled => {}
        }
        solution
    })
}

/// The residuals or the certificate behind a status.
fn grounds(solution: &ConeSolution) -> String {
    let proof = solution.certificate.as_ref().map(|c| (c.margin, c.defect));
    let ConeSolution { status, residuals, message, forces, .. } = solution;
    let force = forces.iter().flatten().fold(0.0_f64, |most, f| most.max(f.abs()));
    format!(
        "{status:?}, residual {:e}, maximum force {force:e}, margin and defect {proof:?}, {message}",
        residuals.worst()
    )
}

/// Whether a proof of one solver excludes the solution of the other. A mechanism in which contacts
/// close by its defect excludes forces whose work on that closing is below its margin; forces that
/// lock bodies exclude a solution on which their imbalance, their part beyond the limits and their
/// part on elastic interactions do less work than the forces do on the overlaps.
fn excludes(program: &ConeProgram, proof: &ConeSolution, solution: &ConeSolution) -> bool {
    match &proof.certificate {
        Some(found) => {
            let u = &found.mechanism;
            let loads = program.bodies.iter().zip(u).flat_map(|(body, u)| body.dofs.iter().zip(u));
            let work: f64 = loads
                .map(|(dof, u)| if let Dof::Free(free) = dof { free.load * u } else { 0.0 })
                .sum();
            let forces: f64 = solution.forces.iter().map(|s| s[0].max(0.0)).sum();
            found.margin * work > found.defect * forces
        }
        None => {
            let known = program.imposed();
            let work: f64 = program
                .interactions
                .iter()
                .zip(&proof.forces)
                .map(|(c, s)| {
                    let e = program.kinematics(c, &known);
                    (e[0] - c.offset) * s[0] + e[1] * s[1] + e[2] * s[2]
                })
                .sum();
            let mut imbalance = vec![[0.0; 3]; program.bodies.len()];
            program.add_forces(&proof.forces, &mut imbalance);
            let mut lost = 0.0;
            let of_solution = solution.forces.iter().zip(&proof.forces);
            for (c, (s, f)) in program.interactions.iter().zip(of_solution) {
                let e = program.kinematics(c, &solution.displacements);
                lost += c.normal_compliance * (f[0] * s[0]).abs()
                    + c.tangential_compliance * (f[1] * (s[1] - c.previous_shear)).abs()
                    + c.rolling_compliance * (f[2] * (s[2] - c.previous_moment)).abs()
                    + (f[1].abs() - c.limits.friction * f[0]).max(0.0) * e[1].abs()
                    + (f[2].abs() - c.limits.rolling * f[0]).max(0.0) * e[2].abs()
                    + (-f[0]).max(0.0) * (e[0] - c.offset).abs();
            }
            for ((body, row), u) in
                program.bodies.iter().zip(&imbalance).zip(&solution.displacements)
            {
                for k in 0..3 {
                    if let Dof::Free(_) = body.dofs[k] {
                        lost += (row[k] * u[k]).abs();
                    }
                }
            }
            work > lost
        }
    }
}

#[test]
fn random_programs_end_in_a_status_that_is_true() {
    statuses_are_true(program);
}

#[test]
fn random_programs_with_arms_of_normal_forces_end_in_a_status_that_is_true() {
    let with_arms = (0..CASES)
        .map(eccentric)
        .filter(|p| p.interactions.iter().any(|c| c.normal_arm_a != 0.0 && c.normal_arm_b != 0.0));
    assert!(2 * with_arms.count() as u64 > CASES);
    statuses_are_true(eccentric);
}

#[test]
fn random_programs_with_elastic_rolling_end_in_a_status_that_is_true() {
    let rolls = |p: &ConeProgram| {
        p.interactions.iter().any(|c| c.rolling_compliance > 0.0 && c.limits.has_rolling())
    };
    assert!(5 * (0..CASES).map(sprung).filter(rolls).count() as u64 > CASES);
    statuses_are_true(sprung);
}

/// Tries all cases of a kind. The engine's own solver decides all but one in [`MAX_UNDECIDED`].
fn statuses_are_true(program: fn(u64) -> ConeProgram) {
    let kept = fs::read_to_string(CORPUS).unwrap();
    let kept = kept.lines().filter_map(|line| line.split('#').next()?.trim().parse::<u64>().ok());
    let kept: BTreeSet<u64> = kept.collect();
    assert!(!kept.is_empty(), "the corpus is gone");
    let cases = std::env::var("CLASTIC_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(CASES);
    let (mut counts, mut contradictions, mut stalled) = ([[0_u64; 4]; 2], Vec::new(), Vec::new());
    let mut failed = Vec::new();
    let first = (0..cases).filter(|case| !kept.contains(case));
    for case in kept.iter().copied().chain(first) {
        let program = program(case);
        let Ok(solutions) = catch_unwind(AssertUnwindSafe(|| try_program(&program))) else {
            failed.push(case);
            continue;
        };
        let statuses = [solutions[0].status, solutions[1].status];
        for (status, count) in statuses.iter().zip(&mut counts) {
            count[*status as usize] += 1;
        }
        match statuses {
            [SolveStatus::Stalled, _] => {
                if std::env::var_os("CLASTIC_VERBOSE").is_some() {
                    let [a, b] = [grounds(&solutions[0]), grounds(&solutions[1])];
                    println!("{case}: {a}; Clarabel: {b}");
                }
                stalled.push(case);
            }
            [_, SolveStatus::Stalled] => {}
            // A program that locks in one part and collapses in another is both.
            [SolveStatus::Locked, SolveStatus::Collapsed]
            | [SolveStatus::Collapsed, SolveStatus::Locked] => {}
            [SolveStatus::Solved, _] | [_, SolveStatus::Solved] if statuses[0] != statuses[1] => {
                let [a, b] = &solutions;
                let (proof, solution) =
                    if statuses[0] == SolveStatus::Solved { (b, a) } else { (a, b) };
                if excludes(&program, proof, solution) {
                    contradictions.push(format!(
                        "{case}: {}; Clarabel: {}",
                        grounds(a),
                        grounds(b)
                    ));
                }
            }
            _ => {}
        }
    }
    println!("solved, collapsed, locked, stalled: own {:?}, Clarabel {:?}", counts[0], counts[1]);
    println!("stalled: {stalled:?}");
    assert!(failed.is_empty(), "add to {CORPUS}: {failed:?}");
    assert!(contradictions.is_empty(), "{}", contradictions.join("\n"));
    let tried = cases + kept.len() as u64;
    // The programs must be of all kinds.
    assert!(counts[0][..3].iter().all(|count| 50 * count > cases), "{counts:?}");
    assert!(MAX_UNDECIDED * stalled.len() as u64 <= tried, "{} of {tried} stalled", stalled.len());
}

#[test]
fn a_malformed_program_is_no_solution() {
    let sound = (0..).map(program).find(|program| program.interactions.len() > 3).unwrap();
    type Harm = fn(&mut ConeProgram);
    let harms: [(&str, Harm); 6] = [
        ("a body that is not there", |p| p.interactions[1].b = 99),
        ("a body with itself", |p| p.interactions[1].b = p.interactions[1].a),
        ("not a number", |p| p.interactions[2].offset = f64::NAN),
        ("infinite", |p| p.interactions[2].limits.cohesion = f64::INFINITY),
        ("negative compliance", |p| p.interactions[0].normal_compliance = -1e-6),
        ("negative limit", |p| p.interactions[0].limits.tension = -1.0),
    ];
    for (what, harm) in harms {
        let mut program = sound.clone();
        harm(&mut program);
        for solver in
            [Solver(Box::new(Condensed::default())), Solver(Box::new(Clarabel::default()))]
        {
            let solution = solve(&program, solver);
            assert_eq!(solution.status, SolveStatus::Stalled, "{what}");
            assert!(solution.message.contains("malformed"), "{what}: {}", solution.message);
        }
    }
}
