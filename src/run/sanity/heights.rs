//! Heights at which compactions end, so that later stages know where the specimen is.

use std::cell::LazyCell;

use crate::run::disks::Disks;
use crate::run::minerals::specimen;
use crate::scene::format::{Compact, CompactBy, CompactTarget, Scene, Stage};
use crate::scene::specimen_file::StoredSpecimen;
use crate::text::shown::label;

/// Of every compaction by a wall to a porosity, the distance of wall and base at its end,
/// A/((1 - n) L) with the area A of the disks and the length L of the base, in a line each.
pub fn heights(scene: &Scene, stored: Option<&StoredSpecimen>) -> Vec<String> {
    let radii = || specimen(scene, stored).into_iter().map(|seed| seed.radius);
    let area = LazyCell::new(|| Disks::of(radii()).area);
    let mut lines = Vec::new();
    for stage in &scene.stages {
        let Stage::Compact(Compact { name, wall, base, target, by: CompactBy::Boundary, .. }) =
            stage
        else {
            // The disks that later compactions have are not known.
            if matches!(stage, Stage::Remove(_) | Stage::Pour(_)) {
                break;
            }
            continue;
        };
        let &CompactTarget::Porosity(porosity) = target else { continue };
        let Some(base) = scene.walls.iter().find(|of| of.name == *base) else { continue };
        let length = (base.end.0 - base.start.0).hypot(base.end.1 - base.start.1);
        lines.push(format!(
            "stage {} ends with {} {:.4e} m from {}",
            label(name),
            label(wall),
            *area / ((1.0 - porosity) * length),
            label(&base.name)
        ));
    }
    lines
}
