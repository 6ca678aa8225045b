//! Slacks and multipliers of the limits of one interaction.

/// Slacks and multipliers of the limits, their steps, and the right sides of the system.
#[derive(Clone, Copy, Debug)]
pub struct Slacks<const Q: usize> {
    /// Slacks w.
    pub w: [f64; Q],
    /// Multipliers lambda.
    pub lambda: [f64; Q],
    /// Steps of w.
    pub dw: [f64; Q],
    /// Steps of lambda.
    pub dlambda: [f64; Q],
    /// Defects d of the limits.
    pub defect: [f64; Q],
    /// Products c that the step takes away.
    pub product: [f64; Q],
}

impl<const Q: usize> Default for Slacks<Q> {
    fn default() -> Self {
        let zero = [0.0; Q];
        Self { w: zero, lambda: zero, dw: zero, dlambda: zero, defect: zero, product: zero }
    }
}

/// Right sides of the limits, `b = c/lambda - d`.
#[inline]
pub fn right<const Q: usize>(slacks: &Slacks<Q>) -> [f64; Q] {
    std::array::from_fn(|q| slacks.product[q] / slacks.lambda[q] - slacks.defect[q])
}
