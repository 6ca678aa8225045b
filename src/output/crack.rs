//! A broken bond as it is drawn: a stroke across the contact.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::bond::RuptureMode;

/// A broken bond. The stroke lies half-way between the two surfaces, at a right angle to the line
/// that joins the bodies, and is as long as the bond was wide: twice the smaller radius, which is
/// the section that its strength counts (formulation, section 3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Crack {
    /// Ends of the stroke, m.
    pub ends: [DVec2; 2],
    /// Limit at which the bond broke.
    pub mode: RuptureMode,
}

impl Crack {
    /// The crack between two disks (centre in m, radius in m).
    #[must_use]
    pub fn between_disks(a: (DVec2, f64), b: (DVec2, f64), mode: RuptureMode) -> Self {
        let normal = (b.0 - a.0).normalize_or(DVec2::X);
        let middle = 0.5 * ((a.0 + a.1 * normal) + (b.0 - b.1 * normal));
        Self::across(middle, normal, a.1.min(b.1), mode)
    }

    /// The crack between a disk and the point of a wall that is nearest to its centre, m.
    #[must_use]
    pub fn at_wall(disk: (DVec2, f64), foot: DVec2, mode: RuptureMode) -> Self {
        let normal = (foot - disk.0).normalize_or(DVec2::X);
        Self::across(0.5 * (disk.0 + disk.1 * normal + foot), normal, disk.1, mode)
    }

    fn across(middle: DVec2, normal: DVec2, half: f64, mode: RuptureMode) -> Self {
        let along = half * normal.perp();
        Self { ends: [middle - along, middle + along], mode }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crack_lies_across_its_contact_and_is_as_long_as_the_bond_is_wide() {
        let disk = (DVec2::ZERO, 1.0);
        let crack = Crack::between_disks(disk, (DVec2::new(3.5, 0.0), 2.0), RuptureMode::Shear);
        assert_eq!(crack.ends, [DVec2::new(1.25, -1.0), DVec2::new(1.25, 1.0)]);
        let crack = Crack::at_wall(disk, DVec2::new(0.0, -1.5), RuptureMode::Tension);
        assert_eq!(crack.ends, [DVec2::new(-1.0, -1.25), DVec2::new(1.0, -1.25)]);
    }
}
