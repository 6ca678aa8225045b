//! The forces of contacts with which the next increment starts.

use bevy_ecs::prelude::*;
use clastic_components::prelude::*;
use clastic_cone::residuals::Carrying;

use crate::solved::{Solved, SolvedTables};

/// Stores the forces of contacts that persist.
pub fn remember_contacts(
    tables: SolvedTables,
    analysis: Res<ClasticAnalysis>,
    corrections: Res<Corrections>,
    draft: Res<DraftHistory>,
    mut history: ResMut<ContactHistory>,
) {
    *history = remembered(tables.get(), &analysis, &corrections, &draft.0);
}

/// Forces of the persistent contacts after a solution, given those `before` it. An elastic shear
/// force of the program is the average over the increment, so the force at its end is
/// `q = q_0 + (q_program - q_0)/theta`; likewise an elastic rolling moment.
pub fn remembered(
    solved: Solved,
    analysis: &ClasticAnalysis,
    corrections: &Corrections,
    before: &ContactHistory,
) -> ContactHistory {
    let Solved { bodies, contacts, program, solution } = solved;
    let theta = analysis.kind.theta();
    let carrying = Carrying::new(program, solution);
    let mut history = ContactHistory(Vec::with_capacity(contacts.0.len()));
    let is_known = |body: u32| !program.bodies[body as usize].is_free();
    for (k, (contact, c, f)) in solved.contacts().enumerate() {
        // The force between two rigid bodies with known motion is not unique. It may be large, and
        // as a scale it would hide the errors of other forces.
        if c.normal_compliance == 0.0 && is_known(c.a) && is_known(c.b) {
            history.0.extend(before.get(contact.a, contact.b).copied());
            continue;
        }
        let is_kept = c.limits.has_strength() || (f[0] > 0.0 && carrying.is_carrying(k));
        if !is_kept {
            continue;
        }
        let q = if c.tangential_compliance > 0.0 {
            let shift = corrections.shear_shift((contact.a, contact.b), c.tangential_compliance);
            let before = c.previous_shear - shift;
            before + (f[1] - before) / theta
        } else {
            f[1]
        };
        let tau = if c.rolling_compliance > 0.0 {
            c.previous_moment + (f[2] - c.previous_moment) / theta
        } else {
            f[2]
        };
        history.0.push(ContactMemory { a: contact.a, b: contact.b, p: f[0], q, tau });
    }
    if !bodies.groups.is_empty() {
        // Within a group nothing moves, and forces stay as they were.
        history.0.extend(before.0.iter().filter(|m| bodies.are_joined(m.a, m.b)));
        history.0.sort_unstable_by_key(|m| (m.a, m.b));
    }
    history
}
