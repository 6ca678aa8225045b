//! Grains that were set aside and are held again.

use clastic_components::contact::BodyTable;
use clastic_components::contact_history::{ContactHistory, ContactMemory};

use crate::assemble_program::regularise::MIN_LOAD;
use crate::measures::fragments::fragments;

/// Which particles that are set aside have been touched: a force from outside acts on their fragment.
#[must_use]
pub fn touched(bodies: &BodyTable, history: &ContactHistory) -> Vec<bool> {
    let fragments = fragments(bodies);
    let mut touched = vec![false; bodies.particles];
    let force = |m: &ContactMemory| m.p.abs().max(m.q.abs());
    let threshold = MIN_LOAD * history.0.iter().map(force).fold(0.0, f64::max);
    for m in history.0.iter().filter(|m| force(m) > threshold) {
        let (a, b) = (fragments[m.a as usize], fragments.get(m.b as usize));
        if b != Some(&a) {
            touched[a as usize] = true;
            b.into_iter().for_each(|b| touched[*b as usize] = true);
        }
    }
    fragments.iter().map(|root| touched[*root as usize]).collect()
}
