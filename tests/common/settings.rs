//! Fields of the settings of the solvers by name, for scaling.

use clastic::cone::condensed::CondensedSettings;
use clastic::cone::coulomb::CoulombSettings;

/// A number, or several, that a factor can scale.
pub trait Scaled {
    /// Multiplies by `factor`. Integers are rounded to the nearest and stay above zero.
    fn scale(&mut self, factor: f64);
}

impl Scaled for f64 {
    fn scale(&mut self, factor: f64) {
        *self *= factor;
    }
}

impl Scaled for usize {
    fn scale(&mut self, factor: f64) {
        *self = ((*self as f64 * factor).round() as Self).max(1);
    }
}

impl Scaled for u32 {
    fn scale(&mut self, factor: f64) {
        *self = ((f64::from(*self) * factor).round() as Self).max(1);
    }
}

impl<const N: usize> Scaled for [f64; N] {
    fn scale(&mut self, factor: f64) {
        for x in self {
            x.scale(factor);
        }
    }
}

/// A field: its path, and the function that scales it.
pub type Field<S> = (&'static str, fn(&mut S, f64));

macro_rules! fields {
    ($settings:ty: $($($field:ident).+),* $(,)?) => {
        vec![$((
            stringify!($($field).+),
            (|s: &mut $settings, factor: f64| s.$($field).+.scale(factor))
                as fn(&mut $settings, f64),
        )),*]
    };
}

/// Scales the remainder of a part, because twice the part itself may exceed the whole.
fn scale_rest(part: &mut f64, factor: f64) {
    *part = 1.0 - factor * (1.0 - *part);
}

/// All fields of the condensed solver.
pub fn of_condensed() -> Vec<Field<CondensedSettings>> {
    let mut fields = fields![CondensedSettings:
        tolerance, safety, margin, large, max_start,
        newton.max_iterations, newton.tiny_step, newton.max_tiny_steps, newton.damping,
        newton.max_slope, newton.max_evaluations,
        local.short_step, local.share, local.rings, local.max_bodies, local.max_interactions,
        local.fast, local.newton.max_iterations, local.newton.tiny_step,
        local.newton.max_tiny_steps, local.newton.damping, local.newton.max_slope,
        local.newton.max_evaluations,
        interior.max_iterations, interior.max_start_force, interior.start,
        interior.warm_product, interior.proximal, interior.min_proximal,
        interior.min_compliance, interior.product_weight, interior.near, interior.slow,
        interior.patience, interior.progress, interior.max_decisions, interior.decided,
    ];
    fields.push(("local.fast_quantile", |s, factor| {
        scale_rest(&mut s.local.fast_quantile, factor);
    }));
    fields
}

/// All fields of the solver of Coulomb's law.
pub fn of_coulomb() -> Vec<Field<CoulombSettings>> {
    let mut fields = fields![CoulombSettings:
        product, share, near, max_iterations, arc_products, max_arc, max_sharpening, sharp, progress,
        refined, interior.regularisation, interior.short_step, interior.max_short_steps,
        interior.patience, interior.centring_step,
        arc.regularisation, arc.close, arc.shortening, arc.divergence,
    ];
    fields.push(("interior.min_centring", |s, factor| {
        scale_rest(&mut s.interior.min_centring, factor);
    }));
    fields.push(("arc.reach", |s, factor| scale_rest(&mut s.arc.reach, factor)));
    fields
}
