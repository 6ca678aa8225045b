//! The energy ledger of a periodic cell in static stages: against the work of the stresses, with
//! elastic forces, friction, bonds that break and avalanches.

use clastic::components::attempt::IncrementStatus;
use clastic::components::cell::PeriodicCell;
use clastic::components::energy::{Energies, EnergyLedger};
use clastic::run::measures::reading;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::Scene;

use crate::common::{parse, step};

/// A packing of disks with springs in a cell, compacted and then loaded by `stages`. `bond` is a
/// field of the material.
fn packing(more: &str, bond: &str, stages: &str) -> Scene {
    parse(&format!(
        r#"(
    version: 1, title: "energy of a cell", output: (energy: true), {more}
    materials: {{ "sand": (density: 2650.0,
        contact: (normal_stiffness: 3.0e7, tangential_stiffness: 1.0e7, friction: 0.4), {bond}) }},
    specimen: Packing(count: 100, columns: 10, spacing: 10.1e-3,
        sizes: Uniform(radius: (3.0e-3, 5.0e-3)), seed: 5),
    cell: (size: (0.101, 0.101)),
    stages: [
        Compact(name: "compact", target: Porosity(0.2), step: 2.0e-3, agitation: 0.1, seed: 5),
        {stages}
    ],
    measures: [(name: "elastic", of: ElasticEnergy)],
)"#
    ))
}

const CEMENT: &str = r#"Cement(name: "cement", length: 3.0e-4),"#;
const BOND: &str = "bond: (normal_stiffness: 3.0e7, tangential_stiffness: 1.0e7, friction: 0.4,
    cohesion: 60.0e3, tensile_strength: 30.0e3)";

/// What a run has found.
struct Run {
    total: Energies,
    /// Work of the stresses on the strains of the cell by the trapezoidal rule, and that of the
    /// ledger in the same increments, J: those without a motion, in which the loads of the end act.
    work: f64,
    booked: f64,
    broken: usize,
    /// Increments within avalanches, and steps of motions.
    in_avalanches: usize,
    motion_steps: u32,
    elastic: f64,
}

/// Runs a scene of a thickness of 1 m.
fn run(scene: &Scene) -> Run {
    let mut simulation = Simulation::new(scene, None);
    let cell = |simulation: &Simulation| *simulation.world().resource::<PeriodicCell>();
    let mut last: Option<PeriodicCell> = None;
    let (mut booked, mut work, mut broken, mut in_avalanches, mut motion_steps) =
        (0.0, 0.0, 0, 0, 0);
    while let Some(record) = step(&mut simulation) {
        assert!(record.status.is_committed(), "increment {}", record.increment);
        let now = cell(&simulation);
        if record.stage == "compact" {
            // Forces of a compaction have no meaning: the ledger begins free of stress.
            last = Some(PeriodicCell { stress: [0.0; 3], ..now });
            continue;
        }
        let before = last.replace(now).unwrap();
        let mean = [0, 1, 2].map(|k| 0.5 * (before.stress[k] + now.stress[k]));
        let area = 0.5 * (before.area() + now.area());
        broken += record.ruptures.len();
        in_avalanches += usize::from(record.in_avalanche);
        motion_steps += record.motion_steps;
        let increment = simulation.world().resource::<EnergyLedger>().increment;
        if record.motion_steps == 0 {
            booked += increment.external;
            work -= mean[0] * area * (now.width / before.width).ln();
            work -= mean[1] * area * (now.height / before.height).ln();
            work += mean[2] * area * (now.shear - before.shear);
        }
        let error = increment.error().abs();
        // Under Coulomb's law an increment may keep a residual of up to 1e-4.
        let allowed = if record.status == IncrementStatus::Capped { 1e-3 } else { 1e-6 };
        assert!(error <= allowed * increment.throughput() + 1e-12, "{error:e} {increment:?}");
    }
    assert_eq!(simulation.run(), Outcome::Completed);
    let elastic = reading(simulation.world(), "elastic").unwrap();
    let total = simulation.world().resource::<EnergyLedger>().total;
    Run { total, work, booked, broken, in_avalanches, motion_steps, elastic }
}

/// Rough disks store all work, whether strains or stresses are imposed. Normals turn within an
/// increment; that part vanishes in proportion to the increment.
#[test]
fn rough_disks_store_the_work_of_the_cell() {
    let bonds = BOND.replace("60.0e3", "1.0e9").replace("30.0e3", "1.0e9");
    for law in ["friction_law: Associated,", "friction_law: Coulomb(),"] {
        for stage in [
            "xx: Strain(1.0e-3), yy: Strain(0.5e-3), shear: Strain(1.0e-3)",
            "xx: Stress(50.0e3), yy: Stress(80.0e3), shear: Stress(20.0e3)",
            "mean: Stress(60.0e3), difference: Strain(1.0e-3)",
        ] {
            let stages = |n: u32| {
                format!(r#"{CEMENT} Load(name: "load", increments: {n}, cell: ({stage})),"#)
            };
            let turning = [5, 20].map(|n| {
                let Run { total, work, elastic, broken, .. } =
                    run(&packing(law, &bonds, &stages(n)));
                let about = format!("{law} {stage} in {n}: {work:e} {elastic:e} {total:?}");
                assert_eq!(broken, 0);
                assert!(total.error().abs() <= 1e-9 * total.external, "{about}");
                assert!((total.external / work - 1.0).abs() < 5e-3, "{about}");
                // One is of the geometry at the end, the other of the normals of the program.
                assert!((total.elastic / elastic - 1.0).abs() < 1e-3, "{about}");
                (total.external - total.elastic).abs() / total.external
            });
            assert!(turning[0] < 0.02 && turning[1] < 0.5 * turning[0], "{turning:?}: {stage}");
        }
    }
}

/// Sheared under a confining stress: the work goes into friction, and into bonds that break one by
/// one, in avalanches of each kind, in motions and many together.
#[test]
fn the_ledger_closes_where_contacts_slide_and_bonds_break() {
    let stages = r#"Load(name: "confine", increments: 3,
            cell: (xx: Stress(50.0e3), yy: Stress(80.0e3), shear: Stress(0.0))),
        Load(name: "shear", increments: 15, cell: (shear: Strain(0.01))),"#;
    let cemented = format!("{CEMENT} {stages}");
    let one_by_one = |avalanche: &str| {
        format!("rupture: (avalanche: {avalanche}, density: 30.0, brittleness: 0.0),")
    };
    let (mut turning, mut external) = (0.0, 0.0);
    for law in ["friction_law: Associated,", "friction_law: Coulomb(),"] {
        for (rule, stages) in [
            (String::new(), stages),
            (String::new(), &cemented),
            ("rupture: (order: OneRound),".to_owned(), &cemented),
            (one_by_one("MostOverloaded"), &cemented),
            (one_by_one("Dynamic"), &cemented),
        ] {
            let bond = if stages == cemented { BOND } else { "" };
            let found = run(&packing(&format!("{law} {rule}"), bond, stages));
            let Run { total, work, booked, broken, in_avalanches, motion_steps, .. } = found;
            let about = format!(
                "{law} {rule}: {broken} broken, {in_avalanches} in avalanches, {motion_steps} \
                 steps; {booked:e} {work:e} {total:?}"
            );
            assert!(total.error().abs() <= 1e-5 * total.external, "{about}");
            assert!(work > 0.0 && (booked / work - 1.0).abs() < 0.01, "{booked:e}: {about}");
            assert!(total.friction > 0.0, "{about}");
            turning += total.turning.abs();
            external += total.external;
            if stages == cemented {
                assert!(broken >= 10 && total.rupture > 0.0, "{about}");
                let is_dynamic = rule.contains("Dynamic");
                assert!(!rule.contains("avalanche") || in_avalanches > 0 || is_dynamic, "{about}");
                assert!(!is_dynamic || motion_steps > 0, "{about}");
            }
        }
    }
    // Of all ten together: in one of them an avalanche breaks three times as many bonds as in the others.
    assert!(turning < 0.03 * external, "{turning:e} of {external:e}");
}
