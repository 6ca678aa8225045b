//! Judge: was a grain thrown? A static solution may move a barely supported grain by many radii
//! although its residuals are small. The grain lands on others, and later increments lose load
//! without a physical reason. The motion is measured relative to the affine field that fits all
//! grains best.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::Bodies;
use clastic_components::findings::Restraints;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind};
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::closed_pairs::ClosedPairs;
use super::restraints::restrain;
use crate::mean_field::furthest;

/// Maximum number of consecutive attempts with new restraints before the motion is followed.
const MAX_REPLIES: u32 = 3;

/// A grain that a solution moves further than this, in its radii, has no support.
const UNSUPPORTED: f64 = 10.0;

/// Rejects a static solution in which a grain moves further than [`Acceptance::throw`] radii
/// about the mean field.
pub fn judge(
    bodies: Res<Bodies>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    acceptance: Res<Acceptance>,
    analysis: Res<Analysis>,
    mut pairs: ClosedPairs,
    mut restraints: ResMut<Restraints>,
    mut attempt: ResMut<Attempt>,
) {
    if analysis.kind == AnalysisKind::Static
        && let Some(reason) = thrown(&bodies, &program, &solution, &acceptance)
    {
        let acceptance = &acceptance;
        attempt.verdict =
            reply(&bodies, &program, &solution, acceptance, &mut pairs, &mut restraints, reason);
    }
}

/// Reply to a throw. It may show pairs outside the program or [restraints](super::restraints),
/// which the next attempt then includes. If it shows neither, or if they have not helped, the
/// solution is too far away. A solution that moves a grain without support shows no pairs: it ends
/// where no accepted solution can, and such a grain crosses thousands of others.
pub(super) fn reply(
    bodies: &Bodies,
    program: &ConeProgram,
    solution: &ConeSolution,
    acceptance: &Acceptance,
    pairs: &mut ClosedPairs,
    restraints: &mut Restraints,
    reason: String,
) -> Verdict {
    // A pair that stops a grain must not be mistaken for a restraint.
    let learnt = !is_unsupported(bodies, program, solution) && pairs.add(bodies, program, solution)
        || restrain(bodies, program, solution, acceptance, restraints);
    if learnt && restraints.replies < MAX_REPLIES {
        restraints.replies += 1;
        Verdict::Again
    } else {
        Verdict::TooFar(reason)
    }
}

/// Complaint about the grain with the largest throw, if any is too large.
#[must_use]
pub fn thrown(
    bodies: &Bodies,
    program: &ConeProgram,
    solution: &ConeSolution,
    acceptance: &Acceptance,
) -> Option<String> {
    let (i, far) = furthest(bodies, program, solution)?;
    (!(far <= acceptance.throw)).then(|| {
        let at = bodies.positions[i];
        format!(
            "{} at ({:.4e}, {:.4e}) m would be thrown by {} radii relative to the mean \
             motion; `acceptance.throw` allows {}",
            bodies.name(i),
            at.x,
            at.y,
            digits(far),
            acceptance.throw
        )
    })
}

/// A number with three significant digits and at least two decimals.
pub(super) fn digits(number: f64) -> String {
    let decimals = (2.0 - number.abs().log10().floor()).max(2.0);
    if decimals.is_finite() {
        format!("{number:.0$}", decimals as usize)
    } else {
        number.to_string()
    }
}

/// Whether a solution moves a grain so far that the grain lacks support. Other scales do not help
/// then.
pub(super) fn is_unsupported(
    bodies: &Bodies,
    program: &ConeProgram,
    solution: &ConeSolution,
) -> bool {
    solution.displacements.len() == bodies.rows_in_program()
        && furthest(bodies, program, solution).is_some_and(|(_, far)| far > UNSUPPORTED)
}

#[cfg(test)]
mod tests {
    use super::digits;

    /// A grain was "thrown by 0.00 radii; accepted 0.003".
    #[test]
    fn small_numbers_keep_their_digits() {
        assert_eq!(digits(0.004_512), "0.00451");
        assert_eq!(digits(0.301), "0.301");
        assert_eq!(digits(12.345), "12.35");
        assert_eq!(digits(0.0), "0");
        assert_eq!(digits(f64::NAN), "NaN");
        assert_eq!(digits(f64::INFINITY), "inf");
    }
}
