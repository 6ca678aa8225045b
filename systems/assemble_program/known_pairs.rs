//! Rigid contacts between two bodies with known motion along the normal.
//!
//! A rigid contact allows no overlap at the end of the increment. If both bodies are held, or
//! driven alike, no motion can remove an overlap between them, and the program would be infeasible
//! although nothing moves. Such a contact is left out of the program. A contact that the known
//! motions close stays in the program: these motions are infeasible, and [`forced`] names the pair.

use clastic_components::contact::{BodyTable, Contact};
use clastic_cone::program::{ConeProgram, Dof, Interaction, Limits, ProgramBody};
use glam::DVec2;

use super::interactions::ROUND_OFF;

/// A body does not move along a direction if its axes have smaller components than this in it.
const ACROSS: f64 = 1e-9;

/// Displacement of a body along a direction, m, at a point with this lever arm of a force along
/// it; `None` if it is unknown.
fn known_motion(body: &ProgramBody, direction: DVec2, arm: f64) -> Option<f64> {
    let mut sum = match body.dofs[2] {
        Dof::Fixed(turn) => arm * turn,
        Dof::Free(_) if arm != 0.0 => return None,
        Dof::Free(_) => 0.0,
    };
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

/// Closing of a rigid contact by the known motions of its bodies, m; `None` for all other
/// interactions.
fn closing(bodies: &[ProgramBody], c: &Interaction) -> Option<f64> {
    if c.normal_compliance > 0.0 || c.limits.has_strength() {
        return None;
    }
    let motion = |body: u32, arm: f64| known_motion(&bodies[body as usize], c.normal, arm);
    Some(motion(c.a, c.normal_arm_a)? - motion(c.b, -c.normal_arm_b)?)
}

/// Leaves out the contacts of bodies that overlap and that no known motion closes: they become open
/// contacts without force. Returns whether any contact was left out.
pub(crate) fn leave_out(
    bodies: &BodyTable,
    contacts: &[Contact],
    program: &mut ConeProgram,
) -> bool {
    let round_off = ROUND_OFF * bodies.mean_radius;
    let mut found = false;
    for (contact, c) in contacts.iter().zip(&mut program.interactions) {
        // `interactions` treats a smaller overlap, which is round-off of the last increment, as a
        // touch.
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
    /// Closing by the known motions in the increment, m.
    pub closing: f64,
}

/// The contact with the maximum overlap that the known motions of its bodies impose; `None` if no
/// contact is forced into overlap.
pub fn forced(program: &ConeProgram) -> Option<Forced> {
    let round_off = ROUND_OFF * program.scales.length;
    let pairs = program.interactions.iter().filter_map(|c| {
        let closing = closing(&program.bodies, c)?;
        let forced = Forced { a: c.a, b: c.b, gap: c.offset, closing };
        (closing > round_off && closing - c.offset > round_off).then_some(forced)
    });
    pairs.max_by(|x, y| (x.closing - x.gap).total_cmp(&(y.closing - y.gap)))
}
