//! Geometric stiffness of taut bonds about which grains would swing.
//!
//! A bond with tension T and length L pulls back a grain that swings about the other end, with the
//! stiffness T/L, like a string. The program holds normals constant and lacks this stiffness. A
//! grain that nothing else holds then swings far past its position of rest, and back again in the
//! next increment. Compared with the stiffness of an elastic bond the term is small (1e-3 at the
//! strength of rock), so it is left out until a grain is thrown, a motion is followed, or an
//! equilibrium is not found. The taut bonds then get a tie along the tangent: those of that grain and
//! of grains that move with it, or all. Its compliance is L/T, and its force is at most that of the
//! bond. It represents the force of the bond itself, turned by the motion, and is no error of the
//! balance. The term of a compressed pair is negative, destabilises a grain, and cannot be part of a
//! convex program. Followed motions cover this case.

use clastic_components::contact::{BodyTable, Contact};
use clastic_components::findings::{Corrections, Restraints};
use clastic_components::increment::{AnalysisKind, ClasticAnalysis};
use clastic_cone::program::{ConeProgram, Interaction, Limits};

/// Elongation over the length of a bond below which it counts as slack.
const MIN_ELONGATION: f64 = 1e-9;

/// Whether a bond with a known last force was taut in it.
#[must_use]
pub fn is_taut(bond: &Interaction, last: &[f64; 3]) -> bool {
    tension(bond, -last[0]) > 0.0
}

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

/// Ties all grains, because an equilibrium that is not found, at the start or about a guess of the end, may
/// lack the geometric stiffness of taut bonds alone. Returns whether that changes the program; without a
/// taut bond no grain is tied.
pub fn tie_all(
    bodies: &BodyTable,
    program: &ConeProgram,
    corrections: &Corrections,
    restraints: &mut Restraints,
) -> bool {
    let joins = |other: u32| (other as usize) < bodies.particles;
    let has_taut = if corrections.list.is_empty() {
        let mut bonds = program.interactions.iter().zip(&program.last_forces);
        bonds.any(|(c, last)| joins(c.b) && is_taut(c, last))
    } else {
        corrections.list.iter().any(|guess| joins(guess.pair.1) && guess.tension > 0.0)
    };
    if !has_taut {
        return false;
    }
    restraints.swinging.resize(bodies.particles, false);
    let mut grains = restraints.swinging.iter().zip(&bodies.swinging);
    let is_new = grains.any(|(found, before)| !found && !before);
    restraints.swinging.fill(true);
    is_new
}

/// Appends the ties of taut bonds at swinging bodies.
pub fn assemble(
    bodies: &BodyTable,
    contacts: &[Contact],
    analysis: &ClasticAnalysis,
    (restraints, ties_all): (&Restraints, bool),
    corrections: &Corrections,
    last_forces: &[[f64; 3]],
    interactions: &mut Vec<Interaction>,
) {
    if analysis.kind != AnalysisKind::Static {
        return;
    }
    let is_found = |i: usize| restraints.swinging.get(i).is_some_and(|swings| *swings);
    let swings = |i: usize| ties_all || bodies.swinging[i] || is_found(i);
    for k in 0..contacts.len() {
        let (contact, bond) = (&contacts[k], interactions[k]);
        let ends = [contact.a as usize, contact.b as usize];
        // A wall has no centre about which a grain could swing.
        let pair = ends[1] < bodies.particles;
        if !pair || !ends.into_iter().any(swings) {
            continue;
        }
        let guess = corrections.of((contact.a, contact.b));
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
