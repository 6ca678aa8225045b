//! Explicit bonds.

use std::collections::BTreeMap;
use std::fmt::Arguments;

use crate::scene::format::Specimen;
use crate::scene::spans::join;

use super::findings::Findings;
use super::references::index_exists;

/// Checks the bonds that the scene lists.
pub(super) fn check(findings: &mut Findings) {
    let scene = findings.context.scene;
    if !findings.are_sure_of(&["specimen", "bonds"]) {
        return;
    }
    let mut seen = BTreeMap::new();
    for (i, bond) in scene.bonds.iter().enumerate() {
        let mut exist = true;
        for (end, index) in [("a", bond.a), ("b", bond.b)] {
            exist &= index_exists(format_args!("bonds[{i}].{end}"), index, findings);
        }
        let path = format_args!("bonds[{i}]");
        if bond.a == bond.b {
            let message = format!("a bond of particle {} to itself", bond.a);
            findings.add(path, message, "name two particles");
        } else if let Some(first) = seen.insert((bond.a.min(bond.b), bond.a.max(bond.b)), i) {
            let message = format!("a second bond of particles {} and {}", bond.a, bond.b);
            findings.add(path, message, &format!("the first is bonds[{first}]"));
        } else if exist {
            bond_law(path, (bond.a, bond.b), findings);
        }
    }
}

fn bond_law(path: Arguments, (a, b): (u32, u32), findings: &mut Findings) {
    let context = findings.context;
    let only = (context.materials.len() == 1).then(|| context.materials[0]);
    let of = |index: u32| {
        let index = index as usize;
        if let Some(seeds) = &context.seeds {
            return seeds.get(index)?.material.as_deref().or(only);
        }
        let named = match &context.scene.specimen {
            Specimen::Particles(list) => list.get(index)?.material.as_deref(),
            Specimen::Lattice { material, .. } | Specimen::Packing { material, .. } => {
                material.as_deref()
            }
            Specimen::File { material, .. } => {
                let row = context.specimen?.rows.get(index)?;
                row.material.as_deref().or(material.as_deref())
            }
            Specimen::State { .. } => context.specimen?.rows.get(index)?.material.as_deref(),
        };
        named.or(only)
    };
    // A missing or unknown material is reported at the particle.
    let lawless = |name: &&str| {
        context.scene.materials.get(*name).is_some_and(|material| material.bond.is_none())
    };
    let material = [of(a), of(b)].into_iter().flatten().find(lawless);
    if let Some(name) = material.filter(|_| findings.is_sure_of("materials")) {
        let help = format!("add `bond: (...)` to {}", join("materials", name));
        findings.add(path, format!("material `{name}` has no bond law"), &help);
    }
}
