//! The size of a cone program in standard form.

use clastic_cone::program::{ConeProgram, Limits};

/// Size of a [`ConeProgram`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProgramSize {
    /// Variables p, q, tau.
    pub forces: usize,
    /// Variables t, r: degrees of freedom with inertia or regularisation.
    pub inertias: usize,
    /// Balance rows: free degrees of freedom.
    pub balance_rows: usize,
    /// Limit rows.
    pub limit_rows: usize,
}

/// Number of force variables, balance rows and limit rows of a program.
pub fn size(program: &ConeProgram) -> ProgramSize {
    let limits = || program.interactions.iter().map(|c| &c.limits);
    let free = || program.bodies.iter().flat_map(|body| body.free().map(|(_, free)| free));
    let rows = |l: &Limits| {
        2 * usize::from(l.has_shear())
            + 2 * usize::from(l.has_rolling())
            + usize::from(l.has_tension_row())
    };
    ProgramSize {
        forces: limits().flat_map(Limits::forces).filter(|has| *has).count(),
        inertias: free().filter(|f| f.inertia + f.proximal > 0.0).count(),
        balance_rows: free().count(),
        limit_rows: limits().map(rows).sum(),
    }
}
