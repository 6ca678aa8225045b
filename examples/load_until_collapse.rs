//! A load that grows over a stage of ten increments, and the message with which the app stops when
//! the specimen carries no more.
//!
//! A bond of 24 N between two disks is loaded by up to 48 N. It breaks at half of the stage, and no
//! equilibrium exists without it.

use bevy_app::{App, Update};
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

fn report(mut stops: MessageReader<ClasticStopped>) {
    for stopped in stops.read() {
        println!("{:?} in increment {}: {}", stopped.by, stopped.increment, stopped.reason);
    }
}

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default()).add_systems(Update, report.after(ClasticStepping));
    // Disks of 6 mm radius and 1 m thickness: the bond carries 2 r h sigma_t = 24 N.
    let bond =
        BondLaw { normal_compliance: 1.0 / 8.0e6, tensile_strength: 2.0e3, ..Default::default() };
    let disk = |x| (Particle::disk(6.0e-3, 2650.0, 1.0), BodyPosition(DVec2::new(x, 0.0)));
    let world = app.world_mut();
    let held = world.spawn((disk(0.0), BodyDrives::imposed([0.0; 3]))).id();
    let loaded = world.spawn(disk(12.0e-3)).id();
    world.spawn(Bond::between(held, loaded, bond));

    begin_stage(world, 10);
    world.entity_mut(loaded).insert(LoadControl([(0.0, 48.0), (0.0, 0.0), (0.0, 0.0)]));
    while *app.world().resource::<ClasticRunning>() == ClasticRunning::Always {
        app.update();
    }
    let world = app.world();
    assert_eq!(*world.resource::<ClasticRunning>(), ClasticRunning::Stopped(StoppedBy::Collapsed));
    // The last state that was committed carries the strength of the bond.
    let force = world.get::<BodyExternalForce>(loaded).map_or(0.0, |force| force.0[0]);
    println!("the bond carried {force:.3} N");
    assert!((force - 24.0).abs() < 1e-3);
}
