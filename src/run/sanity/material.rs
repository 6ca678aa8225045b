//! Properties of the materials that the physical check of a test needs.

use clastic_components::bond::{Bond as BondOfState, BondId, BondState};

use crate::scene::format::{Bond, Scene, Stage};
use crate::scene::specimen_file::StoredSpecimen;

/// Stiffness and strength of the materials of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grains {
    /// Minimum normal stiffness of elastic contacts, N/m; `None` for rigid grains.
    pub stiffness: Option<f64>,
    /// Maximum cohesion or tensile strength of the bonds that the scene makes, Pa; 0 without bonds.
    pub strength: f64,
    /// Out-of-plane thickness, m.
    pub thickness: f64,
}

impl Grains {
    /// The grains of a scene. Bonds of a saved state count with their own strength.
    pub fn of(scene: &Scene, stored: Option<&StoredSpecimen>) -> Self {
        let materials = scene.materials.values();
        let stiffness = materials.clone().filter_map(|m| m.contact.normal_stiffness);
        let strength = |bond: &Bond| bond.cohesion.max(bond.tensile_strength);
        let of_materials = || {
            let bonds = materials.clone().filter_map(|material| material.bond.as_ref());
            bonds.map(strength).fold(0.0, f64::max)
        };
        let cemented = scene.stages.iter().filter_map(|stage| match stage {
            Stage::Cement(cement) => Some(cement.bond.as_ref().map_or_else(of_materials, strength)),
            _ => None,
        });
        let at_start = (!scene.bonds.is_empty()).then(of_materials);
        Self {
            stiffness: stiffness.min_by(f64::total_cmp),
            strength: cemented.chain(at_start).chain(of_state(stored)).fold(0.0, f64::max),
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
    pub(crate) fn are_rock(&self, pressure: Option<f64>) -> bool {
        self.strength > pressure.unwrap_or(0.0)
    }
}

/// Maximum strength of the intact bonds of a saved state, Pa; `None` without a state.
fn of_state(stored: Option<&StoredSpecimen>) -> Option<f64> {
    let world = &stored?.state.as_ref()?.saved.as_ref()?.world;
    let bonds = world.components::<BondId, BondOfState>("bond").ok()?;
    let states = world.components::<BondId, BondState>("bond_state").ok()?;
    let is_intact = |id: &BondId| {
        let at = states.binary_search_by_key(id, |(id, _)| *id);
        at.is_ok_and(|at| states[at].1 == BondState::Intact)
    };
    let bonds = bonds.iter().filter(|(id, _)| is_intact(id));
    Some(bonds.map(|(_, b)| b.law.cohesion.max(b.law.tensile_strength)).fold(0.0, f64::max))
}

/// Inertial number of disks of a mean mass, kg, at a strain rate, 1/s.
pub(super) fn inertial(rate: f64, mass: f64, pressure: f64, thickness: f64) -> Option<f64> {
    (pressure > 0.0).then(|| rate.abs() * (mass / (pressure * thickness)).sqrt())
}
