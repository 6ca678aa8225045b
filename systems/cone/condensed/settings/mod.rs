//! Settings of the [condensed solver](super::Condensed): every number that steers it.
//!
//! Lengths and displacements are in units of the program's displacement scale and forces in units
//! of its force scale, unless a field says otherwise. Round-off limits and array sizes are
//! constants beside the code that uses them.
//!
//! `docs/decisions/001-solver-settings.md` says what half and double of the fields change, and how
//! that is measured. A field without evidence of its own refers to it.

mod interior;
mod newton;

pub use self::interior::InteriorSettings;
pub use self::newton::{LocalSettings, NewtonSettings};

/// Tolerance of increments by default (`acceptance.residual` of a scene).
pub(crate) const DEFAULT_RESIDUAL: f64 = 1e-8;

/// Settings of the condensed solver.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CondensedSettings {
    /// Maximum residual of a solution, without dimension. A program may allow more
    /// ([`ConeSolver::solve`](crate::solver::ConeSolver::solve)).
    ///
    /// 0.9 times the default tolerance of increments, 1e-8.
    pub tolerance: f64,
    /// Safety factor on the tolerance that a program states.
    ///
    /// 0.9: the judge of the increment computes the residual again, with different round-off.
    pub safety: f64,
    /// Tolerance over the goal of the Newton iteration. The iteration measures the unbalance, which
    /// is not the residual of the program. The interior point aims lower by the factor
    /// [`near`](InteriorSettings::near).
    ///
    /// 90: a goal of 1e-10 for the default tolerance. With 900 `three_point_bending` takes a third more
    /// factorisations.
    pub margin: f64,
    /// Number of interactions above which a program is large: its limits are not decided, and without
    /// bonds a time step ends with the first point within the tolerance.
    ///
    /// 2500: beyond, exact forces cost more than they gain.
    pub large: usize,
    /// Maximum displacement of a starting point. A body beyond starts from zero: a start far away
    /// (a grain that settled, another increment) is worse than none.
    ///
    /// 20: decision 001.
    pub max_start: f64,
    /// Complementarity products that the interior point starts with where it starts from the last
    /// forces, force times displacement.
    ///
    /// 3e-4: with less it gets stuck at the wrong limits, with more it forgets the start.
    pub warm_product: f64,
    /// Newton iteration of the whole program.
    pub newton: NewtonSettings,
    /// Local elimination between the steps of the Newton iteration.
    pub local: LocalSettings,
    /// Interior-point method.
    pub interior: InteriorSettings,
}

impl Default for CondensedSettings {
    fn default() -> Self {
        let safety = 0.9;
        Self {
            tolerance: safety * DEFAULT_RESIDUAL,
            safety,
            margin: 90.0,
            large: 2500,
            max_start: 20.0,
            warm_product: 3e-4,
            newton: NewtonSettings::default(),
            local: LocalSettings::default(),
            interior: InteriorSettings::default(),
        }
    }
}

impl CondensedSettings {
    /// The defaults with another maximum residual.
    #[must_use]
    pub fn with_tolerance(tolerance: f64) -> Self {
        Self { tolerance, ..Self::default() }
    }
}
