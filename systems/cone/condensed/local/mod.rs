//! Newton iteration with local elimination: bodies that are far out of balance, and their
//! surroundings, are brought to balance with all others held before the next global step.
//!
//! After a rupture a few contacts out of thousands change their state, and a cluster that came
//! loose dominates the global direction. One global step length then serves one cluster per
//! factorisation. Each cluster on its own is a small problem (`patches`). It is solved to the goal of
//! the whole program: if all but a few clusters are elastic, its unbalance becomes that of the whole
//! program after the next step. (Nonlinear elimination, or nonlinearly preconditioned Newton: Cai
//! and Keyes 2002.)
//!
//! Where a few fast bodies shorten a global step, the step is made without them (`fast`). Local
//! elimination then balances them.

mod fast;
mod patches;

use super::MIN_FORCE;
use super::matrix::BodyMatrix;
use super::newton::{Between, Goal, Newton, Point, Step, iterate};
use super::rolling_spring::RollingSpring;
use super::scaled::Scaled;
use super::settings::{LocalSettings, NewtonSettings};
use super::spring::{Elastic, Spring};
use crate::adjacency::Adjacency;

/// Solves the program from the displacements `start` until the unbalance over the maximum force is
/// at most `goal`.
pub fn solve(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    newton: &NewtonSettings,
    local: &LocalSettings,
    goal: f64,
) -> Newton {
    let goal = Goal { unbalance: goal, min_force: MIN_FORCE };
    let mut elimination = Elimination::new(program, local, goal, matrix.is_shared());
    if program.locals.iter().any(|l| l.has[2]) {
        iterate::<RollingSpring, 3>(program, matrix, start, newton, goal, &mut elimination)
    } else {
        iterate::<Spring, 2>(program, matrix, start, newton, goal, &mut elimination)
    }
}

/// Local elimination between two steps.
struct Elimination<'a> {
    program: &'a Scaled,
    adjacency: Adjacency,
    settings: &'a LocalSettings,
    /// Goal of the iteration.
    goal: Goal,
    /// Length of the last step; 0 before the first.
    last_length: f64,
    /// Bodies that the last step left behind; empty if it left none.
    fast: Vec<bool>,
    /// Whether bodies were eliminated since the last step: a step comes next in any case.
    is_done: bool,
    /// Whether threads share the matrix of the program.
    is_shared: bool,
}

impl<S: Elastic<F>, const F: usize> Between<S, F> for Elimination<'_> {
    fn move_bodies(&mut self, point: &mut Point<S, F>) -> bool {
        let is_first = !std::mem::replace(&mut self.is_done, true);
        let is_short = self.last_length < self.settings.short_step;
        let moved = is_first && (is_short || !self.fast.is_empty()) && self.eliminate(point);
        if !moved {
            self.is_done = false;
        }
        moved
    }

    fn change_step(&mut self, point: &Point<S, F>, step: &mut Step<F>, search: &NewtonSettings) {
        self.fast.clear();
        if step.length < self.settings.short_step
            && let Some((fast, slow)) = self.slow_part(step)
        {
            let length = point.search(&slow, search);
            if length > self.settings.fast * step.length {
                *step = Step { length: length.min(1.0), ..slow };
                self.fast = fast;
            }
        }
        self.last_length = step.length;
    }
}

impl<'a> Elimination<'a> {
    fn new(program: &'a Scaled, settings: &'a LocalSettings, goal: Goal, is_shared: bool) -> Self {
        let pairs = program.locals.iter().map(|l| program.pair(l));
        Self {
            program,
            adjacency: Adjacency::new(program.free.len(), pairs),
            settings,
            goal,
            last_length: 0.0,
            fast: Vec::new(),
            is_done: false,
            is_shared,
        }
    }

    /// Whether a body is held: the cell, or a body with more than `max_interactions` interactions, as
    /// walls have. They touch bodies everywhere and would join all patches to one.
    fn is_held(&self, body: usize) -> bool {
        self.adjacency.of(body).len() > self.settings.max_interactions
            || self.program.images.is_cell(body)
    }

    /// Brings the bodies that are furthest out of balance, and fast ones, to balance; whether any
    /// moved.
    fn eliminate<S: Elastic<F>, const F: usize>(&self, point: &mut Point<S, F>) -> bool {
        let of_body = |g: &[f64; 3]| g.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
        let n = self.program.free.len();
        let unbalance: Vec<f64> = point.gradient[..n].iter().map(of_body).collect();
        let maximum = unbalance.iter().copied().fold(0.0, f64::max);
        let share = self.settings.share;
        let patches =
            self.patches(|i| unbalance[i] > share * maximum || self.fast.get(i) == Some(&true));
        let goal = Goal { min_force: point.force, ..self.goal };
        let solutions = self.balance_all::<S, F>(&patches, &point.u, goal);
        for (i, u) in &solutions {
            point.u[*i] = *u;
        }
        !solutions.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{column, posed};
    use super::*;

    /// With local elimination a column comes to the forces of a chain of springs, also from a start
    /// in which its upper half hangs in the air.
    #[test]
    fn a_column_from_a_start_with_open_contacts() {
        let program = column(6, 0.1);
        let (scaled, mut matrix, place) = posed(&program);
        for lift in [0.0, 3.0, 40.0] {
            let mut start = vec![[0.0; 3]; 7];
            for body in 4..7 {
                start[place[body]][1] = lift * body as f64;
            }
            let (newton, local) = (NewtonSettings::default(), LocalSettings::default());
            let result = solve(&scaled, &mut matrix, &start, &newton, &local, 1e-12);
            for (k, s) in result.s.iter().enumerate() {
                assert!((s[0] - (6 - k) as f64).abs() < 1e-9, "lift {lift}: {:?}", result.s);
            }
        }
    }
}
