//! Geometric stiffness of taut bonds.
//!
//! A bond with tension T and length L pulls back a grain that swings about the other end, with the
//! stiffness T/L, like a string. Constant normals lack this stiffness: a grain that nothing else holds
//! would swing far past its position of rest, and back again in the next increment. Every taut bond of
//! a static program therefore has a tie along its tangent. The compliance of the tie is L/T, and its
//! force is at most that of the bond. It represents the force of the bond itself, turned by the motion,
//! and is no error of the balance. The term of a compressed pair is negative, destabilises a grain, and
//! cannot be part of a convex program. Followed motions cover this case.

use clastic_components::increment::AnalysisKind;
use clastic_cone::program::{ConeProgram, Interaction, Limits};

use super::Trial;
use crate::solved::Solved;

/// Elongation over the length of a bond below which it counts as slack.
const MIN_ELONGATION: f64 = 1e-9;

/// Tension of an elastic bond that counts, N: its elongation does not tell it, because a bond that has
/// turned by 0.02 rad in a step with constant normals is as much longer as a thousand times the weight
/// of its grain stretches it. The tension of a rigid bond is not unique.
fn tension(bond: &Interaction, tension: f64) -> f64 {
    let elongation = tension * bond.normal_compliance;
    if elongation > MIN_ELONGATION * (bond.arm_a + bond.arm_b) {
        tension.min(bond.limits.tension)
    } else {
        0.0
    }
}

/// Appends the ties of taut bonds.
pub(super) fn assemble(trial: &Trial, program: &mut ConeProgram) {
    if trial.analysis.kind != AnalysisKind::Static {
        return;
    }
    let ConeProgram { interactions, last_forces, .. } = program;
    for (k, contact) in trial.contacts.0.iter().enumerate() {
        let bond = interactions[k];
        // A wall has no centre about which a grain could swing.
        if contact.b as usize >= trial.bodies.particles {
            continue;
        }
        let guess = trial.corrections.of((contact.a, contact.b));
        let tension = tension(&bond, guess.map_or(-last_forces[k][0], |guess| guess.tension));
        if tension > 0.0 {
            interactions.push(Interaction {
                normal: bond.normal.perp(),
                offset: guess.map_or(0.0, |guess| guess.tie),
                normal_compliance: (bond.arm_a + bond.arm_b) / tension,
                limits: Limits { tension, ..Limits::default() },
                image: bond.image,
                ..Interaction::between(bond.a, bond.b)
            });
        }
    }
}

/// The ties of a program in the order of their contacts: the index of the contact and that of the tie.
pub fn ties(solved: Solved) -> impl Iterator<Item = (usize, usize)> {
    let Solved { bodies, contacts, program, .. } = solved;
    let listed = contacts.0.len();
    let mut next = 0;
    // Interactions of plugins follow, of which none is across a contact between its bodies.
    (listed + bodies.links.len()..program.interactions.len()).map_while(move |tie| {
        let c = &program.interactions[tie];
        let is_of =
            |bond: &Interaction| (bond.a, bond.b, bond.normal.perp()) == (c.a, c.b, c.normal);
        let contact = (next..listed).find(|k| is_of(&program.interactions[*k]))?;
        next = contact + 1;
        Some((contact, tie))
    })
}
