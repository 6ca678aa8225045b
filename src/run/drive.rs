//! The drive of a degree of freedom that follows from the motion of a scene.

use clastic_components::body::BodyDrive;
use clastic_components::increment::ClasticAnalysis;

use crate::scene::format as scene;

/// The drive of a motion in a stage with this analysis.
pub(super) fn drive(motion: scene::Motion, analysis: &ClasticAnalysis) -> BodyDrive {
    match motion {
        scene::Motion::Free => BodyDrive::Free,
        scene::Motion::Held => BodyDrive::Imposed(0.0),
        scene::Motion::Displacement(u) => BodyDrive::Imposed(u),
        scene::Motion::Velocity(v) => BodyDrive::Imposed(v * analysis.kind.dt().unwrap_or(0.0)),
    }
}
