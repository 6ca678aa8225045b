//! Increments in `FixedUpdate`: the simulation keeps its own time, whatever the frame rate.
//!
//! A disk of 1 kg falls under dynamic analysis with increments of 5 ms. Four of them fit into a
//! frame of 20 ms. After 10 frames the speed is 9.81 m/s^2 times 0.2 s.

use bevy_app::{App, FixedMain, FixedUpdate, RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

/// Time step of the simulation and of `FixedUpdate`, s.
const DT: f64 = 5.0e-3;

/// Highest speed of a disk so far, m/s.
#[derive(Resource, Default)]
struct Highest(f64);

/// A system of yours that reads results in the same schedule, after the increment.
fn follow(disks: Query<&Velocity, With<Particle>>, mut highest: ResMut<Highest>) {
    highest.0 = disks.iter().map(|v| v.0.length()).fold(highest.0, f64::max);
}

/// Stands for `TimePlugin` of `bevy_time`, which runs `FixedMain` once per time step that has
/// passed. With `bevy_time` set the same time step: `Time::<Fixed>::from_seconds(DT)`. If an
/// increment takes longer than this, the simulation falls behind, and `bevy_time` asks for ever
/// more increments; choose a longer time step, or `Update`.
fn frame_of_20_ms(world: &mut World) {
    for _ in 0..4 {
        world.run_schedule(FixedMain);
    }
}

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::new(FixedUpdate))
        .init_resource::<Highest>()
        .add_systems(FixedUpdate, follow.after(Stepping))
        .add_systems(
            RunFixedMainLoop,
            frame_of_20_ms.in_set(RunFixedMainLoopSystems::FixedMainLoop),
        )
        .insert_resource(Analysis {
            kind: AnalysisKind::Dynamic { dt: DT, theta: 1.0 },
            gravity: DVec2::new(0.0, -9.81),
            ..Analysis::default()
        });
    let disk = Particle::disk(0.1, 1.0 / (0.01 * std::f64::consts::PI), 1.0);
    app.world_mut().spawn((disk, body::Position::default()));

    for _ in 0..10 {
        app.update();
    }
    let (time, highest) =
        (app.world().resource::<Progress>().time, app.world().resource::<Highest>().0);
    println!("{highest:.4} m/s after {time:.3} s");
    assert!((time - 0.2).abs() < 1e-12 && (highest - 9.81 * 0.2).abs() < 1e-9);
}
