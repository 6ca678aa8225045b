//! Rigid contacts between two bodies whose motion along the normal is known.
//!
//! A rigid contact allows no overlap at the end of the increment. Where both bodies are held, or are
//! driven alike, nothing can take out an overlap that they have: the program would have no feasible
//! motion, though nothing moves. Such a contact takes no part in the program. A contact that the known
//! motions close stays in it: these motions are not feasible, and [`forced`] names the pair.

use clastic_components::contact::{Bodies, Contact};
use clastic_cone::program::{ConeProgram, Dof, Interaction, Limits, ProgramBody};
use glam::DVec2;

use super::interactions::ROUND_OFF;

/// A body has no motion along a direction in which its axes have less than this.
const ACROSS: f64 = 1e-9;

/// Displacement of a body along a direction, m; none where it is unknown.
fn known_motion(body: &ProgramBody, direction: DVec2) -> Option<f64> {
    let mut sum = 0.0;
    for (dof, axis) in body.dofs.iter().zip([body.axis, body.axis.perp()]) {
        let part = axis.dot(direction);
        match dof {
            Dof::Fixed(u) => sum += u * part,
            Dof::Free(_) if part.abs() > ACROSS => return None,
            Dof::Free(_) => {}
        }
    }
    Some(sum)
}

/// What the known motions of two bodies close a rigid contact by, m; none for all other interactions.
fn closing(bodies: &[ProgramBody], c: &Interaction) -> Option<f64> {
    if c.normal_compliance > 0.0 || c.limits.has_strength() {
        return None;
    }
    let motion = |body: u32| known_motion(&bodies[body as usize], c.normal);
    Some(motion(c.a)? - motion(c.b)?)
}

/// Leaves out the contacts of bodies that overlap and that no known motion closes: they become open
/// contacts, which carry nothing. Returns whether it left out any.
pub fn leave_out(bodies: &Bodies, contacts: &[Contact], program: &mut ConeProgram) -> bool {
    let round_off = ROUND_OFF * bodies.mean_radius;
    let mut found = false;
    for (contact, c) in contacts.iter().zip(&mut program.interactions) {
        // A smaller overlap is the round-off of the last increment: `interactions` takes it for a touch.
        if contact.gap < -round_off
            && closing(&program.bodies, c).is_some_and(|closing| closing <= round_off)
        {
            (c.offset, c.limits) = (-contact.gap, Limits::default());
            found = true;
        }
    }
    found
}

/// A rigid contact that the known motions of its bodies force into an overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forced {
    /// First body.
    pub a: u32,
    /// Second body.
    pub b: u32,
    /// Gap at the start of the increment, m; negative is overlap.
    pub gap: f64,
    /// What the motions close it by in the increment, m.
    pub closing: f64,
}

/// The contact with the maximum overlap that the known motions of its bodies force. None if no contact is
/// forced.
#[must_use]
pub fn forced(program: &ConeProgram) -> Option<Forced> {
    let round_off = ROUND_OFF * program.scales.length;
    let pairs = program.interactions.iter().filter_map(|c| {
        let closing = closing(&program.bodies, c)?;
        let forced = Forced { a: c.a, b: c.b, gap: c.offset, closing };
        (closing > round_off && closing - c.offset > round_off).then_some(forced)
    });
    pairs.max_by(|x, y| (x.closing - x.gap).total_cmp(&(y.closing - y.gap)))
}
