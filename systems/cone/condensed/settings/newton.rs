//! Settings of the Newton iteration and of local elimination.

/// Settings of one semismooth Newton iteration.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSettings {
    /// Maximum number of factorisations.
    ///
    /// 16 for the whole program: giving up earlier costs a tenth to a third of the time at the peak
    /// of the rock specimen, because the interior point that follows costs more (decision 007). 30 for
    /// patches: a guard.
    pub max_iterations: u32,
    /// Length below which a step is tiny, as a fraction of the Newton step. Tiny steps in a row
    /// mean that every loose cluster holds all others back.
    ///
    /// 0.02: without the guard `retaining_wall`, `oedometer` and `isotropic_compression` take 2 to 12 %
    /// more factorisations.
    pub tiny_step: f64,
    /// Maximum number of tiny steps in a row.
    ///
    /// 4 for the whole program: with 1 or 2, six packings take 0.6 to 3 % more. None in patches, where
    /// the guard changes nothing.
    pub max_tiny_steps: u32,
    /// Damping of the first matrix: added to its diagonal, force over displacement. Halved by every
    /// factorisation. Keeps a step short where nothing is stiff.
    ///
    /// 1e-10 for the whole program, 1e-6 for patches. With less damping in patches than before, and
    /// patches of up to 1500 bodies, a tenth to a fifth of the time was saved (decision 007).
    /// Where it is not halved, nine laboratory scenes take 5 % more factorisations.
    pub damping: f64,
    /// Derivative of the energy along a step at which the line search ends, as a fraction of that at
    /// the start of the step.
    ///
    /// 0.02: decision 001.
    pub max_slope: f64,
    /// Maximum number of evaluations of the derivative in a line search.
    ///
    /// 30: a bisection gains a factor of 1e9 with as many.
    pub max_evaluations: u32,
}

impl Default for NewtonSettings {
    fn default() -> Self {
        Self {
            max_iterations: 16,
            tiny_step: 0.02,
            max_tiny_steps: 4,
            damping: 1e-10,
            max_slope: 0.02,
            max_evaluations: 30,
        }
    }
}

/// Settings of local elimination: when it comes before a step of the Newton iteration, which bodies
/// it takes, and how exactly it solves for them.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalSettings {
    /// Length of the last step below which bodies are eliminated, as a fraction of the Newton step.
    ///
    /// 0.7: decision 001.
    pub short_step: f64,
    /// Unbalance above which a body is eliminated, as a fraction of the maximum unbalance.
    ///
    /// 0.05: fractions of 1 to 10 % change the time by a tenth (decision 007).
    pub share: f64,
    /// Interactions from a body that is eliminated to the bodies that are eliminated with it.
    ///
    /// 2: values of 2 to 5 change the time by a tenth (decision 007).
    pub rings: usize,
    /// Maximum number of bodies of a patch. Larger ones are left to the global step.
    ///
    /// 1500: saved a tenth to a fifth of the time, together with
    /// [`damping`](NewtonSettings::damping) (decision 007).
    pub max_bodies: usize,
    /// Maximum number of interactions of a body that is eliminated. Bodies with more are mostly
    /// walls, which would join everything to one patch.
    ///
    /// 32: a disk among equal ones has at most six contacts.
    pub max_interactions: usize,
    /// Factor by which the step of a fast body exceeds the [`fast_quantile`](Self::fast_quantile) of
    /// all steps, and by which a step must be longer without the fast bodies for them to be left
    /// behind.
    ///
    /// 2: decision 001. Without fast bodies rock at its peak takes twice the iterations.
    pub fast: f64,
    /// Quantile of the steps of all bodies that fast bodies are compared with.
    ///
    /// 0.97: other quantiles change the time by a tenth (decision 007).
    pub fast_quantile: f64,
    /// Newton iteration of a patch. Its limits guard against hanging: a patch ends at its goal.
    pub newton: NewtonSettings,
}

impl Default for LocalSettings {
    fn default() -> Self {
        Self {
            short_step: 0.7,
            share: 0.05,
            rings: 2,
            max_bodies: 1500,
            max_interactions: 32,
            fast: 2.0,
            fast_quantile: 0.97,
            newton: NewtonSettings {
                max_iterations: 30,
                max_tiny_steps: 30,
                damping: 1e-6,
                ..NewtonSettings::default()
            },
        }
    }
}
