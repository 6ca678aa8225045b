//! Semismooth Newton iteration in the displacements, where every force has a compliance.
//!
//! Given u, the forces of a contact are the projection of its elastic trial onto its limits in the
//! metric of the compliances ([`Spring`](super::spring::Spring), and
//! [`RollingSpring`](super::spring::RollingSpring) with a rolling moment). The balance is
//! then the gradient of a convex, piecewise quadratic function of u, and its generalised Hessian is
//! the condensed matrix of the current regions. The derivative along a step is monotone and
//! piecewise linear, and the line search finds its zero.

use super::local::Elimination;
use super::matrix::BodyMatrix;
use super::scaled::{Arms, Scaled, add_times};
use super::settings::NewtonSettings;
use super::spring::{Elastic, Response};

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

/// Whether every force of the program has a compliance.
pub fn applies(program: &Scaled) -> bool {
    program.locals.iter().all(|l| (0..3).all(|f| !l.has[f] || l.compliance[f] > 0.0))
}

/// Runs the iteration from the displacements `start`, with local elimination between its steps or
/// without.
pub(crate) fn iterate<S: Elastic<F>, const F: usize>(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    settings: &NewtonSettings,
    goal: Goal,
    mut local: Option<&mut Elimination>,
) -> Newton {
    let mut point = Point::<S, F>::new(program, start, goal);
    let mut step = Step::new(program);
    let (mut iterations, mut tiny_steps) = (0, 0);
    let mut damping = settings.damping;
    loop {
        point.evaluate();
        let gives_up =
            iterations >= settings.max_iterations || tiny_steps >= settings.max_tiny_steps;
        if !point.gradient.as_flattened().iter().all(|g| g.is_finite())
            || point.is_done()
            || gives_up
        {
            break;
        }
        if local.as_mut().is_some_and(|local| local.move_bodies(&mut point)) {
            continue;
        }
        iterations += 1;
        if !point.find_step(matrix, damping, &mut step) {
            break;
        }
        damping *= 0.5;
        step.length = point.search(&step, settings);
        if let Some(local) = &mut local {
            local.change_step(&point, &mut step, settings);
        }
        tiny_steps = if step.length < settings.tiny_step { tiny_steps + 1 } else { 0 };
        add_times(point.u.as_flattened_mut(), step.length, step.du.as_flattened());
    }
    let of = |s: &[f64; F]| std::array::from_fn(|f| if f < F { s[f] } else { 0.0 });
    let s = point.responses.iter().map(|r| of(&r.s)).collect();
    let converged = point.is_done();
    point.u.truncate(program.free.len());
    Newton { s, u: point.u, iterations, converged }
}

/// A point of the iteration, and what follows from its displacements, for interactions with `F`
/// forces.
pub struct Point<'a, S, const F: usize> {
    pub program: &'a Scaled,
    springs: Vec<S>,
    arms: Vec<Arms<F>>,
    responses: Vec<Response<F>>,
    /// Displacements by body, then by image.
    pub u: Vec<[f64; 3]>,
    /// Kinematics by interaction.
    e: Vec<[f64; F]>,
    /// Out-of-balance forces by body, zero for images: the gradient of the energy.
    pub gradient: Vec<[f64; 3]>,
    goal: Goal,
    /// Maximum force of the interactions, at least that of the goal.
    pub force: f64,
    unbalance: f64,
}

/// A step of the iteration.
pub struct Step<const F: usize> {
    /// Newton step of the displacements by body, then by image.
    pub du: Vec<[f64; 3]>,
    /// The kinematics that belong to it.
    pub de: Vec<[f64; F]>,
    /// Part of it that is made.
    pub length: f64,
}

impl<const F: usize> Step<F> {
    fn new(program: &Scaled) -> Self {
        let du = vec![[0.0; 3]; program.places()];
        Self { du, de: vec![[0.0; F]; program.locals.len()], length: 0.0 }
    }
}

impl<'a, S: Elastic<F>, const F: usize> Point<'a, S, F> {
    fn new(program: &'a Scaled, start: &[[f64; 3]], goal: Goal) -> Self {
        let count = program.locals.len();
        Self {
            program,
            springs: program.locals.iter().map(S::new).collect(),
            arms: program.locals.iter().map(Arms::of).collect(),
            responses: vec![Response::default(); count],
            u: program.with_known(start),
            e: vec![[0.0; F]; count],
            gradient: vec![[0.0; 3]; program.places()],
            goal,
            force: 0.0,
            unbalance: 0.0,
        }
    }

    /// Computes forces and out-of-balance forces from the displacements.
    fn evaluate(&mut self) {
        self.program.images.spread(&mut self.u);
        self.program.balance_of_bodies(&self.u, &mut self.gradient);
        let mut force = self.goal.min_force;
        for (k, (spring, arms)) in self.springs.iter().zip(&self.arms).enumerate() {
            self.e[k] = arms.kinematics(&self.u);
            self.responses[k] = spring.respond(self.e[k]);
            let s = &self.responses[k].s;
            arms.add_forces(s, 1.0, &mut self.gradient);
            force = force.max(s[0].abs()).max(s[1].abs());
        }
        self.program.images.fold(&mut self.gradient);
        self.force = force;
        self.unbalance = self.gradient.iter().flatten().map(|g| g.abs()).fold(0.0, f64::max);
    }

    fn is_done(&self) -> bool {
        self.unbalance <= self.goal.unbalance * self.force
    }

    /// Sets the matrix to the Hessian, with damping on its diagonal, and solves for the step; whether
    /// the matrix has a factor.
    fn find_step(&self, matrix: &mut BodyMatrix, damping: f64, step: &mut Step<F>) -> bool {
        let program = self.program;
        matrix.clear();
        let mut values = matrix.assembly();
        values.add_weights(program, damping);
        for (k, (arms, response)) in self.arms.iter().zip(&self.responses).enumerate() {
            values.add(k, &arms.rows, &response.d);
        }
        for (du, g) in step.du.iter_mut().zip(&self.gradient) {
            *du = g.map(|g| -g);
        }
        if !matrix.factorise_shifted_and_solve(&mut step.du) {
            return false;
        }
        program.clear_fixed(&mut step.du);
        for (de, arms) in step.de.iter_mut().zip(&self.arms) {
            *de = arms.kinematics(&step.du);
        }
        true
    }

    /// The length a at which the derivative of the energy along a step vanishes, to a few per cent of
    /// the derivative at a = 0: a Newton iteration for one number, safeguarded by a bracket.
    ///
    /// The derivative at a is `du.(M (u + a du) - f) + sum de.s(e + a de)`; it rises with a, and is
    /// piecewise linear.
    pub fn search(&self, Step { du, de, .. }: &Step<F>, settings: &NewtonSettings) -> f64 {
        let Self { program, u, .. } = self;
        let both = self.gradient.iter().flatten().zip(du.iter().flatten());
        let slope: f64 = both.map(|(g, du)| g * du).sum();
        let of_bodies = |i: usize, k: usize| program.weight[i][k] * u[i][k] - program.right[i][k];
        let linear = program.sum_of_free(|i, k| of_bodies(i, k) * du[i][k]);
        let quadratic = program.sum_of_free(|i, k| program.weight[i][k] * du[i][k] * du[i][k]);
        let derivative = |a: f64| {
            let (mut value, mut curvature) = (linear + a * quadratic, quadratic);
            for ((spring, e), de) in self.springs.iter().zip(&self.e).zip(de) {
                let at = std::array::from_fn(|f| e[f] + a * de[f]);
                let (power, change) = spring.respond(at).along(de);
                value += power;
                curvature += change;
            }
            (value, curvature)
        };
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut a = 1.0;
        for _ in 0..settings.max_evaluations {
            let (value, curvature) = derivative(a);
            if value.abs() <= settings.max_slope * slope.abs() {
                break;
            }
            if value > 0.0 {
                high = a;
            } else {
                low = a;
            }
            let newton = a - value / curvature;
            a = if newton > low && newton < high {
                newton
            } else if high.is_finite() {
                0.5 * (low + high)
            } else {
                4.0 * a
            };
        }
        a
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::spring::Spring;
    use super::super::tests::{column, contact, held, loaded, posed};
    use super::*;
    use crate::program::ConeProgram;

    const GOAL: Goal = Goal { unbalance: 1e-12, min_force: 0.0 };

    fn solve(program: &ConeProgram) -> (Newton, Vec<usize>) {
        let (scaled, mut matrix, place) = posed(program);
        assert!(applies(&scaled));
        let start = vec![[0.0; 3]; scaled.free.len()];
        let settings = NewtonSettings::default();
        let result = iterate::<Spring, 2>(&scaled, &mut matrix, &start, &settings, GOAL, None);
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

    /// A body with weight 1 at a contact of stiffness 10 moves down by `a du`: the derivative of
    /// the energy vanishes at a depth of 0.1, whatever the length of du.
    #[test]
    fn the_minimum_of_a_parabola() {
        let program = ConeProgram {
            bodies: vec![held(), loaded(0.0, -1.0)],
            interactions: vec![contact(0, 1, DVec2::Y, 0.1, 0.0)],
            ..ConeProgram::default()
        };
        let (scaled, _, place) = posed(&program);
        let goal = Goal { unbalance: 0.0, min_force: 0.0 };
        let mut point = Point::<Spring, 2>::new(&scaled, &[[0.0; 3]; 2], goal);
        point.evaluate();
        for length in [0.05, 0.1, 2.0] {
            let mut step = Step { de: vec![[length, 0.0]], ..Step::new(&scaled) };
            step.du[place[1]][1] = -length;
            let settings = NewtonSettings::default();
            let a = point.search(&step, &settings);
            assert!((a * length - 0.1).abs() <= 0.1 * settings.max_slope, "{a} times {length}");
        }
    }
}
