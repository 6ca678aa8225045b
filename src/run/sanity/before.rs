//! Estimates before a run, from what the scene imposes.

use glam::DVec2;

use crate::run::disks::{Disks, ends, in_other_unit, is_apart};
use crate::run::minerals::specimen;
use crate::run::wall_pieces::pieces;
use crate::scene::format::{
    Analysis, Area, Cell, CellStrain, CellTarget, Compact, CompactBy, CompactTarget, LidLoad, Load,
    Measure, Particle, Quantity, Scene, Specimen, Stage, Strain, Table, WallControl,
};
use crate::scene::specimen_file::StoredSpecimen;
use crate::text::shown::label;
use clastic_components::wall;
use clastic_systems::membranes::{MEMBRANES, MembraneStates};
use clastic_systems::wall_states::{ControlStates, WALL_CONTROL};

use super::material::{Grains, inertial};
use super::mistakes::mistakes;
use super::untouched::{nothing_acts, out_of_reach};
use super::{Report, is_specimen, is_test};

/// The ratios that follow from the imposed motions and stresses.
pub fn before(scene: &Scene, stored: Option<&StoredSpecimen>) -> Report {
    let grains = Grains::of(scene, stored);
    let seeds = specimen(scene, stored);
    let loads = scene.stages.iter().filter_map(Stage::load);
    let pressure = loads.filter_map(confining).chain(kept(stored)).max_by(f64::total_cmp);
    let reference = scene.stages.get(scene.reference_stage()).and_then(Stage::load);
    let reference = reference.filter(|_| is_test(scene));
    let disks = Disks::of(seeds.iter().map(|seed| seed.radius));
    let packed = Packed::of(scene, &seeds, &disks);
    let strain = reference.and_then(|load| imposed_strain(scene, load, packed.as_ref()));
    let dt = reference.and_then(|load| time_step(scene, load));
    let number = || {
        let load = reference?;
        let shear = load.cell.as_ref().and_then(|cell| of_increment(load, cell.shear));
        let rate = strain.into_iter().chain(shear).max_by(f64::total_cmp)? / dt?;
        inertial(rate, packed.as_ref()?.mean_mass, pressure?, scene.thickness)
    };
    let in_other_units = packed.as_ref().map(|packed| packed.in_other_units(scene));
    let mut report = Report {
        stiffness_over_pressure: grains.level(pressure).filter(|_| is_test(scene)),
        inertial_number: number(),
        increment_over_elastic_strain: grains.steps(strain.filter(|_| dt.is_none()), pressure),
        disks_across: packed.map(|packed| packed.across()).filter(|_| is_specimen(scene)),
        ..Report::default()
    }
    .with_warnings(grains.strength > 0.0, grains.are_rock(pressure));
    report.warnings.extend(too_dense(scene, &disks));
    report.warnings.extend(in_other_units.unwrap_or_default());
    report.warnings.extend(out_of_reach(scene, &seeds));
    report.warnings.extend(nothing_acts(scene, &seeds));
    report.warnings.extend(mistakes(scene, &grains, &seeds, pressure));
    report
}

/// Porosity at which random packings jam, far from walls.
const JAMMED: f64 = 0.16;

/// Warning of a compaction to a porosity that these disks do not reach.
fn too_dense(scene: &Scene, disks: &Disks) -> Option<String> {
    scene.stages.iter().find_map(|stage| match stage {
        Stage::Compact(Compact { name, target: CompactTarget::Porosity(target), .. }) => {
            Some(format!("stage `{name}`: {}", disks.refusal(*target)?))
        }
        _ => None,
    })
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

/// The smallest stress above 0 that walls and membranes of a saved state keep, Pa. A scene with walls
/// of its own has neither.
fn kept(stored: Option<&StoredSpecimen>) -> Option<f64> {
    let state = stored?.gives_walls()?;
    let world = &state.saved.as_ref()?.world;
    let walls = world.get::<ControlStates>(WALL_CONTROL).map(|list| list.0).unwrap_or_default();
    let walls = walls.into_iter().filter_map(|(_, control, _)| match control {
        wall::WallControl::Stress { to, .. } => Some(to),
        _ => None,
    });
    let membranes = world.get::<MembraneStates>(MEMBRANES).map(|list| list.0).unwrap_or_default();
    let pressures = membranes.into_iter().map(|membrane| membrane.pressure.1);
    walls.chain(pressures).filter(|stress| *stress > 0.0).min_by(f64::total_cmp)
}

/// Time step of a stage, s; `None` of a static one.
pub(super) fn time_step(scene: &Scene, load: &Load) -> Option<f64> {
    match load.analysis.unwrap_or(scene.analysis) {
        Analysis::Dynamic { dt, .. } => Some(dt),
        Analysis::Static => None,
    }
}

/// Axial strain that a stage imposes in an increment; `None` where it is not imposed by a constant
/// motion of the walls, or of the cell, from which it is measured.
fn imposed_strain(scene: &Scene, load: &Load, packed: Option<&Packed>) -> Option<f64> {
    match scene.strain("axial_strain")? {
        Strain::Walls(a, b) => {
            let wall = |name: &str| scene.walls.iter().find(|wall| wall.name == *name);
            let (a, b) = (wall(a)?, wall(b)?);
            let [line, other] = [a, b].map(|wall| pieces(wall)[0]);
            let normal = line.wall.inward();
            let drawn = (other.position - line.position).dot(normal).abs();
            // A compaction has moved one of these walls to the other.
            let is_moved = |compact: &&Compact| {
                let ends = [&compact.wall, &compact.base];
                compact.by != CompactBy::Radii
                    && (ends == [&a.name, &b.name] || ends == [&b.name, &a.name])
            };
            let moved = compaction(scene).filter(is_moved).and(packed).map(|packed| packed.height);
            let distance = moved.map_or(drawn, |height| height.min(drawn));
            let dt = time_step(scene, load).unwrap_or(0.0);
            let motion = |name: &String| match load.walls.get(name) {
                Some(WallControl::Displacement(x, y)) => normal.dot(DVec2::new(*x, *y)),
                Some(WallControl::Velocity(x, y)) => dt * normal.dot(DVec2::new(*x, *y)),
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
            of_increment(load, component)
        }
        _ => None,
    }
}

/// Strain of one component of the cell in an increment.
fn of_increment(load: &Load, component: Option<CellTarget>) -> Option<f64> {
    match component? {
        CellTarget::Strain(strain) => Some(strain.abs() / f64::from(load.increments.max(1))),
        _ => None,
    }
}

/// The first compaction of a scene.
fn compaction(scene: &Scene) -> Option<&Compact> {
    scene.stages.iter().find_map(|stage| match stage {
        Stage::Compact(compact) => Some(compact),
        _ => None,
    })
}

/// Estimate of a specimen after its compaction.
struct Packed {
    /// Width and height, m.
    width: f64,
    height: f64,
    /// Largest radius, m.
    largest: f64,
    /// Mean mass, kg.
    mean_mass: f64,
}

impl Packed {
    /// A random packing fills the grid from which it is drawn. A compaction brings it to the
    /// height, or the porosity, of its target; without one the height is not known, and the width
    /// decides. A packing that is cut out of a cell is as large as the part that is left.
    fn of(scene: &Scene, seeds: &[Particle], disks: &Disks) -> Option<Self> {
        let Disks { area, largest, .. } = *disks;
        let side = |of: fn(&Particle) -> f64| {
            ends(seeds.iter().map(|seed| (of(seed), seed.radius))).map(|(low, high)| high - low)
        };
        if seeds.is_empty() {
            return None;
        }
        let (width, height) = match (&scene.cell, &scene.specimen) {
            (Some(cell), _) => cell.size,
            (None, Specimen::Packing { count, columns, spacing, .. }) if scene.keep.is_none() => {
                let rows = count.div_ceil((*columns).max(1));
                (f64::from(*columns) * spacing, f64::from(rows) * spacing)
            }
            (None, _) => (side(|seed| seed.position.0)?, side(|seed| seed.position.1)?),
        };
        let density = scene.materials.values().next()?.density;
        let mean_mass = density * scene.thickness * area / seeds.len() as f64;
        let loose = Self { width, height, largest, mean_mass };
        let packed = match compaction(scene) {
            Some(compact) => loose.compacted(compact, area, scene.cell.as_ref()),
            None => loose,
        };
        let cut = scene.stages.iter().find_map(|stage| match stage {
            Stage::Remove(cut) if cut.open_cell => Some(&cut.select),
            _ => None,
        });
        let Some(cut) = cut else { return Some(packed) };
        let [low, high] = cut.left()?;
        Some(Self { width: high.0 - low.0, height: high.1 - low.1, ..packed })
    }

    fn compacted(self, compact: &Compact, area: f64, cell: Option<&Cell>) -> Self {
        // Ratio of the area at the target to the present area.
        let left = |n: f64| (area / ((1.0 - n) * self.width * self.height)).min(1.0);
        let n = match compact.target {
            CompactTarget::Height(target) => {
                return Self { height: self.height.min(target), ..self };
            }
            CompactTarget::Porosity(n) => n,
            CompactTarget::Jammed => JAMMED,
        };
        if compact.by == CompactBy::Radii {
            let growth = left(n).sqrt().recip();
            let (largest, mean_mass) = (self.largest * growth, self.mean_mass * growth * growth);
            Self { largest, mean_mass, ..self }
        } else if cell.is_some() {
            let factor = left(n).sqrt();
            Self { width: self.width * factor, height: self.height * factor, ..self }
        } else {
            Self { height: self.height * left(n), ..self }
        }
    }

    /// Warnings of measures whose length or area is in another unit than the specimen.
    fn in_other_units(&self, scene: &Scene) -> Vec<String> {
        let (sides, area) = ([self.width, self.height], self.width * self.height);
        let given = |of: &Quantity| match of {
            Quantity::Stress(of) => in_other_unit(of, sides),
            Quantity::Porosity(Area::Fixed(given)) if is_apart(*given, [area; 2]) => Some(*given),
            _ => None,
        };
        let wrong = |Measure { name, of }: &Measure| {
            Some(format!(
                "measures.{}: `Fixed({:?})` for a specimen of {:.2e} m by {:.2e} m: lengths are in m, areas in m^2; \
                 no key result follows from it",
                label(name),
                given(of)?,
                self.width,
                self.height
            ))
        };
        // What is poured in may be larger.
        let pours = scene.stages.iter().any(Stage::pours);
        scene.measures.iter().filter(|_| !pours).filter_map(wrong).collect()
    }

    /// Number of largest diameters that fit across the smaller side.
    fn across(&self) -> f64 {
        self.width.min(self.height) / (2.0 * self.largest)
    }
}
