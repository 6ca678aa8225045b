//! The interface of solvers of cone programs, and the check for malformed programs.

use glam::DVec2;

use crate::program::{ConeProgram, ConeSolution, Dof};

/// A program that no solver can read: an error of the code that assembled it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("malformed cone program: {0}")]
pub struct MalformedProgram(pub String);

/// Solves cone programs.
///
/// A solver may keep data between calls. A solution may depend on them within the solver's
/// tolerance only, and the data on which its last bits depend are its [`memory`](Self::memory).
pub trait ConeSolver: Send + Sync {
    /// Solves the program under the associated law. The solver may stop at the residual
    /// `tolerance`, or at its own default if that is larger; 0 asks for the default. Every ending of
    /// a well-formed program is a [`ConeSolution`].
    ///
    /// # Errors
    /// Only for a program that is malformed: indices out of range, numbers that are not finite,
    /// negative inertias, compliances or limits.
    fn solve(
        &mut self,
        program: &ConeProgram,
        tolerance: f64,
    ) -> Result<ConeSolution, MalformedProgram>;

    /// Whether the first point within the tolerance suffices as the solution of a program. By
    /// default it does not.
    fn first_point_suffices(&self, _program: &ConeProgram, _tolerance: f64) -> bool {
        false
    }

    /// The start of the next solve, on which its solution depends besides the program: for every
    /// body in its own axes two displacements, m, and a rotation, rad. A checkpoint stores it.
    fn memory(&self) -> &[[f64; 3]] {
        &[]
    }

    /// Takes over the [`memory`](Self::memory) of another solver of this kind.
    fn remember(&mut self, _memory: &[[f64; 3]]) {}
}

/// Refuses programs that are malformed.
///
/// # Errors
/// Indices out of range, numbers that are not finite, negative inertias, compliances or limits.
pub fn check(program: &ConeProgram) -> Result<(), MalformedProgram> {
    let n = program.bodies.len();
    let malformed = |what: String| Err(MalformedProgram(what));
    for (k, body) in program.bodies.iter().enumerate() {
        let sound = |dof: &Dof| match dof {
            Dof::Fixed(u) => u.is_finite(),
            Dof::Free(f) => {
                [f.load, f.momentum, f.reference].iter().all(|x| x.is_finite())
                    && [f.inertia, f.proximal].iter().all(|x| x.is_finite() && *x >= 0.0)
            }
        };
        if !body.axis.is_finite() || !body.dofs.iter().all(sound) {
            let what = "has a number that is not finite, or a negative inertia";
            return malformed(format!("body {k} {what}"));
        }
    }
    if let Some(cell) = &program.cell
        && !(cell.arm.is_finite() && (cell.body as usize) < n)
    {
        return malformed(format!("the cell is body {} of {n}", cell.body));
    }
    for (k, c) in program.interactions.iter().enumerate() {
        let (a, b) = (c.a, c.b);
        // The image of a body moves along the global axes.
        let is_wrong = |b: usize| program.cell.is_none() || program.bodies[b].axis != DVec2::X;
        if c.is_across() && ((b as usize) < n && is_wrong(b as usize)) {
            let what = "without a cell or along other axes than x and y";
            return malformed(format!("interaction {k} has an image of body {b} {what}"));
        }
        if a as usize >= n || b as usize >= n || a == b {
            return malformed(format!("interaction {k} joins bodies {a} and {b} of {n}"));
        }
        let l = &c.limits;
        let arms = [c.arm_a, c.arm_b, c.normal_arm_a, c.normal_arm_b];
        let previous = [c.offset, c.previous_shear, c.previous_moment];
        let compliances = [c.normal_compliance, c.tangential_compliance, c.rolling_compliance];
        let limits = [l.cohesion, l.friction, l.tension, l.rolling, l.moment];
        let mut signed = arms.iter().chain(&previous);
        let mut not_negative = compliances.iter().chain(&limits);
        let is_finite = c.normal.is_finite()
            && c.image.is_finite()
            && signed.all(|x| x.is_finite())
            && not_negative.clone().all(|x| x.is_finite());
        let mistake = if !is_finite {
            "number that is not finite"
        } else if not_negative.any(|x| *x < 0.0) {
            "negative compliance or limit"
        } else {
            continue;
        };
        return malformed(format!("interaction {k} of bodies {a} and {b} has a {mistake}"));
    }
    Ok(())
}
