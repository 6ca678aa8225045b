//! An app of somebody else: the meshes of the example follow the grains, and the world of the same
//! app is drawn.

#[path = "../../examples/sprites.rs"]
#[expect(dead_code, reason = "the `main` of the example")]
mod sprites;

use std::process::ExitCode;

use bevy::prelude::*;
use bevy_clastic::draw::{DrawPlugin, Look, WatchPlugin, colour};
use clastic::prelude::{BodyPosition, BodyRotation, ClasticProgress, Particle};
use glam::DVec2;

use super::drive::{Steps, drive, on_screen, picture, pixel};

/// That of the example.
const SCALE: f32 = 300.0;

pub fn run() -> ExitCode {
    let mut app = sprites::app();
    app.add_plugins((DrawPlugin { scale: SCALE }, WatchPlugin))
        .insert_resource(Look { disks: false, ..default() });
    let mut steps = Steps::default();
    steps.wait("100 time steps", |world| world.resource::<ClasticProgress>().increment >= 100);
    steps.act("meshes follow", |world| {
        let mut bodies =
            world.query_filtered::<(&BodyPosition, &BodyRotation, &Transform), With<Particle>>();
        let mut turned = 0;
        for (place, angle, transform) in bodies.iter(world) {
            let expected = (f64::from(SCALE) * place.0).as_vec2();
            assert!(transform.translation.truncate().distance(expected) < 1e-3);
            let rotation = Quat::from_rotation_z(angle.0 as f32);
            assert!(transform.rotation.angle_between(rotation) < 1e-3);
            turned += u32::from(angle.0.abs() > 0.1);
        }
        assert!(turned > 5, "{turned} disks have turned");
    });
    steps.wait("the world is drawn", |world| picture(world).frame.increment >= 100);
    steps.shot("own_app");
    steps.act("colour of the floor", |world| {
        // The line lies beyond the edge of the wall.
        let at = on_screen(world, DVec2::new(-1.2, -1.0)) + Vec2::new(0.0, 1.0);
        let expected = Srgba::from(colour("#3c3c3c")).to_u8_array_no_alpha();
        let drawn = pixel(world, "own_app", at);
        let differs = drawn.iter().zip(expected).any(|(a, b)| a.abs_diff(b) > 2);
        assert!(!differs, "the floor is {drawn:?} at {at}, and not {expected:?}");
    });
    drive(app, steps)
}
