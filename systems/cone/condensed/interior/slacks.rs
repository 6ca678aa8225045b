//! Slacks and multipliers of the limits of one interaction, and their steps.

/// Slacks and multipliers of the limits. They are positive.
#[derive(Clone, Copy, Debug)]
pub struct Slacks<const Q: usize> {
    /// Slacks w.
    pub w: [f64; Q],
    /// Multipliers lambda.
    pub lambda: [f64; Q],
}

impl<const Q: usize> Slacks<Q> {
    /// Products `w lambda`.
    #[inline]
    pub fn products(&self) -> [f64; Q] {
        std::array::from_fn(|q| self.w[q] * self.lambda[q])
    }
}

/// What a step takes away: the right sides of the system of one interaction.
#[derive(Clone, Copy, Debug)]
pub struct Right<const F: usize, const Q: usize> {
    /// Kinematics of the bodies' step less residuals of stationarity.
    pub kinematics: [f64; F],
    /// Defects d of the limits.
    pub defect: [f64; Q],
    /// Products c.
    pub product: [f64; Q],
}

impl<const F: usize, const Q: usize> Right<F, Q> {
    /// Right sides of the limits once slacks and multipliers are eliminated, `b = c/lambda - d`.
    #[inline]
    pub fn of_limits(&self, slacks: &Slacks<Q>) -> [f64; Q] {
        std::array::from_fn(|q| self.product[q] / slacks.lambda[q] - self.defect[q])
    }
}

/// Steps of the forces, slacks and multipliers of one interaction.
#[derive(Clone, Copy, Debug)]
pub struct Step<const F: usize, const Q: usize> {
    /// Steps of the forces.
    pub s: [f64; F],
    /// Steps of the slacks.
    pub w: [f64; Q],
    /// Steps of the multipliers.
    pub lambda: [f64; Q],
}

impl<const F: usize, const Q: usize> Default for Step<F, Q> {
    fn default() -> Self {
        Self { s: [0.0; F], w: [0.0; Q], lambda: [0.0; Q] }
    }
}
