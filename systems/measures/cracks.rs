//! Cracks: the length and direction that broken bonds leave.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use super::principal::axis;

/// Adds the bonds that broke in the increment.
pub(crate) fn follow_cracks(
    bodies: Res<BodyTable>,
    observation: Res<Observation>,
    sums: Option<ResMut<CrackSums>>,
) {
    let Some(mut sums) = sums else { return };
    for rupture in &observation.ruptures {
        // A wall has no radius; the bond is as wide as the particle.
        let radius = |id| bodies.row(id).and_then(|row| bodies.radii.get(row)).copied();
        let radii = [rupture.a, rupture.b].map(radius);
        let Some(radius) = radii.into_iter().flatten().reduce(f64::min) else { continue };
        let (length, along) = (2.0 * radius, rupture.normal.perp());
        let sum = &mut sums.0[rupture.mode as usize];
        sum.length += length;
        sum.doubled +=
            length * DVec2::new(along.x * along.x - along.y * along.y, 2.0 * along.x * along.y);
    }
}

/// A reading of the sums; directions are not defined without cracks.
pub fn read(sums: &CrackSums, modes: Modes, part: CrackPart) -> Option<f64> {
    let all = |a: CrackSum, b: CrackSum| CrackSum {
        length: a.length + b.length,
        doubled: a.doubled + b.doubled,
    };
    let sum = sums.0[modes.places()].iter().copied().reduce(all).unwrap_or_default();
    let alignment = (sum.length > 0.0).then(|| sum.doubled.length() / sum.length);
    match part {
        CrackPart::Length => Some(sum.length),
        CrackPart::Alignment => alignment,
        // Below round-off there is no preferred direction.
        CrackPart::Direction => {
            alignment.filter(|a| *a > 1e-12).map(|_| axis(sum.doubled.x, sum.doubled.y))
        }
    }
}
