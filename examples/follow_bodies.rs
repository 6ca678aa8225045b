//! Sprites that follow grains, in an app that draws: one plugin that gives every particle a
//! `Transform` and keeps it where the particle is. Nothing here needs a renderer. In an app with
//! `DefaultPlugins`, insert a `Sprite` or a mesh into the entities of the particles.

use bevy_app::{App, Plugin, PostUpdate};
use bevy_ecs::prelude::*;
use bevy_transform::TransformPlugin;
use bevy_transform::prelude::{GlobalTransform, Transform};
use clastic::prelude::*;
use glam::{DVec2, Quat};

/// Adds a `Transform` to particles, with this number of pixels in a metre.
#[derive(Resource, Clone, Copy)]
struct FollowBodies(f64);

impl Plugin for FollowBodies {
    fn build(&self, app: &mut App) {
        app.insert_resource(*self)
            .register_required_components::<Particle, Transform>()
            .add_systems(PostUpdate, follow.before(bevy_transform::TransformSystems::Propagate));
    }
}

/// A body at rest is not touched, so that `Changed<Transform>` finds what moves.
fn follow(
    scale: Res<FollowBodies>,
    mut moved: Query<
        (&BodyPosition, &BodyRotation, &mut Transform),
        Or<(Changed<BodyPosition>, Changed<BodyRotation>)>,
    >,
) {
    for (position, rotation, mut transform) in &mut moved {
        transform.translation = (scale.0 * position.0).as_vec2().extend(0.0);
        transform.rotation = Quat::from_rotation_z(rotation.0 as f32);
    }
}

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), TransformPlugin, FollowBodies(1.0e3)));
    let gravity = DVec2::new(0.0, -9.81);
    let kind = AnalysisKind::Dynamic { dt: 1.0e-2, theta: 1.0 };
    app.insert_resource(ClasticAnalysis { kind, gravity, ..ClasticAnalysis::default() });
    let disk = Particle::disk(0.1, 2650.0, 1.0);
    let spin = BodyAngularVelocity(1.0);
    let body = app.world_mut().spawn((disk, BodyPosition(DVec2::new(0.5, 1.0)), spin)).id();
    for _ in 0..10 {
        app.update();
    }
    // Implicit Euler falls by g dt^2 (1 + 2 + ... + 10), and the disk turns by 1 rad/s.
    let drawn = app.world().get::<GlobalTransform>(body).map(GlobalTransform::compute_transform);
    let Some(Transform { translation, rotation, .. }) = drawn else { panic!("no transform") };
    println!("{translation} px, {rotation}");
    let y = 1000.0 * (1.0 - 9.81 * 1.0e-4 * 55.0);
    assert!((translation.x - 500.0).abs() < 1e-3 && (translation.y - y).abs() < 1e-2);
    assert!(rotation.angle_between(Quat::from_rotation_z(0.1)) < 1e-3);
}
