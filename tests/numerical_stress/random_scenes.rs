//! Random small scenes with every feature on and off: none may panic, hang, return what is not a
//! number, or report success with a residual above tolerance.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;
use clastic::run::{Outcome, Simulation, Step};
use clastic::scene::{self, format::*};

use clastic::components::energy::EnergyLedger;

use crate::common::parse;
use crate::energy::accepted_error;
use crate::oracle::{Findings, Oracle};
use crate::random::{Random, seeds};

/// Maximum time of a small scene, on a machine with other load.
const LONGEST: Duration = Duration::from_secs(120);
/// Bounds of the attempts at one increment: solves, and the last round that began below the bound.
const MAX_SOLVES: u32 = 1300;

/// A random scene; `maximum` bounds the number of bodies.
pub fn random_scene(seed: u64, maximum: u32) -> Scene {
    let r = &mut Random::new(seed);
    let dynamic = r.chance(0.5);
    let base = r.pick(&[1e-3, 5e-3, 5e-2]);
    let particles = particles(r, dynamic, base, maximum);
    let names = ["soft", "hard"];
    let materials: BTreeMap<String, Material> =
        names.iter().map(|name| ((*name).to_owned(), material(r))).collect();
    let (low, high) = bounds(&particles);
    let gap = r.pick(&[0.0, 0.0, 1e-3, 0.2, 2.0]) * base;
    let walls = walls(r, (low.0 - gap, low.1 - gap), (high.0 + gap, high.1 + gap));
    let bonds = if r.chance(0.3) { bonds(r, &particles, &materials) } else { Vec::new() };
    let mut scene = Scene {
        values: BTreeMap::new(),
        reference_stage: None,
        groups: BTreeMap::new(),
        minerals: Vec::new(),
        keep: None,
        version: 1,
        title: format!("random scene {seed}"),
        thickness: r.pick(&[1.0, 1.0, 0.1]),
        gravity: if r.chance(0.4) { (r.pick(&[0.0, 0.0, 3.0]), -9.81) } else { (0.0, 0.0) },
        analysis: if dynamic { dynamics(r) } else { Analysis::Static },
        friction_law: if r.chance(0.3) {
            r.pick(&[FrictionLaw::COULOMB, FrictionLaw::COULOMB, FrictionLaw::ByAnalysis])
        } else {
            FrictionLaw::Associated
        },
        rupture: Rupture {
            rolling: r.pick(&[RollingLimit::Breaks, RollingLimit::Yields]),
            order: r.pick(&[
                RuptureOrder::Events,
                RuptureOrder::OneRound,
                RuptureOrder::OneRound,
                RuptureOrder::OneRound,
            ]),
            density: r.pick(&[Rupture::DENSITY, Rupture::DENSITY, 30.0]),
            ..Rupture::default()
        },
        probes: BTreeMap::new(),
        cell: None,
        rigid_at_start: Vec::new(),
        solver: if r.chance(0.05) { Solver::Clarabel {} } else { Solver::default() },
        acceptance: Acceptance { halvings: r.pick(&[2, 6]), ..Acceptance::default() },
        materials,
        specimen: Specimen::Particles(particles),
        bonds,
        walls,
        stages: Vec::new(),
        measures: Vec::new(),
        output: Output { energy: true, ..Output::default() },
    };
    if scene.walls.len() == 4 && r.chance(0.15) {
        let height = (high.1 - low.1) * r.between(0.7, 1.0);
        scene.stages.push(Stage::Compact(Compact {
            stop: Vec::new(),
            record: Default::default(),
            name: "compact".into(),
            wall: "top".into(),
            base: "bottom".into(),
            target: CompactTarget::Height(height.max(base)),
            by: Default::default(),
            step: r.between(0.1, 2.0) * base,
            agitation: r.pick(&[0.0, 0.1]),
            seed,
        }));
    }
    if scene.materials.values().any(|m| m.bond.is_some()) && r.chance(0.4) {
        let length = r.decades(1e-4, 1.0) * base;
        let walls = r.chance(0.5);
        scene.stages.push(Stage::Cement(Cement {
            name: "cement".into(),
            length: Some(length),
            coordination: None,
            walls,
            particles: true,
            select: None,
            bond: None,
        }));
    }
    for k in 0..=r.below(3) {
        let load = load(r, k, dynamic, base, low, high, &scene);
        scene.stages.push(Stage::Load(load));
    }
    scene
}

fn dynamics(r: &mut Random) -> Analysis {
    let theta = r.pick(&[0.5, 0.6, 0.75, 1.0, 1.0]);
    Analysis::Dynamic { dt: r.decades(1e-5, 1e-2), theta }
}

fn material(r: &mut Random) -> Material {
    let k = r.decades(1e5, 1e9);
    Material { density: 2650.0, contact: contact(r, k), bond: r.maybe(0.7, |r| bond(r, k)) }
}

pub fn bond(r: &mut Random, k: f64) -> Bond {
    let mut bond = Bond {
        normal_stiffness: r.maybe(0.7, |r| k * r.pick(&[1.0, 10.0])),
        tangential_stiffness: r.maybe(0.7, |_| 0.5 * k),
        friction: r.pick(&[0.0, 0.5, 1.0]),
        rolling_friction: r.pick(&[0.0, 0.0, 0.1, 0.5]),
        cohesion: r.pick(&[0.0, 1e3, 1e5, 1e7]),
        tensile_strength: r.pick(&[0.0, 1e3, 1e5, 1e7]),
        rolling_stiffness: None,
        scatter: None,
    };
    bond.rolling_stiffness = rolling(bond.rolling_friction, k);
    bond
}

/// A rolling stiffness of the order k r^2 in half of the materials that have a rolling moment. It
/// takes no random number, so that scenes without it stay as they are.
fn rolling(friction: f64, k: f64) -> Option<f64> {
    (friction > 0.0 && k.to_bits().is_multiple_of(2)).then_some(2e-5 * k)
}

fn contact(r: &mut Random, k: f64) -> Contact {
    let mut contact = Contact {
        normal_stiffness: r.maybe(0.6, |_| k),
        tangential_stiffness: r.maybe(0.6, |_| 0.5 * k),
        friction: r.pick(&[0.0, 0.3, 0.5, 1.0, 1.5]),
        rolling_friction: r.pick(&[0.0, 0.0, 0.05, 0.3]),
        rolling_stiffness: None,
        restitution: 0.0,
    };
    contact.rolling_stiffness = rolling(contact.rolling_friction, k);
    contact
}

fn particles(r: &mut Random, dynamic: bool, base: f64, maximum: u32) -> Vec<Particle> {
    // Small scenes find most errors: the number is uniform in the logarithm.
    let n = r.decades(1.0, f64::from(maximum + 1)) as u32;
    let columns = 1 + r.below(8);
    let uneven = r.pick(&[0.0, 0.0, 0.3, 0.8]);
    let jitter = r.pick(&[0.0, 1e-9, 0.05, 0.3]);
    // Touching, apart, or overlapping.
    let spacing = base * r.pick(&[2.0, 2.0, 2.0 + 1e-6, 2.1, 3.0, 1.98]);
    let hexagonal = r.chance(0.4);
    let speed = if dynamic { r.pick(&[0.0, 0.1, 2.0]) } else { 0.0 };
    (0..n)
        .map(|k| {
            let (row, column) = (f64::from(k / columns), f64::from(k % columns));
            let (x, y) = if hexagonal {
                (column + 0.5 * (row % 2.0), 0.75_f64.sqrt() * row)
            } else {
                (column, row)
            };
            let wiggle = |r: &mut Random| jitter * base * r.between(-1.0, 1.0);
            Particle {
                position: (spacing * x + wiggle(r), spacing * y + wiggle(r)),
                radius: base * (1.0 - uneven * r.unit()),
                material: Some(r.pick(&["soft", "hard"]).into()),
                velocity: (speed * r.between(-1.0, 1.0), speed * r.between(-1.0, 1.0)),
                angular_velocity: speed / base * r.between(-1.0, 1.0),
                group: r.maybe(0.2, |r| r.pick(&["red", "blue"]).into()),
                probe: None,
            }
        })
        .collect()
}

fn bounds(particles: &[Particle]) -> ((f64, f64), (f64, f64)) {
    particles.iter().fold(
        ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY)),
        |(low, high), p| {
            let ((x, y), r) = (p.position, p.radius);
            ((low.0.min(x - r), low.1.min(y - r)), (high.0.max(x + r), high.1.max(y + r)))
        },
    )
}

fn walls(r: &mut Random, low: (f64, f64), high: (f64, f64)) -> Vec<Wall> {
    let all = [
        ("bottom", low, (high.0, low.1)),
        ("top", high, (low.0, high.1)),
        ("left", (low.0, high.1), low),
        ("right", (high.0, low.1), high),
    ];
    let count = r.pick(&[0, 1, 2, 4, 4]);
    let stiffness = r.decades(1e5, 1e9);
    let law = contact(r, stiffness);
    all[..count]
        .iter()
        .map(|(name, start, end)| Wall {
            shape: WallShape::Line,
            name: (*name).into(),
            start: *start,
            end: *end,
            contact: law,
            bond: None,
            present: true,
            touching: false,
            probe: None,
        })
        .collect()
}

fn bonds(
    r: &mut Random,
    particles: &[Particle],
    materials: &BTreeMap<String, Material>,
) -> Vec<ExplicitBond> {
    let mut bonds = Vec::new();
    for b in 1..particles.len() {
        for a in 0..b {
            let (p, q) = (&particles[a], &particles[b]);
            let d = (p.position.0 - q.position.0).hypot(p.position.1 - q.position.1);
            let cements = |p: &Particle| {
                let name = p.material.as_ref().unwrap();
                materials[name].bond.is_some()
            };
            let near = d - p.radius - q.radius < 0.3 * p.radius && r.chance(0.7);
            if near && cements(p) && cements(q) {
                bonds.push(ExplicitBond { a: a as u32, b: b as u32 });
            }
        }
    }
    bonds
}

fn load(
    r: &mut Random,
    k: u32,
    dynamic: bool,
    base: f64,
    low: (f64, f64),
    high: (f64, f64),
    scene: &Scene,
) -> Load {
    let analysis = r.maybe(0.2, |r| if r.chance(0.5) { dynamics(r) } else { Analysis::Static });
    let moving = match analysis {
        Some(analysis) => analysis != Analysis::Static,
        None => dynamic,
    };
    let step = |r: &mut Random| base * r.decades(1e-6, 0.3) * r.pick(&[-1.0, 1.0]);
    let mut walls = BTreeMap::new();
    for wall in &scene.walls {
        if r.chance(0.4) {
            continue;
        }
        let control = match r.below(5) {
            0 => WallControl::Fixed,
            1 => WallControl::Displacement(step(r), step(r)),
            2 if moving => WallControl::Velocity(r.between(-1.0, 1.0), r.between(-1.0, 1.0)),
            3 => WallControl::Force(r.decades(1e-2, 1e5) * r.pick(&[1.0, 1.0, 1.0, -1.0])),
            4 => WallControl::Stress {
                stress: r.decades(1.0, 1e6),
                between: (scene.walls.len() == 4 && r.chance(0.7)).then(|| {
                    let names = if wall.name == "top" || wall.name == "bottom" {
                        ("left", "right")
                    } else {
                        ("bottom", "top")
                    };
                    (names.0.to_owned(), names.1.to_owned())
                }),
            },
            _ => WallControl::Fixed,
        };
        walls.insert(wall.name.clone(), control);
    }
    let mut particles = Vec::new();
    for _ in 0..r.pick(&[0, 0, 1, 2]) {
        let motion = |r: &mut Random, unit: f64| match r.below(6) {
            0 => Motion::Held,
            1 => Motion::Displacement(r.decades(1e-6, 0.1) * unit * r.pick(&[-1.0, 1.0])),
            2 if moving => Motion::Velocity(r.between(-1.0, 1.0) * unit / base),
            _ => Motion::Free,
        };
        let affine = r.maybe(0.2, |r| {
            let mut e = || 0.01 * r.between(-1.0, 1.0);
            ((e(), e()), (e(), e()))
        });
        let middle = (0.5 * (low.0 + high.0), 0.5 * (low.1 + high.1));
        particles.push(ParticleControl {
            select: match r.below(4) {
                0 => Select::All,
                1 => Select::Index(vec![0]),
                2 => Select::Box { min: low, max: middle },
                _ => Select::Group("red".into()),
            },
            x: if affine.is_some() { Motion::Free } else { motion(r, base) },
            y: if affine.is_some() { Motion::Free } else { motion(r, base) },
            rotation: motion(r, 1.0),
            affine,
            force: r.maybe(0.4, |r| {
                let size = r.decades(1e-2, 1e5);
                (size * r.between(-1.0, 1.0), size * r.between(-1.0, 1.0))
            }),
            moment: r.maybe(0.2, |r| base * r.decades(1e-2, 1e3)),
            remains: None,
        });
    }
    // No group, no selection of it.
    let Specimen::Particles(list) = &scene.specimen else { unreachable!() };
    if !list.iter().any(|p| p.group.as_deref() == Some("red")) {
        particles.retain(|c| c.select != Select::Group("red".into()));
    }
    Load {
        scale: Default::default(),
        record: Default::default(),
        name: format!("load {k}"),
        increments: 1 + r.below(4),
        analysis,
        gravity: r.maybe(0.1, |r| (r.between(-5.0, 5.0), r.between(-10.0, 0.0))),
        walls,
        remove_walls: Vec::new(),
        add_walls: Vec::new(),
        particles,
        rigid: Default::default(),
        release: Vec::new(),
        membranes: Default::default(),
        remove_membranes: Vec::new(),
        cell: None,
        stop: Vec::new(),
    }
}

/// The scene's text, as a user could run it.
pub fn text(scene: &Scene) -> String {
    use ron::extensions::Extensions;
    let extensions = Extensions::IMPLICIT_SOME
        | Extensions::UNWRAP_NEWTYPES
        | Extensions::UNWRAP_VARIANT_NEWTYPES;
    ron::Options::default()
        .with_default_extension(extensions)
        .to_string_pretty(scene, ron::ser::PrettyConfig::default())
        .unwrap()
}

/// How a scene ended.
#[derive(Debug)]
pub struct Story {
    pub outcome: Outcome,
    pub increments: usize,
    pub statuses: [usize; 4],
    pub findings: Findings,
    pub took: Duration,
}

/// Runs a scene from its text; the oracle checks each increment.
pub fn run_checked(scene: &Scene) -> Story {
    let scene = parse(&text(scene));
    let start = Instant::now();
    let mut simulation = Simulation::new(&scene, None);
    let mut story = Story {
        outcome: Outcome::Completed,
        increments: 0,
        statuses: [0; 4],
        findings: Findings::default(),
        took: Duration::ZERO,
    };
    loop {
        let oracle = Oracle::before(&mut simulation, &scene);
        match simulation.step() {
            Step::Finished(outcome) => {
                story.outcome = outcome;
                break;
            }
            Step::Increment => {
                let record = simulation.world().resource::<Observation>().clone();
                assert!(record.solves <= MAX_SOLVES, "{} solves", record.solves);
                story.increments += 1;
                assert!(story.increments < 5000, "{} increments", story.increments);
                story.statuses[match record.status {
                    IncrementStatus::Solved => 0,
                    IncrementStatus::Capped => 1,
                    IncrementStatus::Collapsed => 2,
                    IncrementStatus::Undecided => 3,
                }] += 1;
                oracle.after(&mut simulation, &scene, &record, &mut story.findings);
                let committed =
                    matches!(record.status, IncrementStatus::Solved | IncrementStatus::Capped);
                if committed && simulation.world().contains_resource::<EnergyLedger>() {
                    let accepted = accepted_error(&simulation);
                    let error = simulation.world().resource::<EnergyLedger>().increment.error();
                    story.findings.energy(error.abs() / accepted, record.increment);
                }
                assert!(start.elapsed() < LONGEST, "{:?}", start.elapsed());
            }
        }
    }
    story.took = start.elapsed();
    story
}

#[test]
fn random_scenes_are_solved_or_say_why_not() {
    survey(|seed| random_scene(seed, 60));
}

/// Runs the scenes of all seeds.
pub fn survey(scene_of: impl Fn(u64) -> Scene) {
    let (mut statuses, mut outcomes) = ([0; 4], [0; 4]);
    let (mut failures, mut worst) = (Vec::new(), Findings::default());
    let (mut slowest, mut increments) = ((Duration::ZERO, 0), 0);
    let (mut scenes, mut refused) = (0, 0);
    for seed in seeds(120) {
        let scene = scene_of(seed);
        scenes += 1;
        if std::env::var("CLASTIC_SEED").is_ok() {
            println!("{}", text(&scene));
        }
        if let Err(error) = scene::from_str(&text(&scene), Path::new("r.ron"), Path::new(""), &[]) {
            let error = error.to_string();
            refused += u32::from(error.contains("comes to wall"));
            // A box that is drawn at random may hold nothing.
            if error.contains("comes to wall") || error.contains("selects no particle") {
                continue;
            }
        }
        match catch_unwind(AssertUnwindSafe(|| run_checked(&scene))) {
            Ok(story) => {
                for (sum, n) in statuses.iter_mut().zip(story.statuses) {
                    *sum += n;
                }
                increments += story.increments;
                outcomes[match story.outcome {
                    Outcome::Completed => 0,
                    Outcome::Collapsed(_) => 1,
                    Outcome::Undecided { .. } => 2,
                    Outcome::Refused { .. } | Outcome::Halted(_) => 3,
                }] += 1;
                if !story.findings.complaints.is_empty() {
                    failures.push((seed, story.findings.complaints.join("; ")));
                }
                worst.merge(&story.findings);
                slowest = slowest.max((story.took, seed));
            }
            Err(panic) => {
                let what = panic
                    .downcast_ref::<String>()
                    .cloned()
                    .or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
                failures.push((seed, what.unwrap_or_default()));
            }
        }
    }
    println!(
        "{increments} increments: solved, capped, collapsed, undecided {statuses:?}; scenes: \
         completed, collapsed, stopped, without what a stage selects {outcomes:?}, refused {refused}; slowest {slowest:?}"
    );
    println!("{worst}");
    // Walls that would meet are seen before anything is built; few scenes have them.
    assert!(50 * refused <= scenes.max(50), "{refused} of {scenes} refused");
    if !failures.is_empty() {
        let mut message = String::new();
        for (seed, what) in failures.iter().take(40) {
            let _ = writeln!(message, "CLASTIC_SEED={seed}: {}", &what[..what.len().min(400)]);
        }
        panic!("{} scenes failed:\n{message}", failures.len());
    }
}

/// Random scenes that went wrong once.
fn goes_right(seed: u64) {
    let story = run_checked(&random_scene(seed, 60));
    assert!(story.findings.complaints.is_empty(), "{:?}", story.findings.complaints);
}

/// A loaded wall was thrown 3.6e11 m away: beside it the overlap of held disks with a fixed wall
/// looked like round-off, and forces of 1e24 N were accepted.
#[test]
fn what_is_thrown_far_hides_no_error_seed_71() {
    goes_right(71);
}

/// A held disk had an undetermined force of 2e26 N, which hid the errors of all others; the
/// round-off of this force moved it by 3 km.
#[test]
fn a_pressure_that_nothing_determines_hides_no_error_seed_64() {
    goes_right(64);
}

/// The same, made small: the left disk is led into a fixed rigid wall, and the bottom wall is
/// pulled away with nothing to hold it.
#[test]
fn a_disk_that_is_led_into_a_rigid_wall_is_not_solved() {
    let scene = parse(
        "(
            version: 1,
            title: \"led into a wall\",
            analysis: Dynamic(dt: 1.0e-3),
            materials: { \"stone\": (contact: (friction: 0.5)) },
            specimen: Particles([(position: (0.0, 0.0), radius: 0.05), (position: (0.1, 0.0), radius: 0.05)]),
            walls: [
                (name: \"left\", start: (-0.05005, 1.0), end: (-0.05005, -1.0), contact: (friction: 0.3)),
                (name: \"bottom\", start: (-1.0, -0.05), end: (1.0, -0.05), contact: (friction: 0.3)),
            ],
            stages: [Load(name: \"lead\", increments: 1, walls: { \"bottom\": Force(-1.0) },
                particles: [(select: Index([0]), x: Displacement(-1.0e-4))])],
        )",
    );
    let story = run_checked(&scene);
    assert_eq!(story.statuses[0] + story.statuses[1], 0, "{story:?}");
}

/// The tie of a bond with almost no tension, softer than all others by 1e14, set the scale of
/// forces to 3e-22 N: residuals were relative to round-off.
#[test]
fn a_tie_of_a_slack_bond_sets_no_scale_seed_1835() {
    goes_right(1835);
}
