//! The cone program and its solvers: sizes of programs, residuals and certificates.

use clastic::cone::certificate::{certificate, proves};
use clastic::cone::condensed::Condensed;
use clastic::cone::condensed::interior::{self, Goal, Interior, Judge};
use clastic::cone::condensed::matrix::BodyMatrix;
use clastic::cone::condensed::scaled::Scaled;
use clastic::cone::condensed::settings::InteriorSettings;
use clastic::cone::program::{
    ConeProgram, ConeSolution, Dof, FreeDof, Interaction, Limits, ProgramBody, Scales, SolveStatus,
};
use clastic::cone::residuals::{displacement_scale, force_scale, residuals};
use clastic::cone::solver::ConeSolver;
use clastic::reference::{self, Clarabel, ProgramSize};
use clastic::run::{Simulation, Step};
use glam::DVec2;

use crate::common;
use crate::common::programs::{KINDS, programs, solve};

/// The program of two disks in a vertical row between two plates. `x` says how they may move
/// sideways, `contact` and `plate` are laws, `bonds` and `top` stand in the scene.
fn column(scene: &str, contact: &str, plate: &str, bonds: &str, top: &str) -> ConeProgram {
    let scene = common::parse(&format!(
        "(
            version: 1,
            title: \"column of two\",
            {scene}
            materials: {{ \"stone\": (contact: ({contact}),
                bond: (cohesion: 1.0e5, tensile_strength: 1.0e5, friction: 0.5)) }},
            specimen: Particles([(position: (0.0, 5.0e-3), radius: 5.001e-3), (position: (0.0, 15.0e-3), radius: 5.001e-3)]),
            bonds: [{bonds}],
            walls: [
                (name: \"bottom\", start: (-0.01, 0.0), end: (0.01, 0.0), contact: ({plate})),
                (name: \"top\", start: (0.01, 0.02), end: (-0.01, 0.02), contact: ({plate})),
            ],
            stages: [Load(name: \"load\", increments: 1, walls: {{ \"top\": {top} }},
                particles: [(select: All, x: Held)])],
        )"
    ));
    let mut simulation = Simulation::new(&scene, None);
    assert_eq!(simulation.step(), Step::Increment);
    simulation.world().resource::<ConeProgram>().clone()
}

#[test]
fn a_program_has_only_what_the_scene_has() {
    const STIFF: &str = "normal_stiffness: 1.0e7";
    const ROUGH: &str = "normal_stiffness: 1.0e7, tangential_stiffness: 1.0e7, friction: 0.3";
    const ROLLING: &str = "normal_stiffness: 1.0e7, tangential_stiffness: 1.0e7, friction: 0.3, rolling_friction: 0.1";
    const DOWN: &str = "Displacement(0.0, -1.0e-6)";
    const BOND: &str = "(a: 0, b: 1)";
    let size = |forces, inertias, balance_rows, limit_rows| ProgramSize {
        forces,
        inertias,
        balance_rows,
        limit_rows,
    };
    for (what, program, expected) in [
        // Three normal forces, two heights.
        ("frictionless", column("", STIFF, STIFF, "", DOWN), size(3, 0, 2, 3)),
        // And three shear forces and two rotations; |q| <= mu p implies p >= 0.
        ("friction", column("", ROUGH, ROUGH, "", DOWN), size(6, 0, 4, 6)),
        ("smooth plates", column("", ROUGH, STIFF, "", DOWN), size(4, 0, 4, 4)),
        ("rolling", column("", ROLLING, ROLLING, "", DOWN), size(9, 0, 4, 12)),
        // A bond has a tension row and, without mu_r, no moment.
        ("bond", column("", ROUGH, ROUGH, BOND, DOWN), size(6, 0, 4, 7)),
        ("bond, rolling", column("", ROLLING, ROLLING, BOND, DOWN), size(8, 0, 4, 11)),
        // A loaded wall is one more balance row.
        ("force", column("", ROUGH, ROUGH, "", "Force(100.0)"), size(6, 0, 5, 6)),
        // Inertia of every free degree of freedom that something touches.
        (
            "dynamic",
            column(
                "friction_law: Associated, analysis: Dynamic(dt: 1.0e-3),",
                STIFF,
                STIFF,
                "",
                DOWN,
            ),
            size(3, 2, 2, 3),
        ),
        (
            "dynamic, friction",
            column(
                "friction_law: Associated, analysis: Dynamic(dt: 1.0e-3),",
                ROUGH,
                ROUGH,
                "",
                DOWN,
            ),
            size(6, 4, 4, 6),
        ),
    ] {
        assert_eq!(reference::size(&program), expected, "{what}");
    }
    let nothing = programs(KINDS.last().unwrap(), 1);
    assert_eq!(reference::size(nothing.last().unwrap()), size(0, 0, 0, 0), "no contacts");
}

/// A disk on a plate: 100 N press it down; k_N = k_T = 1 MN/m, mu = 0.5, mu_r r = 1 mm. It sinks by
/// 0.1 mm.
fn disk_on_plate() -> (ConeProgram, Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let free = |load| Dof::Free(FreeDof { load, ..Default::default() });
    let program = ConeProgram {
        bodies: vec![
            ProgramBody { axis: DVec2::X, dofs: [free(0.0), free(-100.0), free(0.0)] },
            ProgramBody { axis: DVec2::X, dofs: [Dof::Fixed(0.0); 3] },
        ],
        interactions: vec![Interaction {
            normal: DVec2::NEG_Y,
            arm_a: 0.01,
            normal_compliance: 1e-6,
            tangential_compliance: 1e-6,
            limits: Limits::new(0.0, 0.5, 0.0, 1e-3),
            ..Interaction::between(0, 1)
        }],
        scales: Scales { length: 0.01, displacement: 1e-4, force: 100.0 },
        ..Default::default()
    };
    (program, vec![[100.0, 0.0, 0.0]], vec![[0.0, -1e-4, 0.0], [0.0; 3]])
}

#[test]
fn residuals_see_what_is_wrong() {
    let (program, forces, u) = disk_on_plate();
    let of = |forces: &[[f64; 3]], u: &[[f64; 3]]| {
        let (forces, displacements) = (forces.to_vec(), u.to_vec());
        residuals(&program, &ConeSolution { forces, displacements, ..ConeSolution::default() })
    };
    let exact = of(&forces, &u);
    assert!(exact.worst() <= 1e-15, "{exact:?}");
    let force = |k: usize, by: f64| {
        let mut forces = forces.clone();
        forces[0][k] += by;
        of(&forces, &u)
    };
    let motion = |k: usize, by: f64| {
        let mut u = u.clone();
        u[0][k] += by;
        of(&forces, &u)
    };
    let close = |value: f64, expected: f64| (value - expected).abs() <= 1e-9 * expected;
    // 101 N in place of 100 N: 1 N is not balanced, and the compression of the spring has an error
    // of 1 um.
    let r = force(0, 1.0);
    assert!(close(r.balance, 1.0 / 101.0) && close(r.complementarity, 1e-6 / 1e-4), "{r:?}");
    // 1 um too deep, and too high: penetration of the spring, and a force across a gap.
    let r = motion(1, -1e-6);
    assert!(close(r.kinematics, 1.0 / 101.0) && r.balance == 0.0, "{r:?}");
    let r = motion(1, 1e-6);
    assert!(close(r.complementarity, 1.0 / 99.0) && r.kinematics == 0.0, "{r:?}");
    // 51 N of shear, where friction holds 50 N; 0.11 N m where 0.1 N m is the limit.
    let r = force(1, 51.0);
    assert!(close(r.cone, 0.01) && close(r.balance, 0.51), "{r:?}");
    let r = force(2, 0.11);
    assert!(close(r.cone, 0.01) && close(r.balance, 0.11), "{r:?}");
    // Tension; and rolling below its limit: 0.1 N m of slack times 1e-3 rad, over 100 N x 0.1 mm.
    let r = force(0, -101.0);
    assert!(close(r.cone, 0.01), "{r:?}");
    let r = motion(2, 1e-3);
    assert!(r.complementarity > 1e-2, "{r:?}");
    assert!(force(0, f64::NAN).worst().is_nan() && motion(0, f64::NAN).worst().is_nan());
}

#[test]
fn residuals_see_any_wrong_force_or_motion_of_a_specimen() {
    // A force of every contact that carries one, and a motion of every disk that is held.
    let kind = KINDS.iter().find(|k| k.name == "stress on the lid").unwrap();
    let program = programs(kind, 1).pop().unwrap();
    let solution = solve(&mut Condensed::default(), &program);
    assert_eq!(solution.status, SolveStatus::Solved);
    let (force, u) = (
        force_scale(&program, &solution.forces),
        displacement_scale(&program, &solution.displacements),
    );
    let mut seen = 0;
    for k in (0..program.interactions.len()).filter(|k| solution.forces[*k][0].abs() > 0.01 * force)
    {
        let mut wrong = solution.clone();
        wrong.forces[k][0] += 1e-4 * force;
        let r = residuals(&program, &wrong);
        assert!(r.balance > 1e-5 && r.complementarity > 1e-7, "{k}: {r:?}");
        let body = program.interactions[k].a as usize;
        for by in [1e-3 * u, -1e-3 * u] {
            let mut wrong = solution.clone();
            wrong.displacements[body][0] += by;
            let r = residuals(&program, &wrong);
            assert!(r.kinematics.max(r.complementarity) > 1e-6, "{body}: {r:?}");
        }
        seen += 1;
    }
    assert!(seen > 10, "{seen}");
}

#[test]
fn a_collapse_comes_with_a_mechanism_that_proves_it() {
    // 10 N pull the disk off its plate.
    let (mut program, ..) = disk_on_plate();
    if let Dof::Free(f) = &mut program.bodies[0].dofs[1] {
        f.load = 10.0;
    }
    for solver in [&mut Condensed::default() as &mut dyn ConeSolver, &mut Clarabel::default()] {
        let solution = solve(solver, &program);
        assert_eq!(solution.status, SolveStatus::Collapsed, "{}", solution.message);
        let proof = solution.certificate.unwrap();
        assert!(proof.margin > 0.999 && proof.defect < 1e-6, "{proof:?}");
        assert!((proof.mechanism[0][1] - 1.0).abs() < 1e-6, "{proof:?}");
        // The scale does not matter; the opposite motion does no work; a motion into the plate is
        // not admissible.
        let check = |u: [f64; 3]| certificate(&program, &[u, [0.0; 3]]);
        assert!(check([0.0, 3e-5, 0.0]).as_ref().is_some_and(proves));
        assert_eq!(check([0.0, -1.0, 0.0]), None);
        assert_eq!(check([0.0; 3]), None);
        // Sliding faster than the opening that goes with it.
        assert!(check([1.0, 0.49, 0.0]).is_some_and(|c| !proves(&c)));
        assert!(check([1.0, 0.51, 0.0]).is_some_and(|c| proves(&c)));
    }
    // A motion of 1e-7 that is not admissible, beside a body without load that moves by 1: relative to
    // that one nothing closes.
    let mut beside = program.clone();
    beside.bodies.push(ProgramBody { axis: DVec2::X, dofs: [Dof::Free(FreeDof::default()); 3] });
    let motion = [[1e-7, 0.4e-7, 0.0], [0.0; 3], [0.0, 1.0, 0.0]];
    let aside = certificate(&beside, &motion).unwrap();
    assert!(!proves(&aside), "{aside:?}");
    // A bond of 20 N holds the 10 N: the same mechanism dissipates more than the load does.
    let limits = &mut program.interactions[0].limits;
    *limits = Limits::new(20.0, limits.friction, 20.0, limits.rolling);
    let held = certificate(&program, &[[0.0, 1.0, 0.0], [0.0; 3]]).unwrap();
    assert!((held.margin + 1.0).abs() < 1e-12 && !proves(&held), "{held:?}");
    assert_eq!(solve(&mut Condensed::default(), &program).status, SolveStatus::Solved);
}

#[test]
fn a_bond_with_little_cohesion_holds_to_the_apex_of_its_shear_limit() {
    // |q| <= 4 N + 0.5 p allows no more than 8 N of tension, whatever the tensile strength of 20 N.
    let pulled_with = |force: f64, compliance: f64| {
        let (mut program, ..) = disk_on_plate();
        if let Dof::Free(f) = &mut program.bodies[0].dofs[1] {
            f.load = force;
        }
        let c = &mut program.interactions[0];
        (c.normal_compliance, c.tangential_compliance) = (compliance, compliance);
        c.limits = Limits::new(4.0, 0.5, 20.0, 0.0);
        program
    };
    for compliance in [1e-6, 0.0] {
        for solver in [&mut Condensed::default() as &mut dyn ConeSolver, &mut Clarabel::default()] {
            assert_eq!(solve(solver, &pulled_with(7.99, compliance)).status, SolveStatus::Solved);
            let solution = solve(solver, &pulled_with(10.0, compliance));
            assert_eq!(solution.status, SolveStatus::Collapsed, "{}", solution.message);
            let margin = solution.certificate.unwrap().margin;
            assert!((margin - 0.2).abs() < 1e-6, "{margin}");
            // Pulled by 0.1 mm instead: it yields at 8 N.
            let mut program = pulled_with(0.0, compliance);
            program.bodies[0].dofs = [Dof::Fixed(0.0), Dof::Fixed(1e-4), Dof::Fixed(0.0)];
            let solution = solve(solver, &program);
            assert_eq!(solution.status, SolveStatus::Solved, "{}", solution.message);
            assert!((solution.forces[0][0] + 8.0).abs() < 1e-6, "{:?}", solution.forces);
        }
    }
}

#[test]
fn a_vice_that_closes_on_a_rigid_disk_is_locked() {
    let (mut program, ..) = disk_on_plate();
    program.interactions[0].normal_compliance = 0.0;
    // The lid presses the disk 0.1 mm into the plate.
    let lid = [Dof::Fixed(0.0), Dof::Fixed(-1e-4), Dof::Fixed(0.0)];
    program.bodies.push(ProgramBody { axis: DVec2::X, dofs: lid });
    program.interactions.push(Interaction { b: 2, normal: DVec2::Y, ..program.interactions[0] });
    for solver in [&mut Condensed::default() as &mut dyn ConeSolver, &mut Clarabel::default()] {
        let solution = solve(solver, &program);
        assert_eq!(solution.status, SolveStatus::Locked, "{}", solution.message);
    }
    // One spring in the way unlocks it, whatever it takes.
    program.interactions[1].normal_compliance = 1e-9;
    let solution = solve(&mut Condensed::default(), &program);
    assert_eq!(solution.status, SolveStatus::Solved);
    let p = solution.forces[1][0];
    assert!((p - 1e5).abs() < 1e-3, "{p} N");
}

/// Accepts points whose residual is at most this.
struct Within(f64);

impl Judge for Within {
    fn is_solution(&self, point: &Interior) -> bool {
        point.merit <= self.0
    }

    fn proof(&self, _: &Interior) -> Option<SolveStatus> {
        None
    }
}

/// In dynamic scenes without bonds the interior point ends at the first point within the tolerance,
/// and continues up to it.
#[test]
fn the_first_point_that_is_enough_ends_the_interior_point() {
    let settings = InteriorSettings::default();
    let (mut saved, mut all) = (0, 0);
    for kind in KINDS.iter().filter(|k| k.name.starts_with("rigid") || k.name == "rolling") {
        for program in (1..=4).flat_map(|seed| programs(kind, seed)) {
            let pairs: Vec<_> = program.interactions.iter().map(|c| (c.a, c.b)).collect();
            let start = vec![[0.0; 3]; program.bodies.len()];
            let end = |at_once: bool, enough: f64| {
                let mut matrix = BodyMatrix::new(program.bodies.len(), &pairs);
                let scaled = Scaled::new(&program, matrix.order());
                let goal = Goal { residual: 1e-11, at_once, ..Goal::default() };
                let judge = Within(enough);
                interior::solve(&scaled, &mut matrix, &start, None, &settings, goal, &judge)
            };
            let (found, exact) = end(false, 1e-6);
            if found != SolveStatus::Solved || !(exact.merit <= 1e-11) {
                continue;
            }
            let (found, first) = end(true, 1e-6);
            assert!(found == SolveStatus::Solved && first.merit <= 1e-6, "{:e}", first.merit);
            let (_, refused) = end(true, 1e-11);
            assert!(refused.iterations >= first.iterations && refused.merit <= 1e-11);
            saved += exact.iterations - first.iterations;
            all += exact.iterations;
        }
    }
    assert!(all > 500 && 8 * saved > all, "{saved} of {all} iterations saved");
}

/// Before grains settle the last solution may lie where contacts would carry a million times the
/// load: from there no step leads anywhere (the first increment of `biaxial_0kPa`).
#[test]
fn a_start_that_loads_contacts_wildly_is_none() {
    let settings = InteriorSettings::default();
    let mut started_again = 0;
    for kind in KINDS.iter().filter(|k| k.name == "rolling") {
        for program in (1..=4).flat_map(|seed| programs(kind, seed)) {
            let pairs: Vec<_> = program.interactions.iter().map(|c| (c.a, c.b)).collect();
            let from = |start: &dyn Fn(usize) -> f64| {
                let mut matrix = BodyMatrix::new(program.bodies.len(), &pairs);
                let scaled = Scaled::new(&program, matrix.order());
                let start: Vec<_> = (0..program.bodies.len()).map(|i| [start(i); 3]).collect();
                let goal = Goal { residual: 1e-8, ..Goal::default() };
                let judge = Within(1e-8);
                interior::solve(&scaled, &mut matrix, &start, None, &settings, goal, &judge).1
            };
            let near = from(&|_| 0.0);
            if !(near.merit <= 1e-8) {
                continue;
            }
            let far = from(&|i| if i % 2 == 0 { 1e9 } else { -1e9 });
            // If such a start only opens contacts, it causes no excessive force.
            started_again += usize::from((far.iterations, &far.u) == (near.iterations, &near.u));
        }
    }
    assert!(started_again >= 10, "{started_again} started again");
}

/// Tolerance of a step of a motion: larger than that of committed increments, and small enough for
/// a comparison.
const OF_STEP: f64 = 1e-7;

/// A step of a motion: a weight, in units of the scales, on every degree of freedom.
fn step_of_motion(program: &ConeProgram, weight: f64, last_forces: &[[f64; 3]]) -> ConeProgram {
    let mut step = program.clone();
    let Scales { length, displacement, force } = step.scales;
    let unit = weight * force / displacement;
    for (k, dof) in step.bodies.iter_mut().flat_map(|body| body.dofs.iter_mut().enumerate()) {
        if let Dof::Free(free) = dof {
            free.proximal = if k < 2 { unit } else { unit * length * length };
            free.reference = 0.0;
        }
    }
    step.last_forces = last_forces.to_vec();
    step
}

/// Steps of a motion with rolling resistance start from the forces of the step before. That saves
/// iterations, and leads to the displacements that Clarabel finds, which knows of no start.
#[test]
fn a_step_of_a_motion_starts_from_the_forces_of_the_last_one() {
    let (mut cold, mut warm, mut steps) = (0, 0, 0);
    for kind in KINDS.iter().filter(|k| ["rolling", "elastic bonds with rolling"].contains(&k.name))
    {
        for program in (1..=4).flat_map(|seed| programs(kind, seed)) {
            let rolls = program.interactions.iter().any(|c| c.limits.has_rolling());
            if program.is_dynamic() || !rolls {
                continue;
            }
            let first = step_of_motion(&program, 1e-1, &[]);
            let before = Condensed::default().solve(&first, OF_STEP).unwrap();
            assert_eq!(before.status, SolveStatus::Solved);
            // The places after the first step; imposed motions are zero.
            let mut next = program.clone();
            for (c, f) in next.interactions.iter_mut().zip(&before.forces) {
                c.offset -= program.kinematics(c, &before.displacements)[0];
                c.previous_shear = if c.tangential_compliance > 0.0 { f[1] } else { 0.0 };
            }
            for dof in next.bodies.iter_mut().flat_map(|body| &mut body.dofs) {
                if let Dof::Fixed(u) = dof {
                    *u = 0.0;
                }
            }
            let end = |last: &[[f64; 3]], solver: &mut dyn ConeSolver| {
                let solution = solver.solve(&step_of_motion(&next, 1e-2, last), OF_STEP).unwrap();
                assert_eq!(solution.status, SolveStatus::Solved, "{}", kind.name);
                solution
            };
            let known = end(&before.forces, &mut Condensed::default());
            let unknown = end(&[], &mut Condensed::default());
            let other = end(&[], &mut Clarabel::default());
            let unit = next.scales.displacement;
            for (u, v) in known.displacements.iter().zip(&other.displacements) {
                let off = (u[0] - v[0]).hypot(u[1] - v[1]);
                assert!(off <= 1e-2 * unit, "{}: {off:e} m of {unit:e} m", kind.name);
            }
            warm += known.iterations;
            cold += unknown.iterations;
            steps += 1;
        }
    }
    assert!(steps >= 20, "{steps} steps");
    assert!(20 * warm < 19 * cold, "{warm} iterations, {cold} without the last forces");
}
