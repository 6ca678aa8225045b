//! The engine in the app of another program: what comes while it runs, and what the app is told.

use std::time::Duration;

use bevy_app::{App, FixedUpdate, Update};
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use clastic::prelude::*;
use clastic::run::spawn::spawn_scene;
use clastic::run::{EndedBy, StageEnd};
use clastic::scene::LoadedScene;
use glam::DVec2;

/// An app under dynamic analysis with gravity.
pub(super) fn falling() -> App {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    app.insert_resource(ClasticAnalysis {
        kind: AnalysisKind::Dynamic { dt: 1.0e-3, theta: 1.0 },
        gravity: DVec2::new(0.0, -9.81),
        ..ClasticAnalysis::default()
    });
    app
}

pub(super) fn disk(x: f64) -> (Particle, BodyPosition) {
    (Particle::disk(0.1, 2650.0, 1.0), BodyPosition(DVec2::new(x, 0.0)))
}

pub(super) fn increments(app: &App) -> u64 {
    app.world().resource::<ClasticProgress>().increment
}

#[derive(Component)]
struct Marker;

/// `QueryState::is_empty` never learns of new archetypes: the app stood still, and said nothing.
#[test]
fn bodies_that_come_after_the_first_update_are_stepped() {
    let mut waiting = falling();
    waiting.update();
    waiting.world_mut().spawn(disk(0.0));
    let mut marked = falling();
    let only = marked.world_mut().spawn(disk(0.0)).id();
    marked.update();
    marked.world_mut().entity_mut(only).insert(Marker);
    let state = WorldState::capture(marked.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    let mut restored = falling();
    restored.update();
    state.restore(restored.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    for (mut app, before) in [(waiting, 0), (marked, 1), (restored, 1)] {
        for n in 1..=10 {
            app.update();
            assert_eq!(increments(&app), before + n);
        }
    }
}

/// A scene that pours its first particle stood still in an app, and said nothing.
#[test]
fn a_scene_that_begins_without_particles_pours_them() {
    let scene = crate::common::load("poured_bin");
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), ScenePlugin));
    spawn_scene(app.world_mut(), &scene, None);
    for n in 1..=20 {
        app.update();
        assert_eq!(increments(&app), n);
    }
    let mut particles = app.world_mut().query::<&Particle>();
    assert!(particles.iter(app.world()).count() > 0);
}

#[derive(Resource, Default)]
struct Heard {
    in_update: usize,
    in_fixed: usize,
    observed: Vec<(Entity, [Entity; 2], RuptureMode)>,
}

/// Readers in `Update` got the ruptures of the last two increments of a frame alone.
#[test]
fn every_rupture_is_read_and_observed_whatever_the_number_of_increments_per_frame() {
    const PAIRS: usize = 40;
    let dt = 1.0e-3;
    let mut app = App::new();
    app.add_plugins((TimePlugin, ClasticPlugins::new(FixedUpdate))).init_resource::<Heard>();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(8)));
    let kind = AnalysisKind::Dynamic { dt, theta: 1.0 };
    app.insert_resource(ClasticAnalysis { kind, ..ClasticAnalysis::default() });
    let read_fixed = |mut ruptures: MessageReader<Rupture>, mut heard: ResMut<Heard>| {
        heard.in_fixed += ruptures.read().count();
    };
    let read = |mut ruptures: MessageReader<Rupture>, mut heard: ResMut<Heard>| {
        heard.in_update += ruptures.read().count();
    };
    app.add_systems(FixedUpdate, read_fixed.after(ClasticStepping)).add_systems(Update, read);
    app.add_observer(|broken: On<BondBroken>, mut heard: ResMut<Heard>| {
        assert!(broken.rupture.p < 0.0);
        heard.observed.push((broken.bond, broken.bodies, broken.rupture.mode));
    });
    let world = app.world_mut();
    let mut bonds = Vec::new();
    for k in 0..PAIRS {
        let tensile_strength = 1.0e3 * (k + 1) as f64;
        let law = BondLaw { normal_compliance: 1.0e-7, tensile_strength, ..Default::default() };
        let disk = |x| {
            let place = BodyPosition(DVec2::new(x, 0.1 * k as f64));
            (Particle::disk(6.0e-3, 2650.0, 1.0), place)
        };
        let a = world.spawn((disk(0.0), BodyDrives::imposed([0.0; 3]))).id();
        let b = world.spawn((disk(12.0e-3), BodyDrives::imposed([1.5e-6, 0.0, 0.0]))).id();
        bonds.push((world.spawn(Bond::between(a, b, law)).id(), [a, b], RuptureMode::Tension));
    }
    for _ in 0..10 {
        app.update();
    }
    let heard = app.world().resource::<Heard>();
    assert_eq!(app.world().resource::<Time<Fixed>>().timestep(), Duration::from_millis(1));
    assert!(increments(&app) > 60, "{}", increments(&app));
    assert_eq!((heard.in_update, heard.in_fixed), (PAIRS, PAIRS));
    let mut observed = heard.observed.clone();
    observed.sort_by_key(|(bond, ..)| bonds.iter().position(|known| known.0 == *bond));
    assert_eq!(observed, bonds);
}

/// What had happened in an increment was forgotten if a system halted the world after it.
#[test]
fn ruptures_are_told_if_the_world_halts_after_they_are_committed() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default()).init_resource::<Heard>();
    let halt = |mut commands: Commands| commands.insert_resource(ClasticHalted("enough".into()));
    app.add_systems(Increment, halt.after(IncrementSystems::Record));
    app.add_observer(|broken: On<BondBroken>, mut heard: ResMut<Heard>| {
        heard.observed.push((broken.bond, broken.bodies, broken.rupture.mode));
    });
    let law = BondLaw { normal_compliance: 1.0e-7, tensile_strength: 1.0, ..Default::default() };
    let [a, b] = two_disks(&mut app);
    app.world_mut()
        .entity_mut(b)
        .insert((BodyPosition(DVec2::new(0.2, 0.0)), BodyDrives::imposed([1.0e-6, 0.0, 0.0])));
    let bond = app.world_mut().spawn(Bond::between(a, b, law)).id();
    app.update();
    app.update();
    assert_eq!(app.world().resource::<Heard>().observed, [(bond, [a, b], RuptureMode::Tension)]);
}

/// A scene of which two stages of one increment each end.
fn short_scene() -> (App, LoadedScene) {
    let text = r#"(
        version: 1, title: "two disks",
        materials: { "stone": () },
        specimen: Particles([(position: (0.0, 0.0), radius: 1.0), (position: (3.0, 0.0), radius: 1.0)]),
        stages: [Load(name: "rest", increments: 1), Load(name: "and rest", increments: 1)],
    )"#;
    let loaded = clastic::scene::from_str(text, "test.ron".as_ref(), "".as_ref(), &[]);
    let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), ScenePlugin));
    spawn_scene(app.world_mut(), &loaded.scene, None);
    (app, loaded)
}

#[derive(Resource, Default)]
struct Ends(Vec<String>, Vec<ClasticStopped>);

/// It went on for ever without an increment, and no message said so.
#[test]
fn the_end_of_a_scene_and_of_its_stages_is_told() {
    let (mut app, _) = short_scene();
    app.init_resource::<Ends>();
    let read = |mut ends: MessageReader<StageEnd>,
                mut stops: MessageReader<ClasticStopped>,
                mut to: ResMut<Ends>| {
        to.0.extend(ends.read().map(|end| end.stage.clone()));
        to.1.extend(stops.read().cloned());
    };
    app.add_systems(Update, read.after(ClasticStepping));
    app.add_observer(|end: On<StageEnd>| assert_eq!(end.ended_by, Some(EndedBy::AllIncrements)));
    for _ in 0..5 {
        app.update();
    }
    assert_eq!(
        *app.world().resource::<ClasticRunning>(),
        ClasticRunning::Stopped(StoppedBy::Completed)
    );
    let Ends(stages, stops) = app.world().resource();
    assert_eq!(stages, &["rest", "and rest"]);
    assert_eq!(stops.len(), 1, "{stops:?}");
    assert_eq!((stops[0].by, stops[0].increment), (StoppedBy::Completed, 2));
}

/// Two disks; the left one is held.
pub(super) fn two_disks(app: &mut App) -> [Entity; 2] {
    let world = app.world_mut();
    let held = world.spawn((disk(0.0), BodyDrives::imposed([0.0; 3]))).id();
    [held, world.spawn(disk(0.2)).id()]
}

/// The clone had the identity of its original, which panicked.
#[test]
fn a_clone_of_a_body_is_another_body() {
    let mut app = falling();
    let original = app.world_mut().spawn(disk(0.0)).id();
    let clone = app.world_mut().entity_mut(original).clone_and_spawn();
    app.world_mut().flush();
    app.world_mut().entity_mut(clone).insert(BodyPosition(DVec2::new(9.0, 0.0)));
    app.update();
    let world = app.world();
    assert_eq!(world.get::<BodyId>(clone), Some(&BodyId(1)));
    let velocity = |body| world.get::<BodyVelocity>(body).map(|v| v.0);
    assert!(velocity(clone) == velocity(original) && velocity(clone) != Some(DVec2::ZERO));
}

#[derive(Resource, Default)]
struct Moved(Vec<Entity>);

/// It found every body in every increment, held ones too.
#[test]
fn changed_finds_the_bodies_that_move_and_no_others() {
    let mut app = falling();
    let [_, free] = two_disks(&mut app);
    app.world_mut().spawn(Wall::between(DVec2::new(1.0, -9.0), DVec2::new(-1.0, -9.0)));
    app.init_resource::<Moved>();
    let watch = |changed: Query<Entity, Changed<BodyPosition>>, mut moved: ResMut<Moved>| {
        moved.0 = changed.iter().collect();
    };
    app.add_systems(Update, watch.after(ClasticStepping));
    app.update();
    for _ in 0..3 {
        app.update();
        assert_eq!(app.world().resource::<Moved>().0, [free]);
    }
}

/// The app was not told which bodies meet.
#[test]
fn an_app_that_asks_is_told_of_every_collision_once() {
    let mut app = falling();
    let law = ContactLaw { normal_compliance: 1.0e-7, ..Default::default() };
    app.insert_resource(material::Materials(vec![material::Material {
        name: "steel".into(),
        density: 7800.0,
        contact: law,
        bond: None,
    }]));
    let ball = app.world_mut().spawn(disk(0.0)).id();
    let floor = Wall::between(DVec2::new(-1.0, -0.11), DVec2::new(1.0, -0.11));
    let floor = app.world_mut().spawn((floor, law)).id();
    app.add_message::<Collision>().init_resource::<Hits>();
    app.add_systems(Update, |mut read: MessageReader<Collision>, mut hits: ResMut<Hits>| {
        hits.0.extend(read.read().copied());
    });
    app.add_observer(|hit: On<BodyHit>, mut hits: ResMut<Hits>| hits.1.push(*hit.event()));
    let hear = |hit: On<BodyHit>, mut hits: ResMut<Hits>| hits.2.push(hit.other);
    app.world_mut().entity_mut(floor).observe(hear);
    for _ in 0..60 {
        app.update();
    }
    let Hits(read, observed, by_floor) = app.world().resource();
    let both = read.iter().flat_map(|hit| {
        let [body, other] = hit.bodies;
        [(body, other), (other, body)].map(|(body, other)| BodyHit { body, other, collision: *hit })
    });
    assert_eq!(observed, &both.collect::<Vec<_>>());
    assert_eq!(by_floor, &[ball]);
    // It falls 10 mm in 45 ms, and rebounds hardly with theta = 1.
    let [first] = read.as_slice() else { panic!("{read:?}") };
    assert_eq!((first.bodies, first.normal), ([ball, floor], DVec2::NEG_Y));
    assert!((44..=47).contains(&first.increment) && first.force > 0.0, "{first:?}");
}

/// After a rewind a contact that lasts was announced again, and one that closes anew was not.
#[test]
fn a_rewind_brings_back_which_bodies_touched() {
    let mut app = falling();
    app.world_mut().spawn(disk(0.0));
    app.world_mut().spawn(Wall::between(DVec2::new(-1.0, -0.11), DVec2::new(1.0, -0.11)));
    app.add_message::<Collision>().init_resource::<Hits>();
    app.add_observer(|hit: On<BodyHit>, mut hits: ResMut<Hits>| hits.1.push(*hit.event()));
    let capture =
        |app: &mut App| WorldState::capture(app.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    let hits = |app: &App| app.world().resource::<Hits>().1.len();
    let above = capture(&mut app);
    let run = |app: &mut App| (0..60).for_each(|_| app.update());
    run(&mut app);
    assert_eq!(hits(&app), 2);
    let at_rest = capture(&mut app);
    at_rest.rewind(app.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    run(&mut app);
    assert_eq!(hits(&app), 2);
    above.rewind(app.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    run(&mut app);
    assert_eq!(hits(&app), 4);
}

/// The collisions of messages, those of an observer of all bodies, and the bodies that the observer
/// of the floor was told of.
#[derive(Resource, Default)]
struct Hits(Vec<Collision>, Vec<BodyHit>, Vec<Entity>);

/// The rewind of a scene left its outcome, so that an app that had come to the end stayed there.
#[test]
fn a_scene_that_has_ended_goes_on_from_a_state_that_was_kept() {
    let text = r#"(
        version: 1, title: "a disk falls", gravity: (0.0, -10.0),
        analysis: Dynamic(dt: 1.0e-2),
        materials: { "m": (density: 2000.0) },
        specimen: Particles([(position: (0.0, 0.0), radius: 0.05)]),
        stages: [Load(name: "up", increments: 3), Load(name: "down", increments: 4)],
    )"#;
    let loaded = clastic::scene::from_str(text, "fall.ron".as_ref(), "".as_ref(), &[]);
    let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), ScenePlugin));
    spawn_scene(app.world_mut(), &loaded.scene, None);
    let place = |app: &mut App| {
        let mut disks = app.world_mut().query_filtered::<&BodyPosition, With<Particle>>();
        disks.iter(app.world()).map(|x| x.0.y.to_bits()).collect::<Vec<_>>()
    };
    let to_the_end = |app: &mut App| {
        for _ in 0..12 {
            app.update();
        }
        let end = ClasticRunning::Stopped(StoppedBy::Completed);
        assert_eq!(*app.world().resource::<ClasticRunning>(), end);
        assert_eq!(increments(app), 7);
    };
    app.update();
    app.update();
    let kept = place(&mut app);
    let state = clastic::run::state::capture(app.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    to_the_end(&mut app);
    let end = place(&mut app);
    clastic::run::state::rewind(app.world_mut(), &state).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((increments(&app), place(&mut app)), (2, kept));
    app.insert_resource(ClasticRunning::Always);
    to_the_end(&mut app);
    assert_eq!(place(&mut app), end);
}
