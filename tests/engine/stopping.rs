//! An app that stops by itself, loads of an app without stages, and states of worlds that do not
//! suit.

use bevy_app::{App, Update};
use bevy_ecs::prelude::*;
use clastic::components::increment::RuptureRules;
use clastic::components::material::{Material, Materials};
use clastic::cone::program::{ConeProgram, ConeSolution};
use clastic::cone::solver::{ConeSolver, MalformedProgram};
use clastic::prelude::*;
use clastic::run::StateError;
use clastic::run::script::Script;
use clastic::run::spawn::spawn_scene;
use clastic::systems::solve_program::Solver;
use glam::DVec2;

/// Normal stiffness of the bond, N/m, and its strength 2 r h sigma_t, N.
const STIFFNESS: f64 = 8.0e6;
const STRENGTH: f64 = 24.0;

/// The messages that the app has read.
#[derive(Resource, Default)]
struct Stops(Vec<ClasticStopped>);

fn listen(mut messages: MessageReader<ClasticStopped>, mut stops: ResMut<Stops>) {
    stops.0.extend(messages.read().cloned());
}

/// Two bonded disks; the left one is held. The other one is returned.
fn pair() -> (App, Entity) {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default())
        .init_resource::<Stops>()
        .add_systems(Update, listen.after(ClasticStepping));
    let bond = BondLaw {
        normal_compliance: 1.0 / STIFFNESS,
        tensile_strength: STRENGTH / 12.0e-3,
        ..Default::default()
    };
    let disk = |x| (Particle::disk(6.0e-3, 2650.0, 1.0), BodyPosition(DVec2::new(x, 0.0)));
    let world = app.world_mut();
    let held = world.spawn((disk(0.0), BodyDrives::imposed([0.0; 3]))).id();
    let free = world.spawn(disk(12.0e-3)).id();
    world.spawn(Bond::between(held, free, bond));
    (app, free)
}

fn load(app: &mut App, disk: Entity, force: f64) {
    app.world_mut().entity_mut(disk).insert(LoadControl::constant([force, 0.0, 0.0]));
}

/// Elongation of the bond times its stiffness, N.
fn tension(app: &App, disk: Entity) -> f64 {
    let place = app.world().get::<BodyPosition>(disk).map_or(f64::NAN, |x| x.0.x);
    STIFFNESS * (place - 12.0e-3)
}

fn increment(app: &App) -> u64 {
    app.world().resource::<ClasticProgress>().increment
}

#[test]
fn an_app_stops_at_a_collapse_and_goes_on_under_a_load_that_can_be_carried() {
    let (mut app, free) = pair();
    load(&mut app, free, 2.0 * STRENGTH);
    for _ in 0..20 {
        app.update();
    }
    let running = *app.world().resource::<ClasticRunning>();
    assert_eq!(running, ClasticRunning::Stopped(StoppedBy::Collapsed));
    let stops = app.world().resource::<Stops>().0.clone();
    assert_eq!(stops.len(), 1);
    assert_eq!(stops[0].by, StoppedBy::Collapsed);
    assert_eq!(stops[0].increment, increment(&app));
    assert!(stops[0].reason.contains("no equilibrium"), "{}", stops[0].reason);
    assert_eq!(app.world().resource::<Attempt>().status, IncrementStatus::Collapsed);

    // The bond is broken. Pressed against the other disk, the disk has an equilibrium again.
    load(&mut app, free, -1.0);
    let before = increment(&app);
    app.insert_resource(ClasticRunning::Times(2));
    for _ in 0..5 {
        app.update();
    }
    assert_eq!(increment(&app), before + 2);
    assert_eq!(*app.world().resource::<ClasticRunning>(), ClasticRunning::Paused);
    assert_eq!(app.world().resource::<Observation>().status, IncrementStatus::Solved);
    assert_eq!(app.world().resource::<Stops>().0.len(), 1);
}

/// A solver that finds nothing.
struct Helpless;

impl ConeSolver for Helpless {
    fn solve(&mut self, program: &ConeProgram, _: f64) -> Result<ConeSolution, MalformedProgram> {
        Ok(ConeSolution {
            forces: vec![[0.0; 3]; program.interactions.len()],
            displacements: vec![[0.0; 3]; program.bodies.len()],
            ..ConeSolution::default()
        })
    }
}

#[test]
fn an_app_stops_at_an_undecided_increment_with_the_residual() {
    let (mut app, free) = pair();
    load(&mut app, free, 0.5 * STRENGTH);
    app.insert_resource(Solver(Box::new(Helpless)));
    for _ in 0..5 {
        app.update();
    }
    let running = *app.world().resource::<ClasticRunning>();
    assert_eq!(running, ClasticRunning::Stopped(StoppedBy::Undecided));
    assert_eq!(increment(&app), 1);
    let stops = &app.world().resource::<Stops>().0;
    assert_eq!(stops.len(), 1);
    assert_eq!(stops[0].reason, app.world().resource::<Attempt>().complaint);
    assert!(!stops[0].reason.is_empty());
    // Nothing was committed, and the record says so.
    assert_eq!(app.world().resource::<Observation>().status, IncrementStatus::Undecided);
    assert_eq!(tension(&app, free), 0.0);
}

#[test]
fn a_halted_app_says_why_once() {
    let (mut app, _) = pair();
    app.insert_resource(ClasticHalted("the laboratory is closed".to_owned()));
    for _ in 0..3 {
        app.update();
    }
    let stops = &app.world().resource::<Stops>().0;
    assert_eq!(stops.len(), 1);
    assert_eq!((stops[0].by, stops[0].increment), (StoppedBy::Halted, 0));
    assert_eq!(stops[0].reason, "the laboratory is closed");
}

#[test]
fn a_collapse_ends_a_stage_of_a_scene_and_the_last_stage_stops_its_app() {
    let text = r#"(
        version: 1, title: "a disk that nothing carries", gravity: (0.0, -9.81),
        materials: { "stone": (density: 2650.0) },
        specimen: Particles([(position: (0.0, 0.0), radius: 1.0)]),
        stages: [Load(name: "hang", increments: 2),
            Load(name: "fall", increments: 3, analysis: Dynamic(dt: 1.0e-3))],
    )"#;
    let scene = clastic::scene::from_str(text, "test.ron".as_ref(), "".as_ref(), &[]);
    let scene = scene.unwrap_or_else(|e| panic!("{e}")).scene;
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), ScenePlugin));
    spawn_scene(app.world_mut(), &scene, None);
    for _ in 0..4 {
        app.update();
        assert_eq!(*app.world().resource::<ClasticRunning>(), ClasticRunning::Always);
    }
    app.update();
    assert_eq!(
        *app.world().resource::<ClasticRunning>(),
        ClasticRunning::Stopped(StoppedBy::Collapsed)
    );
    let script = app.world().resource::<Script>();
    assert!(matches!(script.outcome, Some(Outcome::Collapsed(_))), "{:?}", script.outcome);
    assert_eq!(increment(&app), 4);
    assert!((app.world().resource::<ClasticProgress>().time - 3.0e-3).abs() < 1e-15);
}

#[test]
fn a_load_of_a_stage_grows_linearly_stays_and_grows_again_from_there() {
    let (mut app, free) = pair();
    begin_stage(app.world_mut(), 4);
    let ramp = LoadControl([(0.0, 8.0), (0.0, 0.0), (0.0, 0.0)]);
    app.world_mut().entity_mut(free).insert(ramp);
    let follow = |app: &mut App, expected: &[f64]| {
        for expected in expected {
            app.update();
            let found = tension(app, free);
            assert!((found - expected).abs() < 1e-6, "{found} N instead of {expected} N");
        }
    };
    // After its stage the load stays. It went on beyond its target.
    follow(&mut app, &[2.0, 4.0, 6.0, 8.0, 8.0, 8.0]);
    begin_stage(app.world_mut(), 2);
    app.world_mut().get_mut::<LoadControl>(free).unwrap().0[0].1 = 20.0;
    follow(&mut app, &[14.0]);
    // Another target within a stage.
    let progress = app.world().resource::<ClasticProgress>().clone();
    let load = &mut app.world_mut().get_mut::<LoadControl>(free).unwrap().0[0];
    *load = progress.retarget(*load, 10.0);
    follow(&mut app, &[10.0, 10.0]);
}

#[test]
fn a_load_without_a_stage_acts_at_once_and_stays() {
    let (mut app, free) = pair();
    let ramp = LoadControl([(0.0, 8.0), (0.0, 0.0), (0.0, 0.0)]);
    app.world_mut().entity_mut(free).insert(ramp);
    for _ in 0..3 {
        app.update();
        assert!((tension(&app, free) - 8.0).abs() < 1e-6);
    }
}

#[test]
fn a_state_is_refused_by_a_world_that_has_bodies() {
    let (mut app, _) = pair();
    app.update();
    let state = WorldState::capture(app.world_mut()).unwrap();
    let (mut other, free) = pair();
    let error = state.restore(other.world_mut()).unwrap_err();
    assert_eq!(error, StateError::Occupied { bodies: 2, bonds: 1 });
    assert!(error.to_string().contains("the world is not empty (bodies: 2, bonds: 1)"), "{error}");
    // It has changed nothing.
    assert_eq!(increment(&other), 0);
    assert!(other.world().get_entity(free).is_ok());
}

#[test]
fn a_state_is_refused_by_a_world_with_other_materials() {
    let materials = |names: &[&str]| {
        let named = |name: &&str| Material { name: (*name).to_owned(), ..Material::default() };
        Materials(names.iter().map(named).collect())
    };
    let (mut app, _) = pair();
    app.insert_resource(materials(&["sand", "clay"]));
    let state = WorldState::capture(app.world_mut()).unwrap();
    for names in [&["clay", "sand"][..], &["sand"], &[]] {
        let mut other = App::new();
        other.add_plugins(ClasticPlugins::default()).insert_resource(materials(names));
        let error = state.restore(other.world_mut()).unwrap_err().to_string();
        assert!(error.contains("it has the materials `sand`, `clay`"), "{error}");
        assert_eq!(other.world_mut().query::<&BodyId>().iter(other.world()).count(), 0);
    }
    // Laws are settings, which may differ.
    let mut other = App::new();
    let mut list = materials(&["sand", "clay"]);
    list.0[0].contact.friction = 0.3;
    other.add_plugins(ClasticPlugins::default()).insert_resource(list);
    state.restore(other.world_mut()).unwrap();
    assert_eq!(other.world_mut().query::<&BodyId>().iter(other.world()).count(), 2);
}

#[test]
fn bonds_that_break_at_once_stop_the_app_too() {
    let (mut app, free) = pair();
    app.insert_resource(RuptureRules {
        order: clastic::components::increment::RuptureOrder::OneRound,
        ..Default::default()
    });
    load(&mut app, free, 2.0 * STRENGTH);
    for _ in 0..20 {
        app.update();
    }
    assert!(matches!(*app.world().resource::<ClasticRunning>(), ClasticRunning::Stopped(_)));
    assert_eq!(app.world().resource::<Stops>().0.len(), 1);
}
