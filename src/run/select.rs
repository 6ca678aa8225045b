//! The particles of a selection.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use super::cores::cores;
use super::script::Script;
use crate::scene::format::Select;

/// Data of a particle on which selections depend.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<'a> {
    /// Index in the specimen.
    pub index: u32,
    /// Centre, m.
    pub place: DVec2,
    /// Name of the material.
    pub material: Option<&'a str>,
    /// Group that the specimen gives it.
    pub group: Option<&'a str>,
    /// Name of its probe.
    pub probe: Option<&'a str>,
    /// How well contacts hold it: its core number, `u32::MAX` where that is not asked for.
    pub core: u32,
}

/// Whether a selection has a particle. `groups` are those of the scene.
pub fn selects(select: &Select, groups: &BTreeMap<String, Select>, of: &Candidate) -> bool {
    let has = |select: &Select| selects(select, groups, of);
    match select {
        Select::All => true,
        Select::Index(list) => list.contains(&of.index),
        Select::Range(first, last) => (*first..=*last).contains(&of.index),
        Select::Material(name) => of.material == Some(name),
        Select::Group(name) => match groups.get(name) {
            Some(select) => has(select),
            None => of.group == Some(name),
        },
        Select::Probe(name) => of.probe == Some(name),
        Select::Box { min, max } => {
            let x = of.place;
            x.x >= min.0 && x.y >= min.1 && x.x <= max.0 && x.y <= max.1
        }
        Select::Circle { centre, radius } => of.place.distance(DVec2::from(*centre)) <= *radius,
        Select::Layer { normal, from, to } => {
            let height = of.place.dot(DVec2::from(*normal).normalize_or_zero());
            (*from..=*to).contains(&height)
        }
        Select::Polygon(corners) => is_inside(corners, of.place),
        Select::Loose(contacts) => of.core < *contacts,
        Select::Union(list) => list.iter().any(has),
        Select::Intersection(list) => list.iter().all(has),
        Select::Except(from, without) => has(from) && !has(without),
    }
}

/// Whether a point is inside a polygon: a ray along x crosses an odd number of sides.
fn is_inside(corners: &[(f64, f64)], x: DVec2) -> bool {
    let next = corners.iter().cycle().skip(1);
    let crosses = |(a, b): &(&(f64, f64), &(f64, f64))| {
        (a.1 > x.y) != (b.1 > x.y) && x.x < a.0 + (b.0 - a.0) * (x.y - a.1) / (b.1 - a.1)
    };
    corners.iter().zip(next).filter(crosses).count() % 2 == 1
}

/// Whether a selection depends on the forces of contacts. A world without a scene has no groups.
pub(super) fn needs_forces(world: &World, select: &Select) -> bool {
    let script = world.get_resource::<Script>();
    select.needs_forces(script.map_or(&BTreeMap::new(), |script| &script.scene.groups))
}

/// The particles of a world that a selection has, by entity.
pub fn selected(world: &mut World, select: &Select) -> Vec<(BodyId, Entity)> {
    selected_at(world, select, |place| place)
}

/// The same if every particle were at another place.
pub(super) fn selected_at(
    world: &mut World,
    select: &Select,
    place: impl Fn(DVec2) -> DVec2,
) -> Vec<(BodyId, Entity)> {
    let mut particles = world.query_filtered::<(
        Entity,
        &BodyId,
        &BodyPosition,
        &MaterialIndex,
        Option<&Group>,
        Option<&Probe>,
    ), With<Particle>>();
    // Few selections ask how well particles are held.
    let cores = if needs_forces(world, select) { cores(world) } else { BTreeMap::new() };
    // A world whose stages are those of a program has no groups.
    let empty = BTreeMap::new();
    let groups = world.get_resource::<Script>().map_or(&empty, |script| &script.scene.groups);
    let materials = world.get_resource::<Materials>();
    let rows = particles.iter(world).filter(|(_, id, x, material, group, probe)| {
        let of = Candidate {
            index: id.0,
            place: place(x.0),
            material: materials
                .and_then(|all| all.0.get(material.0 as usize))
                .map(|material| material.name.as_str()),
            group: group.map(|group| group.0.as_str()),
            probe: probe.map(|probe| probe.0.as_str()),
            core: cores.get(id).copied().unwrap_or(u32::MAX),
        };
        selects(select, groups, &of)
    });
    let mut found: Vec<_> = rows.map(|(entity, id, ..)| (*id, entity)).collect();
    found.sort_unstable_by_key(|(id, _)| *id);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_and_sets_of_them() {
        let at = |x: f64, y: f64| Candidate {
            index: 3,
            place: DVec2::new(x, y),
            material: Some("sand"),
            group: Some("low"),
            probe: None,
            core: 2,
        };
        let groups = BTreeMap::from([(
            "disk".to_owned(),
            Select::Circle { centre: (0.0, 0.0), radius: 1.0 },
        )]);
        let has = |select: &Select, x: f64, y: f64| selects(select, &groups, &at(x, y));
        let ell = Select::Polygon(vec![
            (0.0, 0.0),
            (2.0, 0.0),
            (2.0, 1.0),
            (1.0, 1.0),
            (1.0, 2.0),
            (0.0, 2.0),
        ]);
        assert!(has(&ell, 0.5, 1.5) && has(&ell, 1.5, 0.5) && !has(&ell, 1.5, 1.5));
        let disk = Select::Group("disk".to_owned());
        assert!(has(&disk, 0.6, 0.6) && !has(&disk, 0.8, 0.8));
        assert!(has(&Select::Group("low".to_owned()), 0.0, 0.0));
        assert!(has(&Select::Except(Box::new(ell.clone()), Box::new(disk.clone())), 1.5, 0.5));
        assert!(!has(&Select::Except(Box::new(ell.clone()), Box::new(disk.clone())), 0.5, 0.5));
        assert!(has(&Select::Union(vec![ell.clone(), disk.clone()]), -0.5, 0.0));
        assert!(!has(&Select::Intersection(vec![ell, disk]), -0.5, 0.0));
        let layer = Select::Layer { normal: (0.0, 2.0), from: 0.1, to: 0.2 };
        assert!(has(&layer, 9.0, 0.15) && !has(&layer, 9.0, 0.3));
        assert!(has(&Select::Range(1, 3), 0.0, 0.0) && !has(&Select::Range(4, 9), 0.0, 0.0));
        assert!(has(&Select::Material("sand".to_owned()), 0.0, 0.0));
        assert!(has(&Select::Loose(3), 0.0, 0.0) && !has(&Select::Loose(2), 0.0, 0.0));
    }
}
