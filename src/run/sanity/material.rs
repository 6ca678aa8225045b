//! What the sanity of a test needs to know of its materials.

use crate::scene::format::Scene;

/// Stiffness and strength of the materials of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grains {
    /// Minimum normal stiffness of elastic contacts, N/m; `None` for rigid grains.
    pub stiffness: Option<f64>,
    /// Maximum cohesion or tensile strength of the bonds, Pa; 0 without bonds.
    pub strength: f64,
    /// Out-of-plane thickness, m.
    pub thickness: f64,
}

impl Grains {
    pub fn of(scene: &Scene) -> Self {
        let materials = scene.materials.values();
        let stiffness = materials.clone().filter_map(|m| m.contact.normal_stiffness);
        let bonds = materials.filter_map(|m| m.bond.as_ref());
        Self {
            stiffness: stiffness.min_by(f64::total_cmp),
            strength: bonds.map(|b| b.cohesion.max(b.tensile_strength)).fold(0.0, f64::max),
            thickness: scene.thickness,
        }
    }

    /// Stiffness level k/(p h) at a pressure.
    pub fn level(&self, pressure: Option<f64>) -> Option<f64> {
        let pressure = pressure.filter(|pressure| *pressure > 0.0)?;
        Some(self.stiffness? / (pressure * self.thickness))
    }

    /// Strain of an increment over the elastic strain at a pressure.
    pub fn steps(&self, strain: Option<f64>, pressure: Option<f64>) -> Option<f64> {
        let stress = pressure.unwrap_or(0.0).max(self.strength);
        let strain = strain.filter(|_| stress > 0.0)?;
        Some(strain.abs() * self.stiffness? / (stress * self.thickness))
    }

    /// Whether bonds are stronger than the confining stress.
    pub fn are_rock(&self, pressure: Option<f64>) -> bool {
        self.strength > pressure.unwrap_or(0.0)
    }
}

/// Inertial number of disks of a mean mass, kg, at a strain rate, 1/s.
pub(super) fn inertial(rate: f64, mass: f64, pressure: f64, thickness: f64) -> Option<f64> {
    (pressure > 0.0).then(|| rate.abs() * (mass / (pressure * thickness)).sqrt())
}
