//! Settings of the [condensed solver](super::Condensed): every number that steers it.
//!
//! Lengths and displacements are in units of the program's displacement scale and forces in units
//! of its force scale, unless a field says otherwise. Round-off limits and array sizes are
//! constants beside the code that uses them.
//!
//! A default in a comment is followed by what speaks for it; what speaks for the others is in
//! `docs/decisions/001-solver-settings.md`, which says what half and double of all fields change.

/// Tolerance of increments by default (`acceptance.residual` of a scene).
pub(crate) const DEFAULT_RESIDUAL: f64 = 1e-8;

/// Safety factor on the tolerance that a program states, by default.
/// 0.9: the judge of the increment computes the residual again, with different round-off.
const SAFETY: f64 = 0.9;

/// Structs of numbers, each with its default beside it.
macro_rules! settings {
    ($($(#[$about:meta])* pub struct $name:ident {
        $($(#[$field_about:meta])* pub $field:ident: $type:ty = $default:expr,)*
    })*) => {$(
        $(#[$about])*
        #[non_exhaustive]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $($(#[$field_about])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }
    )*};
}
pub(crate) use settings;

settings! {
/// Settings of the condensed solver.
pub struct CondensedSettings {
    /// Maximum residual of a solution, without dimension. A program may allow more
    /// ([`ConeSolver::solve`](crate::solver::ConeSolver::solve)).
    pub tolerance: f64 = SAFETY * DEFAULT_RESIDUAL,
    /// Safety factor on the tolerance that a program states.
    pub safety: f64 = SAFETY,
    /// Tolerance over the goal of the Newton iteration. The iteration measures the unbalance, which
    /// is not the residual of the program. The interior point aims lower by the factor
    /// [`near`](InteriorSettings::near). 90: a goal of 1e-10 for the default tolerance. With 900
    /// `three_point_bending` takes a third more factorisations.
    pub margin: f64 = 90.0,
    /// Number of interactions above which a program is large: its limits are not decided, and without
    /// bonds a time step ends with the first point within the tolerance.
    /// 2500: beyond, exact forces cost more than they gain.
    pub large: usize = 2500,
    /// Maximum displacement of a starting point. A body beyond starts from zero: a start far away
    /// (a grain that settled, another increment) is worse than none.
    pub max_start: f64 = 20.0,
    /// Newton iteration of the whole program.
    pub newton: NewtonSettings = NewtonSettings::default(),
    /// Local elimination between the steps of the Newton iteration.
    pub local: LocalSettings = LocalSettings::default(),
    /// Interior-point method.
    pub interior: InteriorSettings = InteriorSettings::default(),
}

/// Settings of one semismooth Newton iteration.
pub struct NewtonSettings {
    /// Maximum number of factorisations. 16 for the whole program: giving up earlier costs a tenth
    /// to a third of the time at the peak of the rock specimen, because the interior point that
    /// follows costs more (decision 007). 30 for patches: a guard.
    pub max_iterations: u32 = 16,
    /// Length below which a step is tiny, as a fraction of the Newton step. Tiny steps in a row
    /// mean that every loose cluster holds all others back.
    /// 0.02: without the guard `retaining_wall`, `oedometer` and `isotropic_compression` take 2 to 12 %
    /// more factorisations.
    pub tiny_step: f64 = 0.02,
    /// Maximum number of tiny steps in a row. 4 for the whole program: with 1 or 2, six packings
    /// take 0.6 to 3 % more. None in patches, where the guard changes nothing.
    pub max_tiny_steps: u32 = 4,
    /// Damping of the first matrix: added to its diagonal, force over displacement. Halved by every
    /// factorisation. Keeps a step short where nothing is stiff.
    /// 1e-10 for the whole program, 1e-6 for patches. With less damping in patches than before, and
    /// patches of up to 1500 bodies, a tenth to a fifth of the time was saved (decision 007).
    /// Where it is not halved, nine laboratory scenes take 5 % more factorisations.
    pub damping: f64 = 1e-10,
    /// Derivative of the energy along a step that ends the line search, over that at its start.
    pub max_slope: f64 = 0.02,
    /// Maximum number of evaluations of the derivative in a line search.
    /// 30: a bisection gains a factor of 1e9 with as many.
    pub max_evaluations: u32 = 30,
}

/// Settings of local elimination: when it comes before a step of the Newton iteration, which bodies
/// it takes, and how exactly it solves for them.
pub struct LocalSettings {
    /// Length of the last step below which bodies are eliminated, as a fraction of the Newton step.
    pub short_step: f64 = 0.7,
    /// Unbalance above which a body is eliminated, as a fraction of the maximum unbalance.
    /// 0.05: fractions of 1 to 10 % change the time by a tenth (decision 007).
    pub share: f64 = 0.05,
    /// Interactions from a body that is eliminated to the bodies that are eliminated with it.
    /// 2: values of 2 to 5 change the time by a tenth (decision 007).
    pub rings: usize = 2,
    /// Maximum number of bodies of a patch. Larger ones are left to the global step.
    /// 1500: see [`damping`](NewtonSettings::damping).
    pub max_bodies: usize = 1500,
    /// Maximum number of interactions of a body that is eliminated. Bodies with more are mostly
    /// walls, which would join everything to one patch.
    /// 32: a disk among equal ones has at most six contacts.
    pub max_interactions: usize = 32,
    /// Factor by which the step of a fast body exceeds the [`fast_quantile`](Self::fast_quantile) of
    /// all steps, and by which a step must be longer without the fast bodies for them to be left
    /// behind. Without fast bodies rock at its peak takes twice the iterations.
    pub fast: f64 = 2.0,
    /// Quantile of the steps of all bodies that fast bodies are compared with.
    /// 0.97: other quantiles change the time by a tenth (decision 007).
    pub fast_quantile: f64 = 0.97,
    /// Newton iteration of a patch. Its limits guard against hanging: a patch ends at its goal.
    pub newton: NewtonSettings = NewtonSettings {
                max_iterations: 30,
                max_tiny_steps: 30,
                damping: 1e-6,
                ..NewtonSettings::default()
            },
}

/// Settings of the interior-point method. *Residual* is what the method measures of a point, *best*
/// the point with the minimum of it so far.
pub struct InteriorSettings {
    /// Maximum number of factorisations. 80: no solved program is known to have taken more than 59.
    pub max_iterations: u32 = 80,
    /// Maximum force of the elastic trial at the starting displacements. Where a contact carries
    /// more, the method starts from zero.
    /// 1e3: the last solution may load contacts far more than the loads do, and the method does not
    /// recover from such a start (decision 006). With 1e5 a step of disks that roll, which starts with
    /// 9000 times the loads, stalls; 572 programs of laboratory scenes take the same iterations.
    pub max_start_force: f64 = 1e3,
    /// Root of the complementarity products of the starting point.
    pub start: f64 = 0.3,
    /// Complementarity products that the method starts with where it is given forces,
    /// force times displacement.
    /// 3e-4: with less it gets stuck at the wrong limits, with more it forgets the start.
    pub warm_product: f64 = 3e-4,
    /// Proximal weight, force over displacement, and compliance of an interaction, displacement over
    /// force, in a step, per unit of the mean product. They keep bodies that nothing holds in place,
    /// and forces that are not unique.
    pub proximal: f64 = 1e-3,
    /// Minimum proximal weight in a step, force over displacement.
    pub min_proximal: f64 = 1e-10,
    /// Bounds of the minimum compliance of an interaction in a step, displacement over force. An
    /// interaction within its limits is as stiff as this allows. Its minimum is, between the bounds,
    /// the round-off of the matrix over the weakest stiffness that holds a body.
    /// 1e-9: with 1e-12 one random program in 300 remains undecided, mostly those that have a
    /// solution. 1e-6: with 1e-9, 36 of 45 steps of rigid bonded specimens that hang on the
    /// regularisation alone stall; with 1e-6 where bodies have inertia, rigid grains that slide stall,
    /// because a step leaves this part of the way of the forces (decision 006).
    pub min_compliance: [f64; 2] = [1e-9, 1e-6],
    /// Weight of the maximum product in the residual.
    pub product_weight: f64 = 0.02,
    /// Goal of the Newton iteration over that of the method. Which limits are active shows only at a
    /// point that is more exact than the tolerance. A point between the two goals may end the method
    /// if it is good enough and the method is slow.
    /// 10: a goal of 1e-11 for the default tolerance. With 1 `biaxial_membrane_small` takes a quarter
    /// more factorisations: grains without load move further.
    pub near: f64 = 10.0,
    /// Residual over that of the last iteration above which the method is slow.
    /// 0.3: where the method ends only at its goal, `three_point_bending` takes 17 % more
    /// factorisations, near round-off.
    pub slow: f64 = 0.3,
    /// Number of iterations in which the best residual must fall by [`progress`](Self::progress).
    pub patience: usize = 20,
    /// Factor by which the best residual must fall in [`patience`](Self::patience) iterations.
    pub progress: f64 = 0.1,
    /// Maximum number of Newton steps that decide limits, in each of two passes.
    /// 4: with 2 solutions differ by 3e-7, with 8 by 8e-9.
    pub max_decisions: usize = 4,
    /// Slack and multiplier that leave a limit undecided in the second pass, and what a step gives to
    /// both where both vanish, over the tolerance.
    /// 1e-4: from 1e-5 to 1e-2 solutions differ by at most 5e-8, and iterations by 2 %.
    pub decided: f64 = 1e-4,
}
}

impl CondensedSettings {
    /// The defaults with another maximum residual.
    pub fn with_tolerance(tolerance: f64) -> Self {
        Self { tolerance, ..Self::default() }
    }
}
