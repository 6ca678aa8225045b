//! The current point of the method, and the steps that make an iteration.

use std::ops::Add as _;

use super::cell::for_each;
use super::groups::Groups;
use super::point::{Interior, max_magnitude, part_of_way};
use super::sums::{Ahead, Gains, Sizes};
use crate::condensed::MIN_FORCE;
use crate::condensed::matrix::BodyMatrix;
use crate::condensed::scaled::{Local, Scaled, add_times};
use crate::condensed::settings::InteriorSettings;

/// Minimum of k at the start, force times displacement: a start without products is no reason to
/// begin at the boundary.
const MIN_K: f64 = 1e-6;
/// Maximum displacement of a start. The residuals of a start further away are round-off.
const MAX_START: f64 = 1e4;
/// Round-off of the duality gap over the magnitude of its terms. The step of tau follows from the
/// gap, and below this it would follow from noise.
const GAP_ROUND_OFF: f64 = 1e-11;
/// Round-off of the kinematics over the maximum displacement. A multiplier has it too, and the gap
/// counts it times the strength, which may be thousands of times the loads.
const KINEMATIC_ROUND_OFF: f64 = 1e-15;
/// Defect of a linear solve, over the maximum force, that round-off leaves.
const SOLVE_ROUND_OFF: f64 = 1e-14;
/// Maximum step of tau over tau. At the end of a solve the gap is round-off, and tau must not run
/// away with it.
const MAX_GROWTH: f64 = 1.0;
/// Round-off of the matrix over its stiffnesses.
const MATRIX_ROUND_OFF: f64 = 1e-15;
/// Maximum sum of the products after a step, over that before it. A step that is right to first
/// order only lets the products fall; where second-order terms dominate, the step is too long.
const MAX_PRODUCTS: f64 = 10.0;
/// Part of tau below which the proximal weight falls no further.
const MIN_TAU: f64 = 1e-12;

/// The current point, its residuals, and the step that leads on from it.
pub(crate) struct Iteration<'a> {
    program: &'a Scaled,
    matrix: &'a mut BodyMatrix,
    settings: &'a InteriorSettings,
    /// The interactions, with their forces, slacks and multipliers.
    groups: Groups,
    /// Displacements by body.
    u: Vec<[f64; 3]>,
    /// The homogenising variable. All other variables are those of the embedding over tau.
    tau: f64,
    /// kappa over tau.
    k: f64,
    /// Number of products: those of the limits and that of tau and kappa.
    products: f64,
    /// Minimum compliance of an interaction in a step, displacement over force.
    min_compliance: f64,
    /// Whether tau moves. It stays 1 where a solution is known to exist or no proof is sought, and
    /// saves a solve an iteration.
    is_embedded: bool,
    /// Part of the last step that the interactions have still to make. They make it in the pass
    /// that evaluates the residuals, since every pass over them costs.
    length: f64,
    /// Out-of-balance forces by body.
    balance: Vec<[f64; 3]>,
    unbalance: f64,
    /// Residuals of the interactions.
    sizes: Sizes,
    /// Residual of the duality gap.
    gap: f64,
    gap_round_off: f64,
    /// Sum of the strengths of the limits, force.
    strengths: f64,
    /// Mean product.
    mu: f64,
    /// Weight of the degrees of freedom in the matrix beside their own.
    proximal: f64,
    /// Right sides of the responses to residuals and to products and of the corrector.
    rights: [Vec<[f64; 3]>; 3],
    /// The responses of the bodies, and the corrector.
    responses: [Vec<[f64; 3]>; 3],
    gains: Gains,
    /// Right side and solution of the whole step.
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
        forces: Option<&[[f64; 3]]>,
        is_embedded: bool,
    ) -> Self {
        let mut u = program.with_known(start);
        let mut groups = Groups::new(program, matrix, &u, settings);
        if let Some(forces) = forces {
            for_each!(cell in groups => cell.warm(&u, forces, settings.warm_product));
        } else {
            let mut force = 0.0_f64;
            for_each!(cell in groups => force = force.max(cell.x.s[0].abs()));
            if force > settings.max_start_force || max_magnitude(&u) > MAX_START {
                u = program.with_known(&vec![[0.0; 3]; program.free.len()]);
                groups = Groups::new(program, matrix, &u, settings);
            }
        }
        let limits = program.locals.iter().flat_map(Local::limits).count();
        let zeros = vec![[0.0; 3]; program.places()];
        let mut iteration = Self {
            program,
            matrix,
            settings,
            groups,
            u,
            tau: 1.0,
            k: 0.0,
            products: (limits + usize::from(is_embedded)).max(1) as f64,
            min_compliance: min_compliance(program, settings),
            is_embedded,
            length: 0.0,
            balance: zeros.clone(),
            unbalance: 0.0,
            sizes: Sizes::default(),
            gap: 0.0,
            gap_round_off: 0.0,
            strengths: program.locals.iter().flat_map(Local::limits).map(|(_, b)| b.abs()).sum(),
            mu: 0.0,
            proximal: 0.0,
            rights: std::array::from_fn(|_| zeros.clone()),
            responses: std::array::from_fn(|_| zeros.clone()),
            gains: Gains::default(),
            right: zeros.clone(),
            du: zeros.clone(),
            defect: zeros,
        };
        iteration.update_residuals();
        if is_embedded {
            // The product of tau and kappa begins as the mean of the others.
            iteration.k = (iteration.sizes.products / limits.max(1) as f64).max(MIN_K);
            iteration.update_gap();
        }
        iteration
    }

    /// Makes the last step in the interactions, and evaluates all residuals.
    pub(crate) fn update_residuals(&mut self) {
        let Self { groups, u, length, .. } = self;
        self.program.balance_of_bodies(u, &mut self.balance);
        let sizes = groups.scatter(&mut self.balance, |cells, balance| {
            let mut size = Sizes::default();
            for_each!(cell of cells => cell.evaluate(*length, u, balance, &mut size));
            size
        });
        self.program.images.fold(&mut self.balance);
        self.sizes = sizes.into_iter().fold(Sizes::default(), Sizes::add);
        self.unbalance = max_magnitude(&self.balance);
        self.length = 0.0;
        self.update_gap();
    }

    /// The mean product, and the residual of `k = f'u - l's - b'lambda - u'Mu - s'Cs`.
    fn update_gap(&mut self) {
        let Self { program, u, sizes, strengths, .. } = self;
        self.mu = (sizes.products + self.k) / self.products;
        if !self.is_embedded {
            return;
        }
        let work = program.sum_of_free(|i, k| program.right[i][k] * u[i][k]);
        let energy =
            sizes.energy + program.sum_of_free(|i, k| program.weight[i][k] * u[i][k].powi(2));
        self.gap = self.k - (work - sizes.linear - sizes.strength - energy);
        self.gap_round_off = GAP_ROUND_OFF
            * (work.abs() + sizes.linear.abs() + sizes.strength.abs() + energy)
            + KINEMATIC_ROUND_OFF * max_magnitude(u) * *strengths;
    }

    /// Whether all residuals are numbers.
    pub fn is_finite(&self) -> bool {
        (self.merit() + self.mu + self.gap).is_finite()
    }

    /// Residual of the point: balance and limits over the maximum force, kinematics, and the
    /// maximum product. The mean product says little of a start near a solution, where most are
    /// zero.
    pub fn merit(&self) -> f64 {
        let Sizes { kinematic, primal, product, .. } = self.sizes;
        let force = self.force();
        (self.unbalance.max(primal) / force)
            .max(kinematic)
            .max(self.settings.product_weight * product / force)
    }

    /// Maximum force, for comparison.
    fn force(&self) -> f64 {
        self.sizes.force.max(MIN_FORCE)
    }

    /// Whether the point goes to infinity: kappa is larger than tau.
    pub fn diverges(&self) -> bool {
        self.k > 1.0
    }

    /// Copies the point.
    pub fn store(&mut self, point: &mut Interior) {
        point.u.copy_from_slice(&self.u[..self.program.free.len()]);
        point.merit = self.merit();
        for_each!(cell in self.groups => cell.store(&mut point.s, &mut point.lambda));
    }

    /// Goes back to an earlier point.
    pub fn restore(&mut self, point: &Interior) {
        self.u = self.program.with_known(&point.u);
        (self.is_embedded, self.tau, self.k) = (false, 1.0, 0.0);
        for_each!(cell in self.groups => cell.restore(&point.s, &point.lambda));
        self.update_residuals();
    }

    /// Copies the last step of the point, displacements and forces.
    pub(crate) fn store_step(&mut self, point: &mut Interior) {
        point.u.copy_from_slice(&self.du[..self.program.free.len()]);
        for_each!(cell in self.groups => cell.store_steps(&mut point.s));
    }

    /// Assembles the condensed matrix, and the right sides of the two responses.
    pub fn assemble(&mut self) {
        let Self { program, matrix, settings, groups, rights, .. } = self;
        let n = program.free.len();
        // A small proximal weight keeps bodies that nothing holds from moving to infinity, and a
        // small compliance keeps forces of rigid interactions that are not unique from growing. Both
        // fall with the products, so that they delay the end of the method no more than those do.
        // Neither holds a point back that goes to infinity for want of a solution, and neither
        // changes a solution, since they act on the step alone.
        let scale = self.tau.clamp(MIN_TAU, 1.0);
        let of_products = settings.proximal * (self.mu * scale * scale).min(1.0);
        self.proximal = scale * (settings.min_proximal + of_products);
        let min_compliance = scale * (self.min_compliance + of_products);
        let [of_residuals, of_products, _] = rights;
        matrix.clear();
        matrix.assembly().add_weights(program, self.proximal);
        for (right, balance) in of_residuals.iter_mut().zip(&self.balance[..n]) {
            *right = balance.map(|b| -b);
        }
        of_residuals[n..].fill([0.0; 3]);
        of_products.fill([0.0; 3]);
        groups.condense(matrix, [of_residuals, of_products], |cells, values, rights| {
            for_each!(cell of cells => cell.condense(min_compliance, values, rights));
        });
        program.images.fold(of_residuals);
        program.images.fold(of_products);
    }

    /// Factorises and solves for the responses to residuals and to products; whether the matrix has
    /// a factor.
    pub fn respond(&mut self) -> bool {
        let Self { program, matrix, groups, rights, responses, u, .. } = self;
        let [a, b, _] = responses;
        if !self.is_embedded {
            // Both responses have the same factor: one solve serves their sum.
            let [of_residuals, of_products, _] = rights;
            let of_products = of_products.as_flattened_mut();
            for (sum, product) in of_residuals.as_flattened_mut().iter_mut().zip(of_products) {
                *sum += std::mem::take(product);
            }
        }
        a.clone_from(&rights[0]);
        if !matrix.factorise_shifted_and_solve(a) {
            return false;
        }
        if !self.is_embedded {
            return true;
        }
        b.clone_from(&rights[1]);
        matrix.solve(b);
        let (a, b) = (&*a, &*b);
        let square = |i: usize, k: usize| {
            (program.weight[i][k] + self.proximal) * (a[i][k] + 2.0 * b[i][k]).powi(2)
        };
        let of_bodies = Gains {
            of_residuals: gain(program, u, a),
            of_products: gain(program, u, b),
            squares: program.sum_of_free(square),
        };
        self.gains = groups.sum(of_bodies, |cells, gains| {
            for_each!(cell of cells => cell.set_responses([a, b], gains));
        });
        true
    }

    /// The step of tau over tau that takes the gap away, with `of_kappa` the product that tau and
    /// kappa lose and `gain` that of the corrector.
    fn growth(&self, of_kappa: f64, gain: f64) -> f64 {
        if !self.is_embedded {
            return 0.0;
        }
        let denominator = self.k + self.gains.squares + self.gap_round_off;
        let Gains { of_residuals, of_products, .. } = self.gains;
        ((self.gap - of_kappa - of_residuals - of_products - gain) / denominator).min(MAX_GROWTH)
    }

    /// Looks ahead along the predictor, which takes all residuals and products away. Returns the
    /// product that the corrector aims at, `mu (mu_p/mu)^3` with mu the mean product now and mu_p
    /// that after the predictor (Mehrotra 1992), and the second-order product of tau and kappa.
    fn predict(&mut self) -> (f64, f64) {
        let rho = self.growth(self.k, 0.0);
        let dk = -self.k - self.k * rho;
        let Self { groups, responses: [a, ..], is_embedded, .. } = self;
        let mut ahead = groups.sum(Ahead::default(), |cells, ahead| {
            if !*is_embedded {
                for_each!(cell of cells => cell.set_response(a));
            }
            for_each!(cell of cells => cell.predict(rho, ahead));
        });
        if self.is_embedded {
            ahead.take(1.0, self.k, rho, dk);
        }
        let after = ahead.products_after() / self.products;
        let ratio = if self.mu > 0.0 { after / self.mu } else { 0.0 };
        (ratio.powi(3).min(1.0) * self.mu, rho * dk)
    }

    /// Solves for the corrector, and moves the point along the whole step, up to a part of the
    /// distance to the boundary. Returns whether the step is a number.
    pub fn correct(&mut self) -> bool {
        let (target, of_tau) = self.predict();
        let right = &mut self.rights[2];
        right.fill([0.0; 3]);
        self.groups.scatter(right, |cells, right| {
            for_each!(cell of cells => cell.aim(target, right));
        });
        self.program.images.fold(right);
        let corrector = &mut self.responses[2];
        corrector.clone_from(right);
        self.matrix.solve(corrector);
        let (rho, dk) = self.step_of_tau(target, of_tau);
        let parts = [1.0 + rho, 1.0 + 2.0 * rho];
        let sum = |[a, b, c]: &[Vec<[f64; 3]>; 3], to: &mut [[f64; 3]]| {
            for (i, to) in to.iter_mut().enumerate() {
                *to = [0, 1, 2].map(|k| parts[0] * a[i][k] + parts[1] * b[i][k] + c[i][k]);
            }
        };
        sum(&self.rights, &mut self.right);
        sum(&self.responses, &mut self.du);
        self.refine();
        let mut ahead = self.set_step(parts, rho);
        if self.is_embedded {
            ahead.take(1.0, self.k, rho, dk);
        }
        ahead.bound_growth(MAX_PRODUCTS);
        self.make_step(ahead.length, rho, dk)
    }

    /// Number of limits that have slack and multiplier, or violate either, by more than `size`.
    pub fn undecided(&mut self, size: f64) -> usize {
        self.groups.sum(0, |cells, count| {
            for_each!(cell of cells => *count += cell.undecided(size));
        })
    }

    /// Gives to the larger of slack and multiplier what limits with both above `size` have, with
    /// `rest` for both where they are equal. Then makes a whole Newton step, whatever it violates.
    /// Returns whether the point is a number.
    pub fn decide(&mut self, size: f64, rest: f64) -> bool {
        for_each!(cell in self.groups => cell.decide(size, rest * rest));
        self.update_residuals();
        self.assemble();
        let [of_residuals, of_products, _] = &self.rights;
        for (right, (r, p)) in self.right.iter_mut().zip(of_residuals.iter().zip(of_products)) {
            *right = std::array::from_fn(|k| r[k] + p[k]);
        }
        self.du.clone_from(&self.right);
        if !self.matrix.factorise_shifted_and_solve(&mut self.du) {
            return false;
        }
        self.refine();
        self.set_step([1.0; 2], 0.0);
        let is_finite = self.make_step(1.0, 0.0, 0.0);
        self.update_residuals();
        is_finite && self.is_finite()
    }

    /// Computes the whole step of the interactions from that of the bodies.
    fn set_step(&mut self, parts: [f64; 2], rho: f64) -> Ahead {
        let Self { groups, du, .. } = self;
        groups.sum(Ahead::default(), |cells, ahead| {
            for_each!(cell of cells => cell.set_step(du, parts, rho, ahead));
        })
    }

    /// The steps of tau, over tau, and of k that belong to the corrector.
    fn step_of_tau(&mut self, target: f64, of_tau: f64) -> (f64, f64) {
        if !self.is_embedded {
            return (0.0, 0.0);
        }
        let corrector = &self.responses[2];
        let gain_of_cells = self.groups.sum(0.0, |cells, sum| {
            for_each!(cell of cells => *sum += cell.gain_of_corrector(corrector));
        });
        let of_bodies = gain(self.program, &self.u, corrector);
        let of_kappa = self.k + of_tau - target;
        let rho = self.growth(of_kappa, of_bodies + gain_of_cells);
        (rho, -of_kappa - self.k * rho)
    }

    fn make_step(&mut self, to_boundary: f64, rho: f64, dk: f64) -> bool {
        let part = part_of_way(self.mu * self.tau * self.tau);
        // A step onto the boundary, tau = 0, is as short of it as one that would cross it.
        let reaches = to_boundary < 1.0 || rho <= -1.0;
        let step = if reaches { to_boundary * part } else { 1.0 };
        let growth = 1.0 + step * rho;
        self.length = step / growth;
        add_times(self.u.as_flattened_mut(), self.length, self.du.as_flattened());
        self.program.images.spread(&mut self.u);
        self.tau *= growth;
        self.k = (self.k + step * dk) / growth;
        self.length.is_finite()
    }

    /// Refines the solution of the condensed system, on the operator whose matrix was factorised.
    fn refine(&mut self) {
        let force = self.force();
        let Self { program, matrix, groups, proximal, right, du, defect, .. } = self;
        let set = |du: &[[f64; 3]], defect: &mut [[f64; 3]]| {
            defect.fill([0.0; 3]);
            for (i, k) in program.all_free() {
                defect[i][k] = right[i][k] - (program.weight[i][k] + *proximal) * du[i][k];
            }
            groups.scatter(defect, |cells, defect| {
                for_each!(cell of cells => cell.take_away(du, defect));
            });
        };
        matrix.refine(SOLVE_ROUND_OFF * force, du, defect, set);
    }
}

/// Minimum compliance of an interaction in a step, displacement over force. It bounds the stiffnesses
/// of the matrix, whose round-off must stay below the weakest stiffness that holds a body.
fn min_compliance(program: &Scaled, settings: &InteriorSettings) -> f64 {
    let weights = program.all_free().map(|(i, k)| program.weight[i][k]);
    let weakest = weights.fold(f64::INFINITY, f64::min);
    let [lower, upper] = settings.min_compliance;
    (MATRIX_ROUND_OFF / weakest.max(settings.min_proximal)).clamp(lower, upper)
}

/// Derivative of the duality gap along a step of the bodies.
fn gain(program: &Scaled, u: &[[f64; 3]], du: &[[f64; 3]]) -> f64 {
    program
        .sum_of_free(|i, k| (program.right[i][k] - 2.0 * program.weight[i][k] * u[i][k]) * du[i][k])
}
