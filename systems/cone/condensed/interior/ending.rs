//! The best point so far, and what ends the method.

use super::iteration::Iteration;
use super::point::{Goal, Interior, Judge};
use crate::condensed::scaled::Scaled;
use crate::condensed::settings::InteriorSettings;
use crate::program::SolveStatus;

/// Residual of a point, over the goal, up to which every better point is judged. The method's
/// residual is relative to the scales of the program, and the program's own may be far below it.
const NEAR: f64 = 1e4;
/// Number of iterations without a better point after which round-off has stopped a method that has
/// a solution already.
const MAX_IDLE: usize = 3;

/// Memory of earlier points.
pub struct Ending<'a, J> {
    settings: &'a InteriorSettings,
    judge: &'a J,
    goal: Goal,
    iterations: u32,
    /// The point with the minimum residual.
    best: Interior,
    /// The last best point that solves the program.
    solution: Option<Interior>,
    /// The displacements or forces of a proof.
    proof: Interior,
    /// Residuals of the best point, iteration by iteration.
    merits: Vec<f64>,
    last_merit: f64,
    idle: usize,
}

impl<'a, J: Judge> Ending<'a, J> {
    pub fn new(program: &Scaled, settings: &'a InteriorSettings, goal: Goal, judge: &'a J) -> Self {
        Self {
            settings,
            judge,
            goal,
            iterations: 0,
            best: Interior::of(program),
            solution: None,
            proof: Interior::of(program),
            merits: Vec::new(),
            last_merit: f64::INFINITY,
            idle: 0,
        }
    }

    /// Takes note of the current point. Returns how the method ends there; `None` if it goes on.
    pub(crate) fn consider(&mut self, iteration: &mut Iteration) -> Option<SolveStatus> {
        if !iteration.is_finite() {
            return Some(self.limit());
        }
        let merit = iteration.merit();
        let is_slow = merit > self.settings.slow * self.last_merit;
        self.last_merit = merit;
        self.idle += 1;
        if merit < self.best.merit {
            self.idle = 0;
            iteration.store(&mut self.best);
            if merit <= NEAR * self.goal.residual && self.judge.is_solution(&self.best) {
                self.solution = Some(self.best.clone());
            }
        }
        self.merits.push(self.best.merit);
        if self.solution.is_some() && (self.is_done(merit, is_slow) || self.idle >= MAX_IDLE) {
            return Some(SolveStatus::Solved);
        }
        if iteration.diverges()
            && let Some(end) = self.proved(iteration)
        {
            return Some(end);
        }
        let stalls = !iteration.diverges() && self.stalls();
        if stalls || self.iterations >= self.settings.max_iterations {
            return Some(self.limit());
        }
        self.iterations += 1;
        None
    }

    /// Whether a point with this residual is accurate enough, given that the best one is a solution.
    fn is_done(&self, merit: f64, is_slow: bool) -> bool {
        let Goal { residual, at_once, .. } = self.goal;
        at_once || merit <= residual || (is_slow && merit <= self.settings.near * residual)
    }

    /// Whether the residual has fallen too little in the last iterations.
    fn stalls(&self) -> bool {
        let earlier = self.merits.len().checked_sub(self.settings.patience + 1);
        earlier.is_some_and(|k| self.best.merit > self.settings.progress * self.merits[k])
    }

    /// Whether the point or its last step is a proof that the program has no solution.
    fn proved(&mut self, iteration: &mut Iteration) -> Option<SolveStatus> {
        iteration.store(&mut self.proof);
        let proof = self.judge.proof(&self.proof);
        if proof.is_some() || self.iterations == 0 {
            return proof;
        }
        iteration.store_step(&mut self.proof);
        self.judge.proof(&self.proof)
    }

    /// Decides of every limit whether it is active, where that leads to a solution. A product says
    /// little of a limit that is just reached: slack and multiplier are both its root. Returns how the
    /// method ends.
    pub fn decide(&mut self, iteration: &mut Iteration, size: f64) -> SolveStatus {
        // The method may have gone on to a worse point, or to none.
        if self.solution.is_none() || !(iteration.merit() <= self.best.merit) {
            iteration.restore(&self.best);
        }
        // Limits that are decided by less mislead where grains are loose: first the clear ones.
        let rest = self.settings.decided * size;
        for small in [size, rest] {
            let Some(point) = self.decided(iteration, small, rest) else { break };
            self.solution = Some(point);
        }
        self.limit()
    }

    /// The solution after the steps that leave no limit undecided by more than `small`.
    fn decided(&mut self, iteration: &mut Iteration, small: f64, rest: f64) -> Option<Interior> {
        let mut point = self.best.clone();
        for left in (0..=self.settings.max_decisions).rev() {
            if iteration.undecided(small) == 0 {
                iteration.store(&mut point);
                if self.judge.is_solution(&point) {
                    return Some(point);
                }
            }
            if left == 0 || !iteration.decide(small, rest) {
                break;
            }
            self.iterations += 1;
        }
        None
    }

    /// How the method ends where it cannot go on.
    pub fn limit(&self) -> SolveStatus {
        if self.solution.is_some() { SolveStatus::Solved } else { SolveStatus::Stalled }
    }

    /// The point that belongs to an end.
    pub(crate) fn into_point(self, end: SolveStatus) -> Interior {
        let Self { best, solution, proof, iterations, .. } = self;
        let point = match end {
            SolveStatus::Solved => solution.unwrap_or(best),
            SolveStatus::Stalled => best,
            SolveStatus::Collapsed | SolveStatus::Locked => proof,
        };
        Interior { iterations, ..point }
    }
}
