//! References to named parts of the scene, and checks that stages and controls share.

use std::collections::BTreeMap;
use std::fmt::Display;

use crate::scene::format::{Motion, Wall, WallShape};
use crate::text::suggest;

use super::findings::At;
use super::places::{are_alike, are_askew, are_opposite, distance, length};

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
        self.refuse(a == b, field, format!("a {kind} given twice"), format!("name two {kind}s"));
    }

    /// Checks the names of the items of a list, if all are known.
    pub fn names(&mut self, list: &str, kind: &str, names: &[&str]) {
        if self.is_sure_of(list) {
            let paths = (0..names.len()).map(|i| format!("{list}[{i}].name"));
            self.unique(kind, paths.zip(names.iter().copied()));
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

/// Checks a wall that a stage needs. Returns the wall if it exists.
pub(super) fn wall_there<'a>(
    at: &mut At<'_, 'a>,
    field: impl Display,
    name: &str,
) -> Option<&'a Wall> {
    if !at.wall(&field, name) {
        return None;
    }
    if at.is_there(name) == Some(true) {
        return at.context.wall(name);
    }
    let message = format!("wall `{name}` is not there in this stage");
    at.refuse(at.are_sure_of(&["stages", "walls"]), field, message, "bring it in with `add_walls`");
    None
}

/// Checks that a wall, if it exists, is straight.
pub(super) fn straight(at: &mut At, field: impl Display, wall: Option<&Wall>, help: &str) {
    if let Some(wall) = wall.filter(|wall| !wall.shape.is_straight()) {
        at.add(field, format!("wall `{}` is not straight", wall.name), help);
    }
}

/// Help where a control needs a wall of one piece.
pub(super) const ONE_PIECE: &str = "name a wall of one piece";

/// Checks a wall that a control or a measure needs as one straight or curved piece. `what` completes
/// "has no one ...".
pub(super) fn one_piece(at: &mut At, field: impl Display, name: &str, (what, help): (&str, &str)) {
    let wall = at.context.wall(name);
    if wall.is_some_and(|wall| matches!(wall.shape, WallShape::Polyline(_))) {
        let message = format!("wall `{name}` is a polyline, which has no one {what}");
        at.add(field, message, help);
    }
}

/// Refuses two walls, if they exist and are straight, that lie to each other as they should not. `wrong` completes
/// "wall A ... wall B".
fn lie(
    at: &mut At,
    field: &str,
    (a, b): (&str, &str),
    is_wrong: fn(&Wall, &Wall) -> bool,
    (wrong, help): (&str, &str),
) {
    let find = |name: &str| {
        let wall = at.context.wall(name);
        wall.filter(|wall| wall.shape.is_straight() && length(wall) > 0.0)
    };
    let is_wrong = find(a).zip(find(b)).is_some_and(|(a, b)| is_wrong(a, b));
    let message = format!("wall `{a}` {wrong} wall `{b}`");
    at.refuse(is_wrong && at.is_sure_of("walls"), field, message, help);
}

/// Checks that a strain is not that between two walls of which one is drawn from its end to its start:
/// a wall that comes at the outermost particles would come from the other side.
pub(super) fn towards_each_other(at: &mut At, walls: (&str, &str)) {
    if !at.are_sound(&["walls", "specimen"]) {
        return;
    }
    let alike = |a: &Wall, b: &Wall| a.name != b.name && are_alike(a, b);
    let help = "exchange start and end of one of them";
    lie(at, "", walls, alike, ("has its inside on the same side as", help));
    let apart = |a: &Wall, b: &Wall| {
        !a.is_placed() && !b.is_placed() && are_opposite(a, b) && distance(a, b) < 0.0
    };
    lie(at, "", walls, apart, ("has its outside towards", "exchange start and end of both"));
}

/// Checks that two walls are parallel, with their insides towards each other.
pub(super) fn face(at: &mut At, field: &str, walls: (&str, &str)) {
    let help = "the two walls must be parallel, with their insides towards each other";
    lie(at, field, walls, |a, b| !are_opposite(a, b), ("does not face", help));
}

/// Checks that two walls have a distance that is the size of something between them.
pub(super) fn are_apart(at: &mut At, field: &str, walls: (&str, &str)) {
    let help = "name two walls on opposite sides, as left and right";
    lie(at, field, walls, are_askew, ("does not lie opposite", help));
}

/// Checks that a wall is at an end of another one, along which a length is measured.
pub(super) fn bounds(at: &mut At, field: &str, walls: (&str, &str)) {
    let help = "name two walls at its ends, as left and right of a lid";
    lie(at, field, walls, |a, b| !are_askew(a, b), ("is at no end of", help));
}

/// Finds a control by time in a stage that has none. `instead` is one by increments.
pub(super) fn needs_time(at: &mut At, field: &str, what: &str, instead: &str) {
    let message = format!("{what} in a static stage, which has no time");
    let help = format!("use `{instead}`, in every increment, or a dynamic analysis");
    at.refuse(at.is_timeless(), field, message, help);
}

/// Checks the motion along one degree of freedom, whose unit is m or rad.
pub(super) fn motion(at: &mut At, field: &str, motion: Motion, unit: &str) {
    let number = format_args!("{field}[0]");
    match motion {
        Motion::Free | Motion::Held => {}
        Motion::Displacement(value) => {
            at.finite(number, value, &format!("a displacement in {unit}"));
        }
        Motion::Velocity(value) => {
            at.finite(number, value, &format!("a velocity in {unit}/s"));
            needs_time(at, field, "a velocity", "Displacement");
        }
    }
}

pub(super) fn load(at: &mut At, force: Option<(f64, f64)>, moment: Option<f64>) {
    at.vector("force", force, "a force in N");
    at.finite("moment", moment, "a moment in N m");
}

/// Checks the name of something that is to go and must be there, as `known` are.
pub(super) fn is_known<'n>(
    at: &mut At,
    name: &str,
    known: impl Iterator<Item = &'n str>,
    kind: &str,
) {
    let known: Vec<&str> = known.collect();
    if !known.contains(&name) && at.is_sure_of("stages") {
        let help = suggest::help(name, &known, &format!("{kind}s"));
        at.add("", format!("no {kind} `{name}`"), help);
    }
}
