//! Two bonded disks in a Bevy app: add the plugins, spawn, update.
//!
//! One disk is held; the other is pulled away by 1 um in every increment. The bond force is the
//! stiffness times the stretch: 8 N after the first increment, 16 N after the second.

use bevy_app::App;
use clastic::prelude::*;
use glam::DVec2;

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    let bond =
        BondLaw { normal_compliance: 1.0 / 8.0e6, tensile_strength: 1.0e4, ..Default::default() };

    let world = app.world_mut();
    let mut disk = |x, pull| {
        let place = BodyPosition(DVec2::new(x, 0.0));
        world.spawn((Particle::disk(6.0e-3, 2650.0, 1.0), place, BodyDrives::imposed(pull))).id()
    };
    let (held, pulled) = (disk(0.0, [0.0; 3]), disk(12.0e-3, [1.0e-6, 0.0, 0.0]));
    world.spawn(Bond::between(held, pulled, bond));

    for expected in [8.0, 16.0] {
        app.update();
        let force = app.world().get::<BodyExternalForce>(pulled).map_or(0.0, |force| force.0[0]);
        println!("{force:.3} N");
        assert!((force - expected).abs() < 1e-6);
    }
}
