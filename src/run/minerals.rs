//! Layers, minerals and cuts of a specimen.

use std::collections::BTreeMap;

use super::particles::particles;
use super::select::{Candidate, selects};
use crate::scene::format::{Mineral, Particle, Scene, Select};
use crate::scene::specimen_file::StoredSpecimen;

/// Particles of a scene in the order of identities: those of its specimen that `keep` selects, with
/// the materials that `minerals` gives them. Both select from the uncut specimen.
pub fn specimen(scene: &Scene, stored: Option<&StoredSpecimen>) -> Vec<Particle> {
    let mut seeds = particles(scene, stored);
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
    for Mineral { material, select } in &scene.minerals {
        for (i, seed) in seeds.iter_mut().enumerate() {
            if has(select, i, seed) {
                seed.material = Some(material.clone());
            }
        }
    }
    if let Some(kept) = kept {
        let mut kept = kept.into_iter();
        seeds.retain(|_| kept.next() == Some(true));
    }
    seeds
}
