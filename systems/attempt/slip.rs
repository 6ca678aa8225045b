//! The slip of bonds in a step of a followed motion.

use clastic_components::contact_history::ContactHistory;
use clastic_components::findings::Corrections;
use clastic_cone::program::Interaction;
use glam::DVec2;

use crate::ending::geometry::Increment;
use crate::solved::Solved;

/// Gives bonds the shear force of their slip along the finite motion of the step. The slip of the
/// program lacks L phi^3/6 where a bond turns by phi, which its spring would keep for good.
pub(super) fn follow_slip(solved: Solved, corrections: &Corrections, history: &mut ContactHistory) {
    let is_spring = |c: &Interaction| c.limits.has_strength() && c.tangential_compliance > 0.0;
    let springs: Vec<bool> = solved.program.interactions.iter().map(is_spring).collect();
    let misfits = Increment { solved, theta: None, fraction: 1.0, gravity: DVec2::ZERO }
        .ending(corrections, &springs)
        .misfits;
    for ((contact, c, f), [_, slip]) in solved.contacts().zip(misfits) {
        let memory = history.0.binary_search_by_key(&(contact.a, contact.b), |m| (m.a, m.b));
        if let Ok(memory) = memory
            && is_spring(c)
            && !c.limits.slides(f)
        {
            history.0[memory].q += slip / c.tangential_compliance;
        }
    }
}
