//! Layers, minerals and cuts of a specimen.

use std::collections::BTreeMap;

use glam::DVec2;

use super::particles::particles;
use super::random::Random;
use super::select::{Candidate, selects};
use crate::scene::format::{Clusters, Mineral, Particle, Scene, Select};
use crate::scene::specimen_file::StoredSpecimen;

/// Particles of a scene in the order of identities: those of its specimen that `keep` selects, with
/// the materials that `minerals` gives them. Both select from the uncut specimen.
pub fn specimen(scene: &Scene, stored: Option<&StoredSpecimen>) -> Vec<Particle> {
    let mut seeds = particles(&scene.specimen, stored);
    if stored.is_some_and(StoredSpecimen::is_resumed) {
        return seeds;
    }
    let only = scene.materials.keys().next().filter(|_| scene.materials.len() == 1);
    let has = |select: &Select, index: usize, seed: &Particle| {
        let of = Candidate {
            index: index as u32,
            place: seed.position.into(),
            material: seed.material.as_ref().or(only).map(String::as_str),
            group: seed.group.as_deref(),
            probe: seed.probe.as_deref(),
            core: u32::MAX,
        };
        // Groups of the scene select from what is left after the cut.
        selects(select, &BTreeMap::new(), &of)
    };
    let kept: Option<Vec<bool>> = scene
        .keep
        .as_ref()
        .map(|keep| seeds.iter().enumerate().map(|(i, seed)| has(keep, i, seed)).collect());
    for Mineral { material, select, clusters } in &scene.minerals {
        let mut chosen: Vec<usize> =
            (0..seeds.len()).filter(|i| has(select, *i, &seeds[*i])).collect();
        if let Some(clusters) = clusters {
            chosen = in_clusters(&seeds, chosen, clusters);
        }
        for i in chosen {
            seeds[i].material = Some(material.clone());
        }
    }
    if let Some(kept) = kept {
        let mut kept = kept.into_iter();
        seeds.retain(|_| kept.next() == Some(true));
    }
    seeds
}

/// Those of the chosen particles that are in clusters.
///
/// A square grid of the size of a cluster has one random point in every cell, and a random rank. A
/// particle belongs to the nearest point. In the order of their ranks, points take their particles
/// as long as that brings the share of the area nearer to the requested one. The result does not
/// depend on the order of the particles.
fn in_clusters(seeds: &[Particle], chosen: Vec<usize>, clusters: &Clusters) -> Vec<usize> {
    let mut cells: BTreeMap<(u64, [i32; 2]), Vec<usize>> = BTreeMap::new();
    let mut points = Points { seed: clusters.seed, known: BTreeMap::new() };
    for i in chosen {
        let (rank, cell) = points.nearest(DVec2::from(seeds[i].position) / clusters.size);
        cells.entry((rank, cell)).or_default().push(i);
    }
    // Sums in the order of sizes do not depend on that of the particles.
    let area = |members: &Vec<usize>| {
        let mut squares: Vec<f64> = members.iter().map(|i| seeds[*i].radius.powi(2)).collect();
        squares.sort_unstable_by(f64::total_cmp);
        squares.iter().sum::<f64>()
    };
    let areas: Vec<f64> = cells.values().map(area).collect();
    let wanted = clusters.share * areas.iter().sum::<f64>();
    let (mut taken, mut members) = (0.0, Vec::new());
    for (cell, area) in cells.into_values().zip(areas) {
        if (taken + area - wanted).abs() < (taken - wanted).abs() {
            taken += area;
            members.extend(cell);
        }
    }
    members
}

/// Random points, one in every cell of a grid of unit squares, each with a rank.
struct Points {
    seed: u64,
    known: BTreeMap<[i32; 2], (DVec2, u64)>,
}

impl Points {
    /// Rank and cell of the point that is nearest to a place.
    fn nearest(&mut self, place: DVec2) -> (u64, [i32; 2]) {
        let home = place.floor().to_array().map(|x| x as i32);
        let mut best = (f64::INFINITY, 0, home);
        // The point of the cell itself is within 1.42; points three cells away are beyond 2.
        for dy in -2..=2 {
            for dx in -2..=2 {
                let cell = [home[0].saturating_add(dx), home[1].saturating_add(dy)];
                let (point, rank) = self.of(cell);
                let distance = point.distance_squared(place);
                if distance < best.0 {
                    best = (distance, rank, cell);
                }
            }
        }
        (best.1, best.2)
    }

    /// Point and rank of a cell.
    fn of(&mut self, cell: [i32; 2]) -> (DVec2, u64) {
        *self.known.entry(cell).or_insert_with(|| {
            let key = cell.map(i32::to_le_bytes);
            let mut random = Random::keyed(key.as_flattened(), self.seed);
            let within = DVec2::new(random.unit(), random.unit());
            (DVec2::from(cell.map(f64::from)) + within, random.integer())
        })
    }
}
