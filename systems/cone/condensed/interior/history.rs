//! The best point so far, and the conditions that end the method.

use super::iteration::Iteration;
use super::point::{Goal, Interior};
use crate::condensed::settings::InteriorSettings;

/// Memory of earlier points.
pub struct History<'a> {
    settings: &'a InteriorSettings,
    goal: Goal,
    /// The point with the minimum residual.
    best: Option<Interior>,
    /// Number of iterations since.
    idle: usize,
    /// Residuals of the best points, iteration by iteration.
    best_merits: Vec<f64>,
    /// Residuals of the last point and of the one before.
    merit: f64,
    last_merit: f64,
    /// Residual of the last point that was offered and was not good enough.
    refused: f64,
}

impl<'a> History<'a> {
    pub fn new(settings: &'a InteriorSettings, goal: Goal) -> Self {
        Self {
            settings,
            goal,
            best: None,
            idle: 0,
            best_merits: Vec::new(),
            merit: f64::INFINITY,
            last_merit: f64::INFINITY,
            refused: f64::INFINITY,
        }
    }

    /// Adds the current point, and keeps it if it is the best one.
    pub fn record(&mut self, iteration: &mut Iteration) {
        let merit = iteration.merit();
        (self.last_merit, self.merit) = (self.merit, merit);
        if self.best.as_ref().is_none_or(|b| merit < b.merit) {
            iteration.store(&mut self.best);
            self.idle = 0;
        } else {
            self.idle += 1;
        }
        self.best_merits.push(self.best_merit());
    }

    fn best_merit(&self) -> f64 {
        self.best.as_ref().map_or(self.merit, |b| b.merit)
    }

    /// Whether the best point may end the method and is accurate enough. Each point is checked
    /// once, because the check evaluates the whole program.
    pub fn is_enough(&mut self, is_enough: impl Fn(&Interior) -> bool) -> bool {
        let Goal { residual, first } = self.goal;
        let is_slow = self.merit > self.settings.slow * self.last_merit;
        let is_near = self.merit <= residual
            || (self.merit <= first.unwrap_or(self.settings.near) * residual
                && (is_slow || first.is_some()));
        let refused = self.refused;
        let offered = self.best.as_ref().filter(|best| is_near && best.merit < refused);
        let Some(point) = offered else { return false };
        self.refused = point.merit;
        is_enough(point)
    }

    /// Whether more iterations lead nowhere: at the goal, far from the best point, or slowly.
    ///
    /// The residual is relative to the scales of the program. Where bodies hardly move, an accurate
    /// point may need a residual far below the goal. The method then continues while it finds
    /// better points.
    pub fn is_over(&self) -> bool {
        let settings = self.settings;
        let best = self.best_merit();
        let is_at_goal = best <= self.goal.residual && self.idle >= settings.max_idle_at_goal;
        let diverges =
            self.idle > settings.max_idle_diverging && self.merit > settings.divergence * best;
        let earlier = self.best_merits.len().checked_sub(settings.patience + 1);
        let earlier = earlier.map_or(f64::INFINITY, |k| self.best_merits[k]);
        let stalls = best > settings.progress * earlier;
        is_at_goal || diverges || self.idle > settings.max_idle || stalls
    }

    /// The best point.
    pub fn into_best(self) -> Option<Interior> {
        self.best
    }
}
