//! Estimate of the memory that a scene needs, before anything is built.
//!
//! The estimate counts particles and pairs of particles, for the tables of bodies, bonds and
//! contacts and for the factor of the solver. Bonded lattices of 10^4 and 9 10^4 disks took 9.0 and
//! 9.9 kB per disk in measurements; the estimate gives 10 kB.

use std::f64::consts::PI;

use clastic_systems::detect_contacts::grid::count_within;
use glam::DVec2;

use crate::run::sieve;

use super::format::{Analysis, Scene, Sizes, Specimen, Stage};
use super::specimen_file::StoredSpecimen;

/// Memory per particle, bytes.
const PARTICLE: f64 = 1000.0;
/// Memory per pair that touches or is bonded, bytes.
const PAIR: f64 = 3000.0;
/// Pairs per particle in a dense packing of disks of similar size.
const TOUCHING: f64 = 3.0;
/// Maximum fraction of the area that equal disks can cover.
const DENSEST: f64 = 0.907;
/// A scene with more pairs than this is not counted pair by pair.
const COUNTED: usize = 100_000_000;

/// Requirements of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// Number of particles, with all that are poured in.
    pub particles: u64,
    /// Estimated maximum number of pairs that touch or are bonded at one time.
    pub pairs: f64,
    /// Estimated memory, bytes.
    pub bytes: f64,
}

impl Need {
    /// Requirements of a scene with the stored specimen that it names.
    pub fn of(scene: &Scene, stored: Option<&StoredSpecimen>) -> Self {
        let first = particles(&scene.specimen, stored);
        let poured: f64 = scene.stages.iter().map(|stage| poured(scene, stage)).sum();
        let count = first as f64 + poured;
        // A number beyond all integers becomes the largest one.
        let n = first.saturating_add(poured as u64);
        let mean = match scene.stages.iter().find(|stage| stage.pours()) {
            Some(Stage::Pour(pour)) if first == 0 => mean_of(&pour.stream.sizes),
            _ => mean_radius(&scene.specimen, stored),
        };
        // The packing that a cementing stage finds is unknown, so the estimate takes a dense one.
        let bonded = scene.stages.iter().filter_map(|stage| match stage {
            Stage::Cement(cement) => cement.length,
            _ => None,
        });
        let length = bonded.filter(|length| length.is_finite()).fold(0.0, f64::max);
        let neighbours = DENSEST * (2.0 + length / mean).powi(2) - 1.0;
        let neighbours = if neighbours.is_finite() { neighbours } else { count };
        let each = (0.5 * neighbours).max(TOUCHING).min(0.5 * (count - 1.0).max(0.0));
        let mut pairs = (count * each).max(scene.bonds.len() as f64);
        // Particles that are listed one by one may overlap in any number.
        let disks = disks(&scene.specimen, stored);
        if !disks.0.is_empty() {
            pairs = pairs.max(count_within(&disks.0, &disks.1, 0.0, COUNTED) as f64);
        }
        Self { particles: n, pairs, bytes: PARTICLE * count + PAIR * pairs }
    }
}

/// Bytes in a suitable unit.
pub fn size(bytes: f64) -> String {
    let (unit, size) = match bytes {
        b if b >= 1e18 => return format!("{b:.0e} bytes"),
        b if b >= 1e15 => ("PB", 1e15),
        b if b >= 1e12 => ("TB", 1e12),
        b if b >= 1e9 => ("GB", 1e9),
        _ => ("MB", 1e6),
    };
    format!("{:.1} {unit}", bytes / size)
}

pub(super) fn particles(specimen: &Specimen, stored: Option<&StoredSpecimen>) -> u64 {
    match specimen {
        Specimen::Particles(list) => list.len() as u64,
        Specimen::Lattice { columns, rows, .. } => {
            let (columns, rows) = (u64::from(*columns), u64::from(*rows));
            (columns * rows).saturating_sub(rows / 2)
        }
        Specimen::Packing { count, .. } => u64::from(*count),
        Specimen::File { .. } | Specimen::State { .. } => stored.map_or(0, |stored| stored.indices),
    }
}

/// Number of grains that a stage pours in if there is room; 0 where a value makes no sense.
pub(crate) fn poured(scene: &Scene, stage: &Stage) -> f64 {
    let Stage::Pour(pour) = stage else { return 0.0 };
    let Analysis::Dynamic { dt, .. } = pour.load.analysis.unwrap_or(scene.analysis) else {
        return 0.0;
    };
    let all = f64::from(pour.load.increments);
    let due = pour.stream.rate.due(all, all, dt);
    let number = if pour.stream.rate.is_of_mass() {
        let densities = scene.materials.values().map(|material| material.density);
        let density = densities.fold(f64::INFINITY, f64::min);
        due / (density * PI * mean_of(&pour.stream.sizes).powi(2) * scene.thickness)
    } else {
        due
    };
    if number.is_finite() { number.max(0.0).ceil() } else { 0.0 }
}

/// Radius of a disk of mean area of a distribution, m.
pub(crate) fn mean_of(sizes: &Sizes) -> f64 {
    match sizes {
        Sizes::Equal { radius } | Sizes::LogNormal { radius, .. } => *radius,
        Sizes::Uniform { radius: (low, high) } => {
            ((low * low + low * high + high * high) / 3.0).sqrt()
        }
        // A curve of one point is refused.
        Sizes::Sieve { passing } if passing.len() < 2 => f64::NAN,
        Sizes::Sieve { passing } => {
            let radii = sieve::radii(passing, 1000, 0);
            (radii.iter().map(|r| r * r).sum::<f64>() / radii.len() as f64).sqrt()
        }
    }
}

/// Radius of a disk of mean area, m.
fn mean_radius(specimen: &Specimen, stored: Option<&StoredSpecimen>) -> f64 {
    match specimen {
        Specimen::Lattice { radius, .. } => *radius,
        Specimen::Packing { sizes, .. } => mean_of(sizes),
        Specimen::Particles(_) | Specimen::File { .. } | Specimen::State { .. } => {
            let (_, radii) = disks(specimen, stored);
            let area: f64 = radii.iter().map(|r| PI * r * r).sum();
            (area / (PI * radii.len() as f64)).sqrt()
        }
    }
}

/// The disks that a scene lists one by one.
fn disks(specimen: &Specimen, stored: Option<&StoredSpecimen>) -> (Vec<DVec2>, Vec<f64>) {
    match specimen {
        Specimen::Particles(list) => {
            list.iter().map(|p| (DVec2::from(p.position), p.radius)).unzip()
        }
        Specimen::File { .. } | Specimen::State { .. } => {
            let rows = stored.iter().flat_map(|stored| &stored.rows);
            rows.map(|row| (DVec2::new(row.x, row.y), row.r)).unzip()
        }
        _ => (Vec::new(), Vec::new()),
    }
}
