//! Settings of the interior-point method.

/// Settings of the interior-point method. *Residual* is what the method measures of a point, *best*
/// the point with the minimum of it so far.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InteriorSettings {
    /// Maximum number of factorisations.
    ///
    /// 80: no solved program is known to have taken more than 59.
    pub max_iterations: u32,
    /// Maximum force of the elastic trial at the starting displacements. Where a contact carries
    /// more, the method starts from zero.
    ///
    /// 1e3: the last solution may load contacts far more than the loads do, and the method does not
    /// recover from such a start (decision 006). With 1e5 a step of disks that roll, which starts with
    /// 9000 times the loads, stalls; 572 programs of laboratory scenes take the same iterations.
    pub max_start_force: f64,
    /// Root of the complementarity products of the starting point.
    ///
    /// 0.3: decision 001.
    pub start: f64,
    /// Proximal weight, force over displacement, and compliance of an interaction, displacement over
    /// force, in a step, per unit of the mean product. They keep bodies that nothing holds in place,
    /// and forces that are not unique.
    ///
    /// 1e-3: decision 001.
    pub proximal: f64,
    /// Minimum proximal weight in a step, force over displacement.
    ///
    /// 1e-10: decision 001.
    pub min_proximal: f64,
    /// Bounds of the minimum compliance of an interaction in a step, displacement over force. An
    /// interaction within its limits is as stiff as this allows. Its minimum is, between the bounds,
    /// the round-off of the matrix over the weakest stiffness that holds a body.
    ///
    /// 1e-9: with 1e-12 one random program in 300 remains undecided, mostly those that have a
    /// solution. 1e-6: with 1e-9, 36 of 45 steps of rigid bonded specimens that hang on the
    /// regularisation alone stall; with 1e-6 where bodies have inertia, rigid grains that slide stall,
    /// because a step leaves this part of the way of the forces (decision 006).
    pub min_compliance: [f64; 2],
    /// Weight of the maximum product in the residual.
    ///
    /// 0.02: decision 001.
    pub product_weight: f64,
    /// Goal of the Newton iteration over that of the method. Which limits are active shows only at a
    /// point that is more exact than the tolerance. A point between the two goals may end the method
    /// if it is good enough and the method is slow.
    ///
    /// 10: a goal of 1e-11 for the default tolerance. With 1 `biaxial_membrane_small` takes a quarter
    /// more factorisations: grains without load move further.
    pub near: f64,
    /// Residual over that of the last iteration above which the method is slow.
    ///
    /// 0.3: where the method ends only at its goal, `three_point_bending` takes 17 % more
    /// factorisations, near round-off.
    pub slow: f64,
    /// Number of iterations in which the best residual must fall by [`progress`](Self::progress).
    ///
    /// 20: decision 001.
    pub patience: usize,
    /// Factor by which the best residual must fall in [`patience`](Self::patience) iterations.
    ///
    /// 0.1: decision 001.
    pub progress: f64,
    /// Maximum number of Newton steps that decide limits, in each of two passes.
    ///
    /// 4: with 2 solutions differ by 3e-7, with 8 by 8e-9 (decision 001).
    pub max_decisions: usize,
    /// Slack and multiplier that leave a limit undecided in the second pass, and what a step gives to
    /// both where both vanish, over the tolerance.
    ///
    /// 1e-4: from 1e-5 to 1e-2 solutions differ by at most 5e-8, and iterations by 2 % (decision 001).
    pub decided: f64,
}

impl Default for InteriorSettings {
    fn default() -> Self {
        Self {
            max_iterations: 80,
            max_start_force: 1e3,
            start: 0.3,
            proximal: 1e-3,
            min_proximal: 1e-10,
            min_compliance: [1e-9, 1e-6],
            product_weight: 0.02,
            near: 10.0,
            slow: 0.3,
            patience: 20,
            progress: 0.1,
            max_decisions: 4,
            decided: 1e-4,
        }
    }
}
