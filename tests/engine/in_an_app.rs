//! The engine in the app of another program: what comes while it runs, and what the app is told.

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
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
