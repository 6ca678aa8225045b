//! Bodies and their places in words, for the complaints of the judges.

use clastic_components::contact::BodyTable;
use clastic_cone::program::ConeProgram;
use clastic_cone::residuals::worst_bodies;

use crate::solved::Solved;

/// Two bodies, which may be the same, and the place of the first one.
pub(crate) fn near(bodies: &BodyTable, [a, b]: [usize; 2]) -> String {
    let partner = if a == b { String::new() } else { format!(" and {}", bodies.name(b)) };
    // The cell has no position.
    let at = bodies
        .positions
        .get(a)
        .map_or(String::new(), |at| format!(" near ({:.4e}, {:.4e}) m", at.x, at.y));
    format!("{}{partner}{at}", bodies.name(a))
}

/// Place of the maximum residual of a solution; empty if it has none.
pub(crate) fn worst_place(Solved { bodies, program, solution, .. }: Solved) -> String {
    worst_bodies(program, solution)
        .map_or(String::new(), |pair| format!(", worst at {}", near(bodies, pair)))
}

/// The body that moves furthest of those that may move, in words. `None` if nothing moves.
pub(crate) fn moves_most(
    bodies: &BodyTable,
    program: &ConeProgram,
    displacements: &[[f64; 3]],
) -> Option<String> {
    let far = program.bodies.iter().zip(displacements).enumerate();
    far.filter(|(_, (body, _))| body.free().any(|(k, _)| k < 2))
        .map(|(i, (_, u))| (i, u[0].hypot(u[1])))
        .filter(|(_, far)| *far > 0.0)
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(i, _)| format!("{} moves most", near(bodies, [i, i])))
}

/// A number with three significant digits and at least two decimals.
pub(crate) fn digits(number: f64) -> String {
    let decimals = (2.0 - number.abs().log10().floor()).max(2.0);
    if decimals.is_finite() {
        format!("{number:.0$}", decimals as usize)
    } else {
        number.to_string()
    }
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
