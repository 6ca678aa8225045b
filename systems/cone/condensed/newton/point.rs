//! A point of the iteration, its evaluation, and the step from it.

use super::Goal;
use crate::condensed::line_search::line_search;
use crate::condensed::matrix::BodyMatrix;
use crate::condensed::scaled::{Local, Scaled, add_forces, kinematics};
use crate::condensed::settings::LineSearchSettings;
use crate::condensed::spring::{Elastic, Response};

/// The bodies of an interaction and the rows of its forces.
struct Arms<const F: usize> {
    bodies: [u32; 2],
    rows: [[[f64; F]; 3]; 2],
}

impl<const F: usize> Arms<F> {
    fn new(l: &Local) -> Self {
        let rows = l.rows.map(|rows| rows.map(|row| std::array::from_fn(|f| row[f])));
        Self { bodies: l.bodies.map(|i| i as u32), rows }
    }

    fn kinematics(&self, u: &[[f64; 3]]) -> [f64; F] {
        kinematics(self.bodies, &self.rows, u)
    }
}

/// A point of the iteration, and what follows from its displacements, for interactions with `F`
/// forces.
pub struct Point<S, const F: usize> {
    springs: Vec<S>,
    arms: Vec<Arms<F>>,
    responses: Vec<Response<F>>,
    /// Displacements by body, then by image.
    pub u: Vec<[f64; 3]>,
    /// Kinematics by interaction.
    pub e: Vec<[f64; F]>,
    /// Out-of-balance forces by body, zero for images: the gradient of the energy.
    pub gradient: Vec<[f64; 3]>,
    goal: Goal,
    /// Maximum force of the interactions, at least that of the goal.
    pub force: f64,
    /// Maximum out-of-balance force.
    pub unbalance: f64,
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
    pub(super) fn new(program: &Scaled) -> Self {
        let du = vec![[0.0; 3]; program.places()];
        Self { du, de: vec![[0.0; F]; program.locals.len()], length: 0.0 }
    }
}

impl<S: Elastic<F>, const F: usize> Point<S, F> {
    pub(super) fn new(program: &Scaled, start: &[[f64; 3]], goal: Goal) -> Self {
        let count = program.locals.len();
        Self {
            springs: program.locals.iter().map(S::new).collect(),
            arms: program.locals.iter().map(Arms::new).collect(),
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
    pub(super) fn evaluate(&mut self, program: &Scaled) {
        program.images.spread(&mut self.u);
        program.balance_of_bodies(&self.u, &mut self.gradient);
        let mut force = self.goal.min_force;
        for (k, (spring, arms)) in self.springs.iter().zip(&self.arms).enumerate() {
            self.e[k] = arms.kinematics(&self.u);
            self.responses[k] = spring.respond(self.e[k]);
            let s = &self.responses[k].s;
            add_forces(arms.bodies, &arms.rows, s, 1.0, &mut self.gradient);
            force = force.max(s[0].abs()).max(s[1].abs());
        }
        program.images.fold(&mut self.gradient);
        self.force = force;
        self.unbalance = self.gradient.iter().flatten().map(|g| g.abs()).fold(0.0, f64::max);
    }

    pub(super) fn is_finite(&self) -> bool {
        self.gradient.iter().flatten().all(|g| g.is_finite())
    }

    pub(super) fn is_done(&self) -> bool {
        self.unbalance <= self.goal.unbalance * self.force
    }

    /// Sets the matrix to the Hessian, with damping on its diagonal.
    pub(super) fn assemble(&self, program: &Scaled, matrix: &mut BodyMatrix, damping: f64) {
        matrix.clear();
        let mut values = matrix.assembly();
        for (i, free) in program.free.iter().enumerate() {
            for k in 0..3 {
                let weight = if free[k] { program.weight[i][k] + damping } else { 1.0 };
                values.add_diagonal(i, k, weight);
            }
        }
        for (k, (arms, response)) in self.arms.iter().zip(&self.responses).enumerate() {
            values.add(k, &arms.rows, &response.d);
        }
    }

    /// Solves for the step; whether the matrix has a factor.
    pub(super) fn find_step(
        &self,
        program: &Scaled,
        matrix: &mut BodyMatrix,
        step: &mut Step<F>,
    ) -> bool {
        for (du, g) in step.du.iter_mut().zip(&self.gradient) {
            *du = g.map(|g| -g);
        }
        if !matrix.factorise_shifted_and_solve(&mut step.du[..program.free.len()]) {
            return false;
        }
        for (du, free) in step.du.iter_mut().zip(&program.free) {
            for k in (0..3).filter(|k| !free[*k]) {
                du[k] = 0.0;
            }
        }
        program.images.spread(&mut step.du);
        for (de, arms) in step.de.iter_mut().zip(&self.arms) {
            *de = arms.kinematics(&step.du);
        }
        true
    }

    /// The length at which the derivative of the energy along a step vanishes.
    pub fn search(
        &self,
        program: &Scaled,
        du: &[[f64; 3]],
        de: &[[f64; F]],
        settings: &LineSearchSettings,
    ) -> f64 {
        let along = [&self.u[..], du, &self.gradient[..]];
        line_search(program, &self.springs, settings, along, &self.e, de)
    }

    /// Makes a step.
    pub(super) fn make(&mut self, step: &Step<F>) {
        for (u, du) in self.u.iter_mut().zip(&step.du) {
            for k in 0..3 {
                u[k] += step.length * du[k];
            }
        }
    }

    pub(super) fn forces(&self) -> Vec<[f64; 3]> {
        let of = |s: &[f64; F]| std::array::from_fn(|f| if f < F { s[f] } else { 0.0 });
        self.responses.iter().map(|r| of(&r.s)).collect()
    }
}
