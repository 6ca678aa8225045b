//! Several increments in a frame: the simulation keeps its own time, whatever the frame rate.
//!
//! Bevy's `TimePlugin` runs `FixedPostUpdate` once per time step that has passed. The time step is
//! `dt` of the analysis, and the plugins set that of Bevy to it. A disk of 1 kg falls with
//! increments of 5 ms, four to a frame of 20 ms.
//!
//! A simulation that is faster or slower than the clock: `Time::<Virtual>::set_relative_speed`. If
//! increments take longer than `dt`, the simulation falls behind, and `TimePlugin` asks for ever
//! more of them, up to `Time::<Virtual>::max_delta` in a frame: see `background.rs`.

use std::time::Duration;

use bevy_app::{App, FixedPostUpdate, Update};
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use clastic::prelude::*;
use glam::DVec2;

/// Number of frames, and what the last one showed.
#[derive(Resource, Default)]
struct Shown {
    frames: u64,
    increments: u64,
    speed: f64,
}

/// A system of yours that reads what was committed last, once per frame.
fn show(
    disks: Query<&BodyVelocity, With<Particle>>,
    progress: Res<ClasticProgress>,
    mut shown: ResMut<Shown>,
) {
    shown.frames += 1;
    shown.increments = progress.increment;
    shown.speed = disks.iter().map(|v| v.0.length()).fold(0.0, f64::max);
}

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, ClasticPlugins::new(FixedPostUpdate)))
        .init_resource::<Shown>()
        .add_systems(Update, show)
        // Instead of the clock, so that the numbers below are always the same.
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(20)))
        .insert_resource(ClasticAnalysis {
            kind: AnalysisKind::Dynamic { dt: 5.0e-3, theta: 1.0 },
            gravity: DVec2::new(0.0, -9.81),
            ..ClasticAnalysis::default()
        });
    let disk = Particle::disk(0.1, 1.0 / (0.01 * std::f64::consts::PI), 1.0);
    app.world_mut().spawn((disk, BodyPosition::default()));

    // The first frame starts the clock.
    for _ in 0..51 {
        app.update();
    }
    let Shown { frames, increments, speed } = app.world().resource();
    println!("{frames} frames, {increments} increments, {speed:.4} m/s");
    let step = app.world().resource::<Time<Fixed>>().timestep();
    assert_eq!(step, Duration::from_millis(5));
    assert_eq!((*frames, *increments), (51, 200));
    assert!((speed - 9.81 * 5.0e-3 * *increments as f64).abs() < 1e-9);
}
