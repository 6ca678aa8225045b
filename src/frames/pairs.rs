//! Contacts and bonds of a frame.

use clastic_components::prelude::*;
use clastic_systems::detect_contacts::gaps::{pair_contact, wall_contact};
use clastic_systems::measures::fragments::connected;

use super::{FramePairs, NONE};

/// A pair of bodies of a frame.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub ids: (BodyId, BodyId),
    pub bond: u32,
    pub state: u8,
    pub memory: Option<ContactMemory>,
    pub contact: Contact,
}

/// The code of a bond's state, an index into [`STATES`](super::STATES). Modes are declared in the same
/// order.
pub(crate) fn code(state: BondState) -> u8 {
    match state {
        BondState::Intact => 1,
        BondState::Broken(mode) => 2 + mode as u8,
    }
}

/// Pairs with force or a bond, ordered by bodies and bond. A pair of bodies with several bonds has
/// a row for each. Its force stands with the intact one, or else with the last one.
pub(super) fn pairs(
    bodies: &BodyTable,
    kept: &KeptRows,
    history: &ContactHistory,
    bonds: impl Iterator<Item = ((BodyId, BodyId), u32, u8)>,
) -> Vec<Pair> {
    let row = |ids, bond, state, memory| {
        let contact = contact(bodies, ids)?;
        Some(Pair { ids, bond, state, memory, contact })
    };
    let bonds = bonds.filter_map(|(ids, bond, state)| row(ids, bond, state, None));
    let mut all: Vec<Pair> = bonds.collect();
    all.sort_unstable_by_key(|pair| (pair.ids, pair.bond));
    let bonded = all.len();
    let id = |row: u32| kept.ids.get(row as usize).copied();
    for memory in &history.0 {
        let (Some(a), Some(b)) = (id(memory.a), id(memory.b)) else { continue };
        let known = &mut all[..bonded];
        let from = known.partition_point(|pair| pair.ids < (a, b));
        let to = known.partition_point(|pair| pair.ids <= (a, b));
        let rows = &mut known[from..to];
        let at = rows.iter().position(|pair| pair.state == 1).or(rows.len().checked_sub(1));
        match at {
            Some(at) => rows[at].memory = Some(*memory),
            None => all.extend(row((a, b), NONE, 0, Some(*memory))),
        }
    }
    all.sort_unstable_by_key(|pair| (pair.ids, pair.bond));
    all
}

/// The contact of two bodies where they are; `None` if one of them is gone.
pub(crate) fn contact(bodies: &BodyTable, (a, b): (BodyId, BodyId)) -> Option<Contact> {
    let (a, b) = (bodies.row(a)? as u32, bodies.row(b)? as u32);
    if (b as usize) < bodies.particles {
        return Some(pair_contact(bodies, a, b));
    }
    Some(wall_contact(bodies, a, bodies.wall(b)?))
}

/// The pairs by column.
pub(super) fn columns(all: &[Pair]) -> FramePairs {
    let force = |of: fn(&ContactMemory) -> f64| {
        all.iter().map(|pair| pair.memory.as_ref().map_or(0.0, of) as f32).collect()
    };
    FramePairs {
        a: all.iter().map(|pair| pair.ids.0.0).collect(),
        b: all.iter().map(|pair| pair.ids.1.0).collect(),
        bond: all.iter().map(|pair| pair.bond).collect(),
        state: all.iter().map(|pair| pair.state).collect(),
        p_n: force(|memory| memory.p),
        q_n: force(|memory| memory.q),
        tau_nm: force(|memory| memory.tau),
        gap_m: all.iter().map(|pair| pair.contact.gap as f32).collect(),
        angle_rad: all.iter().map(|pair| pair.contact.normal.to_angle() as f32).collect(),
    }
}

/// Mean stress of every particle: xx, yy and xy, Pa, compression positive. Half the gap belongs to
/// either particle, and the whole gap at a wall, so that the mean of the stresses by volume is that
/// of all contacts.
pub(super) fn stresses(bodies: &BodyTable, all: &[Pair], thickness: f64) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0_f64; 3]; bodies.particles];
    for pair in all {
        let Some(memory) = pair.memory else { continue };
        let Contact { a, b, normal: n, gap, .. } = pair.contact;
        let force = memory.p * n + memory.q * n.perp();
        let is_wall = b as usize >= bodies.particles;
        let share = if is_wall { gap } else { 0.5 * gap };
        for i in [a, b].map(|i| i as usize).into_iter().take(if is_wall { 1 } else { 2 }) {
            let arm = (bodies.radii[i] + share) * n;
            let shear = 0.5 * (arm.x * force.y + arm.y * force.x);
            let parts = [arm.x * force.x, arm.y * force.y, shear];
            sums[i].iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
        }
    }
    let volume = |i: usize| std::f64::consts::PI * bodies.radii[i].powi(2) * thickness;
    sums.iter().enumerate().map(|(i, sum)| sum.map(|s| (s / volume(i)) as f32)).collect()
}

/// The lowest identity of the particles that intact bonds hold together, by particle.
pub(super) fn fragments(bodies: &BodyTable, all: &[Pair]) -> Vec<u32> {
    let intact = all.iter().filter(|pair| pair.state == 1);
    let pairs = intact.map(|pair| (pair.contact.a, pair.contact.b));
    let n = bodies.particles;
    // Rows of particles ascend with their identities.
    let first = connected(n, pairs.filter(|(_, b)| (*b as usize) < n));
    first.into_iter().map(|row| bodies.ids[row as usize].0).collect()
}
