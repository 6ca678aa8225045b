//! Flexible membranes: resultants, mean stress, and forces that follow the grains.

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_4;

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::components::attempt::Attempt;
use clastic::prelude::*;
use clastic::run::Outcome;
use clastic::systems::measures::stress::average_stress;
use clastic::systems::membranes::find_shape;
use clastic::systems::solved::Solved;
use glam::DVec2;

use crate::common::{assert_relative, load_with_specimen, next, stage};

const RADIUS: f64 = 5.0e-3;
const PRESSURE: f64 = 150.0e3;
const THICKNESS: f64 = 0.3;
/// Height of two touching rows of a triangular lattice above each other.
const ROW: f64 = 1.732_050_807_568_877_2 * RADIUS;

fn law(friction: f64) -> ContactLaw {
    ContactLaw {
        normal_compliance: 1.0 / 6.0e7,
        tangential_compliance: 1.0 / 3.0e7,
        friction,
        ..Default::default()
    }
}

fn app(total: f64, friction: f64) -> App {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    let sand = material::Material {
        name: "sand".into(),
        density: 2650.0,
        contact: law(friction),
        bond: None,
    };
    app.insert_resource(material::Materials(vec![sand]));
    app.insert_resource(ClasticAnalysis { thickness: THICKNESS, ..Default::default() });
    app.insert_resource(ClasticProgress { total, ..Default::default() });
    app
}

fn disk(x: DVec2) -> impl Bundle {
    (Particle::disk(RADIUS, 2650.0, THICKNESS), BodyPosition(x), BodyOrigin(x))
}

fn membrane(course: Course) -> Membrane {
    Membrane { name: "skin".into(), pressure: (0.0, PRESSURE), course, ball: None }
}

/// Runs an increment and returns the pressure at its end.
fn increment(world: &mut World) -> f64 {
    world.run_schedule(Increment);
    assert_eq!(world.resource::<Observation>().status.name(), "solved");
    let progress = world.resource::<ClasticProgress>();
    PRESSURE * progress.done / progress.total
}

fn shape(world: &mut World) -> MembraneShape {
    world.query::<&MembraneShape>().single(world).unwrap().clone()
}

/// Sum of the forces that the membranes add to all bodies, N.
fn resultant(world: &World) -> DVec2 {
    let bodies = world.resource::<BodyTable>();
    let sums = world.resource::<TrialLoads>().sums(bodies);
    sums.iter().map(|sum| DVec2::new(sum[0].force, sum[1].force)).sum()
}

fn mean_stress(world: &World, area: f64) -> [[f64; 2]; 2] {
    average_stress(Solved::of(world), area, THICKNESS)
}

/// Places of a triangular lattice in rows from y = radius on.
fn lattice(columns: usize, rows: usize) -> Vec<DVec2> {
    let place = |k: usize| {
        let (row, column) = (k / columns, k % columns);
        let shift = if row % 2 == 1 { RADIUS } else { 0.0 };
        DVec2::new(shift + 2.0 * RADIUS * column as f64, RADIUS + ROW * row as f64)
    };
    (0..columns * rows).map(place).collect()
}

/// A disk of grains within a closed membrane: the sum of the forces is zero, and the mean stress is
/// the pressure in all directions, since `sum F (x) x = p h A I` over the polygon.
#[test]
fn a_closed_membrane_brings_its_pressure_and_no_force() {
    let mut app = app(4.0, 0.5);
    let world = app.world_mut();
    let grains = lattice(15, 17);
    let centre = grains[8 * 15 + 7];
    for x in grains.into_iter().filter(|x| x.distance(centre) < 11.5 * RADIUS) {
        if x == centre {
            world.spawn((disk(x), BodyDrives::imposed([0.0; 3])));
        } else {
            world.spawn(disk(x));
        }
    }
    world.spawn(membrane(Course::Closed));
    let mut area = None;
    for _ in 0..4 {
        let pressure = increment(world);
        let scale = pressure * THICKNESS * RADIUS;
        assert!(resultant(world).length() < 1e-10 * scale, "{}", resultant(world));
        // The grain that is held carries nothing.
        let mut held = world.query::<(&BodyDrives, &BodyExternalForce)>();
        let held = held.iter(world).find(|(drives, _)| drives.0 != [BodyDrive::Free; 3]).unwrap().1;
        assert!(held.0[0].hypot(held.0[1]) < 1e-6 * scale, "{held:?}");
        if let Some(area) = area {
            let stress = mean_stress(world, area);
            assert_relative(stress[0][0], pressure, 1e-7);
            assert_relative(stress[1][1], pressure, 1e-7);
            assert!(stress[0][1].abs().max(stress[1][0].abs()) < 1e-7 * pressure, "{stress:?}");
        }
        let shape = shape(world);
        assert!(shape.grains() > 25 && shape.grains() == shape.chains[0].points.len());
        area = shape.area();
    }
}

/// A rectangle of grains between two plates. What a side carries is pressure times height times
/// thickness, and the mean stress across is the pressure where the plates are smooth.
#[test]
fn a_side_carries_pressure_times_height_even_in_halved_increments() {
    let rows = 14;
    let height = 2.0 * RADIUS + ROW * (rows - 1) as f64;
    let wall = |tangent: DVec2, y: f64| {
        let place = DVec2::new(6.0 * RADIUS, y);
        (Wall { tangent, half_length: 0.05 }, BodyPosition(place), BodyOrigin(place), law(0.0))
    };
    for sides in [Sides::Right, Sides::Left, Sides::Both] {
        let mut app = app(3.0, 0.5);
        let world = app.world_mut();
        for x in lattice(8, rows) {
            world.spawn(disk(x));
        }
        let bottom = world.spawn(wall(DVec2::X, 0.0)).id();
        let top = world.spawn(wall(DVec2::NEG_X, height)).id();
        // Rigid walls on the side without a membrane.
        if sides != Sides::Both {
            let is_left = sides == Sides::Left;
            let (tangent, x) =
                if is_left { (DVec2::Y, 16.0 * RADIUS) } else { (DVec2::NEG_Y, -RADIUS) };
            let place = BodyPosition(DVec2::new(x, 0.5 * height));
            world.spawn((Wall { tangent, half_length: 0.5 * height }, place, law(0.0)));
        }
        let id = |world: &World, wall: Entity| *world.get::<BodyId>(wall).unwrap();
        let (first, second) = (id(world, bottom), id(world, top));
        world.spawn(membrane(Course::Between { first, second, sides }));
        // As if the increment before had been quartered: fractions grow by doubling.
        world.resource_mut::<ClasticProgress>().tried = 0.25;
        let mut before = None;
        for done in [0.5, 1.0, 2.0, 3.0] {
            let pressure = increment(world);
            assert_eq!(world.resource::<ClasticProgress>().done, done);
            assert_relative(pressure, PRESSURE * done / 3.0, 1e-14);
            let expected = match sides {
                Sides::Right => -pressure * height * THICKNESS,
                Sides::Left => pressure * height * THICKNESS,
                Sides::Both => 0.0,
            };
            let error = resultant(world).x - expected;
            assert!(error.abs() < 1e-10 * pressure * height * THICKNESS, "{sides:?}: {error}");
            if let Some(area) = before {
                assert_relative(mean_stress(world, area)[0][0], pressure, 1e-7);
            }
            before = shape(world).area();
        }
    }
}

/// A grain that the membrane presses inwards with nothing behind it goes to its place.
#[test]
fn a_loose_grain_outside_is_pressed_against_the_others() {
    let mut app = app(2.0, 0.0);
    let world = app.world_mut();
    for k in 0..6 {
        let y = RADIUS + 2.0 * RADIUS * f64::from(k);
        world.spawn((disk(DVec2::new(0.0, y)), BodyDrives::imposed([0.0; 3])));
        let beside = DVec2::new(2.0 * RADIUS, y);
        if k == 3 {
            // Smaller, away from the column behind and from its two neighbours.
            let small = Particle::disk(0.8 * RADIUS, 2650.0, THICKNESS);
            world.spawn((small, BodyPosition(beside), BodyOrigin(beside)));
        } else {
            world.spawn((disk(beside), BodyDrives::imposed([0.0; 3])));
        }
    }
    let wall = |tangent: DVec2, y: f64| {
        let place = DVec2::new(RADIUS, y);
        (Wall { tangent, half_length: 0.02 }, BodyPosition(place), law(0.0))
    };
    let bottom = world.spawn(wall(DVec2::X, 0.0)).id();
    let top = world.spawn(wall(DVec2::NEG_X, 12.0 * RADIUS)).id();
    let (first, second) =
        (*world.get::<BodyId>(bottom).unwrap(), *world.get::<BodyId>(top).unwrap());
    world.spawn(membrane(Course::Between { first, second, sides: Sides::Right }));
    for _ in 0..2 {
        let pressure = increment(world);
        let mut free = world.query::<(&BodyDrives, &BodyPosition)>();
        let place =
            free.iter(world).find(|(drives, _)| drives.0 == [BodyDrive::Free; 3]).unwrap().1.0;
        // It touches the column behind, which carries half of the two links, 4 radii high.
        let overlap = pressure * 2.0 * RADIUS * THICKNESS / 6.0e7;
        assert!((place.x - 1.8 * RADIUS + overlap).abs() < 1e-6 * RADIUS, "{place}");
        assert!((place.y - 7.0 * RADIUS).abs() < 1e-3 * RADIUS, "{place}");
    }
}

/// The loads when the attempts ended: those of the chains at the start of the trial.
#[derive(Resource, Default)]
struct Seen {
    motions: u32,
    halved: u32,
    trials: u32,
}

fn are_fresh(
    bodies: Res<BodyTable>,
    (progress, analysis, attempt): (Res<ClasticProgress>, Res<ClasticAnalysis>, Res<Attempt>),
    membranes: Query<&Membrane>,
    loads: Res<TrialLoads>,
    mut seen: ResMut<Seen>,
) {
    for membrane in &membranes {
        let pressure = membrane.ramp(&progress).at(progress.fraction);
        let shape = find_shape(membrane, pressure, &bodies);
        let mut expected = TrialLoads::default();
        for chain in &shape.chains {
            for (a, b) in chain.links() {
                let link = chain.points[b] - chain.points[a];
                let force = pressure * analysis.thickness * DVec2::new(-link.y, link.x);
                // Walls come after the particles.
                let is_grain =
                    |end: usize| bodies.row(chain.bodies[end]).unwrap() < bodies.particles;
                let grains: Vec<_> = [a, b].into_iter().filter(|end| is_grain(*end)).collect();
                for end in &grains {
                    let share = force / grains.len() as f64;
                    expected.add(chain.bodies[*end], [share.x, share.y, 0.0]);
                }
            }
        }
        for (found, expected) in loads.sums(&bodies).iter().zip(expected.sums(&bodies)) {
            for k in 0..2 {
                let error = (found[k].force - expected[k].force).abs();
                assert!(error < 1e-9 * pressure * analysis.thickness * bodies.mean_radius);
            }
        }
        // Both sides: no force across.
        let sums = loads.sums(&bodies);
        let across: f64 = sums.iter().map(|sum| sum[0].force).sum();
        assert!(across.abs() < 1e-10 * pressure * analysis.thickness * shape.height, "{across} N");
        seen.trials += 1;
    }
    seen.motions += attempt.motion_steps;
    seen.halved += u32::from(progress.fraction < 1.0);
}

/// Runs the small biaxial test under settings; returns the grains that joined and left the chains.
fn biaxial(change: impl Fn(&mut clastic::scene::format::Scene)) -> (Seen, usize, usize) {
    let mut loaded = load_with_specimen("biaxial_membrane_small");
    change(&mut loaded.scene);
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let app = simulation.app_mut();
    app.init_resource::<Seen>().add_systems(
        Increment,
        are_fresh.after(IncrementSystems::Attempts).before(IncrementSystems::Update),
    );
    let grains = |simulation: &mut Simulation| -> BTreeSet<BodyId> {
        let world = simulation.world_mut();
        let mut shapes = world.query::<&MembraneShape>();
        shapes.iter(world).flat_map(|s| &s.chains).flat_map(|c| c.bodies.clone()).collect()
    };
    let (mut before, mut joined, mut left) = (BTreeSet::new(), 0, 0);
    while let Some(record) = next(&mut simulation) {
        assert_eq!(record.status.name(), "solved", "increment {}", record.increment);
        let now = grains(&mut simulation);
        if !before.is_empty() {
            joined += now.difference(&before).count();
            left += before.difference(&now).count();
        }
        before = now;
    }
    assert_eq!(simulation.run(), Outcome::Completed);
    (simulation.world_mut().remove_resource().unwrap(), joined, left)
}

#[test]
fn loads_are_fresh_in_followed_motions() {
    // A limit that contacts meet all the time.
    let (seen, ..) = biaxial(|scene| {
        scene.acceptance.turn = 0.001;
        stage(scene, "load").increments = 24;
        stage(scene, "load").stop.clear();
    });
    assert!(seen.trials > 24 && seen.motions > 0, "{}", seen.motions);
}

#[test]
fn grains_leave_and_join_the_chain_on_the_way_to_12_per_cent() {
    let (seen, joined, left) = biaxial(|_| {});
    assert!(joined > 0 && left > 0, "{joined} joined, {left} left");
    assert!(seen.trials >= 155, "{}", seen.trials);
}

/// The scene of a membrane test up to its confining stage, with these stages after it.
fn after_confining(stages: &str) -> String {
    let text = std::fs::read_to_string("scenes/biaxial_membrane_small.ron").unwrap();
    let wrap = text.find("// A new membrane starts").unwrap();
    let measures = text.find("    measures: [").unwrap();
    let path = std::path::absolute("scenes/specimens/biaxial_400.csv").unwrap();
    let text = format!("{}{stages}\n    ],\n{}", &text[..wrap], &text[measures..]);
    text.replace("specimens/biaxial_400.csv", path.to_str().unwrap())
}

fn loaded(text: &str) -> Result<clastic::scene::LoadedScene, clastic::scene::LoadError> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("scene.ron");
    std::fs::write(&path, text).unwrap();
    clastic::scene::load(&path, &[])
}

#[test]
fn the_membrane_of_the_documentation_runs_as_it_stands() {
    let text = std::fs::read_to_string("docs/scenes.md").unwrap();
    let start = text.find("// The walls have brought 200 kPa").unwrap();
    let snippet = &text[start..start + text[start..].find("```").unwrap()];
    let loaded = loaded(&after_confining(snippet)).unwrap();
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    assert_eq!(simulation.run(), Outcome::Completed);
    let observation = simulation.world().resource::<Observation>();
    assert!(observation.axial_strain.unwrap() > 0.1, "{observation:?}");
    assert_relative(observation.lateral_stress.unwrap(), 200.0e3, 1e-12);
}

#[test]
fn walls_on_which_a_kept_stress_acts_stay_or_the_stage_is_refused_with_their_names() {
    let wrap = r#"Load(name: "wrap", increments: 1, CONTROL remove_walls: ["left", "right"],
        membranes: { "sides": (pressure: 200.0e3, between: ("bottom", "top")) }),"#;
    let error = loaded(&after_confining(&wrap.replace("CONTROL", ""))).unwrap_err().to_string();
    assert!(error.contains("walls `left` and `right`"), "{error}");
    // A program that does not check its scene.
    let fixed = r#"walls: { "top": Fixed, "bottom": Fixed },"#;
    let clastic::scene::LoadedScene { mut scene, specimen, .. } =
        loaded(&after_confining(&wrap.replace("CONTROL", fixed))).unwrap();
    let clastic::scene::format::Stage::Load(load) = scene.stages.last_mut().unwrap() else {
        panic!("no loading stage")
    };
    load.walls.remove("top");
    let outcome = Simulation::new(&scene, specimen.as_ref()).run();
    let Outcome::Refused { stage, message } = outcome else { panic!("{outcome:?}") };
    assert_eq!(stage, "wrap");
    for name in ["`top`", "`left`", "`right`"] {
        assert!(message.contains(name), "{message}");
    }
}

/// A rewind left the membrane beside the one of the state, so that the pressure was twice as high.
#[test]
fn a_rewind_leaves_one_membrane() {
    let mut app = app(10.0, 0.0);
    let ring = (0..8).map(|k| 2.0 * RADIUS * DVec2::from_angle(f64::from(k) * FRAC_PI_4) / 0.765);
    for place in ring {
        app.world_mut().spawn(disk(place));
    }
    let membranes = |app: &mut App| app.world_mut().query::<&Membrane>().iter(app.world()).count();
    let before = WorldState::capture(app.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    app.world_mut().spawn(membrane(Course::Closed));
    let with = WorldState::capture(app.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    with.rewind(app.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(membranes(&mut app), 1);
    before.rewind(app.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(membranes(&mut app), 0);
}
