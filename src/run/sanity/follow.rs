//! System: the ratios of a run, increment by increment.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, ConeSolution};
use clastic_cone::residuals::multipliers;
use clastic_systems::measures::strain::shear_of;

use super::material::{Grains, inertial};
use super::{Report, is_specimen, is_test};
use crate::run::disks::sides;
use crate::run::script::Script;
use crate::scene::format::Scene;

/// Name of [`Sanity`] in a state.
pub const SANITY: &str = "sanity";

/// Data of the increments from which the sanity of a run follows.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sanity {
    /// Maximum of the smaller one of axial and lateral stress, Pa.
    pressure: Option<f64>,
    /// Maximum overlap over the smaller radius.
    overlap: Option<f64>,
    /// Axial strain after the last increment of the reference stage.
    strain: Option<f64>,
    /// Maximum axial strain of a static increment there.
    increment: Option<f64>,
    /// Sums over the dynamic increments there: time, axial strain, axial less lateral strain, shear
    /// strain, pressure times time.
    dynamic: [f64; 5],
    /// Lateral strain after the last increment there.
    lateral: f64,
    /// Mean mass, kg.
    mass: f64,
    /// Largest diameters across the smaller side, after the first increment there.
    across: Option<f64>,
    /// Maximum cohesion or tensile strength of the bonds that were there, Pa; 0 without bonds.
    strength: f64,
    /// Sums over the static increments from the reference stage on, weighted by the normal forces, J: of
    /// the gaps that sliding opens, and of the elastic closures.
    opened: [f64; 2],
}

/// Minimum closure of a contact, mean radii: gaps that sliding opens between rigid grains count, and
/// round-off does not.
const MIN_CLOSURE: f64 = 1e-6;

impl Sanity {
    /// The ratios so far.
    pub fn report(&self, scene: &Scene) -> Report {
        let grains = Grains { strength: self.strength, ..Grains::of(scene, None) };
        let [time, axial, across, shear, pressure] = self.dynamic;
        let strain = axial.abs().max(across.abs()).hypot(shear);
        let number = || inertial(strain / time, self.mass, pressure / time, scene.thickness);
        let [opened, closure] = self.opened;
        Report {
            stiffness_over_pressure: grains.level(self.pressure),
            maximum_overlap_over_radius: self.overlap,
            inertial_number: (time > 0.0).then(number).flatten(),
            increment_over_elastic_strain: grains.steps(self.increment, self.pressure),
            disks_across: self.across,
            opening_over_closure: (closure > 0.0).then(|| opened / closure),
            warnings: Vec::new(),
        }
        .with_warnings(grains.strength > 0.0, grains.are_rock(self.pressure))
    }

    /// Adds an increment of the reference stage.
    fn see_strain(&mut self, o: &Observation, analysis: &ClasticAnalysis, bodies: &BodyTable) {
        let Some(strain) = o.axial_strain else { return };
        let change = strain - self.strain.replace(strain).unwrap_or(0.0);
        let lateral = o.lateral_strain.unwrap_or(0.0);
        let across = change - (lateral - std::mem::replace(&mut self.lateral, lateral));
        match analysis.kind {
            AnalysisKind::Static if o.axial_stress.is_some() => {
                self.increment = larger(self.increment, Some(change.abs()));
            }
            AnalysisKind::Dynamic { dt, .. } => {
                if let Some(pressure) = confining(o) {
                    let time = dt * o.fraction;
                    let shear = shear_of(bodies).unwrap_or(0.0);
                    let seen = [time, change, across, shear, pressure * time];
                    self.dynamic.iter_mut().zip(seen).for_each(|(sum, seen)| *sum += seen);
                }
            }
            _ => {}
        }
    }
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

/// The smaller of axial and lateral stress, of those that are measured.
fn confining(o: &Observation) -> Option<f64> {
    o.axial_stress.into_iter().chain(o.lateral_stress).reduce(f64::min)
}

/// Adds the increment.
pub fn follow(
    (script, progress, analysis): (Res<Script>, Res<ClasticProgress>, Res<ClasticAnalysis>),
    (bodies, contacts): (Res<BodyTable>, Res<ContactTable>),
    (program, solution): (Res<ConeProgram>, Res<ConeSolution>),
    (o, bonds): (Res<Observation>, Query<&Bond>),
    mut sanity: ResMut<Sanity>,
) {
    let carries = o.status.is_committed();
    if !carries || matches!(analysis.kind, AnalysisKind::Compaction { .. }) {
        return;
    }
    let strengths = bonds.iter().map(|bond| bond.law.cohesion.max(bond.law.tensile_strength));
    sanity.strength = strengths.fold(sanity.strength, f64::max);
    sanity.overlap = larger(sanity.overlap, overlap(&bodies, &contacts, &program, &solution));
    if o.in_avalanche {
        return;
    }
    // Without a lateral stress the axial one is the load and no confinement, except on loose
    // grains.
    let is_loose = sanity.strength == 0.0;
    let pressure = confining(&o).filter(|_| is_loose || o.lateral_stress.is_some());
    sanity.pressure = larger(sanity.pressure, pressure);
    if is_test(&script.scene) && progress.stage >= script.reference_stage() {
        if sanity.mass == 0.0 {
            sanity.across = across(&bodies).filter(|_| is_specimen(&script.scene));
            let n = bodies.particles;
            sanity.mass = bodies.masses[..n].iter().sum::<f64>() / n.max(1) as f64;
        }
        sanity.see_strain(&o, &analysis, &bodies);
        if analysis.kind == AnalysisKind::Static {
            let seen = opened(&program, &solution);
            sanity.opened.iter_mut().zip(seen).for_each(|(sum, seen)| *sum += seen);
        }
    }
}

/// Gaps that the sliding of contacts opens, and elastic closures of contacts and bonds, both times the
/// normal forces, J.
fn opened(program: &ConeProgram, solution: &ConeSolution) -> [f64; 2] {
    let contacts = program.interactions.iter().zip(&solution.forces);
    let mut sums = [0.0; 2];
    for (c, f) in contacts.filter(|(_, f)| f[0] > 0.0) {
        let m = multipliers(solution.law, c, &program.kinematics(c, &solution.displacements), f);
        let gap = c.limits.friction * m.slip.abs() + c.limits.rolling * m.rotation.abs();
        if !c.limits.has_strength() {
            sums[0] += f[0] * solution.law.dilation(c) * gap;
        }
        sums[1] += f[0] * (f[0] * c.normal_compliance).max(MIN_CLOSURE * program.scales.length);
    }
    sums
}

/// Maximum overlap over the smaller radius; `None` without an elastic contact under pressure.
fn overlap(
    bodies: &BodyTable,
    contacts: &ContactTable,
    program: &ConeProgram,
    solution: &ConeSolution,
) -> Option<f64> {
    let solved = program.interactions.iter().zip(&solution.forces);
    let ratios = contacts.0.iter().zip(solved).filter_map(|(contact, (row, [p, ..]))| {
        let radius = |body: u32| bodies.radii.get(body as usize).copied().unwrap_or(f64::INFINITY);
        let overlap = row.normal_compliance * p;
        (overlap > 0.0).then(|| overlap / radius(contact.a).min(radius(contact.b)))
    });
    ratios.max_by(f64::total_cmp)
}

/// Largest diameters across the smaller side of the box around the particles, or of the cell.
fn across(bodies: &BodyTable) -> Option<f64> {
    let radii = &bodies.radii[..bodies.particles];
    let largest = radii.iter().copied().max_by(f64::total_cmp)?;
    let [width, height] = sides(bodies)?;
    Some(width.min(height) / (2.0 * largest))
}
