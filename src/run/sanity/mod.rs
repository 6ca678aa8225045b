//! Physical sanity of a test: ratios without dimension that tell whether contacts are stiff, steps
//! small and the specimen large enough. `clastic check` estimates them before a run (`before`), the
//! run measures them (`follow`).

mod before;
mod follow;
mod heights;
mod material;
mod mistakes;
#[cfg(test)]
mod tests;
mod untouched;

use bevy_ecs::prelude::World;
use clastic_components::bond::Bond;
use clastic_components::contact::BodyTable;
use serde::{Deserialize, Serialize};

pub use self::before::before;
pub(super) use self::follow::follow;
pub use self::follow::{SANITY, Sanity};
pub use self::heights::heights;
pub use self::untouched::Untouched;
pub(super) use self::untouched::{UNTOUCHED, follow_driven};
use crate::run::script::Script;
use crate::scene::format::{Scene, Specimen, Stage, Strain, Stress};
use crate::text::shown::label;

/// Stiffness level below which deflections of contacts count: at 1000 they are a thousandth of a
/// diameter. The limit is a choice of this project; da Cruz et al. (2005, Phys. Rev. E 72, 021309)
/// take 1e4 for rigid grains.
const STIFF: f64 = 1e3;
/// Overlap over radius above which it is not small, as linear contacts assume. Cleary and Sawley
/// (2002, Appl. Math. Model. 26, 89-111) keep its mean between 0.1 and 1 %; the maximum is
/// several times the mean. The limit is a choice of this project.
const OVERLAP: f64 = 0.05;
/// Inertial number above which a flow is not quasi-static (GDR MiDi 2004, Eur. Phys. J. E 14,
/// 341-365; da Cruz et al. 2005).
const QUASI_STATIC: f64 = 1e-3;
/// Increments that strain more than this many elastic strains do not resolve the elastic response,
/// whose range of strain is p h / k (Roux and Combe 2002, C. R. Physique 3, 131-140).
const STEP: f64 = 1.0;
/// Gap opened by sliding over elastic closure above which the associated law counts. In cells of 196 disks
/// with k/(p h) of 400 to 4e4 and three sizes of the increment each, stress ratios are 5 to 17 % above
/// those of Coulomb's law at 0.12 to 0.4, and as often below them at 0.1 and less.
const OPENED: f64 = 0.1;
/// Largest grains across a bonded specimen: minimum ten (ISRM 1979, Int. J. Rock Mech. Min. Sci.
/// 16, 135-140).
const ROCK: f64 = 10.0;
/// Largest grains across an unbonded specimen: minimum six (ASTM D7181).
const SOIL: f64 = 6.0;
/// Gap of a bond, mean radii, above which a coordination bonds grains across pores. In a jammed packing 4.5 bonds a
/// grain reach 0.1 radii, 5 reach 0.3 and 6 reach 0.9.
const FAR: f64 = 0.5;
/// Relative error of a measured ratio: a stress is as exact as the residual, and ten columns are
/// ten.
const ROUNDING: f64 = 1e-6;

/// Whether the number of grains across counts: a stress and a strain of the whole specimen are
/// measured, which its walls, its membrane or its cell bound, and its grains are not on a lattice,
/// which has no random structure to average over.
pub(super) fn is_specimen(scene: &Scene) -> bool {
    let strained = matches!(
        scene.strain("axial_strain"),
        Some(Strain::Walls(..) | Strain::Membrane(..) | Strain::Cell(..))
    );
    let stressed = matches!(
        scene.stress("axial_stress"),
        Some(Stress::Walls { .. } | Stress::Membrane(..) | Stress::Average { .. })
    );
    strained && stressed && !matches!(scene.specimen, Specimen::Lattice { .. })
}

/// The ratios and the warnings of a run so far.
pub fn after(world: &World) -> Report {
    let script = world.resource::<Script>();
    let mut report = world.resource::<Sanity>().report(&script.scene);
    let untouched = world.get_resource::<Untouched>();
    report.warnings.extend(untouched.map(|driven| driven.warnings(script)).unwrap_or_default());
    report.warnings.extend(long_bonds(world, &script.scene));
    report
}

/// Warning of bonds that a coordination has made between grains that are no neighbours.
fn long_bonds(world: &World, scene: &Scene) -> Option<String> {
    let counts = |stage: &&Stage| matches!(stage, Stage::Cement(of) if of.coordination.is_some());
    let stage = scene.stages.iter().find(counts)?;
    let bodies = world.resource::<BodyTable>();
    let is_particle = |id| bodies.row(id).is_some_and(|row| row < bodies.particles);
    let mut bonds = world.try_query::<&Bond>()?;
    let gaps = bonds.iter(world).filter(|bond| is_particle(bond.b)).map(|bond| bond.initial_gap);
    let longest = gaps.max_by(f64::total_cmp)? / bodies.mean_radius;
    (longest > FAR).then(|| {
        format!(
            "stage {}: the longest bond bridges a gap of {longest:.2} mean radii, as there are too few pairs that are \
             nearer; give a smaller `coordination`",
            label(stage.name())
        )
    })
}

/// Whether the scene measures a stress and a strain.
fn is_test(scene: &Scene) -> bool {
    scene.strain("axial_strain").is_some() && scene.stress("axial_stress").is_some()
}

/// The ratios, before or after a run. `None` where one is not defined.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Stiffness level k/(p h): the minimum normal stiffness k of the materials over the confining
    /// stress p times the thickness h. p is the smaller of axial and lateral stress, at its maximum
    /// in the run; before it, that of the imposed stresses.
    pub stiffness_over_pressure: Option<f64>,
    /// Maximum overlap of two bodies in contact over the smaller radius.
    pub maximum_overlap_over_radius: Option<f64>,
    /// Inertial number `I = rate sqrt(m / (p h))` of the dynamic increments of the reference stage,
    /// with the rate of shear and the mean mass m. Its strain is `max(|a|, |a - l|)` of the axial and
    /// the lateral one, squared and added to that of the shear of the particles.
    pub inertial_number: Option<f64>,
    /// Maximum axial strain of a static increment over the elastic strain s h/k, with s the larger
    /// one of the confining stress p and the strength of the bonds.
    pub increment_over_elastic_strain: Option<f64>,
    /// Diameters of the largest disk across the smaller side of the specimen, where it is one.
    pub disks_across: Option<f64>,
    /// Gap that sliding contacts open in a static increment over the elastic closure p/k of all contacts,
    /// both means weighted by the normal forces: the associated law dilates. A closure is at least
    /// 1e-6 mean radii, so that rigid grains have one.
    pub opening_over_closure: Option<f64>,
    /// Warnings, each with its source.
    pub warnings: Vec<String>,
}

impl Report {
    /// Finds the warnings. `is_rock` means that bonds are stronger than the confining stress: the
    /// stiffness of the contacts is then that of the material, and no choice.
    fn with_warnings(mut self, is_bonded: bool, is_rock: bool) -> Self {
        let mut warnings = Vec::new();
        let soft = |level: &f64| *level < STIFF * (1.0 - ROUNDING) && !is_rock;
        if let Some(level) = self.stiffness_over_pressure.filter(soft) {
            warnings.push(format!(
                "k/(p h) is {}: below 1000 the deflection of the contacts changes friction \
                 angle and volume with the pressure; give stiffer contacts or a lower stress (da \
                 Cruz et al. 2005 take 1e4 for rigid grains)",
                short(level)
            ));
        }
        if let Some(overlap) = self.maximum_overlap_over_radius.filter(|o| *o > OVERLAP) {
            warnings.push(format!(
                "contacts overlap by up to {:.1} % of a radius: linear contacts assume small overlaps; \
                 give stiffer contacts (Cleary and Sawley 2002 keep the mean below 1 %)",
                100.0 * overlap
            ));
        }
        if let Some(number) = self.inertial_number.filter(|number| *number > QUASI_STATIC) {
            warnings.push(format!(
                "the inertial number is {number:.1e}: above 1e-3 stresses depend on the rate; load \
                 more slowly (GDR MiDi 2004; da Cruz et al. 2005)"
            ));
        }
        if let Some(ratio) = self.increment_over_elastic_strain.filter(|ratio| *ratio > STEP) {
            warnings.push(format!(
                "an increment strains the specimen by {ratio:.1} elastic strains: the initial modulus, \
                 the first yield and, in increments of 1 % strain or more, the strength are not \
                 resolved; give smaller increments (p h/k is the range of elastic strain, Roux and \
                 Combe 2002)"
            ));
        }
        if let Some(ratio) = self.opening_over_closure.filter(|ratio| *ratio > OPENED) {
            warnings.push(format!(
                "the gaps that sliding contacts open in an increment are {} of their elastic closure: the \
                 associated law overestimates friction and dilation; give increments that are {:.0} times \
                 smaller, or `friction_law: Coulomb()`",
                short(ratio),
                (ratio / (0.5 * OPENED)).ceil()
            ));
        }
        let (enough, source) = if is_bonded {
            (ROCK, "ISRM 1979 asks for ten of the largest grains")
        } else {
            (SOIL, "ASTM D7181 asks for six of the largest particles")
        };
        let few = |disks: &f64| *disks < enough * (1.0 - ROUNDING);
        if let Some(disks) = self.disks_across.filter(few) {
            warnings.push(format!(
                "{disks:.1} of the largest disks lie across the specimen: too few for the stress of a \
                 continuum ({source})"
            ));
        }
        self.warnings = warnings;
        self
    }

    /// The ratios that are defined, in one line; empty without any.
    pub fn line(&self) -> String {
        let parts = [
            ("k/(p h)", self.stiffness_over_pressure),
            ("maximum overlap/radius", self.maximum_overlap_over_radius),
            ("inertial number", self.inertial_number),
            ("increment/elastic strain", self.increment_over_elastic_strain),
            ("opening/closure", self.opening_over_closure.filter(|ratio| *ratio > 0.0)),
            ("disks across", self.disks_across),
        ];
        let text: Vec<_> = parts
            .iter()
            .filter_map(|(name, value)| value.map(|value| format!("{name} {}", short(value))))
            .collect();
        text.join("; ")
    }
}

/// Three digits.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        v if (0.01..1e5).contains(&v) => {
            let digits = (2 - v.log10().floor() as i32).max(0) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{value:.1e}"),
    }
}
