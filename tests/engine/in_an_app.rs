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
fn falling() -> App {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    app.insert_resource(Analysis {
        kind: AnalysisKind::Dynamic { dt: 1.0e-3, theta: 1.0 },
        gravity: DVec2::new(0.0, -9.81),
        ..Analysis::default()
    });
    app
}

fn disk(x: f64) -> (Particle, body::Position) {
    (Particle::disk(0.1, 2650.0, 1.0), body::Position(DVec2::new(x, 0.0)))
}

fn increments(app: &App) -> u64 {
    app.world().resource::<Progress>().increment
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
    app.insert_resource(Time::<Fixed>::from_seconds(dt));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(8)));
    let kind = AnalysisKind::Dynamic { dt, theta: 1.0 };
    app.insert_resource(Analysis { kind, ..Analysis::default() });
    let read_fixed = |mut ruptures: MessageReader<Rupture>, mut heard: ResMut<Heard>| {
        heard.in_fixed += ruptures.read().count();
    };
    let read = |mut ruptures: MessageReader<Rupture>, mut heard: ResMut<Heard>| {
        heard.in_update += ruptures.read().count();
    };
    app.add_systems(FixedUpdate, read_fixed.after(Stepping)).add_systems(Update, read);
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
            let place = body::Position(DVec2::new(x, 0.1 * k as f64));
            (Particle::disk(6.0e-3, 2650.0, 1.0), place)
        };
        let a = world.spawn((disk(0.0), Drives::imposed([0.0; 3]))).id();
        let b = world.spawn((disk(12.0e-3), Drives::imposed([1.5e-6, 0.0, 0.0]))).id();
        bonds.push((world.spawn(Bond::between(a, b, law)).id(), [a, b], RuptureMode::Tension));
    }
    for _ in 0..10 {
        app.update();
    }
    let heard = app.world().resource::<Heard>();
    assert!(increments(&app) > 60, "{}", increments(&app));
    assert_eq!((heard.in_update, heard.in_fixed), (PAIRS, PAIRS));
    let mut observed = heard.observed.clone();
    observed.sort_by_key(|(bond, ..)| bonds.iter().position(|known| known.0 == *bond));
    assert_eq!(observed, bonds);
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
struct Ends(Vec<String>, Vec<Stopped>);

/// It went on for ever without an increment, and no message said so.
#[test]
fn the_end_of_a_scene_and_of_its_stages_is_told() {
    let (mut app, _) = short_scene();
    app.init_resource::<Ends>();
    let read = |mut ends: MessageReader<StageEnd>,
                mut stops: MessageReader<Stopped>,
                mut to: ResMut<Ends>| {
        to.0.extend(ends.read().map(|end| end.stage.clone()));
        to.1.extend(stops.read().cloned());
    };
    app.add_systems(Update, read.after(Stepping));
    app.add_observer(|end: On<StageEnd>| assert_eq!(end.ended_by, Some(EndedBy::AllIncrements)));
    for _ in 0..5 {
        app.update();
    }
    assert_eq!(*app.world().resource::<Running>(), Running::Stopped(StoppedBy::Completed));
    let Ends(stages, stops) = app.world().resource();
    assert_eq!(stages, &["rest", "and rest"]);
    assert_eq!(stops.len(), 1, "{stops:?}");
    assert_eq!((stops[0].by, stops[0].increment), (StoppedBy::Completed, 2));
}
