//! Estimates before a run, from what the scene imposes.

use std::f64::consts::PI;

use crate::run::minerals::specimen;
use crate::run::particles::ParticleSeed;
use crate::scene::format::{
    Analysis, CellStrain, CellTarget, CompactBy, CompactTarget, LidLoad, Load, Scene, Specimen,
    Stage, Strain, Table, Wall, WallControl,
};
use crate::scene::specimen_file::StoredSpecimen;

use super::material::{Grains, inertial};
use super::{Report, is_specimen};

/// What the scene imposes says of the ratios.
#[must_use]
pub fn before(scene: &Scene, stored: Option<&StoredSpecimen>) -> Report {
    let grains = Grains::of(scene);
    let seeds = specimen(scene, stored);
    let loads = scene.stages.iter().filter_map(Stage::load);
    let pressure = loads.filter_map(confining).max_by(f64::total_cmp);
    let is_test = scene.measures.axial_strain.is_some() && scene.measures.axial_stress.is_some();
    let reference = scene.stages.get(scene.reference_stage()).and_then(Stage::load);
    let reference = reference.filter(|_| is_test);
    let analysis = |load: &Load| load.analysis.unwrap_or(scene.analysis);
    let strain = reference.and_then(|load| Some((load, imposed_strain(scene, load)?)));
    let increment = strain
        .filter(|(load, _)| matches!(analysis(load), Analysis::Static))
        .map(|(_, strain)| strain);
    let number = strain.and_then(|(load, strain)| match analysis(load) {
        Analysis::Dynamic { dt, .. } => {
            inertial(strain / dt, mean_mass(scene, &seeds)?, pressure?, scene.thickness)
        }
        Analysis::Static => None,
    });
    Report {
        stiffness_over_pressure: grains.level(pressure).filter(|_| is_test),
        inertial_number: number,
        increment_over_elastic_strain: grains.steps(increment, pressure),
        disks_across: across(scene, &seeds).filter(|_| is_specimen(scene)),
        ..Report::default()
    }
    .with_warnings(grains.strength > 0.0, grains.are_rock(pressure))
}

/// The smallest stress above 0 that a stage imposes, Pa.
fn confining(load: &Load) -> Option<f64> {
    let walls = load.walls.values().filter_map(|control| match control {
        WallControl::Stress { stress, .. }
        | WallControl::Lid { load: LidLoad::Stress { stress, .. }, .. } => Some(*stress),
        WallControl::Follow(Table::Stress { stress, .. }) => {
            stress.iter().map(|(_, stress)| *stress).max_by(f64::total_cmp)
        }
        _ => None,
    });
    let cell = load.cell.iter().flat_map(|cell| [cell.xx, cell.yy]).filter_map(|of| match of {
        Some(CellTarget::Stress(stress)) => Some(stress),
        _ => None,
    });
    let membranes = load.membranes.values().map(|membrane| membrane.pressure);
    walls.chain(cell).chain(membranes).filter(|stress| *stress > 0.0).min_by(f64::total_cmp)
}

/// Axial strain that a stage imposes in an increment; `None` where it is not imposed by a constant
/// motion of the walls, or of the cell, from which it is measured.
fn imposed_strain(scene: &Scene, load: &Load) -> Option<f64> {
    match scene.measures.axial_strain.as_ref()? {
        Strain::Walls(a, b) => {
            let [a, b] = [a, b].map(|name| scene.walls.iter().find(|wall| wall.name == *name));
            let (a, b) = (a?, b?);
            let along = (a.end.0 - a.start.0, a.end.1 - a.start.1);
            let length = along.0.hypot(along.1);
            let normal = (-along.1 / length, along.0 / length);
            let dot = |v: (f64, f64)| v.0 * normal.0 + v.1 * normal.1;
            let middle = |wall: &Wall| {
                (0.5 * (wall.start.0 + wall.end.0), 0.5 * (wall.start.1 + wall.end.1))
            };
            let (at_a, at_b) = (middle(a), middle(b));
            let distance = dot((at_b.0 - at_a.0, at_b.1 - at_a.1)).abs();
            let dt = match load.analysis.unwrap_or(scene.analysis) {
                Analysis::Dynamic { dt, .. } => dt,
                Analysis::Static => 0.0,
            };
            let motion = |name: &String| match load.walls.get(name) {
                Some(WallControl::Displacement(x, y)) => dot((*x, *y)),
                Some(WallControl::Velocity(x, y)) => dt * dot((*x, *y)),
                _ => 0.0,
            };
            let strain = (motion(&a.name) - motion(&b.name)).abs() / distance;
            (strain > 0.0 && strain.is_finite()).then_some(strain)
        }
        Strain::Cell(of) => {
            let cell = load.cell.as_ref()?;
            let component = match of {
                CellStrain::Width => cell.xx,
                CellStrain::Height => cell.yy,
                CellStrain::Shear => cell.shear,
            };
            match component {
                Some(CellTarget::Strain(strain)) => {
                    Some(strain.abs() / f64::from(load.increments.max(1)))
                }
                _ => None,
            }
        }
        _ => None,
    }
}

/// Largest diameters across the smaller side of the specimen. A random packing fills the grid from
/// which it is drawn. A compaction brings it to the height, or the porosity, of its target; where
/// none does, its height is not known and its width decides.
fn across(scene: &Scene, seeds: &[ParticleSeed]) -> Option<f64> {
    let largest = seeds.iter().map(|seed| seed.radius).max_by(f64::total_cmp)?;
    let area: f64 = seeds.iter().map(|seed| PI * seed.radius * seed.radius).sum();
    let side = |of: fn(&ParticleSeed) -> f64| {
        let low = seeds.iter().map(|seed| of(seed) - seed.radius).min_by(f64::total_cmp);
        let high = seeds.iter().map(|seed| of(seed) + seed.radius).max_by(f64::total_cmp);
        Some(high? - low?)
    };
    let (mut width, mut height) = match (&scene.cell, &scene.specimen) {
        (Some(cell), _) => cell.size,
        (None, Specimen::Packing { count, columns, spacing, .. }) if scene.keep.is_none() => {
            let rows = count.div_ceil((*columns).max(1));
            (f64::from(*columns) * spacing, f64::from(rows) * spacing)
        }
        (None, _) => (side(|seed| seed.position.x)?, side(|seed| seed.position.y)?),
    };
    let compact = scene.stages.iter().find_map(|stage| match stage {
        Stage::Compact(compact) => Some(compact),
        _ => None,
    });
    // Of the area that the target leaves, to that which is there.
    let left = |n: f64| (area / ((1.0 - n) * width * height)).min(1.0);
    match compact.map(|compact| (compact.by, compact.target)) {
        Some((_, CompactTarget::Height(target))) => height = height.min(target),
        // Sides shrink, or radii grow, by this factor.
        Some((by, CompactTarget::Porosity(n)))
            if scene.cell.is_some() || by == CompactBy::Radii =>
        {
            let factor = left(n).sqrt();
            (width, height) = (width * factor, height * factor);
        }
        Some((_, CompactTarget::Porosity(n))) => height *= left(n),
        None => {}
    }
    Some(width.min(height) / (2.0 * largest))
}

fn mean_mass(scene: &Scene, seeds: &[ParticleSeed]) -> Option<f64> {
    let density = scene.materials.values().next()?.density;
    let area: f64 = seeds.iter().map(|seed| PI * seed.radius * seed.radius).sum();
    Some(density * scene.thickness * area / seeds.len().max(1) as f64)
}
