//! States: capture one, restore it in another app, and go back to it in the same app.
//!
//! A disk of 1 kg is thrown upwards. Its height after n increments is the same whether the flight
//! is interrupted or not.

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use clastic::run::StateError;
use glam::DVec2;

/// An app with the settings of the simulation, which are no part of a state.
fn empty() -> App {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    app.insert_resource(ClasticAnalysis {
        kind: AnalysisKind::Dynamic { dt: 1.0e-2, theta: 0.5 },
        gravity: DVec2::new(0.0, -9.81),
        ..ClasticAnalysis::default()
    });
    app
}

/// Height of the disk after further updates, m.
fn height_after(app: &mut App, updates: usize) -> f64 {
    for _ in 0..updates {
        app.update();
    }
    let mut disks = app.world_mut().query_filtered::<&BodyPosition, With<Particle>>();
    disks.iter(app.world()).map(|x| x.0.y).sum()
}

/// Runs the example.
pub fn main() -> Result<(), StateError> {
    let mut app = empty();
    let disk = Particle::disk(0.1, 1.0 / (0.01 * std::f64::consts::PI), 1.0);
    app.world_mut().spawn((disk, BodyPosition::default(), BodyVelocity(DVec2::new(0.0, 5.0))));
    height_after(&mut app, 20);
    let state = WorldState::capture(app.world_mut())?;
    let uninterrupted = height_after(&mut app, 30);

    // A state is serialised as any serde type; here it stays in memory. It goes into an app without
    // bodies.
    let mut other = empty();
    state.restore(other.world_mut())?;
    let resumed = height_after(&mut other, 30);
    println!("{uninterrupted:.6} m, resumed {resumed:.6} m");
    assert_eq!(uninterrupted.to_bits(), resumed.to_bits());
    // With theta = 0.5 the height is that of the parabola: v t - g t^2 / 2 after t = 0.5 s.
    assert!((resumed - (5.0 * 0.5 - 0.5 * 9.81 * 0.25)).abs() < 1e-9);

    // The world from which it was captured goes back by `rewind`; `restore` refuses its bodies.
    assert!(matches!(state.restore(app.world_mut()), Err(StateError::Occupied { .. })));
    state.rewind(app.world_mut())?;
    assert_eq!(height_after(&mut app, 30).to_bits(), uninterrupted.to_bits());
    Ok(())
}
