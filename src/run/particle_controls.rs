//! Controls of particles in a loading stage.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use super::select::selected;
use crate::scene::format as scene;

/// Sets drives and loads of the particles for a loading stage. Drives end with their stage. Loads
/// keep their last values.
pub(super) fn set(world: &mut World, stage: &scene::Load, analysis: &ClasticAnalysis) {
    let mut particles =
        world.query_filtered::<(&mut BodyDrives, &mut LoadControl), With<Particle>>();
    for (mut drives, mut loads) in particles.iter_mut(world) {
        drives.0 = [BodyDrive::Free; 3];
        for load in &mut loads.0 {
            load.0 = load.1;
        }
    }
    let mut particles = world.query::<(&BodyPosition, &mut BodyDrives, &mut LoadControl)>();
    for control in &stage.particles {
        for (_, entity) in selected(world, &control.select) {
            let Ok((x, mut drives, mut loads)) = particles.get_mut(world, entity) else { continue };
            for (k, motion) in [control.x, control.y, control.rotation].into_iter().enumerate() {
                if motion != scene::Motion::Free {
                    drives.0[k] = drive(motion, analysis);
                }
            }
            if let Some(((xx, xy), (yx, yy))) = control.affine {
                drives.0[0] = BodyDrive::Imposed(xx * x.0.x + xy * x.0.y);
                drives.0[1] = BodyDrive::Imposed(yx * x.0.x + yy * x.0.y);
            }
            if let Some((fx, fy)) = control.force {
                loads.0[0].1 = fx;
                loads.0[1].1 = fy;
            }
            if let Some(moment) = control.moment {
                loads.0[2].1 = moment;
            }
            if let Some(remains) = control.remains {
                loads.0 = loads.0.map(|(from, _)| (from, remains * from));
            }
        }
    }
}

/// The drive of a motion in a stage with this analysis.
pub(super) fn drive(motion: scene::Motion, analysis: &ClasticAnalysis) -> BodyDrive {
    match motion {
        scene::Motion::Free => BodyDrive::Free,
        scene::Motion::Held => BodyDrive::Imposed(0.0),
        scene::Motion::Displacement(u) => BodyDrive::Imposed(u),
        scene::Motion::Velocity(v) => BodyDrive::Imposed(v * analysis.kind.dt().unwrap_or(0.0)),
    }
}
