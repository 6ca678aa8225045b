//! Settings of the [solver of Coulomb's law](super::Coulomb).
//!
//! Forces are in units of the maximum force of the start, displacements in units of the program's
//! displacement scale, and a complementarity product is a force times a displacement.
//! `docs/decisions/001-solver-settings.md` has the effect of half and double of every field, and the
//! evidence for those that name none.

use crate::condensed::settings::settings;

settings! {
/// Settings of the solver of Coulomb's law.
pub struct CoulombSettings {
    /// Products at the start of the interior-point iteration from the associated solution.
    pub product: f64 = 1e-3,
    /// Products at the start of the interior-point iteration from forces of the law, those of the last
    /// solution or after sweeps, and at the end of an arc, as a share of the residual that these leave
    /// (decision 004).
    pub share: f64 = 0.1,
    /// Residual after the sweeps of a time step up to which it begins with such products; beyond it begins
    /// with those of the first arc. Grains that flow are close to their solution then, which takes three to
    /// six factorisations. Of jammed ones the wrong contacts carry load, and such products take forty or fail.
    /// 1e-3: 21 time steps of 2000 disks to 1e-4 take 1.2 times as long with half of it, and as long with
    /// double.
    pub near: f64 = 1e-3,
    /// Maximum number of factorisations of the interior-point iteration.
    pub max_iterations: u32 = 40,
    /// Products at the start of the first and of the second arc, in a fixed order: runs repeat. A time
    /// step of jammed grains begins with the first.
    pub arc_products: [f64; 2] = [1e-1, 1e-3],
    /// Maximum number of factorisations of an arc.
    pub max_arc: u32 = 250,
    /// Maximum number of factorisations that sharpen the end of an arc.
    pub max_sharpening: u32 = 8,
    /// Natural map at which a solution is sharp, over the tolerance. A sharp solution ends the
    /// iteration. 1e-3: the products are then a thousandth of what the tolerance allows.
    pub sharp: f64 = 1e-3,
    /// Factor by which an iteration must lower the residual for another one to follow once the
    /// program is solved, and [`patience`](CoulombInteriorSettings::patience) iterations before.
    pub progress: f64 = 0.5,
    /// Defect of a linear solve, over its right side, that needs no refinement.
    pub refined: f64 = 1e-10,
    /// Interior-point iteration.
    pub interior: CoulombInteriorSettings = CoulombInteriorSettings::default(),
    /// Path by arc length.
    pub arc: ArcSettings = ArcSettings::default(),
}

/// Settings of the interior-point iteration for Coulomb's law.
pub struct CoulombInteriorSettings {
    /// Compliance that regularises the matrix, over the usual compliance of the interaction.
    /// 1e-8: with 1e-10 `poured_bin` takes 13 % more iterations.
    pub regularisation: f64 = 1e-8,
    /// Length below which a step is short, as a fraction of the step to the target.
    pub short_step: f64 = 0.05,
    /// Number of short steps in a row that ends the iteration.
    pub max_short_steps: u32 = 3,
    /// Number of iterations in which the best residual must fall by
    /// [`progress`](CoulombSettings::progress).
    pub patience: usize = 10,
    /// Length of the last step below which the next one goes back to the path first: its target is
    /// at least [`min_centring`](Self::min_centring) times the mean product.
    pub centring_step: f64 = 0.2,
    /// Minimum target after such a step, over the mean product; at most 1.
    pub min_centring: f64 = 0.8,
}

/// Settings of the path by arc length. A *predictor* is a step along the tangent of the path, a
/// *correction* a step back to the path, and tau the parameter of the path.
pub struct ArcSettings {
    /// Compliance that regularises the matrix, over the usual compliance of the interaction.
    /// 1e-10: with 1e-8 `hopper` takes 4 % more iterations, `rotating_drum_small` with a tolerance of
    /// 1e-3 20 % more, `poured_bin` 7 % fewer.
    pub regularisation: f64 = 1e-10,
    /// Relative change of slacks and multipliers by a correction below which the point is on the
    /// path. 0.3: with half and double `poured_bin` takes 13 and 17 % more iterations.
    pub close: f64 = 0.3,
    /// Part of the way to the boundary that a step takes.
    pub reach: f64 = 0.9,
    /// Factor that shortens a predictor whose corrections do not lead to the path.
    pub shortening: f64 = 0.3,
    /// Ratio of the lengths of two corrections above which they diverge.
    pub divergence: f64 = 2.0,
}
}
