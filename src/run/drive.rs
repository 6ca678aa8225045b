//! The drive of a degree of freedom that follows from the motion of a scene.

use clastic_components::body::Drive;
use clastic_components::increment::{Analysis, AnalysisKind};

use crate::scene::format as scene;

/// The drive of a motion in a stage with this analysis.
pub(super) fn drive(motion: scene::Motion, analysis: &Analysis) -> Drive {
    let dt = match analysis.kind {
        AnalysisKind::Dynamic { dt, .. } => dt,
        AnalysisKind::Static | AnalysisKind::Compaction { .. } => 0.0,
    };
    match motion {
        scene::Motion::Free => Drive::Free,
        scene::Motion::Held => Drive::Imposed(0.0),
        scene::Motion::Displacement(u) => Drive::Imposed(u),
        scene::Motion::Velocity(v) => Drive::Imposed(v * dt),
    }
}
