//! Stiffness of bonds and contacts of a scene.

use crate::scene::format::{Bond, Contact, Scene};

/// Maximum normal stiffness of the contacts and bonds of a scene, N/m; 0 if none is elastic.
pub fn maximum(scene: &Scene) -> f64 {
    let of_walls = scene.walls.iter().map(|wall| (&wall.contact, wall.bond.as_ref()));
    let of_materials = scene.materials.values().map(|m| (&m.contact, m.bond.as_ref()));
    of_walls
        .chain(of_materials)
        .flat_map(|(contact, bond)| {
            [contact.normal_stiffness, bond.and_then(|bond| bond.normal_stiffness)]
        })
        .flatten()
        .fold(0.0, f64::max)
}

/// Whether nothing in a scene is elastic.
pub fn is_rigid(scene: &Scene) -> bool {
    let rigid = |c: &Contact| {
        [c.normal_stiffness, c.tangential_stiffness, c.rolling_stiffness] == [None; 3]
    };
    let rigid_bond = |bond: Option<&Bond>| {
        bond.is_none_or(|b| {
            [b.normal_stiffness, b.tangential_stiffness, b.rolling_stiffness] == [None; 3]
        })
    };
    scene.walls.iter().all(|wall| rigid(&wall.contact) && rigid_bond(wall.bond.as_ref()))
        && scene.materials.values().all(|m| rigid(&m.contact) && rigid_bond(m.bond.as_ref()))
}
