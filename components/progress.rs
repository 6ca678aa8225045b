//! How far a stage has come.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::body::Ramp;

/// How far the run has come. Increments count over all stages; an increment that had to be
/// halved is committed as several with a smaller fraction each.
#[derive(Resource, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct ClasticProgress {
    /// Number of the increment under way, or of the last one; from 1, and 0 before the first.
    pub increment: u64,
    /// Index of the stage.
    pub stage: usize,
    /// Name of the stage.
    pub stage_name: String,
    /// Increments of the stage that are committed, counting fractions.
    pub done: f64,
    /// Number of increments of the stage; 0 without a stage, as in an app that has begun none.
    pub total: f64,
    /// Points (increments done, share) in ascending order; the share is the part of the change from
    /// its value at the start of the stage to its target that every load has made: linear between
    /// whole increments, constant after the last. Without points the share is `done/total`.
    pub course: Vec<[f64; 2]>,
    /// Fraction of a whole increment: that of the trial, or that of the committed increment.
    pub fraction: f64,
    /// Fraction that the increment tried before an
    /// [event](crate::increment::RuptureOrder::Events) shortened it.
    pub tried: f64,
    /// Whether bonds have just broken. The next increment then seeks the equilibrium at constant
    /// load.
    pub relaxing: bool,
    /// Whether many bonds reach their limits soon after each other, so that
    /// [`Events`](crate::increment::RuptureOrder::Events) breaks them together.
    pub dense: bool,
    /// Time, s.
    pub time: f64,
}

impl Default for ClasticProgress {
    fn default() -> Self {
        Self {
            increment: 0,
            stage: 0,
            stage_name: String::new(),
            done: 0.0,
            total: 0.0,
            course: Vec::new(),
            fraction: 1.0,
            tried: 1.0,
            relaxing: false,
            dense: false,
            time: 0.0,
        }
    }
}

impl ClasticProgress {
    /// Whether the stage is over: all its increments are done, and no avalanche is under way.
    pub fn is_over(&self) -> bool {
        self.done >= self.total && !self.relaxing
    }

    /// The ramp, over the next whole increment, of a load that goes from one value to another over
    /// the stage, linearly or on its [`course`](Self::course). Where its share is 1 the target is met
    /// exactly. The ramp goes on beyond the end of the stage where only a part of the last increment
    /// is left: fractions are of whole increments. After the stage the load stays where it is.
    /// Without a stage, `total` is 0, and the load is at its target from the first increment on.
    pub fn ramp(&self, from: f64, to: f64) -> Ramp {
        if !self.course.is_empty() {
            return self.next(|done| {
                let share = value_at(&self.course, done.min(self.total), 1);
                if share == 1.0 { to } else { from + share * (to - from) }
            });
        }
        if self.done >= self.total - 1e-9 {
            return Ramp { from: to, to };
        }
        let at = |done: f64| {
            let is_end = (done - self.total).abs() < 1e-9;
            if is_end { to } else { from + (to - from) * (done / self.total) }
        };
        Ramp { from: at(self.done), to: at(self.done + 1.0) }
    }

    /// The ramp, over the next whole increment, of a value that is known where whole increments are
    /// done. Within an increment it is linear, so that parts of it add up to the whole.
    pub fn next(&self, after: impl Fn(f64) -> f64) -> Ramp {
        let whole = (self.done + 1e-9).floor();
        let (from, to) = (after(whole), after(whole + 1.0));
        let part = (self.done - whole) * (to - from);
        Ramp { from: from + part, to: to + part }
    }

    /// The part of the stage that is over when `done` of its increments are: `done/total`, at most
    /// 1. It is 1 after the stage, and without a stage.
    pub fn part(&self, done: f64) -> f64 {
        if done < self.total { done / self.total } else { 1.0 }
    }

    /// What is left of the whole increment under way. It does not reach beyond the end of the
    /// stage: an avalanche after the last increment of a stage has 0 left. After the stage, and
    /// without one, increments go on.
    pub fn left_of_increment(&self) -> f64 {
        let whole = 1.0 - self.done.fract();
        let of_stage = self.total - self.done;
        let ends = of_stage > 0.0 || of_stage == 0.0 && self.relaxing;
        if ends { whole.min(of_stage) } else { whole }
    }

    /// The ends of a ramp over the stage that has the value now that this one has, and goes to
    /// another target. With `s = done/total` it starts at `(now - target s)/(1 - s)`. After the
    /// stage, without one, and on a [`course`](Self::course), the load is at the new target from the
    /// next increment on.
    pub fn retarget(&self, (from, to): (f64, f64), target: f64) -> (f64, f64) {
        let s = self.part(self.done);
        let now = self.ramp(from, to).from;
        if !self.course.is_empty() {
            return (target, target);
        }
        (if s < 1.0 { (now - target * s) / (1.0 - s) } else { target }, target)
    }
}

/// Value `k` at s of points (s, values): linear between them, constant before the first and after
/// the last.
pub(crate) fn value_at<const N: usize>(points: &[[f64; N]], s: f64, k: usize) -> f64 {
    let next = points.partition_point(|point| point[0] <= s);
    match (next.checked_sub(1).map(|last| &points[last]), points.get(next)) {
        (Some(a), Some(b)) => {
            let t = (s - a[0]) / (b[0] - a[0]);
            a[k] * (1.0 - t) + b[k] * t
        }
        (Some(only), None) | (None, Some(only)) => only[k],
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::ClasticProgress;

    #[test]
    fn loads_on_a_course_are_linear_within_an_increment_and_stay_after_the_stage() {
        let course = vec![[0.0, 0.0], [1.5, 3.0], [4.0, -2.0]];
        let mut progress = ClasticProgress { total: 4.0, course, ..ClasticProgress::default() };
        let values = [10.0, 30.0, 30.0, 10.0, -10.0, -10.0];
        for (done, pair) in (0_u32..).zip(values.windows(2)) {
            for part in [0.0, 0.25] {
                progress.done = f64::from(done) + part;
                let (now, to) = (pair[0] + part * (pair[1] - pair[0]), pair[1] - pair[0]);
                let ramp = progress.ramp(10.0, 20.0);
                assert!((ramp.from - now).abs() + (ramp.to - now - to).abs() < 1e-12, "{ramp:?}");
            }
        }
        assert_eq!(progress.retarget((10.0, 20.0), 7.0), (7.0, 7.0));
    }

    /// A stage of 46 commits once ended at 192.8 of 200 kPa.
    #[test]
    fn many_parts_of_the_last_increment_lose_no_load() {
        let mut progress =
            ClasticProgress { done: 19.0, total: 20.0, ..ClasticProgress::default() };
        for fraction in [0.5, 0.125, 0.25, 0.0625, 0.03125, 0.03125] {
            let ramp = progress.ramp(0.0, 200.0);
            let expected = 200.0 * (progress.done + fraction) / 20.0;
            let reached = ramp.at(fraction);
            assert!((reached - expected).abs() < 1e-10, "{reached} instead of {expected}");
            progress.done += fraction;
        }
        assert_eq!(progress.ramp(0.0, 200.0).from, 200.0);
    }

    #[test]
    fn a_load_stays_at_its_target_after_its_stage() {
        for done in [3.0, 4.0, 10.5] {
            let progress = ClasticProgress { done, total: 3.0, ..ClasticProgress::default() };
            let ramp = progress.ramp(1.0, 7.0);
            assert_eq!((ramp.from, ramp.to), (7.0, 7.0), "after {done} increments");
        }
    }

    #[test]
    fn a_whole_increment_at_the_end_meets_its_target_exactly() {
        let progress = ClasticProgress { done: 2.0, total: 3.0, ..ClasticProgress::default() };
        assert_eq!(progress.ramp(0.1, 0.7).at(1.0), 0.7);
        assert_eq!(ClasticProgress::default().ramp(0.1, 0.7).to, 0.7);
    }

    #[test]
    fn a_stage_is_not_over_within_an_avalanche() {
        let progress = ClasticProgress { done: 3.0, total: 3.0, ..ClasticProgress::default() };
        assert!(progress.is_over());
        assert!(!ClasticProgress { relaxing: true, ..progress }.is_over());
    }

    /// An increment that was tried with `OneRound` had a length of 0 or less where an app has no
    /// stage or goes on after one.
    #[test]
    fn increments_without_a_stage_and_after_it_have_their_whole_length() {
        let left = |done, total, relaxing| {
            ClasticProgress { done, total, relaxing, ..ClasticProgress::default() }
                .left_of_increment()
        };
        assert_eq!(left(0.0, 0.0, false), 1.0);
        assert_eq!(left(2.25, 0.0, true), 0.75);
        assert_eq!(left(4.0, 4.0, false), 1.0);
        assert_eq!(left(6.5, 4.0, false), 0.5);
        // Within a stage increments end with it.
        assert_eq!(left(3.25, 4.0, false), 0.75);
        assert_eq!(left(3.25, 3.5, false), 0.25);
        assert_eq!(left(4.0, 4.0, true), 0.0);
    }

    #[test]
    fn without_a_stage_a_load_gets_its_new_target_at_once() {
        let progress = ClasticProgress::default();
        assert_eq!(progress.retarget((0.0, 5.0), 8.0), (8.0, 8.0));
        assert_eq!(progress.part(0.0), 1.0);
        assert_eq!(ClasticProgress { total: 4.0, ..progress }.part(1.0), 0.25);
    }
}
