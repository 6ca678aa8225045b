//! Geometric stiffness of taut bonds about which grains would swing.
//!
//! A bond with tension T and length L pulls back a grain that swings about the other end, with the
//! stiffness T/L, like a string. The program holds normals constant and lacks this stiffness. A
//! grain that nothing else holds then swings far past its position of rest, and back again in the
//! next increment. Compared with the stiffness of an elastic bond the term is small (1e-3 at the
//! strength of rock), so it is left out until a grain is thrown. The taut bonds of that grain, and
//! of grains that move with it, then get a tie along the tangent. Its compliance is L/T, and its
//! force is at most that of the bond. It represents the force of the bond itself, turned by the
//! motion, and is no error of the balance. The term of a compressed pair is negative, destabilises
//! a grain, and cannot be part of a convex program. Followed motions cover this case.

use clastic_components::contact::{BodyTable, Contact};
use clastic_components::findings::{Corrections, Restraints};
use clastic_components::increment::{AnalysisKind, ClasticAnalysis};
use clastic_cone::program::{Interaction, Limits};

/// Elongation over the length of a bond below which it counts as slack.
const MIN_ELONGATION: f64 = 1e-9;

/// Whether a bond is taut at the start of the increment.
#[must_use]
pub fn is_taut(bond: &Interaction) -> bool {
    tension(bond) > 0.0
}

/// Tension of an elastic bond at the start of the increment, N. The tension of a rigid bond is not
/// known.
fn tension(bond: &Interaction) -> f64 {
    if bond.normal_compliance <= 0.0 {
        return 0.0;
    }
    if !(bond.offset > MIN_ELONGATION * (bond.arm_a + bond.arm_b)) {
        return 0.0;
    }
    (bond.offset / bond.normal_compliance).min(bond.limits.tension)
}

/// Appends the ties of taut bonds at swinging bodies.
pub fn assemble(
    bodies: &BodyTable,
    contacts: &[Contact],
    analysis: &ClasticAnalysis,
    restraints: &Restraints,
    corrections: &Corrections,
    interactions: &mut Vec<Interaction>,
) {
    if analysis.kind != AnalysisKind::Static {
        return;
    }
    let swings = |i: usize| bodies.swinging[i] || restraints.swinging.get(i).is_some_and(|s| *s);
    for k in 0..contacts.len() {
        let (contact, bond) = (&contacts[k], interactions[k]);
        let ends = [contact.a as usize, contact.b as usize];
        // A wall has no centre about which a grain could swing.
        let pair = ends[1] < bodies.particles;
        if !pair || !ends.into_iter().any(swings) {
            continue;
        }
        let tension = tension(&bond);
        if tension > 0.0 {
            interactions.push(Interaction {
                normal: bond.normal.perp(),
                offset: corrections.of((contact.a, contact.b)).map_or(0.0, |c| c.tie),
                normal_compliance: (bond.arm_a + bond.arm_b) / tension,
                limits: Limits { tension, ..Limits::default() },
                image: bond.image,
                ..Interaction::between(bond.a, bond.b)
            });
        }
    }
}
