//! Dissipation of interactions in a static increment, whose forces go from initial to final values.
//!
//! With the forces `s_0` at the start, the forces `s_1` at the end, which balance the loads `f_1`,
//! and the loads `f_0` at the start, `G'u = e` gives
//!
//! ```text
//! 1/2 (f_0 + f_1) . u = sum_c 1/2 (s_0 + s_1) . e + 1/2 (f_0 - G s_0) . u
//! ```
//!
//! The last term is the work of the out-of-balance force at the start: normals have turned, bonds
//! have broken.

use clastic_components::contact_history::{ContactHistory, ContactMemory};
use clastic_components::energy::{Energies, Released};

use super::interactions::{Part, Tables};
use crate::assemble_program::taut;
use crate::solved::Solved;

/// Forces of the interactions at the start of a static increment.
pub struct Starts<'a> {
    /// Memory of the contacts at the start.
    pub memory: &'a ContactHistory,
    /// Forces that ended with the bonds that broke at the end of the last increment.
    pub released: &'a [Released],
    /// Whether no interaction is elastic. The forces then store no energy and hold from the start.
    pub is_rigid: bool,
    /// Forces by interaction before bonds broke, N, N, N m. They balance the loads at the start.
    pub forces: Vec<[f64; 3]>,
}

impl<'a> Starts<'a> {
    /// Before any interaction is booked, all have their final forces. Links and interactions of plugins
    /// keep them; ties have none at the start, where the force of the bond has its direction.
    pub fn new(memory: &'a ContactHistory, released: &'a [Released], tables: &Tables) -> Self {
        let Solved { program, solution, .. } = tables.solved;
        let is_rigid = program.interactions.iter().all(|c| {
            [c.normal_compliance, c.tangential_compliance, c.rolling_compliance] == [0.0; 3]
        });
        let released: &[Released] = if is_rigid { &[] } else { released };
        let mut forces = solution.forces.clone();
        taut::ties(tables.solved).for_each(|(_, tie)| forces[tie] = [0.0; 3]);
        Self { memory, released, is_rigid, forces }
    }

    /// Adds the work of an interaction.
    pub fn book(&mut self, e: &mut Energies, tables: &Tables, part: &Part) {
        let memory = self.memory.get(part.contact.a, part.contact.b);
        let start = if self.is_rigid { part.forces } else { self.start(e, part, memory) };
        let [p, q, tau] = [0, 1, 2].map(|k| 0.5 * (start[k] + part.forces[k]));
        let [normal, shear, rolling] = part.change();
        let (m, d) = (&part.multipliers, part.kinematics);
        let (slid, rolled) = (part.forces[1] * m.slip, part.forces[2] * m.rotation);
        e.turning -= part.normal[2] - part.normal[1];
        e.friction += slid;
        e.rolling += rolled;
        e.numerical += q * d[1] - slid - shear + tau * d[2] - rolled - rolling;
        // Work of the normal force that is not stored as elastic energy.
        let rest = p * d[0] - normal - part.opening();
        let ends = tables.history.get(part.contact.a, part.contact.b).is_some();
        let stays = part.is_bond || (memory.is_some() && ends);
        if stays && !part.breaks {
            *(if part.dilates() { &mut e.dilation } else { &mut e.turning }) += rest;
        } else {
            // A bond opens at its limit under the final force.
            let under = if part.is_bond { part.forces[0] } else { p };
            let opened = if part.is_bond || ends { -under * part.opened() } else { 0.0 };
            e.dilation += opened;
            e.numerical += rest - opened;
        }
    }

    /// Forces of an interaction at the start, after bonds broke.
    fn start(&mut self, e: &mut Energies, part: &Part, memory: Option<&ContactMemory>) -> [f64; 3] {
        let c = part.law;
        let gap = part.gap;
        let by_law = if c.normal_compliance > 0.0 { -gap / c.normal_compliance } else { 0.0 };
        let by_law = if part.is_bond { by_law } else { by_law.max(0.0) };
        let mut before = memory.map_or([by_law, 0.0, 0.0], |m| [m.p, m.q, m.tau]);
        let key = (part.contact.a, part.contact.b);
        let released = self.released.binary_search_by_key(&key, |r| (r.a, r.b)).ok();
        let after = if let Some(k) = released {
            // The memory contains the remaining shear force and elastic moment.
            let lost = self.released[k].forces;
            before[1] += lost[1];
            if c.rolling_compliance > 0.0 {
                before[2] += lost[2];
            }
            [0, 1, 2].map(|k| before[k] - lost[k])
        } else {
            before
        };
        self.forces[part.index] = before;
        e.motion += (0..3).map(|k| 0.5 * (before[k] - after[k]) * part.kinematics[k]).sum::<f64>();
        after
    }
}
