//! Likely mistakes of a scene: values that are possible and seldom meant.

use super::material::Grains;
use super::{OVERLAP, is_specimen};
use crate::run::wall_pieces::pieces;
use crate::scene::format::{Particle, Scene, Specimen, Stage, Strain, WallControl};
use crate::text::shown::label;
use clastic_systems::detect_contacts::grid::pairs_within;
use glam::DVec2;

/// Coefficient of friction above which an angle in degrees was meant: the tangent of 63 degrees.
const TANGENT: f64 = 2.0;
/// Strength times thickness over stiffness, the stretch of a bond at its strength in m/m, of bonds
/// whose two units agree. Rock and sand have 1e-4 to 3e-2, the softest of the scenes that ship 1.
const STRETCH: std::ops::Range<f64> = 1e-6..2.0;
/// Stiffness over pressure and thickness above which a stress in kPa was given as one in Pa. Stresses
/// of 10 Pa on stiff grains have 1e6.
const STIFFEST: f64 = 1e7;
/// Gap of the longest bond that a stage makes, mean radii, above which it joins grains that are no
/// neighbours: a grain fits between two at a gap of two radii.
const LONG: f64 = 2.0;
/// Mean diameter of the grains of a test, m, above which they were given in mm. Those of laboratory
/// tests are below 0.1 m.
const LARGE: f64 = 0.1;

/// Warnings of values that are seldom meant.
pub(super) fn mistakes(
    scene: &Scene,
    grains: &Grains,
    seeds: &[Particle],
    pressure: Option<f64>,
) -> Vec<String> {
    let mut list: Vec<String> = frictions(scene)
        .filter(|(_, friction)| *friction > TANGENT)
        .map(|(path, friction)| {
            format!(
                "{path} is {friction:?}, which looks like degrees: friction is the tangent of its angle, \
                 1 for 45 degrees"
            )
        })
        .collect();
    list.extend(stretch(scene).filter(|(_, of)| !STRETCH.contains(of)).map(|(path, of)| {
        format!(
            "{path}: at its strength a bond stretches by {of:.1e} times the thickness; strengths are in Pa \
             and stiffnesses in N/m"
        )
    }));
    if let Some(level) = grains.level(pressure).filter(|level| *level > STIFFEST) {
        let pressure = pressure.unwrap_or_default();
        list.push(format!(
            "a stress of {pressure:?} Pa is small beside the grains (k/(p h) is {level:.0e}): stresses are \
             in Pa, 100 kPa is 1e5"
        ));
    }
    let mean = 2.0 * seeds.iter().map(|seed| seed.radius).sum::<f64>() / seeds.len().max(1) as f64;
    if is_specimen(scene) && mean > LARGE {
        list.push(format!(
            "the grains of the test are {mean:.2} m in diameter: lengths are in m, 1 mm is 1e-3"
        ));
    }
    list.extend(long_bonds(scene, 0.5 * mean));
    list.extend(overlap(scene, seeds));
    list.extend(loose_sides(scene));
    list.extend(unused_bonds(scene));
    list
}

/// Warning of a material with bonds in a scene that makes none.
fn unused_bonds(scene: &Scene) -> Option<String> {
    let makes = |stage: &Stage| matches!(stage, Stage::Cement(_) | Stage::Custom(_));
    let is_made = !scene.bonds.is_empty()
        || scene.stages.iter().any(makes)
        || matches!(scene.specimen, Specimen::State { .. });
    let (name, _) =
        scene.materials.iter().filter(|_| !is_made).find(|(_, of)| of.bond.is_some())?;
    Some(format!(
        "no bond has the law materials.{}.bond: `bonds` is empty, and no stage `Cement` makes any",
        label(name)
    ))
}

/// The coefficients of friction of a scene with their places.
fn frictions(scene: &Scene) -> impl Iterator<Item = (String, f64)> {
    let materials = scene.materials.iter().map(|(name, of)| {
        (format!("materials.{}", label(name)), of.contact.friction, of.bond.as_ref())
    });
    let walls = scene
        .walls
        .iter()
        .map(|of| (format!("walls.{}", label(&of.name)), of.contact.friction, of.bond.as_ref()));
    let both = materials.chain(walls).flat_map(|(path, contact, bond)| {
        let of_bond = bond.map(|bond| (format!("{path}.bond.friction"), bond.friction));
        std::iter::once((format!("{path}.contact.friction"), contact)).chain(of_bond)
    });
    both.chain(cements(scene).map(|(path, bond)| (format!("{path}.friction"), bond.friction)))
}

/// The laws that stages give to their bonds.
fn cements(scene: &Scene) -> impl Iterator<Item = (String, &crate::scene::format::Bond)> {
    scene.stages.iter().filter_map(|stage| match stage {
        Stage::Cement(of) => Some((format!("stages.{}.bond", label(&of.name)), of.bond.as_ref()?)),
        _ => None,
    })
}

/// Strength times thickness over stiffness of the elastic bonds of a scene.
fn stretch(scene: &Scene) -> impl Iterator<Item = (String, f64)> {
    let of_materials = scene.materials.iter().filter_map(|(name, of)| {
        Some((format!("materials.{}.bond", label(name)), of.bond.as_ref()?))
    });
    of_materials.chain(cements(scene)).filter_map(|(path, bond)| {
        let strength = bond.cohesion.max(bond.tensile_strength);
        let of = strength * scene.thickness / bond.normal_stiffness?;
        (strength > 0.0 && strength.is_finite()).then_some((path, of))
    })
}

/// Warnings of bonds that are far longer than the grains.
fn long_bonds(scene: &Scene, mean: f64) -> Vec<String> {
    let long = |stage: &Stage| {
        let Stage::Cement(of) = stage else { return None };
        let joins = |length: &f64| of.particles && mean > 0.0 && *length > LONG * mean;
        let length = of.length.filter(joins)?;
        Some(format!(
            "stages.{}.length is {length:?} m, {:.1} mean radii: bonds as long as that join grains that are no \
             neighbours; lengths are in m, 1 mm is 1e-3",
            label(&of.name),
            length / mean
        ))
    };
    scene.stages.iter().filter_map(long).collect()
}

/// Warning of disks that overlap at the start by more than linear contacts assume, with each other
/// or with a wall.
fn overlap(scene: &Scene, seeds: &[Particle]) -> Option<String> {
    if matches!(scene.specimen, Specimen::State { .. }) {
        return None;
    }
    let (places, radii): (Vec<DVec2>, Vec<_>) =
        seeds.iter().map(|seed| (DVec2::from(seed.position), seed.radius)).unzip();
    let mut pairs = pairs_within(&places, &radii, 0.0);
    let of_pair = |(a, b): (u32, u32)| {
        let (a, b) = (a as usize, b as usize);
        let gap = places[a].distance(places[b]) - radii[a] - radii[b];
        (-gap / radii[a].min(radii[b]), format!("particle {a} and particle {b}"))
    };
    let all: Vec<_> = scene.walls.iter().filter(|wall| wall.present).collect();
    let of_walls = all.iter().flat_map(|wall| {
        pieces(wall).into_iter().flat_map(move |piece| {
            seeds.iter().enumerate().map(move |(i, seed)| {
                let overlap = 1.0 - piece.distance(seed.position.into()) / seed.radius;
                (overlap, format!("particle {i} and wall {}", label(&wall.name)))
            })
        })
    });
    // Grains of one group may be a rigid body.
    let group = |i: u32| seeds[i as usize].group.as_ref();
    pairs.retain(|(a, b)| group(*a).is_none() || group(*a) != group(*b));
    let all = pairs.into_iter().map(of_pair).chain(of_walls);
    let (most, names) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (most > OVERLAP)
        .then(|| format!("{names} overlap by {:.0} % of a radius at the start", 100.0 * most))
}

/// Warning of a strain that is measured from walls under no load, which do not follow the specimen.
fn loose_sides(scene: &Scene) -> Option<String> {
    let Some(Strain::Walls(a, b)) = scene.strain("lateral_strain") else { return None };
    let stages = scene.stages.iter().take(scene.reference_stage() + 1).filter_map(Stage::load);
    let last = |name: &String| stages.clone().filter_map(|load| load.walls.get(name)).next_back();
    let is_loose = |name: &&String| {
        let control = last(name);
        matches!(control, Some(WallControl::Force(p) | WallControl::Stress { stress: p, .. }) if *p == 0.0)
    };
    let wall = [a, b].into_iter().find(is_loose)?;
    Some(format!(
        "`lateral_strain` is measured from wall {}, which carries no load and does not follow the \
         specimen; measure `Strain(Region(...))`, or take the wall away",
        label(wall)
    ))
}
