//! A boundary condition of a program's own: disks wrapped in a flexible membrane, under water.
//!
//! The pressure on a link of the membrane grows with its depth. A system in the public set
//! `AddTrialLoads` finds the chain of the outermost disks wherever a trial starts, so that the
//! forces follow the disks, in halved increments and followed motions too. One disk is held: it
//! carries the buoyancy, the specific weight of the water times the volume within the membrane
//! (Archimedes).

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use clastic::systems::membranes::find_shape;
use glam::DVec2;

const RADIUS: f64 = 5.0e-3;
const THICKNESS: f64 = 0.5;

/// A membrane in water. The membrane is no component, so that the engine does not press on it.
#[derive(Component)]
struct Bath {
    membrane: Membrane,
    /// Height of the surface, m.
    level: f64,
    /// Specific weight of the water, N/m^3.
    weight: f64,
    /// Area within the membrane where the last trial started, m^2.
    area: f64,
}

/// Adds [`press`] to the loads of every trial.
struct BathPlugin;

impl Plugin for BathPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(AddTrialLoads, press);
    }
}

/// Half of the force of each link acts on each of its ends. At the pressure in its middle that is
/// the exact resultant of a pressure that grows linearly.
fn press(
    bodies: Res<BodyTable>,
    analysis: Res<ClasticAnalysis>,
    mut baths: Query<&mut Bath>,
    mut loads: ResMut<TrialLoads>,
) {
    for mut bath in &mut baths {
        let shape = find_shape(&bath.membrane, 0.0, &bodies);
        bath.area = shape.area().unwrap_or(0.0);
        for chain in &shape.chains {
            for (a, b) in chain.links() {
                let [from, to] = [chain.points[a], chain.points[b]];
                let depth = (bath.level - 0.5 * (from.y + to.y)).max(0.0);
                let force = bath.weight * depth * analysis.thickness * (to - from).perp();
                for end in [a, b] {
                    loads.add(chain.bodies[end], [0.5 * force.x, 0.5 * force.y, 0.0]);
                }
            }
        }
    }
}

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), BathPlugin));
    let contact = ContactLaw {
        normal_compliance: 1.0 / 6.0e7,
        tangential_compliance: 1.0 / 3.0e7,
        friction: 0.5,
        ..Default::default()
    };
    let sand = material::Material { name: "sand".into(), density: 2650.0, contact, bond: None };
    app.insert_resource(material::Materials(vec![sand]));
    app.insert_resource(ClasticAnalysis { thickness: THICKNESS, ..Default::default() });

    let world = app.world_mut();
    let mut held = None;
    for k in -7_i32..=7 {
        for i in -7_i32..=7 {
            let shift = 0.5 * f64::from(k.rem_euclid(2));
            let x =
                RADIUS * DVec2::new(2.0 * (f64::from(i) + shift), 3.0_f64.sqrt() * f64::from(k));
            if x.length() > 11.5 * RADIUS {
                continue;
            }
            let disk = (Particle::disk(RADIUS, 2650.0, THICKNESS), BodyPosition(x));
            if (k, i) == (0, 0) {
                held = Some(world.spawn((disk, BodyDrives::imposed([0.0; 3]))).id());
            } else {
                world.spawn(disk);
            }
        }
    }
    let membrane =
        Membrane { name: "skin".into(), pressure: (0.0, 0.0), course: Course::Closed, ball: None };
    let bath = world.spawn(Bath { membrane, level: 10.0, weight: 9.81e3, area: 0.0 }).id();

    for _ in 0..2 {
        app.update();
        let world = app.world();
        assert_eq!(world.resource::<Observation>().status.name(), "solved");
        let buoyancy = world.get::<Bath>(bath).map_or(0.0, |b| b.weight * b.area * THICKNESS);
        let force =
            held.and_then(|held| world.get::<BodyExternalForce>(held)).map_or([0.0; 3], |f| f.0);
        println!("held with {:.6} N against a buoyancy of {buoyancy:.6} N", force[1]);
        assert!((force[1] + buoyancy).abs() < 1e-6 * buoyancy, "{force:?} {buoyancy}");
        assert!(force[0].abs() < 1e-6 * buoyancy && buoyancy > 10.0);
    }
}
