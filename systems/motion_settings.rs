//! Settings of followed motions: every number that steers
//! [`attempt::motion`](crate::attempt::motion) and [`kinetic_damping`](crate::kinetic_damping).
//!
//! Travels are of the furthest grain ([`travel`](crate::travel)), in its radii. Weights are those of
//! [`Motion::weight`](clastic_components::motion::Motion::weight), without dimension: a small
//! weight is a long step.

use bevy_ecs::prelude::*;

/// Settings of a followed motion. To change them, insert the resource before the first increment.
#[non_exhaustive]
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct MotionSettings {
    /// Maximum travel of all motions of one increment, radii, rejected steps included, if each step
    /// has its intended length. It bounds the number of steps.
    ///
    /// 150: five times [`travel_to_rest`](Self::travel_to_rest).
    pub max_travel: f64,
    /// Maximum travel of one motion, radii: the sum over its steps. Half a turn of what hangs, as a rigid
    /// group or by bonds on a support, and half of a bowl are added. A motion beyond it does not come to
    /// rest.
    ///
    /// 30: a grain that has passed fifteen others; no study.
    pub travel_to_rest: f64,
    /// Maximum number of motions of one increment at one fraction of it.
    ///
    /// 12: a bound on the time of an increment; no study.
    pub max_motions: u32,
    /// Maximum number of rejected steps in a row.
    ///
    /// 10: ten steps of [`min_ratio`](Self::min_ratio) shorten the time to 6e-6; no study.
    pub max_failures: u32,
    /// Gap up to which a pair takes part in every step, mean radii.
    ///
    /// 0.1: a step may change direction, so that the last step does not show which pairs close. The
    /// value is below the intended travel of one step; no study.
    pub reach: f64,
    /// Minimum travel of a motion, in radii of a grain, over
    /// [`Acceptance::turn`](clastic_components::increment::Acceptance::turn): a motion below it
    /// moves nothing. A fixed travel would ignore motions that a small `turn` has asked for.
    ///
    /// 1/20: a fifteenth of the travel of one step at the default of `turn`; no study.
    pub min_travel: f64,
    /// Maximum travel, radii, of a step with a weight of at most [`rest_weight`](Self::rest_weight)
    /// that counts as rest.
    ///
    /// 0.05: a third of the intended travel of one step; no study.
    pub max_travel_at_rest: f64,
    /// Maximum overload of a bond in a step of a motion that a rupture released. It is the part of
    /// the intended travel of a step, in elongations at strength, by which a bond may exceed its
    /// limit.
    ///
    /// 1/3: bonds should break close to their limits.
    pub max_overload: f64,
    /// Weight of the first step of a motion where equilibrium was lost.
    ///
    /// 1e-3: a step that is too long is repeated in a shorter time; no study.
    pub first_weight: f64,
    /// Maximum weight of a step that shows whether the motion is at rest.
    ///
    /// 1e-6: with [`max_travel_at_rest`](Self::max_travel_at_rest) its inertia is at most 5e-6 of the loads.
    pub rest_weight: f64,
    /// Number of steps at [`min_weight`](Self::min_weight) that end the motion: bodies that still
    /// move then are free.
    ///
    /// 4: grains that nothing holds never come to rest; no study.
    pub max_free_steps: u32,
    /// Maximum number of steps of all motions of one increment that ruptures released, rejected
    /// ones included.
    ///
    /// 50 000: a bound on the time, some ten times what the longest took in packings of 400 disks.
    pub max_released_steps: u32,
    /// Minimum weight of a step.
    ///
    /// 1e-9: a thousandth of [`rest_weight`](Self::rest_weight); no study.
    pub min_weight: f64,
    /// Minimum factor between the times of two steps, and factor after a step without a solution.
    ///
    /// 0.3: a step without a solution gives no other information; no study.
    pub min_ratio: f64,
    /// Maximum factor between the times of two steps.
    ///
    /// 10: a hundredth of the weight; no study.
    pub max_ratio: f64,
    /// Maximum factor between the times of a step that went too far and of its repetition; after each
    /// further rejection in a row its square, its cube and so on.
    ///
    /// 0.7: halves a travel that forces cause; no study.
    pub max_shortened: f64,
    /// Minimum share of the travel of a step that counts as caused by forces, not by momentum.
    ///
    /// 1e-3: it keeps the time of the next step finite where momentum is the whole travel; no
    /// study.
    pub min_gain: f64,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            max_travel: 150.0,
            travel_to_rest: 30.0,
            max_motions: 12,
            max_failures: 10,
            reach: 0.1,
            min_travel: 0.05,
            max_travel_at_rest: 0.05,
            max_overload: 1.0 / 3.0,
            first_weight: 1e-3,
            rest_weight: 1e-6,
            max_free_steps: 4,
            max_released_steps: 50_000,
            min_weight: 1e-9,
            min_ratio: 0.3,
            max_ratio: 10.0,
            max_shortened: 0.7,
            min_gain: 1e-3,
        }
    }
}
