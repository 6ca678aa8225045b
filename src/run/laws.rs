//! The laws of contacts and bonds that follow from a scene.

use clastic_components::material::{BondLaw, ContactLaw};

use crate::scene::format as scene;

fn compliance(stiffness: Option<f64>) -> f64 {
    stiffness.map_or(0.0, f64::recip)
}

/// Index and density (kg/m^3) of the material of a name; of the first one without such a name.
pub(crate) fn material_of(scene: &scene::Scene, name: Option<&String>) -> (u32, f64) {
    let place = |name: &String| scene.materials.keys().position(|known| known == name);
    let index = name.and_then(place).unwrap_or(0);
    (index as u32, scene.materials.values().nth(index).map_or(0.0, |material| material.density))
}

/// The engine's law for a scene's contact.
pub fn contact_law(contact: &scene::Contact) -> ContactLaw {
    ContactLaw {
        normal_compliance: compliance(contact.normal_stiffness),
        tangential_compliance: compliance(contact.tangential_stiffness),
        rolling_compliance: compliance(contact.rolling_stiffness),
        friction: contact.friction,
        rolling_friction: contact.rolling_friction,
        restitution: contact.restitution,
    }
}

/// The engine's law for a scene's bond.
pub(crate) fn bond_law(bond: &scene::Bond) -> BondLaw {
    BondLaw {
        normal_compliance: compliance(bond.normal_stiffness),
        tangential_compliance: compliance(bond.tangential_stiffness),
        rolling_compliance: compliance(bond.rolling_stiffness),
        friction: bond.friction,
        rolling_friction: bond.rolling_friction,
        cohesion: bond.cohesion,
        tensile_strength: bond.tensile_strength,
    }
}
