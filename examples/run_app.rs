//! A program that is the app and nothing else: `Startup` spawns two bonded disks in one batch of
//! `Commands`, Bevy's runner updates the app, and the message `ClasticStopped` ends it.
//!
//! Without a runner, or a plugin group that brings one (`DefaultPlugins`, `MinimalPlugins`),
//! `App::run` makes one update and returns.

use bevy_app::{App, AppExit, ScheduleRunnerPlugin, Startup, Update};
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

/// The disk with the load.
#[derive(Component)]
struct Loaded;

/// Loads grow over ten increments. A stage begins before bodies are loaded: what is spawned first
/// counts as loaded already.
fn begin(world: &mut World) {
    begin_stage(world, 10);
}

/// Two disks of 6 mm radius and 1 m thickness. Their bond carries 2 r h sigma_t = 24 N, and the
/// load goes up to 48 N.
fn spawn(mut commands: Commands) {
    let disk = |x| (Particle::disk(6.0e-3, 2650.0, 1.0), BodyPosition(DVec2::new(x, 0.0)));
    let bond =
        BondLaw { normal_compliance: 1.0 / 8.0e6, tensile_strength: 2.0e3, ..Default::default() };
    let load = LoadControl([(0.0, 48.0), (0.0, 0.0), (0.0, 0.0)]);
    let held = commands.spawn((disk(0.0), BodyDrives::imposed([0.0; 3]))).id();
    let loaded = commands.spawn((disk(12.0e-3), load, Loaded)).id();
    // The entities get their bodies when the commands are applied, and the bond is resolved then.
    commands.spawn(Bond::between(held, loaded, bond));
}

/// Ends the app when the engine stops: the runner would go on, without increments. The exit code
/// says whether the bond has carried 24 N.
fn end(
    mut stops: MessageReader<ClasticStopped>,
    loads: Query<&BodyExternalForce, With<Loaded>>,
    mut exit: MessageWriter<AppExit>,
) {
    for stopped in stops.read() {
        // The last committed increment.
        let force: f64 = loads.iter().map(|force| force.0[0]).sum();
        println!("{force:.3} N, then {:?}: {}", stopped.by, stopped.reason);
        let as_expected = stopped.by == StoppedBy::Collapsed && (force - 24.0).abs() < 1e-3;
        exit.write(if as_expected { AppExit::Success } else { AppExit::error() });
    }
}

/// Runs the example.
pub fn main() {
    let exit = App::new()
        .add_plugins((ScheduleRunnerPlugin::default(), ClasticPlugins::default()))
        .add_systems(Startup, (begin, spawn).chain())
        .add_systems(Update, end.after(ClasticStepping))
        .run();
    assert!(exit.is_success());
}
