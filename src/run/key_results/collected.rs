//! Collects the data from which the key results follow.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::attempt::IncrementStatus;
use clastic_components::observation::Observation;

use super::definitions::RESOLVED;
use super::results::{BrokenBonds, Results};
use crate::scene::format::{Scene, Specimen};

/// Part of a run to which an increment belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Compaction, whose forces have no physical meaning.
    Preparation,
    /// Loading before the reference stage, for example confinement.
    Loading,
    /// The reference stage and later stages, in which strains exist.
    Reference,
}

/// Collects the key results increment by increment.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KeyResults {
    pub(super) rigid: bool,
    /// Stress that the stiffest contact would have at a strain of 1, Pa. Stresses that are small
    /// relative to it count as round-off.
    pub(super) stiffness: f64,
    /// Delay of ruptures in the last increment with ruptures.
    pub(super) lag: Option<f64>,
    /// Start of the reference stage.
    pub(super) start: Point,
    /// Whether the run starts from a saved state, and neither its forces nor a stage before the
    /// reference stage have told the stress of it.
    pub(super) is_start_unknown: bool,
    /// The last increment with load.
    pub(super) last: Option<Point>,
    /// Increments from the reference stage on that have both a strain and a stress.
    pub(super) curve: Vec<Point>,
    /// Place of the peak on the curve.
    pub(super) peak: Option<usize>,
    /// The last increment that was recorded, and whether it is the peak so far.
    pub(super) seen: (u64, bool),
    /// Whether the specimen collapsed, and the increment before the collapse.
    pub(super) collapse: Option<Option<Point>>,
    /// Whether a bond broke, and the stress of the first increment with a rupture.
    pub(super) crack: Option<Option<f64>>,
    /// Kinetic energy of the increment that is recorded next, over the volume of the particles,
    /// J/m^3; 0 in a static one.
    pub(super) kinetic: f64,
    /// Normal force of a wall beside the specimen over that of a platen, in the increment that is
    /// recorded next.
    pub(super) thrust: f64,
    pub(super) results: Results,
}

/// An increment on the curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Point {
    /// Axial strain; 0 before the reference stage.
    pub(super) strain: f64,
    /// Axial stress, Pa.
    pub(super) stress: f64,
    /// Whether the status is `solved`; false if a maximum number of passes was reached.
    pub(super) solved: bool,
    /// Kinetic energy of a dynamic increment over the volume of the particles, J/m^3.
    pub(super) kinetic: f64,
    /// Lateral strain.
    pub(super) lateral_strain: Option<f64>,
    /// Volumetric strain.
    pub(super) volume: Option<f64>,
    /// Lateral stress, Pa.
    pub(super) lateral_stress: Option<f64>,
    /// Force of a wall beside the specimen over the area of a platen, Pa.
    pub(super) beside: f64,
    /// Number of bonds that broke so far.
    pub(super) broken: usize,
}

/// A start without stress.
impl Default for Point {
    fn default() -> Self {
        Self {
            strain: 0.0,
            stress: 0.0,
            solved: true,
            kinetic: 0.0,
            lateral_strain: None,
            volume: None,
            lateral_stress: None,
            beside: 0.0,
            broken: 0,
        }
    }
}

impl KeyResults {
    /// Results before the run of a scene.
    pub fn of_scene(scene: &Scene) -> Self {
        let all = scene.stiffnesses();
        let stiffest = all.clone().filter_map(|[normal, ..]| normal).fold(0.0, f64::max);
        let is_rigid = all.flatten().all(|stiffness| stiffness.is_none());
        let is_start_unknown = matches!(scene.specimen, Specimen::State { .. });
        let stiffness = stiffest / scene.thickness;
        Self { stiffness, is_start_unknown, ..Self::new(is_rigid) }
    }

    /// Results before the run. `rigid` means that nothing in the specimen is elastic.
    pub fn new(rigid: bool) -> Self {
        Self { rigid, ..Self::default() }
    }

    /// Records the number of bonds created so far.
    pub(crate) fn see_bonds(&mut self, created: usize) {
        // Bonds to a removed wall no longer exist, so the number of existing bonds may decrease.
        self.results.bonds_created = self.results.bonds_created.max(created);
    }

    /// Records the bonds that are there between two increments.
    pub(crate) fn count_bonds(&mut self, created: usize, intact: usize) {
        self.see_bonds(created);
        self.results.bonds_intact = intact;
    }

    /// Takes the stresses of a saved state as those at the start of the reference stage, Pa, with
    /// the number of bonds that broke before. A start that is known stays.
    pub(crate) fn start_from(&mut self, axial: f64, lateral: Option<f64>, broken: usize) {
        if self.is_start_unknown {
            self.start =
                Point { stress: axial, lateral_stress: lateral, broken, ..Point::default() };
            self.is_start_unknown = false;
        }
    }

    /// Whether this increment is the one that was recorded last, and the peak so far.
    pub fn is_peak(&self, increment: u64) -> bool {
        self.seen == (increment, true)
    }

    /// Records an increment. Returns whether it is the peak so far.
    pub fn observe(&mut self, o: &Observation, phase: Phase) -> bool {
        let is_peak = self.follow(o, phase);
        self.seen = (o.increment, is_peak);
        is_peak
    }

    fn follow(&mut self, o: &Observation, phase: Phase) -> bool {
        let results = &mut self.results;
        let [tension, shear, rolling] = o.broken;
        results.bonds_broken = BrokenBonds { tension, shear, rolling };
        results.solver_iterations += u64::from(o.iterations);
        let collapsed = o.status == IncrementStatus::Collapsed;
        if !collapsed {
            let (worst, r) = (&mut results.worst_residuals, &o.residuals);
            worst.balance.see(r.balance, o.increment);
            worst.kinematics.see(r.kinematics, o.increment);
            worst.cone.see(r.cone, o.increment);
            worst.complementarity.see(r.complementarity, o.increment);
        }
        self.count_bonds(o.bonds + tension + shear + rolling, o.bonds);
        if phase == Phase::Preparation {
            self.start = Point::default();
            self.is_start_unknown = false;
            return false;
        }
        let solved = o.status == IncrementStatus::Solved;
        if collapsed && self.collapse.is_none() {
            self.collapse = Some(self.last);
        }
        if !o.ruptures.is_empty() && self.crack.is_none() {
            self.crack = Some(o.axial_stress);
        }
        if o.in_avalanche {
            return false;
        }
        let Some(stress) = o.axial_stress else {
            if !collapsed {
                self.last = None;
            }
            return false;
        };
        let point = Point {
            strain: o.axial_strain.unwrap_or_default(),
            stress,
            solved,
            kinetic: self.kinetic,
            lateral_strain: o.lateral_strain,
            volume: o.volumetric_strain,
            lateral_stress: o.lateral_stress,
            beside: self.thrust * stress,
            broken: o.broken.iter().sum(),
        };
        self.last = Some(point);
        if phase == Phase::Loading {
            self.start = Point { strain: 0.0, lateral_strain: None, volume: None, ..point };
            self.is_start_unknown = false;
            return false;
        }
        if o.axial_strain.is_none() {
            return false;
        }
        self.curve.push(point);
        let height = |stress: f64| (stress - self.start.stress).abs();
        let results = &mut self.results;
        // What exceeds the peak by less than is resolved is no other peak.
        let peak = results
            .peak_stress_pa
            .is_none_or(|peak| height(stress) > height(peak) * (1.0 + RESOLVED));
        if o.rupture_lag > 0.0 {
            self.lag = Some(o.rupture_lag);
        }
        if peak {
            self.peak = Some(self.curve.len() - 1);
            results.peak_stress_pa = Some(stress);
            results.peak_is_capped = !solved;
            results.strain_at_peak = Some(point.strain);
            results.peak_error_estimate = self.lag;
        }
        peak
    }
}
