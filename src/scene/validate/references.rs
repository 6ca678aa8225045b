//! References to materials and particles.

use std::fmt::Arguments;

use crate::scene::suggest;

use super::findings::Findings;

/// Checks the material of a particle or of a recipe.
pub(super) fn material_of(path: Arguments, material: Option<&str>, findings: &mut Findings) {
    let names = &findings.context.materials;
    let minerals = &findings.context.scene.minerals;
    match material {
        Some(name) => {
            let path = format_args!("{path}.material");
            findings.reference(path, name, ("material", "materials"), names);
        }
        // `cuts` checks that minerals leave no particle without a material.
        None if !names.is_empty() && !minerals.is_empty() => {}
        None if names.len() != 1 && findings.is_sure_of("materials") => {
            let (message, help) = match names.len() {
                0 => ("missing material: the scene has none", "add one to `materials`".to_owned()),
                _ => {
                    let help = format!("name one of {}", suggest::list(names));
                    ("missing material: the scene has several", help)
                }
            };
            findings.add(format_args!("{path}.material"), message, &help);
        }
        None => {}
    }
}

/// Checks the index of a particle.
pub(super) fn index_exists(path: Arguments, index: u32, findings: &mut Findings) -> bool {
    let exists = findings.context.particles.is_none_or(|count| u64::from(index) < count);
    if !exists && findings.is_sure_of("specimen") {
        let count = findings.context.particles.unwrap_or_default();
        let help = match count {
            0 => "the specimen has no particles".to_owned(),
            _ => format!("the particles are 0 to {}", count - 1),
        };
        findings.add(path, format!("no such particle ({index})"), &help);
    }
    exists
}
