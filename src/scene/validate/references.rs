//! References to materials and particles.

use std::fmt::Display;

use crate::scene::suggest;

use super::findings::At;

/// Checks the material of a particle or of a recipe.
pub(super) fn material_of(at: &mut At, material: Option<&str>) {
    let names = &at.context.materials;
    if let Some(name) = material {
        at.material("material", name);
        return;
    }
    // `cuts` checks that minerals leave no particle without a material.
    let by_minerals = !names.is_empty() && !at.context.scene.minerals.is_empty();
    if by_minerals || names.len() == 1 || !at.is_sure_of("materials") {
        return;
    }
    if names.is_empty() {
        at.add("material", "missing material: the scene has none", "add one to `materials`");
    } else {
        let help = format!("name one of {}", suggest::list(names));
        at.add("material", "missing material: the scene has several", help);
    }
}

/// Checks the index of a particle.
pub(super) fn index_exists(at: &mut At, field: impl Display, index: u32) -> bool {
    let particles = at.context.particles;
    let missing = particles.filter(|count| u64::from(index) >= *count);
    if let Some(count) = missing.filter(|_| at.is_sure_of("specimen")) {
        let help = match count {
            0 => "the specimen has no particles".to_owned(),
            _ => format!("the particles are 0 to {}", count - 1),
        };
        at.add(field, format!("no such particle ({index})"), help);
    }
    missing.is_none()
}
