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
//! Where a few fast bodies shorten a global step, the step is made without them. Local
//! elimination then balances them.

mod patches;

use self::patches::Motion;
use super::MIN_FORCE;
use super::matrix::BodyMatrix;
use super::newton::{Goal, Newton, Point, Step, iterate};
use super::parallel::in_parallel;
use super::scaled::{Local, Scaled};
use super::settings::{LocalSettings, NewtonSettings};
use super::spring::{Elastic, RollingSpring, Spring};
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
    let elimination = Some(&mut Elimination::new(program, local, goal, matrix.is_shared()));
    if program.locals.iter().any(|l| l.has[2]) {
        iterate::<RollingSpring, 3>(program, matrix, start, newton, goal, elimination)
    } else {
        iterate::<Spring, 2>(program, matrix, start, newton, goal, elimination)
    }
}

/// Local elimination between two steps.
pub(crate) struct Elimination<'a> {
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

    /// Eliminates bodies before the next step where that pays; whether any moved.
    pub fn move_bodies<S: Elastic<F>, const F: usize>(&mut self, point: &mut Point<S, F>) -> bool {
        let pays = self.last_length < self.settings.short_step || !self.fast.is_empty();
        self.is_done = !self.is_done && pays && self.eliminate(point);
        self.is_done
    }

    /// Leaves fast bodies out of a step after its line search where that makes it longer.
    pub(crate) fn change_step<S: Elastic<F>, const F: usize>(
        &mut self,
        point: &Point<S, F>,
        step: &mut Step<F>,
        search: &NewtonSettings,
    ) {
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

    /// The fast bodies, and a step without them. Where a few loose bodies move far, the state of
    /// their contacts changes at once. These contacts would shorten a step that all other bodies
    /// could make, and their kinematics are not counted: they are zero.
    ///
    /// A body is fast if its step exceeds `settings.fast` times the `fast_quantile` of all steps and
    /// it is not held. `None` where no body is fast.
    fn slow_part<const F: usize>(&self, step: &Step<F>) -> Option<(Vec<bool>, Step<F>)> {
        let (Step { du, de, length }, program) = (step, self.program);
        let size = |du: &[f64; 3]| du[0].hypot(du[1]).max(du[2].abs());
        let bodies = &du[..program.free.len()];
        let mut sizes: Vec<f64> = bodies.iter().map(size).collect();
        let last = sizes.len() - 1;
        let place = ((self.settings.fast_quantile * sizes.len() as f64) as usize).min(last);
        let (_, quantile, _) = sizes.select_nth_unstable_by(place, f64::total_cmp);
        let threshold = self.settings.fast * *quantile;
        let is_fast = |i: usize| size(&du[i]) > threshold && !self.is_held(i);
        let fast: Vec<bool> = (0..bodies.len()).map(is_fast).collect();
        if !fast.contains(&true) {
            return None;
        }
        let slow = |(du, fast): (&[f64; 3], &bool)| if *fast { [0.0; 3] } else { *du };
        let both_slow = |l: &Local| !program.pair(l).iter().any(|i| fast[*i]);
        let mut du: Vec<_> = du.iter().zip(&fast).map(slow).collect();
        program.images.extend(&mut du);
        let counted = |(de, l): (&[f64; F], &Local)| if both_slow(l) { *de } else { [0.0; F] };
        let de = de.iter().zip(&program.locals).map(counted).collect();
        Some((fast, Step { du, de, length: *length }))
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
        let balance = |members: &Vec<usize>| self.balance::<S, F>(members, &point.u, goal);
        let solutions: Vec<Option<Motion>> = if self.is_shared {
            in_parallel(patches.iter(), balance)
        } else {
            patches.iter().map(balance).collect()
        };
        let mut moved = false;
        for (i, u) in solutions.into_iter().flatten().flatten() {
            (point.u[i], moved) = (u, true);
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{column, posed};
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

    /// One of 100 bodies moves ten times further than all others, or none does.
    #[test]
    fn a_body_beyond_the_quantile_is_fast() {
        let scaled = Scaled::natural(&column(99, 0.1));
        let settings = LocalSettings::default();
        let goal = Goal { unbalance: 0.0, min_force: 0.0 };
        let elimination = Elimination::new(&scaled, &settings, goal, false);
        let mut step =
            Step { du: vec![[0.0, 1.0, 0.0]; 100], de: vec![[1.0, 0.0]; 99], length: 0.1 };
        assert!(elimination.slow_part(&step).is_none());
        step.du[7] = [0.0, 10.0, 0.0];
        let (fast, slow) = elimination.slow_part(&step).unwrap();
        for i in 0..100 {
            assert_eq!(fast[i], i == 7);
            assert_eq!(slow.du[i], if i == 7 { [0.0; 3] } else { step.du[i] });
        }
        // Interactions 6 and 7 join body 7 to its neighbours.
        for k in 0..99 {
            assert_eq!(slow.de[k][0], if k == 6 || k == 7 { 0.0 } else { 1.0 });
        }
    }
}
