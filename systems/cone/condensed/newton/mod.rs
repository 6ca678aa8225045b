//! Semismooth Newton iteration in the displacements, for programs in which every force has a
//! compliance.
//!
//! Given u, the forces of a contact are the projection of its elastic trial onto its limits in the
//! metric of the compliances ([`Spring`](super::spring::Spring), and
//! [`RollingSpring`](super::rolling_spring::RollingSpring) with a rolling moment). The balance is
//! then the gradient of a convex, piecewise quadratic function of u, and its generalised Hessian is
//! the condensed matrix of the current regions. The derivative along a step is monotone and
//! piecewise linear, and the line search finds its zero.
//!
//! What else happens between two steps is up to the caller: see [`Between`].

mod point;

pub use self::point::{Point, Step};
use super::matrix::BodyMatrix;
use super::scaled::Scaled;
use super::settings::NewtonSettings;
use super::spring::Elastic;

/// Unbalance at which the iteration is done.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// Over the maximum force.
    pub unbalance: f64,
    /// Force that counts where all forces are smaller.
    pub min_force: f64,
}

/// Result of the iteration.
pub struct Newton {
    /// Displacements by body, in the order of elimination.
    pub u: Vec<[f64; 3]>,
    /// Forces by interaction.
    pub s: Vec<[f64; 3]>,
    /// Number of factorisations.
    pub iterations: u32,
    /// Whether the goal was reached.
    pub converged: bool,
}

/// What the caller does between two steps of an iteration with `F` forces an interaction: nothing by
/// default.
pub trait Between<S: Elastic<F>, const F: usize> {
    /// May change the displacements of the point before the next step; whether it did. The point is
    /// then evaluated again.
    fn move_bodies(&mut self, _point: &mut Point<S, F>) -> bool {
        false
    }

    /// May change a step and its length after the line search.
    fn change_step(&mut self, _point: &Point<S, F>, _step: &mut Step<F>, _search: &NewtonSettings) {
    }
}

/// Nothing happens between two steps.
pub struct Nothing;

impl<S: Elastic<F>, const F: usize> Between<S, F> for Nothing {}

/// Whether every force of the program has a compliance.
pub fn applies(program: &Scaled) -> bool {
    program.locals.iter().all(|l| (0..3).all(|f| !l.has[f] || l.compliance[f] > 0.0))
}

/// Runs the iteration from the displacements `start`.
pub fn iterate<S: Elastic<F>, const F: usize>(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    settings: &NewtonSettings,
    goal: Goal,
    between: &mut impl Between<S, F>,
) -> Newton {
    let mut point = Point::<S, F>::new(program, start, goal);
    let mut step = Step::new(program);
    let (mut iterations, mut tiny_steps) = (0, 0);
    let mut damping = settings.damping;
    loop {
        point.evaluate();
        let gives_up =
            iterations >= settings.max_iterations || tiny_steps >= settings.max_tiny_steps;
        if !point.is_finite() || point.is_done() || gives_up {
            break;
        }
        if between.move_bodies(&mut point) {
            continue;
        }
        iterations += 1;
        if !point.find_step(matrix, damping, &mut step) {
            break;
        }
        damping *= 0.5;
        step.length = point.search(&step, settings);
        between.change_step(&point, &mut step, settings);
        tiny_steps = if step.length < settings.tiny_step { tiny_steps + 1 } else { 0 };
        point.make(&step);
    }
    let (s, converged) = (point.forces(), point.is_done());
    point.u.truncate(program.free.len());
    Newton { s, u: point.u, iterations, converged }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::samples::{column, contact, held, loaded, posed};
    use super::super::spring::Spring;
    use super::*;
    use crate::program::ConeProgram;

    const GOAL: Goal = Goal { unbalance: 1e-12, min_force: 0.0 };

    fn solve(program: &ConeProgram) -> (Newton, Vec<usize>) {
        let (scaled, mut matrix, place) = posed(program);
        assert!(applies(&scaled));
        let start = vec![[0.0; 3]; scaled.free.len()];
        let settings = NewtonSettings::default();
        let result =
            iterate::<Spring, 2>(&scaled, &mut matrix, &start, &settings, GOAL, &mut Nothing);
        (result, place)
    }

    /// A column is a chain of springs: contact k carries the weight of all bodies above it, and a
    /// body sinks by the sum of the contacts below it. At the start all contacts just touch.
    #[test]
    fn a_column_of_three() {
        let (result, place) = solve(&column(3, 0.1));
        for (k, force) in [3.0, 2.0, 1.0].into_iter().enumerate() {
            assert!((result.s[k][0] - force).abs() < 1e-9, "{:?}", result.s);
        }
        for (body, sink) in [(1, 0.3), (2, 0.5), (3, 0.6)] {
            assert!((result.u[place[body]][1] + sink).abs() < 1e-9, "{:?}", result.u);
        }
    }

    /// A disk between two walls at right angles, both at 45 degrees: p = W/sqrt(2) each.
    #[test]
    fn a_disk_in_a_groove() {
        let diagonal = DVec2::new(1.0, 1.0).normalize();
        let program = ConeProgram {
            bodies: vec![held(), held(), loaded(0.0, -1.0)],
            interactions: vec![
                contact(0, 2, diagonal, 0.1, 0.0),
                contact(1, 2, DVec2::new(-diagonal.x, diagonal.y), 0.1, 0.0),
            ],
            ..ConeProgram::default()
        };
        let (result, _) = solve(&program);
        for s in &result.s {
            assert!((s[0] - 0.5_f64.sqrt()).abs() < 1e-9, "{s:?}");
        }
    }

    /// A disk that is pulled up from the floor below it and down by nothing: no force holds it, and
    /// the iteration ends without a solution, at a cap.
    #[test]
    fn what_nothing_holds_ends_at_a_cap() {
        let program = ConeProgram {
            bodies: vec![held(), loaded(0.0, 1.0)],
            interactions: vec![contact(0, 1, DVec2::Y, 0.1, 0.0)],
            ..ConeProgram::default()
        };
        let (result, _) = solve(&program);
        let settings = NewtonSettings::default();
        assert!(result.iterations <= settings.max_iterations);
        assert_eq!(result.s[0][0], 0.0);
    }

    /// A caller that moves bodies before every step is asked again at the point that it has made.
    #[test]
    fn the_caller_may_move_bodies_between_steps() {
        struct Solution(u32);
        impl Between<Spring, 2> for Solution {
            fn move_bodies(&mut self, point: &mut Point<Spring, 2>) -> bool {
                self.0 += 1;
                for (u, g) in point.u.iter_mut().zip(&point.gradient) {
                    u[1] -= 0.1 * g[1];
                }
                true
            }
            fn change_step(&mut self, _: &Point<Spring, 2>, _: &mut Step<2>, _: &NewtonSettings) {
                unreachable!("no step is needed");
            }
        }
        let (scaled, mut matrix, place) = posed(&column(1, 0.1));
        let mut between = Solution(0);
        let start = [[0.0; 3]; 2];
        let settings = NewtonSettings::default();
        let result = iterate(&scaled, &mut matrix, &start, &settings, GOAL, &mut between);
        assert_eq!((result.iterations, between.0), (0, 1));
        assert!((result.u[place[1]][1] + 0.1).abs() < 1e-12);
    }
}
