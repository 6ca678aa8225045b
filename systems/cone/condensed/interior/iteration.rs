//! The current point of the method, and the steps that make an iteration.

use super::cell::{Ahead, Aim, Sizes, for_each};
use super::groups::Groups;
use super::point::{Interior, Warm, max_magnitude};
use crate::condensed::matrix::BodyMatrix;
use crate::condensed::scaled::Scaled;
use crate::condensed::settings::InteriorSettings;

/// The current point, its residuals, and the step that leads on from it.
pub struct Iteration<'a> {
    program: &'a Scaled,
    matrix: &'a mut BodyMatrix,
    settings: &'a InteriorSettings,
    /// The interactions, with their forces, slacks and multipliers.
    groups: Groups,
    /// Displacements by body.
    u: Vec<[f64; 3]>,
    /// Number of limits.
    limits: f64,
    /// Part of the last step that the interactions have still to make. They make it in the pass
    /// that evaluates the residuals, since every pass over them costs.
    length: f64,
    /// Out-of-balance forces by body.
    balance: Vec<[f64; 3]>,
    /// Maximum out-of-balance force.
    unbalance: f64,
    /// Residuals of the interactions.
    sizes: Sizes,
    /// Mean product of slacks and multipliers.
    mu: f64,
    /// Weights of the degrees of freedom in the matrix.
    weight: Vec<[f64; 3]>,
    /// Right side of the condensed system, its solution, and its residual.
    right: Vec<[f64; 3]>,
    du: Vec<[f64; 3]>,
    defect: Vec<[f64; 3]>,
}

impl<'a> Iteration<'a> {
    /// Starts from displacements and forces. Without forces it starts from the elastic trial at the
    /// displacements, or from zero where that trial has forces that are too large.
    pub fn new(
        program: &'a Scaled,
        matrix: &'a mut BodyMatrix,
        settings: &'a InteriorSettings,
        start: &[[f64; 3]],
        warm: Option<Warm>,
    ) -> Self {
        let n = program.free.len();
        let mut u = program.with_known(start);
        let mut groups = Groups::new(program, matrix, &u, settings);
        if let Some(warm) = warm {
            for cells in groups.all() {
                for_each!(cell of cells => cell.warm(&u, warm));
            }
        } else if groups.max_force() > settings.max_start_force {
            u = program.with_known(&vec![[0.0; 3]; n]);
            groups = Groups::new(program, matrix, &u, settings);
        }
        let limits: usize = program.locals.iter().map(|l| l.count).sum();
        let zeros = vec![[0.0; 3]; program.places()];
        Self {
            program,
            matrix,
            settings,
            groups,
            u,
            limits: limits.max(1) as f64,
            length: 0.0,
            balance: zeros.clone(),
            unbalance: 0.0,
            sizes: Sizes::default(),
            mu: 0.0,
            weight: zeros.clone(),
            right: zeros.clone(),
            du: zeros.clone(),
            defect: zeros,
        }
    }

    /// Makes the last step in the interactions, and evaluates all residuals.
    pub fn update_residuals(&mut self) {
        let Self { groups, u, length, .. } = self;
        self.program.balance_of_bodies(u, &mut self.balance);
        let sizes = groups.scatter(&mut self.balance, |cells, balance| {
            let mut size = Sizes::default();
            for_each!(cell of cells => cell.evaluate(*length, u, balance, &mut size));
            size
        });
        self.program.images.fold(&mut self.balance);
        self.sizes = sizes.into_iter().fold(Sizes::default(), Sizes::and);
        self.mu = self.sizes.products / self.limits;
        self.unbalance = max_magnitude(&self.balance);
    }

    /// Whether all residuals are numbers.
    pub fn is_finite(&self) -> bool {
        let Sizes { kinematic, primal, .. } = self.sizes;
        (self.unbalance + kinematic + primal + self.mu).is_finite()
    }

    /// Residual of the point: balance and limits over the maximum force, kinematics, and the
    /// maximum product. The mean product says little of a start near a solution, where most are
    /// zero.
    pub fn merit(&self) -> f64 {
        let Sizes { kinematic, primal, force, product, .. } = self.sizes;
        let force = force.max(self.settings.min_force);
        (self.unbalance.max(primal) / force)
            .max(kinematic)
            .max(self.settings.product_weight * product / force)
    }

    /// Mean product of slacks and multipliers.
    #[cfg(test)]
    pub fn mean_product(&self) -> f64 {
        self.mu
    }

    /// Copies the point.
    pub fn store(&mut self, to: &mut Option<Interior>) {
        let point = to.get_or_insert_with(|| Interior::of(self.program));
        point.u.clear();
        point.u.extend_from_slice(&self.u[..self.program.free.len()]);
        point.merit = self.merit();
        for cells in self.groups.all() {
            for_each!(cell of cells => cell.store(&mut point.s, &mut point.lambda));
        }
    }

    /// Assembles the condensed matrix, and the right side of the predictor, which takes all
    /// products away.
    pub fn assemble(&mut self) {
        let Self { program, matrix, settings, groups, weight, right, .. } = self;
        matrix.clear();
        let mut values = matrix.assembly();
        // A small proximal weight keeps bodies that nothing holds from moving to infinity.
        let proximal = settings.min_proximal + settings.proximal * self.mu.min(1.0);
        for i in 0..program.free.len() {
            for k in 0..3 {
                weight[i][k] = program.weight[i][k] + proximal;
                let diagonal = if program.free[i][k] { weight[i][k] } else { 1.0 };
                values.add_diagonal(i, k, diagonal);
            }
        }
        set_negative(right, &self.balance);
        groups.condense(matrix, right, |cells, values, right| {
            for_each!(cell of cells => cell.condense(values, right));
        });
        program.images.fold(right);
    }

    /// Solves for the step of the predictor; whether the matrix has a factor.
    pub fn predict(&mut self) -> bool {
        self.du.clone_from(&self.right);
        let n = self.program.free.len();
        let solved = self.matrix.factorise_shifted_and_solve(&mut self.du[..n]);
        self.program.images.spread(&mut self.du);
        solved
    }

    /// The mean product that the corrector aims at: `mu (mu_p/mu)^3`, with mu the mean product now
    /// and mu_p that after the predictor (Mehrotra 1992).
    pub fn target(&mut self) -> f64 {
        let after = self.steps_of_interactions().products_after() / self.limits;
        let ratio = if self.mu > 0.0 { after / self.mu } else { 0.0 };
        ratio.powi(3).min(1.0) * self.mu
    }

    /// Solves for the step that leads to the target.
    pub fn correct(&mut self, target: f64) {
        set_negative(&mut self.right, &self.balance);
        self.groups.scatter(&mut self.right, |cells, right| {
            for_each!(cell of cells => cell.aim(Aim::Target(target), right));
        });
        self.program.images.fold(&mut self.right);
        self.du.clone_from(&self.right);
        self.matrix.solve(&mut self.du[..self.program.free.len()]);
        self.program.images.spread(&mut self.du);
        self.refine();
    }

    /// Moves the bodies along the step, up to a part of the distance to the boundary.
    pub fn make_step(&mut self) {
        let step = self.steps_of_interactions().length;
        let [lower, upper] = self.settings.step;
        self.length = if step < 1.0 { step * (1.0 - self.mu).clamp(lower, upper) } else { 1.0 };
        for (u, du) in self.u.iter_mut().zip(&self.du) {
            for k in 0..3 {
                u[k] += self.length * du[k];
            }
        }
        self.program.images.spread(&mut self.u);
    }

    /// Steps of forces, slacks and multipliers that belong to the steps of the displacements.
    fn steps_of_interactions(&mut self) -> Ahead {
        let Self { groups, du, .. } = self;
        let ahead = groups.each(|cells| {
            let mut ahead = Ahead::default();
            for_each!(cell of cells => cell.step(du, &mut ahead));
            ahead
        });
        ahead.into_iter().fold(Ahead::default(), Ahead::and)
    }

    /// Refines the solution of the condensed system, on the operator whose matrix was factorised.
    fn refine(&mut self) {
        let Self { program, matrix, settings, groups, weight, right, du, defect, .. } = self;
        let scale = max_magnitude(right);
        for _ in 0..settings.max_refinements {
            let n = program.free.len();
            defect[n..].fill([0.0; 3]);
            for (i, defect) in defect[..n].iter_mut().enumerate() {
                for k in 0..3 {
                    let is_free = program.free[i][k];
                    defect[k] = if is_free { right[i][k] - weight[i][k] * du[i][k] } else { 0.0 };
                }
            }
            groups.scatter(defect, |cells, defect| {
                for_each!(cell of cells => cell.take_away(du, defect));
            });
            program.images.fold(defect);
            if max_magnitude(defect) <= settings.refined * scale {
                return;
            }
            matrix.solve(&mut defect[..n]);
            program.images.spread(defect);
            for (du, d) in du.iter_mut().zip(&*defect) {
                for k in 0..3 {
                    du[k] += d[k];
                }
            }
        }
    }
}

/// Sets rows to the negative of others.
fn set_negative(rows: &mut [[f64; 3]], of: &[[f64; 3]]) {
    for (row, of) in rows.iter_mut().zip(of) {
        *row = of.map(|r| -r);
    }
}
