//! Geometric stiffness of taut bonds and of concave walls.
//!
//! A bond with tension T and length L pulls back a grain that swings about the other end, with the
//! stiffness T/L, like a string. So does the pressure T of a concave arc on a grain inside, whose centre
//! is at the distance L from that of the arc. Constant normals lack this stiffness: a grain that nothing
//! else holds would swing far past its position of rest, and back again in the next increment. Each such
//! contact of a static program therefore has a tie along its tangent. The compliance of the tie is L/T,
//! and its force is at most T. It represents the normal force itself, turned by the motion, and is no
//! error of the balance. The term of other contacts is negative, destabilises a grain, and cannot be part
//! of a convex program. Followed motions cover this case. Rigid groups have their own
//! stiffness, in `groups`.

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Interaction, Limits};
use glam::DVec2;

use super::Trial;
use super::regularise::MIN_LOAD;
use crate::solved::Solved;

/// Elongation over the length from which a contact is taut.
const MIN_ELONGATION: f64 = 1e-9;

/// The force, N, that pulls a grain back which moves along the tangent of a contact, and the length, m, on
/// which it swings. `tension` is that of the last solution: the gap does not give it, because a
/// bond that has turned by 0.02 rad in a step with constant normals is as much longer as a thousand
/// times the weight of its grain stretches it. Stiff contacts hold a load almost without
/// elongation: a force above `least` counts in any case.
fn pull(
    bodies: &BodyTable,
    contact: &Contact,
    c: &Interaction,
    tension: f64,
    least: f64,
) -> Option<[f64; 2]> {
    let (force, length) = if (contact.b as usize) < bodies.particles {
        (tension.min(c.limits.tension), c.arm_a + c.arm_b)
    } else {
        let to_wall = bodies.positions[contact.b as usize] - bodies.positions[contact.a as usize];
        match bodies.wall(contact.b)?.nearest(to_wall, DVec2::ZERO).curve {
            Curve::Hollow(centre) => (-tension, (to_wall + centre).length()),
            Curve::Flat | Curve::Round(_) => return None,
        }
    };
    let is_taut = force > least || force * c.normal_compliance > MIN_ELONGATION * length;
    (force > 0.0 && length > 0.0 && is_taut).then_some([force, length])
}

/// Appends the ties.
pub(super) fn assemble(trial: &Trial, program: &mut ConeProgram) {
    if trial.analysis.kind != AnalysisKind::Static {
        return;
    }
    let ConeProgram { interactions, last_forces, .. } = program;
    let (fraction, gravity) = (trial.progress.fraction, trial.analysis.gravity);
    let loads = (0..trial.bodies.particles).map(|i| trial.bodies.force_on(i, fraction, gravity));
    let loads: f64 = loads.map(DVec2::length).sum();
    let least = if loads > 0.0 { MIN_LOAD * loads } else { f64::INFINITY };
    for (k, contact) in trial.contacts.0.iter().enumerate() {
        let c = interactions[k];
        let guess = trial.corrections.of((contact.a, contact.b));
        let tension = guess.map_or(-last_forces[k][0], |guess| guess.tension);
        // Rigid bonds in loops may carry any force, of which at most the sum of the loads is real.
        let is_rigid = c.normal_compliance == 0.0;
        let tension = if is_rigid { tension.clamp(-loads, loads) } else { tension };
        if let Some([tension, length]) = pull(&trial.bodies, contact, &c, tension, least) {
            interactions.push(Interaction {
                normal: c.normal.perp(),
                offset: guess.map_or(0.0, |guess| guess.tie),
                normal_compliance: length / tension,
                limits: Limits { tension, ..Limits::default() },
                image: c.image,
                ..Interaction::between(c.a, c.b)
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
