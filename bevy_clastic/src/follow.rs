//! `Transform`s that follow bodies, for sprites and meshes of an app of your own.

use bevy::prelude::*;
use clastic::prelude::{BodyPosition, BodyRotation, Particle};

/// Gives every particle a `Transform` and keeps it where the particle is. Insert a sprite or a mesh
/// into the entity of a particle, and it follows.
#[derive(Clone, Copy, Debug)]
pub struct FollowPlugin {
    /// Units of Bevy's space, which are pixels unless a camera scales them, in a metre.
    pub scale: f64,
}

#[derive(Resource)]
struct Scale(f64);

impl Plugin for FollowPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(Scale(self.scale))
            .register_required_components::<Particle, Transform>()
            .register_required_components::<Particle, Visibility>()
            .add_systems(PostUpdate, follow.before(TransformSystems::Propagate));
    }
}

/// The depth z is yours. A body at rest is not touched.
fn follow(
    scale: Res<Scale>,
    mut moved: Query<
        (&BodyPosition, &BodyRotation, &mut Transform),
        Or<(Changed<BodyPosition>, Changed<BodyRotation>)>,
    >,
) {
    for (position, rotation, mut transform) in &mut moved {
        let place = (scale.0 * position.0).as_vec2();
        transform.translation = place.extend(transform.translation.z);
        transform.rotation = Quat::from_rotation_z(rotation.0 as f32);
    }
}
