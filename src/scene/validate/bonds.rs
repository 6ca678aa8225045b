//! Explicit bonds.

use std::collections::BTreeMap;

use crate::scene::format::Specimen;
use crate::text::spans::join;

use super::findings::At;
use super::parts::index_exists;

pub(super) fn check(at: &mut At) {
    if !at.are_sure_of(&["specimen", "bonds"]) {
        return;
    }
    let mut seen = BTreeMap::new();
    for (i, bond) in at.context.scene.bonds.iter().enumerate() {
        let at = &mut at.item("bonds", i);
        let exist = index_exists(at, "a", bond.a) & index_exists(at, "b", bond.b);
        if bond.a == bond.b {
            let message = format!("a bond of particle {} to itself", bond.a);
            at.add("", message, "name two particles");
        } else if let Some(first) = seen.insert((bond.a.min(bond.b), bond.a.max(bond.b)), i) {
            let message = format!("a second bond of particles {} and {}", bond.a, bond.b);
            at.add("", message, format!("the first is bonds[{first}]"));
        } else if exist {
            bond_law(at, [bond.a, bond.b]);
        }
    }
}

fn bond_law(at: &mut At, ends: [u32; 2]) {
    let context = at.context;
    let only = (context.materials.len() == 1).then(|| context.materials[0]);
    let of = |index: u32| {
        let index = index as usize;
        let row = || context.specimen?.rows.get(index);
        if let Some(seeds) = &context.seeds {
            return seeds.get(index)?.material.as_deref().or(only);
        }
        let named = match &context.scene.specimen {
            Specimen::Particles(list) => list.get(index)?.material.as_deref(),
            Specimen::Lattice { material, .. } | Specimen::Packing { material, .. } => {
                material.as_deref()
            }
            Specimen::File { material, .. } => row()?.material.as_deref().or(material.as_deref()),
            Specimen::State { .. } => row()?.material.as_deref(),
        };
        named.or(only)
    };
    // A missing or unknown material is reported at the particle.
    let lawless = |name: &&str| {
        context.scene.materials.get(*name).is_some_and(|material| material.bond.is_none())
    };
    let material = ends.into_iter().filter_map(of).find(lawless);
    if let Some(name) = material.filter(|_| at.is_sure_of("materials")) {
        let help = format!("add `bond: (...)` to {}", join("materials", name));
        at.add("", format!("material `{name}` has no bond law"), help);
    }
}
