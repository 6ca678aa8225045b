//! Random programs of every kind: the two solvers agree on them, and no solution proves a collapse.

use clastic::cone::certificate::{certificate, locks, proves};
use clastic::cone::condensed::{Condensed, CondensedSettings};
use clastic::cone::program::{ConeProgram, ConeSolution, Dof, SolveStatus};
use clastic::cone::residuals::{displacement_scale, force_scale, regularised_residuals, residuals};
use clastic::cone::solver::ConeSolver;
use clastic::reference::Clarabel;
use clastic::run::Simulation;

use crate::common::programs::{KINDS, Kind, RESIDUAL, SPRUNG_WHEELS, WHEELS, programs, solve};
use crate::common::{load, step};

/// Seeds of every kind.
const SEEDS: u32 = 8;

/// All programs of some kinds, with their origin.
fn random_programs(kinds: &[Kind]) -> Vec<(String, ConeProgram)> {
    let mut all = Vec::new();
    for kind in kinds {
        for seed in 1..=SEEDS {
            for (k, program) in programs(kind, seed).into_iter().enumerate() {
                all.push((format!("{}, seed {seed}, increment {}", kind.name, k + 1), program));
            }
        }
    }
    all
}

/// Value of what is minimised, and the sum of the magnitudes of its terms.
fn objective(program: &ConeProgram, solution: &ConeSolution) -> (f64, f64) {
    let (mut value, mut magnitude) = (0.0, 0.0_f64);
    let mut add = |term: f64| {
        value += term;
        magnitude += term.abs();
    };
    let mut imposed = vec![[0.0; 3]; program.bodies.len()];
    for (i, body) in program.bodies.iter().enumerate() {
        for k in 0..3 {
            match body.dofs[k] {
                Dof::Fixed(u) => imposed[i][k] = u,
                Dof::Free(f) => {
                    add(0.5 * (f.inertia + f.proximal) * solution.displacements[i][k].powi(2));
                }
            }
        }
    }
    for (c, [p, q, tau]) in program.interactions.iter().zip(&solution.forces) {
        let e = program.kinematics(c, &imposed);
        add(c.offset * p + 0.5 * c.normal_compliance * p * p);
        add(0.5 * c.tangential_compliance * (q - c.previous_shear).powi(2));
        add(0.5 * c.rolling_compliance * (tau - c.previous_moment).powi(2));
        add(-e[0] * p);
        add(-e[1] * q);
        add(-e[2] * tau);
    }
    let (force, u) = (
        force_scale(program, &solution.forces),
        displacement_scale(program, &solution.displacements),
    );
    (value, magnitude + force * u)
}

/// How the programs ended, and with whose help.
struct Agreement {
    /// By status, where both solvers ended in the same.
    ended: [usize; 4],
    /// Solved without the help of Clarabel.
    own: usize,
    /// Solved where Clarabel stalled.
    alone: usize,
}

/// Accepted difference of what is unique, over the scale of it.
const UNIQUE: f64 = 1e-6;

/// Compares the unique parts of two solutions: the objective to 1e-7, forces of elastic contacts
/// and motions of bodies with inertia to `bound`.
fn differences(
    program: &ConeProgram,
    a: &ConeSolution,
    b: &ConeSolution,
    bound: f64,
) -> Vec<String> {
    let mut found = Vec::new();
    let ((value, one), (other, two)) = (objective(program, a), objective(program, b));
    let magnitude = one.max(two);
    if !((value - other).abs() <= 1e-7 * magnitude) {
        found.push(format!("objective {value:e} and {other:e} of {magnitude:e}"));
    }
    let force = force_scale(program, &a.forces);
    for (k, c) in program.interactions.iter().enumerate() {
        for (f, compliance) in [(0, c.normal_compliance), (1, c.tangential_compliance)] {
            let difference = (a.forces[k][f] - b.forces[k][f]).abs();
            if compliance > 0.0 && !(difference <= bound * force) {
                found.push(format!("force {f} of {k}: {difference:e} of {force:e}"));
            }
        }
        let (difference, unit) =
            ((a.forces[k][2] - b.forces[k][2]).abs(), force * program.scales.length);
        if c.rolling_compliance > 0.0 && !(difference <= bound * unit) {
            found.push(format!("moment of {k}: {difference:e} of {unit:e}"));
        }
    }
    let far = displacement_scale(program, &a.displacements);
    for (i, body) in program.bodies.iter().enumerate() {
        for k in 0..2 {
            let difference = (a.displacements[i][k] - b.displacements[i][k]).abs();
            let unique = matches!(body.dofs[k], Dof::Free(f) if f.inertia > 0.0);
            if unique && !(difference <= bound * far) {
                found.push(format!("motion {k} of {i}: {difference:e} of {far:e}"));
            }
        }
    }
    found
}

/// Solution of Clarabel as a correction of the displacements `base`. Where bodies on stiff springs
/// move far, the forces of an ordinary solution have no correct digits. The correction is small, in
/// units of the deformation of the springs. For springs only: their present deformation goes into
/// offsets and previous shear.
fn solve_from(program: &ConeProgram, base: &[[f64; 3]]) -> Option<ConeSolution> {
    let mut about = program.clone();
    for c in &mut about.interactions {
        let [closing, slip, turn] = program.kinematics(c, base);
        c.offset -= closing;
        if c.tangential_compliance > 0.0 {
            c.previous_shear += slip / c.tangential_compliance;
        } else if c.limits.has_shear() {
            return None;
        }
        if c.rolling_compliance > 0.0 {
            c.previous_moment += turn / c.rolling_compliance;
        } else if c.limits.has_rolling() {
            return None;
        }
    }
    for (body, base) in about.bodies.iter_mut().zip(base) {
        for (dof, u) in body.dofs.iter_mut().zip(base) {
            match dof {
                Dof::Fixed(known) => *known -= u,
                Dof::Free(free) => {
                    free.load -= free.inertia * u;
                    free.reference -= u;
                }
            }
        }
    }
    let softest = program.interactions.iter().map(|c| c.normal_compliance).fold(0.0, f64::max);
    about.scales.displacement = softest * about.scales.force;
    let mut solution = Clarabel::default().solve(&about, 0.0).unwrap();
    for (u, base) in solution.displacements.iter_mut().zip(base) {
        for k in 0..3 {
            u[k] += base[k];
        }
    }
    Some(solution)
}

/// Whether the mechanism of a solution proves the collapse.
fn is_proved(program: &ConeProgram, solution: &ConeSolution) -> bool {
    let claimed = solution.certificate.as_ref();
    claimed.and_then(|c| certificate(program, &c.mechanism)).is_some_and(|c| proves(&c))
}

/// Whether our solver found it by a method for programs at large.
fn is_own(solution: &ConeSolution) -> bool {
    ["newton", "interior"].iter().any(|method| solution.message.starts_with(method))
}

/// Compares the two solvers; panics where they contradict each other, or where ours stalls.
fn compare(programs: &[(String, ConeProgram)]) -> Agreement {
    let (mut ended, mut own, mut alone, mut doubtful) = ([0; 4], 0, 0, 0);
    let mut failures = Vec::new();
    for (name, program) in programs {
        let a = solve(&mut Condensed::default(), program);
        let b = solve(&mut Clarabel::default(), program);
        match (a.status, b.status) {
            // The residuals of one solution show that the other is wrong. Clarabel may find it from
            // there.
            (SolveStatus::Solved, SolveStatus::Stalled) => {
                let b = solve_from(program, &a.displacements);
                let agrees = |b: ConeSolution| {
                    b.status == SolveStatus::Solved
                        && differences(program, &a, &b, UNIQUE).is_empty()
                };
                if b.is_some_and(agrees) {
                    ended[a.status as usize] += 1;
                    own += usize::from(is_own(&a));
                } else {
                    alone += 1;
                }
                continue;
            }
            // So does the certificate of a collapse.
            (SolveStatus::Collapsed, SolveStatus::Stalled) if is_proved(program, &a) => {
                alone += 1;
                continue;
            }
            // And the forces of a lock.
            (SolveStatus::Locked, SolveStatus::Stalled) if locks(program, &a.forces) => continue,
            (SolveStatus::Stalled, other) => {
                failures.push(format!("{name}: stalled ({}; Clarabel: {other:?})", a.message));
            }
            (a, b) if a != b => failures.push(format!("{name}: {a:?} and {b:?}")),
            _ => ended[a.status as usize] += 1,
        }
        if (a.status, b.status) != (SolveStatus::Solved, SolveStatus::Solved) {
            continue;
        }
        own += usize::from(is_own(&a));
        if differences(program, &a, &b, UNIQUE).is_empty() {
            continue;
        }
        // Both solve again with a smaller tolerance, Clarabel where all interactions are springs. The
        // first solution must agree with the new ones as before. That of the second need not: in
        // contacts that just touch without force its error is the square root of its product of gap
        // and force.
        doubtful += 1;
        let exact = solve(&mut Condensed::new(CondensedSettings::with_tolerance(1e-12)), program);
        let b = solve_from(program, &b.displacements)
            .and_then(|b| solve_from(program, &b.displacements))
            .unwrap_or(b);
        let left = |s: &ConeSolution| regularised_residuals(program, s).worst();
        let bound = UNIQUE.max(2.0 * left(&b).sqrt());
        let mut found = differences(program, &a, &exact, UNIQUE);
        found.extend(differences(program, &exact, &b, bound));
        if left(&exact) > 1e-12 || left(&b) > 1e-9 || !found.is_empty() {
            failures.push(format!(
                "{name}: {} ({:e} by {}; {:e} by {})",
                found.join(", "),
                left(&exact),
                exact.message,
                left(&b),
                b.message
            ));
        }
    }
    assert!(500 * doubtful <= programs.len(), "{doubtful} of {} differ", programs.len());
    assert!(failures.is_empty(), "{} programs\n{}", programs.len(), failures.join("\n"));
    println!(
        "{} programs: solved, collapsed, locked, stalled {ended:?}, Clarabel stalled on {alone}, {doubtful} \
         asked again",
        programs.len()
    );
    Agreement { ended, own, alone }
}

#[test]
fn condensed_and_clarabel_agree() {
    let programs = random_programs(KINDS);
    assert!(programs.len() >= 1000, "{} programs", programs.len());
    let Agreement { ended, own, alone } = compare(&programs);
    let [solved, collapsed, locked, _] = ended;
    assert!(collapsed >= 3 && locked >= 3, "{ended:?}");
    assert!(20 * alone <= programs.len(), "Clarabel stalled on {alone} of {}", programs.len());
    assert!(20 * own >= 19 * solved, "{own} of {solved}");
}

/// Programs of 400 disks of which more and more are loose: the Newton steps leave out fast bodies,
/// which small programs do not do.
#[test]
fn condensed_and_clarabel_agree_while_a_specimen_breaks() {
    let mut simulation = Simulation::new(&load("uniaxial_small"), None);
    let mut programs = Vec::new();
    while let Some(record) = step(&mut simulation) {
        if !record.ruptures.is_empty() {
            let program = simulation.world().resource::<ConeProgram>().clone();
            programs.push((format!("increment {}", record.increment), program));
        }
    }
    let agreement = compare(&programs);
    assert!(programs.len() >= 10, "{} increments with ruptures", programs.len());
    assert_eq!(agreement.ended[0] + agreement.alone, programs.len());
    assert_eq!(agreement.own + agreement.alone, programs.len(), "Clarabel had to help");
}

#[test]
fn what_rolls_without_friction_is_solved_whether_clarabel_can_or_not() {
    for kind in [WHEELS, SPRUNG_WHEELS] {
        let programs = random_programs(&[kind]);
        let Agreement { ended, own, alone } = compare(&programs);
        let both = ended[SolveStatus::Solved as usize];
        assert!(
            50 * (both + alone) >= 49 * programs.len(),
            "{both}, {alone} of {}",
            programs.len()
        );
        assert!(20 * own >= 19 * both && 3 * alone <= programs.len(), "{own} of {both}, {alone}");
    }
}

/// A rolling stiffness above all others leaves the forces of the rigid rolling law.
#[test]
fn a_large_rolling_stiffness_is_the_rigid_law() {
    let mut compared = 0;
    for seed in 1..=SEEDS {
        let kind = KINDS.iter().find(|kind| kind.name == "elastic rolling").unwrap();
        for program in programs(kind, seed) {
            let with = |compliance: f64| {
                let mut program = program.clone();
                for c in &mut program.interactions {
                    c.rolling_compliance *= compliance;
                }
                let solver = &mut Condensed::new(CondensedSettings::with_tolerance(1e-12))
                    as &mut dyn ConeSolver;
                (solve(solver, &program), program)
            };
            // The moments that a rigid law has from the last increment count for nothing.
            let ((stiff, _), (rigid, of_rigid)) = (with(1e-9), with(0.0));
            let both = [stiff.status, rigid.status] == [SolveStatus::Solved; 2];
            if !both || rigid.forces.iter().all(|f| f[2] == 0.0) {
                continue;
            }
            let force = force_scale(&of_rigid, &rigid.forces);
            for ((a, b), c) in stiff.forces.iter().zip(&rigid.forces).zip(&of_rigid.interactions) {
                assert!((a[0] - b[0]).abs() <= 1e-6 * force, "{a:?} {b:?}");
                if c.tangential_compliance > 0.0 {
                    assert!((a[1] - b[1]).abs() <= 1e-6 * force, "{a:?} {b:?}");
                }
            }
            compared += 1;
        }
    }
    assert!(compared >= 20, "{compared}");
}

#[test]
fn a_contact_that_rolls_without_friction_carries_no_shear_whatever_was_left_over() {
    let (mut program, mut compared) = (None, 0);
    for increment in programs(&WHEELS, 1) {
        let loaded = solve(&mut Condensed::default(), &increment);
        if loaded.forces.iter().any(|f| f[2] != 0.0) {
            program = Some(increment);
        }
    }
    let mut program = program.expect("a rolling moment");
    let expected = solve(&mut Condensed::default(), &program);
    for c in &mut program.interactions {
        (c.tangential_compliance, c.previous_shear) = (1e-7, 50.0);
    }
    let solution = solve(&mut Condensed::default(), &program);
    assert_eq!(solution.status, SolveStatus::Solved);
    let force = force_scale(&program, &solution.forces);
    for (a, b) in solution.forces.iter().zip(&expected.forces) {
        assert_eq!(a[1], 0.0);
        assert!((a[0] - b[0]).abs() <= 1e-6 * force, "{} {}", a[0], b[0]);
        compared += 1;
    }
    assert!(compared > 10);
}

#[test]
fn nothing_that_is_solved_proves_a_collapse() {
    for (name, program) in [random_programs(KINDS), random_programs(&[WHEELS])].concat() {
        let solution = solve(&mut Condensed::default(), &program);
        // Bodies that only the regularisation holds may collapse.
        let r = residuals(&program, &solution).worst();
        if solution.status == SolveStatus::Solved && r <= RESIDUAL {
            let false_proof = certificate(&program, &solution.displacements).filter(proves);
            assert_eq!(false_proof, None, "{name}");
        }
    }
}

#[test]
fn polish_makes_a_coarse_solution_exact() {
    let (mut polished, mut solved) = (0, 0);
    for (_, program) in random_programs(KINDS) {
        let fine = solve(&mut Clarabel::default(), &program);
        if fine.status != SolveStatus::Solved || fine.forces.is_empty() {
            continue;
        }
        let coarse = solve(&mut Clarabel { tolerance: 1e-5, ..Default::default() }, &program);
        solved += 1;
        polished += usize::from(
            coarse.status == SolveStatus::Solved
                && coarse.message.contains("polished")
                && coarse.iterations <= fine.iterations,
        );
    }
    assert!(10 * polished >= 9 * solved, "{polished} of {solved}");
}
