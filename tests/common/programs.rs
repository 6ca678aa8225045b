//! Cone programs of small random specimens, and solvers whose results are checked.

use clastic::components::attempt::{Attempt, IncrementStatus};
use clastic::cone::certificate::proves;
use clastic::cone::program::{ConeProgram, ConeSolution, SolveStatus};
use clastic::cone::residuals::regularised_residuals;
use clastic::cone::solver::ConeSolver;
use clastic::run::{Simulation, Step};

/// Maximum residual of a valid solution.
pub const RESIDUAL: f64 = 1e-8;

/// A kind of scene: law of contacts, law of bonds, analysis, stages after the compaction.
pub struct Kind {
    /// Name of the kind.
    pub name: &'static str,
    /// Law of contacts.
    pub contact: &'static str,
    /// Law of bonds.
    pub bond: &'static str,
    /// Fields of the scene.
    pub scene: &'static str,
    /// Stages after the compaction.
    pub stages: &'static str,
}

const ELASTIC: &str = "normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, ";
const STRENGTH: &str = "cohesion: 5.0e4, tensile_strength: 5.0e4, friction: 0.5, ";
const PRESS: &str =
    r#"Load(name: "load", increments: 5, walls: { "top": Displacement(0.0, -5.0e-5) })"#;
const CEMENT_AND_CRUSH: &str = r#"Cement(name: "cement", length: 2.0e-3),
    Load(name: "load", increments: 6, remove_walls: ["left", "right"],
        walls: { "top": Displacement(0.0, -2.0e-5) })"#;

/// Kinds of scenes on which the solvers are compared.
pub const KINDS: &[Kind] = &[
    Kind { name: "frictionless", contact: ELASTIC, bond: "", scene: "", stages: PRESS },
    Kind {
        name: "friction",
        contact: "normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.3",
        bond: "",
        scene: "",
        stages: PRESS,
    },
    Kind {
        name: "rolling",
        contact: "normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.3, rolling_friction: 0.1",
        bond: "",
        scene: "",
        stages: PRESS,
    },
    Kind {
        name: "elastic rolling",
        contact: "normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, rolling_stiffness: 4.8e2, friction: 0.3, rolling_friction: 0.1",
        bond: "",
        scene: "",
        stages: PRESS,
    },
    Kind {
        name: "rigid under a force",
        contact: "friction: 0.4",
        bond: "",
        scene: "",
        stages: r#"Load(name: "load", increments: 4, walls: { "top": Force(500.0) })"#,
    },
    Kind {
        name: "elastic bonds",
        contact: "normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.3",
        bond: ELASTIC,
        scene: "rupture: (order: OneRound),",
        stages: CEMENT_AND_CRUSH,
    },
    Kind {
        name: "elastic bonds with rolling",
        contact: "normal_stiffness: 6.0e7, friction: 0.3",
        bond: "normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, rolling_friction: 0.05, ",
        scene: "rupture: (rolling: Yields, order: OneRound),",
        stages: CEMENT_AND_CRUSH,
    },
    Kind {
        name: "elastic bonds with elastic rolling",
        contact: "normal_stiffness: 6.0e7, friction: 0.3",
        bond: "normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, rolling_stiffness: 4.8e2, rolling_friction: 0.05, ",
        scene: "rupture: (rolling: Yields, order: OneRound),",
        stages: CEMENT_AND_CRUSH,
    },
    Kind {
        name: "rigid bonds",
        contact: "friction: 0.3",
        bond: " ",
        scene: "",
        stages: CEMENT_AND_CRUSH,
    },
    Kind {
        name: "stress on the lid",
        contact: "normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.3",
        bond: ELASTIC,
        scene: "rupture: (order: OneRound),",
        stages: r#"Cement(name: "cement", length: 2.0e-3), Load(name: "load", increments: 5,
            walls: { "top": Stress(stress: 2.0e4, between: ("left", "right")) })"#,
    },
    Kind {
        name: "dynamic, rigid",
        contact: "friction: 0.3",
        bond: "",
        scene: "friction_law: Associated, analysis: Dynamic(dt: 5.0e-3), gravity: (0.0, -9.81),",
        stages: r#"Load(name: "load", increments: 6, remove_walls: ["top", "right"])"#,
    },
    Kind {
        name: "dynamic, elastic, bonds",
        contact: "normal_stiffness: 1.0e5, tangential_stiffness: 1.0e5, friction: 0.3, rolling_friction: 0.1",
        bond: "normal_stiffness: 1.0e5, tangential_stiffness: 1.0e5, ",
        scene: "friction_law: Associated, analysis: Dynamic(dt: 1.0e-3, theta: 0.6), gravity: (3.0, -9.81),",
        stages: r#"Cement(name: "cement", length: 0.5e-3),
            Load(name: "load", increments: 6, remove_walls: ["top", "right"])"#,
    },
    Kind {
        name: "infeasible",
        contact: "normal_stiffness: 6.0e7, friction: 0.3",
        bond: ELASTIC,
        scene: "rupture: (order: OneRound),",
        stages: r#"Cement(name: "cement", length: 2.0e-3, walls: true),
            Load(name: "load", increments: 1, remove_walls: ["top", "right"],
                particles: [(select: All, force: (900.0, 2000.0))])"#,
    },
    Kind {
        name: "jammed",
        contact: "",
        bond: "",
        scene: "acceptance: (halvings: 0),",
        stages: r#"Load(name: "load", increments: 6, walls: { "top": Displacement(0.0, -1.5e-3) })"#,
    },
    Kind {
        name: "no contacts",
        contact: "",
        bond: "",
        scene: "",
        stages: r#"Load(name: "spread", increments: 2, remove_walls: ["bottom", "top", "left", "right"],
            particles: [(select: All, affine: ((1.0, 0.0), (0.0, 1.0)))]),
            Load(name: "rest", increments: 2)"#,
    },
];

/// Contacts that roll and that slide without friction. The program is degenerate, since only p is
/// elastic.
pub const WHEELS: Kind = Kind {
    name: "rolling without friction",
    contact: "normal_stiffness: 6.0e7, rolling_friction: 0.1",
    bond: "",
    scene: "",
    stages: PRESS,
};

/// Contacts that roll elastically and slide without friction.
pub const SPRUNG_WHEELS: Kind = Kind {
    name: "elastic rolling without friction",
    contact: "normal_stiffness: 6.0e7, rolling_stiffness: 4.8e2, rolling_friction: 0.1",
    bond: "",
    scene: "",
    stages: PRESS,
};

/// Cone programs of a small random specimen with the loading of its kind: the last program of every
/// increment, compaction included.
pub fn programs(kind: &Kind, seed: u32) -> Vec<ConeProgram> {
    increments(kind, seed).into_iter().map(|(program, _)| program).collect()
}

/// These programs with the solutions of the run.
pub fn increments(kind: &Kind, seed: u32) -> Vec<(ConeProgram, ConeSolution)> {
    let Kind { contact, scene, stages, .. } = kind;
    let bond = if kind.bond.is_empty() {
        String::new()
    } else {
        format!("bond: ({STRENGTH}{})", kind.bond.trim())
    };
    let scene = super::parse(&format!(
        "(
            version: 1,
            title: \"small specimen\",
            {scene}
            materials: {{ \"sand\": (contact: ({contact}), {bond}) }},
            specimen: Packing(count: 12, columns: 4, spacing: 10.0e-3, origin: (0.5e-3, 0.0),
                sizes: Uniform(radius: (3.0e-3, 5.0e-3)), seed: {seed}),
            walls: [
                (name: \"bottom\", start: (0.0, 0.0), end: (0.041, 0.0), contact: ({contact})),
                (name: \"top\", start: (0.041, 0.0305), end: (0.0, 0.0305), contact: ({contact})),
                (name: \"left\", start: (0.0, 0.0305), end: (0.0, 0.0), contact: ({contact})),
                (name: \"right\", start: (0.041, 0.0), end: (0.041, 0.0305), contact: ({contact})),
            ],
            stages: [
                Compact(name: \"compact\", wall: \"top\", base: \"bottom\", target: Porosity(0.34),
                    step: 1.0e-3, agitation: 0.1, seed: {seed}),
                {stages},
            ],
        )"
    ));
    let mut simulation = Simulation::new(&scene, None);
    let mut found = Vec::new();
    while let Step::Increment = simulation.step() {
        // An undecided increment leaves the last of many attempts. It is no program of the scene
        // unless it is locked.
        let world = simulation.world();
        let undecided = world.resource::<Attempt>().status == IncrementStatus::Undecided;
        let solution = world.resource::<ConeSolution>();
        if !undecided || solution.status == SolveStatus::Locked {
            found.push((world.resource::<ConeProgram>().clone(), solution.clone()));
        }
    }
    found
}

/// Solves a program. The status follows from residuals and certificate, whatever the solver
/// reports.
pub fn solve(solver: &mut dyn ConeSolver, program: &ConeProgram) -> ConeSolution {
    let mut solution = solver.solve(program, 0.0).unwrap_or_else(|e| panic!("{e}"));
    match solution.status {
        SolveStatus::Solved | SolveStatus::Stalled => {
            let r = regularised_residuals(program, &solution);
            let converged = r.worst() <= RESIDUAL;
            solution.status = if converged { SolveStatus::Solved } else { SolveStatus::Stalled };
        }
        SolveStatus::Collapsed => assert!(solution.certificate.as_ref().is_some_and(proves)),
        SolveStatus::Locked => {}
    }
    solution
}
