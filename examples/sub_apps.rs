//! Several specimens: one `SubApp` each, since a world holds one specimen.
//!
//! Three pairs of bonded disks of different stiffness are pulled by 1 um in every update of the
//! main app. Each carries its stiffness times the elongation.

use bevy_app::{App, AppLabel};
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

/// Label of a specimen.
#[derive(AppLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Specimen(usize);

/// Force on the pulled disk of every specimen, N: a resource of the main world.
#[derive(Resource, Default)]
struct Forces([f64; 3]);

/// Marks the pulled disk.
#[derive(Component)]
struct Pulled;

/// Two bonded disks in an app of their own. The stiffness is in N/m.
fn specimen(stiffness: f64) -> App {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    let bond = BondLaw {
        normal_compliance: 1.0 / stiffness,
        tensile_strength: 1.0e5,
        ..Default::default()
    };
    let world = app.world_mut();
    let mut disk = |x, pull| {
        let place = BodyPosition(DVec2::new(x, 0.0));
        world.spawn((Particle::disk(6.0e-3, 2650.0, 1.0), place, BodyDrives::imposed(pull))).id()
    };
    let (held, pulled) = (disk(0.0, [0.0; 3]), disk(12.0e-3, [1.0e-6, 0.0, 0.0]));
    world.entity_mut(pulled).insert(Pulled);
    world.spawn(Bond::between(held, pulled, bond));
    app
}

/// Runs the example.
pub fn main() {
    let stiffnesses = [1.0e6, 2.0e6, 4.0e6];
    let mut app = App::new();
    app.init_resource::<Forces>();
    for (k, stiffness) in stiffnesses.into_iter().enumerate() {
        let mut own = specimen(stiffness);
        let mut sub_app = std::mem::take(own.main_mut());
        // Bevy calls this before each update of the specimen. It has both worlds; what the main
        // world reads is therefore of the update before.
        sub_app.set_extract(move |main, specimen| {
            let mut pulled = specimen.query_filtered::<&BodyExternalForce, With<Pulled>>();
            for force in pulled.iter(specimen) {
                main.resource_mut::<Forces>().0[k] = force.0[0];
            }
        });
        app.insert_sub_app(Specimen(k), sub_app);
    }
    for _ in 0..3 {
        app.update();
    }
    // Two increments are extracted; the third one is in the specimens.
    let forces = app.world().resource::<Forces>().0;
    println!("{forces:.3?} N");
    for (k, stiffness) in stiffnesses.into_iter().enumerate() {
        assert!((forces[k] - 2.0e-6 * stiffness).abs() < 1e-6);
        let progress = app.sub_app(Specimen(k)).world().resource::<ClasticProgress>();
        assert_eq!(progress.increment, 3);
    }
}
