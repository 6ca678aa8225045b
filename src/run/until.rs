//! `Until`: the last increments of a stage are shortened, so that a measure lands on a value.
//!
//! After every increment the fraction to the value follows from the rate of the measure over the
//! last increment. Twice the relative change of that rate is kept as a margin, and a rising rate is
//! expected to continue rising. The measure thus approaches the value from one side, and a linear
//! measure reaches it in one fraction.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::increment::Progress;
use clastic_systems::state::StateOf;

use super::measure_error::error_of;
use super::measures::reading;
use crate::scene::format::{Stage, Stop};

/// Name of [`Approach`] in a state.
pub const APPROACH: &str = "until";

/// Error with which a measure lands, over the value or over the maximum magnitude of the measure in
/// the stage, if that is more.
pub const TOLERANCE: f64 = 1e-6;

/// Part of an increment with which a stage begins: the rate of the measure is not known yet.
const FIRST: f64 = 0.25;

/// Minimum fraction of an increment. It must exceed the round-off of the progress.
const FINEST: f64 = 1e-8;

/// The approach of the measure of an `Until` to its value in the current stage.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Approach {
    /// Whether the stage has an `Until`.
    on: bool,
    /// 1 where the measure began below the value, -1 above it, 0 while it has been at it.
    side: f64,
    /// Maximum magnitude of the measure in the stage.
    scale: f64,
    /// Progress of the stage and measure after the last increments, three at most.
    points: Vec<[f64; 2]>,
}

impl StateOf for Approach {
    fn take(world: &mut World) -> Option<Self> {
        world.get_resource::<Self>().filter(|approach| approach.on).cloned()
    }

    fn put(self, world: &mut World) {
        world.insert_resource(self);
    }
}

fn until(stage: &Stage) -> Option<(&str, f64)> {
    let stage = stage.load()?;
    stage.stop.iter().find_map(|stop| match stop {
        Stop::Until(name, value) => Some((name.as_str(), *value)),
        _ => None,
    })
}

/// Begins a stage.
pub(super) fn begin(world: &mut World, stage: &Stage) {
    let mut approach = Approach::default();
    if let Some((name, value)) = until(stage) {
        approach.on = true;
        if let Some(reading) = reading(world, name) {
            approach.see(0.0, reading, value, 0.0);
        }
        // The next increment tries twice this.
        world.resource_mut::<Progress>().tried = 0.5 * FIRST;
    }
    world.insert_resource(approach);
}

/// How a measure came to its value.
pub(super) struct Landing {
    /// The condition.
    pub stop: Stop,
    /// The measure, if it has passed the value by more than the tolerance: its rate jumped in the
    /// last fraction, or it is not continuous.
    pub passed: Option<f64>,
}

/// Whether the measure has reached the value of the `Until` of the stage. If not, the next
/// increment is shortened where the whole would pass it.
pub(super) fn reached(world: &mut World, stage: &Stage) -> Option<Landing> {
    let (name, value) = until(stage)?;
    let now = reading(world, name)?;
    let error = error_of(world, name);
    let done = world.resource::<Progress>().done;
    let mut approach = world.resource_mut::<Approach>();
    let tolerance = approach.see(done, now, value, error);
    if approach.side != 0.0 && approach.side * (value - now) <= tolerance {
        let passed = (approach.side * (now - value) > tolerance).then_some(now);
        return Some(Landing { stop: Stop::Until(name.to_owned(), value), passed });
    }
    if let Some(fraction) = approach.fraction(value) {
        let mut progress = world.resource_mut::<Progress>();
        progress.tried = progress.tried.min(0.5 * fraction.max(FINEST));
    }
    None
}

impl Approach {
    /// Takes a reading. Returns the tolerance of the landing.
    fn see(&mut self, done: f64, now: f64, value: f64, error: f64) -> f64 {
        self.scale = self.scale.max(now.abs());
        let tolerance = error.max(TOLERANCE * self.scale.max(value.abs()));
        if self.side == 0.0 && (value - now).abs() > tolerance {
            self.side = (value - now).signum();
        }
        // States of an avalanche have the same progress; the last one counts.
        self.points.retain(|[at, _]| *at < done);
        self.points.push([done, now]);
        if self.points.len() > 3 {
            self.points.remove(0);
        }
        tolerance
    }

    /// Fraction of an increment that is safe to take; `None` if the measure does not approach the
    /// value.
    fn fraction(&self, value: f64) -> Option<f64> {
        let rate = |[a, x]: [f64; 2], [b, y]: [f64; 2]| (y - x) / (b - a);
        let n = self.points.len();
        let (before, last) = (*self.points.get(n.checked_sub(2)?)?, *self.points.last()?);
        let now = rate(before, last);
        if self.side * now <= 0.0 {
            return None;
        }
        let earlier = n.checked_sub(3).map(|k| rate(self.points[k], before));
        let change = earlier.map_or(1.0, |earlier| ((now - earlier) / now).abs());
        // A measure that steepens is expected to steepen by the same ratio again, but by no more
        // than fourfold: after a rate of zero, as before a gap closes, the ratio says nothing.
        let steeper = earlier.map_or(1.0, |earlier| (now / earlier).clamp(1.0, 4.0));
        // A rate that may not be steady leaves half of the distance.
        Some((1.0 - 2.0 * change).max(0.5) * (value - last[1]) / (now * steeper))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Increments until a function of the progress has landed, and where.
    fn land(f: impl Fn(f64) -> f64, value: f64) -> (usize, f64) {
        let mut approach = Approach { on: true, ..Default::default() };
        approach.see(0.0, f(0.0), value, 0.0);
        let (mut done, mut tried) = (0.0, 0.5 * FIRST);
        for n in 1..100 {
            // As the attempts do: twice the last fraction, up to the end of the whole increment.
            tried = f64::min(2.0 * tried, 1.0 - f64::fract(done));
            done += tried;
            let now = f(done);
            let tolerance = approach.see(done, now, value, 0.0);
            if approach.side * (value - now) <= tolerance {
                return (n, now);
            }
            if let Some(fraction) = approach.fraction(value) {
                tried = tried.min(0.5 * fraction.max(FINEST));
            }
        }
        (100, f64::NAN)
    }

    #[test]
    fn a_straight_line_takes_one_fraction() {
        let (n, at) = land(|x| 3.0 * x, 10.0);
        // 0.25, 0.75, 1, 1.5, 2, 3, 3.333...
        assert!((at - 10.0).abs() <= 1e-5 && n == 7, "{n}: {at}");
        assert!((land(|x| 5.0 - 2.0 * x, 0.0).1).abs() <= 5e-6);
    }

    #[test]
    fn curves_land_from_one_side() {
        for (name, f, value) in [
            ("hardens", (|x: f64| x * x) as fn(f64) -> f64, 7.3),
            ("softens", |x: f64| x.sqrt(), 2.2),
            ("saturates", |x: f64| 1.0 - (-x).exp(), 0.9),
            ("explodes", |x: f64| x.exp(), 50.0),
            ("closes a gap", |x: f64| (x - 1.6).max(0.0), 1.7),
            ("unloads", |x: f64| (4.0 - x).powf(1.5), 0.1),
        ] {
            let (n, at) = land(f, value);
            let error = (at - value).abs() / value.max(f(0.0));
            assert!(error <= 2.0 * TOLERANCE && n < 20, "{name}: {at} after {n}, {error:.1e}");
        }
    }
}
