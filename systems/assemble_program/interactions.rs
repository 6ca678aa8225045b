//! Contacts and bonds as interactions of the program.
//!
//! | | intact bond | unbonded or broken |
//! |---|---|---|
//! | offset g | g_0 - g_b0 | g_0 |
//! | compliances | 1/k of the bond | 1/k of the contact |
//! | c A, f_t, mu, mu_r | of the bond | 0, 0, mu and mu_r of the contact |
//! | previous shear q_0 | last increment's (0 where C_T = 0) | last increment's while in contact |
//! | previous moment tau_0 | last increment's (0 where C_R = 0) | last increment's while in contact
//! |
//!
//! In dynamics an elastic interaction enters with C/theta and g/theta, so that its force in the
//! program is the average over the increment. A rigid interaction keeps g, so that it does not
//! penetrate at the end.

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Interaction, Limits};

use super::Trial;
use crate::contact_laws::Laws;

/// Rigid overlaps below this, in mean radii, are round-off of the last increment. A static program
/// need not remove them. Between bodies that cannot move they would otherwise count as an imposed
/// overlap.
pub(super) const ROUND_OFF: f64 = 1e-9;

/// Fills the interactions with one per contact, in the order of the contacts, and the last forces with
/// theirs after the last increment.
pub(super) fn assemble(trial: &Trial, program: &mut ConeProgram) {
    let Trial { bodies, contacts, history, materials, analysis, pushed, .. } = trial;
    let laws = Laws { bodies, materials, analysis };
    let ConeProgram { interactions, last_forces, .. } = program;
    interactions.clear();
    last_forces.clear();
    let mut memory_of = history.0.ascending();
    interactions.extend(contacts.0.iter().map(|contact| {
        let memory = memory_of(contact.a, contact.b).map_or([0.0; 3], |m| [m.p, m.q, m.tau]);
        last_forces.push(memory);
        let law = match contact.bond.map(|k| &bodies.bonds[k as usize]) {
            Some(bond) => bonded(laws, contact, bond),
            None => unbonded(laws, pushed, contact),
        };
        interaction(trial, contact, law, memory)
    }));
}

/// What the law of a contact or of a bond says of an interaction.
struct Law {
    /// Gap less that without normal force, m.
    gap: f64,
    /// Normal, tangential and rolling compliance.
    compliances: [f64; 3],
    limits: Limits,
}

fn bonded(Laws { bodies, analysis, .. }: Laws, contact: &Contact, bond: &BondRow) -> Law {
    let law = &bond.law;
    let radius = contact.common_radius(bodies);
    let strength = analysis.strength;
    let area = strength * 2.0 * radius * analysis.thickness;
    Law {
        gap: contact.gap - bond.initial_gap,
        compliances: [law.normal_compliance, law.tangential_compliance, law.rolling_compliance],
        limits: Limits::new(
            law.cohesion * area,
            law.friction * strength,
            law.tensile_strength * area,
            law.rolling_friction * strength * radius,
        ),
    }
}

fn unbonded(laws: Laws, pushed: &Pushed, contact: &Contact) -> Law {
    let law = laws.contact(contact);
    let rolling = law.rolling_friction * contact.common_radius(laws.bodies);
    // The motion that separates overlaps is known. Forces and velocities are those of bodies that
    // just touch.
    let touches = pushed.0.is_some() && law.normal_compliance == 0.0;
    Law {
        gap: if touches { contact.gap.max(0.0) } else { contact.gap },
        compliances: [law.normal_compliance, law.tangential_compliance, law.rolling_compliance],
        limits: Limits::new(0.0, law.friction, 0.0, rolling),
    }
}

fn interaction(
    trial: &Trial,
    contact: &Contact,
    law: Law,
    [_, shear, moment]: [f64; 3],
) -> Interaction {
    let Trial { bodies, analysis, corrections, .. } = trial;
    let Law { gap, compliances: [normal, tangential, rolling], limits } = law;
    let theta = analysis.kind.theta();
    let pair = (contact.a, contact.b);
    let correction = corrections.of(pair);
    let (direction, at) = correction.map_or((contact.normal, contact.gap), |c| (c.normal, c.gap));
    // The contact point is the middle of the gap. The arms then add up to the centre distance, so
    // that angular momentum is conserved to round-off.
    let half_gap = 0.5 * at;
    let arm_b = bodies.radii.get(contact.b as usize).map_or(0.0, |r| r + half_gap);
    // The correction applies to the end of the increment, and the program uses averages over it.
    let [turned, lag] = corrections.shift(contact);
    let (normal_compliance, tangential_compliance) = (normal / theta, tangential / theta);
    let shift = corrections.shear_shift(pair, tangential_compliance);
    let has_round_off = normal == 0.0 && (-ROUND_OFF * bodies.mean_radius..0.0).contains(&gap);
    let is_touch = has_round_off
        && match analysis.kind {
            AnalysisKind::Static => true,
            // A group that is held along one direction and turns may touch on the left and on the
            // right of its centre. A rotation that removes the round-off on one side adds to it on
            // the other.
            AnalysisKind::Dynamic { .. } => {
                [contact.a, contact.b].iter().any(|body| is_imposed_on(bodies, *body))
            }
            AnalysisKind::Compaction { .. } => false,
        };
    let gap = if is_touch { 0.0 } else { gap };
    Interaction {
        normal: direction,
        arm_a: bodies.radii[contact.a as usize] + half_gap,
        arm_b,
        offset: if normal > 0.0 { gap / theta } else { gap } + turned + lag,
        normal_compliance,
        tangential_compliance,
        previous_shear: if tangential > 0.0 { shear + shift } else { 0.0 },
        rolling_compliance: rolling / theta,
        previous_moment: if rolling > 0.0 { moment } else { 0.0 },
        limits,
        ..Interaction::between(contact.a, contact.b)
    }
}

/// Whether a body is a member of a rigid group with an imposed motion.
fn is_imposed_on(bodies: &BodyTable, body: u32) -> bool {
    let group = bodies.group(body as usize);
    group.is_some_and(|group| group.drives.iter().any(|drive| *drive != BodyDrive::Free))
}
