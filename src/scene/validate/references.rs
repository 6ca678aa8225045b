//! Names of parts of the scene, and references to them.

use std::collections::BTreeMap;
use std::fmt::Display;

use crate::scene::suggest;

use super::findings::At;

impl At<'_, '_> {
    /// Checks a reference to a named part of the scene. `topic` is the field that defines such
    /// parts.
    pub fn reference(
        &mut self,
        field: impl Display,
        name: &str,
        (kind, topic): (&str, &str),
        names: &[&str],
    ) -> bool {
        let known = names.contains(&name);
        if !known && self.is_sure_of(topic) {
            let help = suggest::help(name, names, &format!("{kind}s"));
            self.add(field, format!("unknown {kind} (`{name}`)"), help);
        }
        known
    }

    pub fn material(&mut self, field: impl Display, name: &str) -> bool {
        let names = &self.context.materials;
        self.reference(field, name, ("material", "materials"), names)
    }

    pub fn wall(&mut self, field: impl Display, name: &str) -> bool {
        let names = &self.context.walls;
        self.reference(field, name, ("wall", "walls"), names)
    }

    /// Checks two references to different parts.
    pub fn pair<T: PartialEq>(&mut self, field: impl Display, (a, b): (T, T), kind: &str) {
        if a == b {
            self.add(field, format!("a {kind} given twice"), format!("name two {kind}s"));
        }
    }

    /// Checks that names are not empty and are unique.
    pub fn unique<'n>(&mut self, kind: &str, names: impl IntoIterator<Item = (String, &'n str)>) {
        let mut seen: BTreeMap<&str, String> = BTreeMap::new();
        for (path, name) in names {
            if name.trim().is_empty() {
                self.add(path, format!("empty {kind}"), "give a name");
            } else if let Some(first) = seen.get(name) {
                let message = format!("{kind} given twice (`{name}`)");
                self.add(path, message, format!("it is also that of {first}"));
            } else {
                seen.insert(name, path);
            }
        }
    }
}

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
