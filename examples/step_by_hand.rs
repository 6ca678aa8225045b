//! Pausing, single increments, and bodies that come and go while a simulation is under way.
//!
//! A disk of 1 kg falls freely under dynamic analysis: after n increments of 1 ms its speed is
//! 9.81 n mm/s.

use bevy_app::App;
use clastic::prelude::*;
use glam::DVec2;

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    app.insert_resource(ClasticAnalysis {
        kind: AnalysisKind::Dynamic { dt: 1.0e-3, theta: 1.0 },
        gravity: DVec2::new(0.0, -9.81),
        ..ClasticAnalysis::default()
    });
    // 1 m thick; the density makes it 1 kg.
    let disk = Particle::disk(0.1, 1.0 / (0.01 * std::f64::consts::PI), 1.0);
    let first = app.world_mut().spawn((disk, BodyPosition(DVec2::new(0.0, 1.0)))).id();
    let speed = |app: &App, disk| app.world().get::<BodyVelocity>(disk).map_or(0.0, |v| v.0.y);

    app.insert_resource(ClasticRunning::Paused);
    app.update();
    assert_eq!(speed(&app, first), 0.0);

    // Three increments, one in every update, then it is paused again.
    app.insert_resource(ClasticRunning::Times(3));
    for _ in 0..10 {
        app.update();
    }
    println!("{:.5} m/s after three increments", speed(&app, first));
    assert!((speed(&app, first) + 3.0 * 9.81e-3).abs() < 1e-12);
    assert_eq!(*app.world().resource::<ClasticRunning>(), ClasticRunning::Paused);

    // A second disk comes, the first goes: identities are not used again.
    let second = app.world_mut().spawn((disk, BodyPosition(DVec2::new(1.0, 1.0)))).id();
    app.world_mut().despawn(first);
    app.insert_resource(ClasticRunning::Times(1));
    app.update();
    assert_eq!(app.world().get::<BodyId>(second), Some(&BodyId(1)));
    assert!((speed(&app, second) + 9.81e-3).abs() < 1e-12);
}
