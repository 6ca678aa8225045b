//! What contacts and bonds take of an increment or of a step of a motion.

use glam::DVec2;

use clastic_components::bond::BondId;
use clastic_components::contact::{Bodies, Contact, ContactHistory, Contacts};
use clastic_components::energy::Energies;
use clastic_components::findings::Corrections;
use clastic_components::increment::{Analysis, AnalysisKind};
use clastic_components::material::Materials;
use clastic_components::program::{ConeProgram, ConeSolution};

use crate::assemble_program::interactions::contact_law;
use crate::solve_program::residuals::multipliers;

/// Tables at the start of what is booked, and what came of it.
pub struct Tables<'a> {
    pub bodies: &'a Bodies,
    pub contacts: &'a Contacts,
    /// Memory of the contacts at the end.
    pub history: &'a ContactHistory,
    pub materials: &'a Materials,
    pub analysis: &'a Analysis,
    pub program: &'a ConeProgram,
    pub solution: &'a ConeSolution,
    pub corrections: &'a Corrections,
    /// Positions at the end, m.
    pub end: &'a [DVec2],
}

/// Books the work of contacts and bonds, given the elastic energy `before` and which bonds broke, and returns the
/// elastic energy at the end, J.
pub fn book(
    e: &mut Energies,
    tables: &Tables,
    before: Option<f64>,
    is_broken: impl Fn(BondId) -> bool,
) -> f64 {
    let Tables { bodies, contacts, program, solution, corrections, .. } = tables;
    let theta = match tables.analysis.kind {
        AnalysisKind::Dynamic { theta, .. } => theta,
        AnalysisKind::Static | AnalysisKind::LeastMotion { .. } => 1.0,
    };
    // Elastic energy: of the state at the start, by the law of the program at start and end, and
    // of the state at the end. They differ where bonds break.
    let (mut starts, mut ends, mut state) = (0.0, 0.0, 0.0);
    let mut broke_before = false;
    for ((contact, c), f) in contacts.0.iter().zip(&program.interactions).zip(&solution.forces) {
        let m = multipliers(c, &program.kinematics(c, &solution.displacements), f);
        let [p, q, tau] = *f;
        let broken =
            contact.bond.map(|k| &bodies.bonds[k as usize]).is_some_and(|b| is_broken(b.id));
        let as_bond = contact.bond.is_some() && (c.limits.has_strength() || !broken);
        broke_before |= broken && !as_bond;
        let key = (contact.a, contact.b);

        e.friction += q * m.slip;
        e.rolling += tau * m.rotation;
        let opens = c.limits.friction * m.slip.abs() + c.limits.rolling * m.rotation.abs();
        e.dilation -= p * c.dilation * opens;
        if as_bond {
            e.rupture -= p * m.tension;
        }
        let taken = p * (c.offset + c.normal_compliance * p)
            + c.tangential_compliance * q * (q - c.previous_shear);

        let shift = corrections.shear_shift(key, c.tangential_compliance);
        let sheared = c.previous_shear - shift;
        let compliances = [theta * c.normal_compliance, theta * c.tangential_compliance];
        let born = contact.bond.filter(|_| as_bond).map(|k| bodies.bonds[k as usize].initial_gap);
        let gap = gap_at(bodies, tables.end, contact);
        let shear = sheared + (q - sheared) / theta;
        let remembered = tables.history.get(contact.a, contact.b).map_or(0.0, |m| m.q);
        let start = stored(compliances, contact.gap, born, sheared);
        let finish = stored(compliances, gap, born, if broken { shear } else { remembered });
        starts += start;
        ends += finish;
        e.numerical += taken - (finish - start);
        state += if broken && as_bond {
            let law = contact_law(bodies, tables.materials, tables.analysis, contact);
            let compliances = [law.normal_compliance, law.tangential_compliance];
            stored(compliances, gap, None, remembered)
        } else {
            finish
        };
    }
    // Bonds that break before the last solve, or cement between two increments.
    let before = before.unwrap_or(starts);
    *(if broke_before { &mut e.rupture } else { &mut e.numerical }) += before - starts;
    e.rupture += ends - state;
    e.elastic = state - before;
    state
}

/// Gap of a contact at the given positions, m.
fn gap_at(bodies: &Bodies, positions: &[DVec2], contact: &Contact) -> f64 {
    let (a, b) = (contact.a as usize, contact.b as usize);
    match bodies.radii.get(b) {
        Some(radius) => positions[a].distance(positions[b]) - bodies.radii[a] - radius,
        // The normal of a wall points from the particle to the wall.
        None => (positions[b] - positions[a]).dot(contact.normal) - bodies.radii[a],
    }
}

/// Elastic energy of an interaction, J: of a bond that is free of stress at the gap `born`, or of a
/// contact, which only presses.
fn stored([normal, tangential]: [f64; 2], gap: f64, born: Option<f64>, shear: f64) -> f64 {
    let overlap = match born {
        Some(born) => born - gap,
        None => (-gap).max(0.0),
    };
    let pressed = if normal > 0.0 { 0.5 * overlap * overlap / normal } else { 0.0 };
    pressed + 0.5 * tangential * shear * shear
}
