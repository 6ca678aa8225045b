//! Geometric stiffness of taut bonds, where grains would swing about them.
//!
//! A bond that carries tension T over a length L pulls back a grain that swings about the other end,
//! with T/L per displacement, as a string does. The program's normals are those of the start of the
//! increment: it does not see this, and where nothing else holds a grain it swings far past its place
//! of rest, and back again in the next increment. Beside an elastic bond the term is nothing (1e-3 of
//! its stiffness at the strength of rock), so that it is left out until a grain is thrown. Then the
//! taut bonds of that grain and of those that move with it get a companion: a tie along the tangent,
//! of compliance L/T, which cannot pull harder than the bond does. It is the force of the bond itself,
//! turned by the motion, and no error of the balance. The same term of a compressed pair is negative,
//! drives a grain out, and cannot be part of a convex program: that is left to the motion that is followed.

use clastic_components::contact::{Bodies, Contact};
use clastic_components::findings::Restraints;
use clastic_components::increment::{Analysis, AnalysisKind};
use clastic_cone::program::{Interaction, Limits};

/// Bonds below this fraction of their strength count as slack: they hold nothing.
const LEAST_TENSION: f64 = 1e-6;

/// Whether a bond is taut at the start of the increment.
#[must_use]
pub fn is_taut(bond: &Interaction) -> bool {
    tension(bond) > 0.0
}

/// The tension of an elastic bond at the start of the increment, N; a rigid one does not know its own.
fn tension(bond: &Interaction) -> f64 {
    if bond.normal_compliance <= 0.0 {
        return 0.0;
    }
    let tension = (bond.offset / bond.normal_compliance).min(bond.limits.tension);
    if tension > LEAST_TENSION * bond.limits.tension { tension } else { 0.0 }
}

/// Appends the companions of taut bonds at bodies that swing.
pub fn assemble(
    bodies: &Bodies,
    contacts: &[Contact],
    analysis: &Analysis,
    restraints: &Restraints,
    interactions: &mut Vec<Interaction>,
) {
    if analysis.kind != AnalysisKind::Static {
        return;
    }
    let swings = |i: usize| bodies.swinging[i] || restraints.swinging.get(i).is_some_and(|s| *s);
    for k in 0..contacts.len() {
        let (contact, bond) = (&contacts[k], interactions[k]);
        let ends = [contact.a as usize, contact.b as usize];
        // A wall has no centre to swing about.
        let pair = ends[1] < bodies.particles;
        if !pair || !ends.into_iter().any(swings) {
            continue;
        }
        let tension = tension(&bond);
        if tension > 0.0 {
            interactions.push(Interaction {
                normal: bond.normal.perp(),
                arm_a: 0.0,
                arm_b: 0.0,
                offset: 0.0,
                normal_compliance: (bond.arm_a + bond.arm_b) / tension,
                tangential_compliance: 0.0,
                previous_shear: 0.0,
                limits: Limits { tension, ..Limits::default() },
                ..bond
            });
        }
    }
}
