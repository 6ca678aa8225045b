//! Fragments: sets of particles that intact bonds connect.

use clastic_components::contact::BodyTable;
use clastic_components::measure::FragmentPart;

/// The fragment of every particle, as the row of its first particle. Intact bonds between particles
/// and rigid groups connect; walls do not.
pub fn fragments(bodies: &BodyTable) -> Vec<u32> {
    let n = bodies.particles as u32;
    let bonds = bodies.bonds.iter().filter(|bond| bond.b < n).map(|bond| (bond.a, bond.b));
    let members = |group| bodies.particles_of(group).map(|row| row as u32);
    let groups = bodies.groups.iter().flat_map(|group| members(group).zip(members(group).skip(1)));
    connected(bodies.particles, bonds.chain(groups))
}

/// The first of the rows that pairs connect with each of `n` rows.
pub fn connected(n: usize, pairs: impl Iterator<Item = (u32, u32)>) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..n as u32).collect();
    for (a, b) in pairs {
        // The lower row becomes the root, so that the result does not depend on the order.
        let (a, b) = (root(&mut parents, a), root(&mut parents, b));
        parents[a.max(b) as usize] = a.min(b);
    }
    (0..n as u32).map(|row| root(&mut parents, row)).collect()
}

/// The root of a row in a forest of parents.
fn root(parents: &mut [u32], mut row: u32) -> u32 {
    while parents[row as usize] != row {
        let above = parents[parents[row as usize] as usize];
        parents[row as usize] = above;
        row = above;
    }
    row
}

/// A reading of the fragments. `None` without particles.
pub fn read(bodies: &BodyTable, part: FragmentPart) -> Option<f64> {
    let fragments = fragments(bodies);
    let mut sizes = vec![0_usize; fragments.len()];
    let mut masses = vec![0.0; fragments.len()];
    for (row, fragment) in fragments.iter().enumerate() {
        sizes[*fragment as usize] += 1;
        masses[*fragment as usize] += bodies.masses[row];
    }
    let largest = sizes.iter().copied().max()?;
    Some(match part {
        FragmentPart::Number => sizes.iter().filter(|size| **size > 0).count() as f64,
        FragmentPart::Largest => largest as f64,
        FragmentPart::LargestShare => {
            masses.iter().copied().fold(0.0, f64::max) / bodies.masses.iter().sum::<f64>()
        }
        FragmentPart::Single => sizes.iter().filter(|size| **size == 1).count() as f64,
    })
}
