//! A measure of one's own: the coordination number, as a resource that follows every increment.
//!
//! Four disks in a square, pressed together by two lids, have two contacts each with their
//! neighbours: Z = 2, walls not counted.

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

/// Mean number of contacts with pressure that a particle has with other particles.
#[derive(Resource, Default)]
struct Coordination(f64);

fn measure(
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    solution: Res<ConeSolution>,
    mut coordination: ResMut<Coordination>,
) {
    let loaded =
        contacts.0.iter().zip(&solution.forces).filter(|(contact, force)| {
            (contact.b as usize) < bodies.particles && force[0] > 1.0e-6
        });
    coordination.0 = 2.0 * loaded.count() as f64 / bodies.particles as f64;
}

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    app.init_resource::<Coordination>();
    app.add_systems(Increment, measure.after(IncrementSystems::Record));

    let law = ContactLaw { normal_compliance: 1.0e-6, ..Default::default() };
    let mut materials = material::Materials::default();
    materials.0.push(material::Material { contact: law, ..Default::default() });
    app.insert_resource(materials);
    let world = app.world_mut();
    for (x, y) in [(1.0, 1.0), (3.0, 1.0), (1.0, 3.0), (3.0, 3.0)] {
        world.spawn((Particle::disk(1.0, 2650.0, 1.0), BodyPosition(DVec2::new(x, y))));
    }
    // The material lies on the left of the way from the start of a wall to its end.
    for (tangent, x, y, push) in [
        (DVec2::X, 2.0, 0.0, DVec2::ZERO),
        (DVec2::NEG_Y, 0.0, 2.0, DVec2::ZERO),
        (DVec2::NEG_X, 2.0, 4.0, DVec2::new(0.0, -1.0e-4)),
        (DVec2::Y, 4.0, 2.0, DVec2::new(-1.0e-4, 0.0)),
    ] {
        let wall = Wall { tangent, half_length: 2.0 };
        let place = BodyPosition(DVec2::new(x, y));
        world.spawn((wall, law, place, WallControl::Displacement(push)));
    }
    app.update();
    let Coordination(z) = *app.world().resource::<Coordination>();
    println!("coordination number {z}");
    assert_eq!(z, 2.0);
}
