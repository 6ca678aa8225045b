//! The data of one interaction in the interior-point method, and its part of an iteration.
//!
//! An iteration passes over all interactions several times, and these passes wait for memory.
//! Interactions of a kind therefore lie together, without room for forces and limits that the kind
//! does not have.

use super::super::matrix::{Assembly, Cholesky};
use super::super::scaled::{Local, ROWS, add_times, first};
use super::super::settings::InteriorSettings;
use super::law::{Law, Rows, Variables};
use super::local_system::LocalSystem;
use super::sums::{Ahead, Gains, Sizes};

/// One interaction.
#[derive(Clone)]
pub struct Cell<const F: usize, const Q: usize> {
    /// Its place in the program.
    number: usize,
    law: Law<F, Q>,
    pub x: Variables<F, Q>,
    /// Residuals of stationarity.
    stationarity: [f64; F],
    /// Residuals of the limits.
    defect: [f64; Q],
    system: LocalSystem<F, Q>,
    /// Response A to the residuals, and response B to the products.
    responses: [Variables<F, Q>; 2],
    /// Products that the corrector takes away.
    correction: [f64; Q],
    /// The step of the iteration, without the part that follows the growth of tau.
    step: Variables<F, Q>,
}

/// Interactions, by their forces and limits: the inner loops are compiled for each kind.
#[derive(Default)]
pub struct Cells {
    /// p alone, with the limit of tension.
    pub normal: Vec<Cell<1, 1>>,
    /// p and q, with two limits of shear.
    pub friction: Vec<Cell<2, 2>>,
    /// p and q, with two limits of shear and that of tension.
    pub bond: Vec<Cell<2, 3>>,
    /// p, q and tau, with two limits of shear and two of rolling.
    pub rolling: Vec<Cell<3, 4>>,
    /// p and tau, with two limits of rolling; q is a dummy with a compliance and without load.
    pub wheel: Vec<Cell<3, 2>>,
}

/// Evaluates an expression for every interaction `of` cells, or `in` groups of cells.
macro_rules! for_each {
    ($cell:ident in $groups:expr => $what:expr) => {
        for cells in $groups.all() {
            for_each!($cell of cells => $what);
        }
    };
    ($cell:ident of $cells:expr => $what:expr) => {
        for_each!($cell of $cells => $what; normal friction bond rolling wheel)
    };
    ($cell:ident of $cells:expr => $what:expr; $($kind:ident)*) => {{
        let cells: &mut $crate::condensed::interior::cell::Cells = $cells;
        $(for $cell in &mut cells.$kind {
            $what;
        })*
    }};
}
pub(super) use for_each;

impl Cells {
    /// Adds an interaction, near the elastic trial at the starting displacements.
    pub fn push(
        &mut self,
        number: usize,
        local: &Local,
        u: &[[f64; 3]],
        settings: &InteriorSettings,
    ) {
        let [_, shear, rolling] = local.has;
        match (shear, rolling) {
            (false, false) => self.normal.push(Cell::new(number, local, u, settings)),
            (true, false) if local.has_tension => {
                self.bond.push(Cell::new(number, local, u, settings));
            }
            (true, false) => self.friction.push(Cell::new(number, local, u, settings)),
            (true, true) => self.rolling.push(Cell::new(number, local, u, settings)),
            (false, true) => self.wheel.push(Cell::new(number, local, u, settings)),
        }
    }
}

impl<const F: usize, const Q: usize> Cell<F, Q> {
    /// Forces, slacks and multipliers near the elastic trial at the displacements.
    fn new(number: usize, local: &Local, u: &[[f64; 3]], settings: &InteriorSettings) -> Self {
        let law = Law::<F, Q>::new(local);
        let e = law.arms.kinematics(u);
        let trial: [f64; F] = std::array::from_fn(|f| {
            let c = local.compliance[f];
            if local.has[f] && c > 0.0 { (e[f] - law.linear[f]) / c } else { 0.0 }
        });
        let mut x = Variables::default();
        // The trial clamped to the limits: normal force first, then the others with it.
        x.s[0] = trial[0].max(local.lowest());
        for k in 0..Law::<F, Q>::PAIRS {
            let strength = (law.right[2 * k] + law.slopes[k] * x.s[0]).max(0.0);
            let f = Law::<F, Q>::force(k);
            x.s[f] = trial[f].clamp(-strength, strength);
        }
        // Inside of a limit the distance to it is the slack; outside, the excess is the multiplier.
        let is_rigid = local.compliance[0] == 0.0;
        // The multipliers of a rigid open contact add up to its gap: the stationarity of p. Near
        // rest gaps are thousands of displacements, and smaller multipliers would shorten the steps
        // of all other interactions. An interaction with strength does not open by itself.
        let has_strength = law.right.iter().any(|right| *right > 0.0);
        let gap = if has_strength { 0.0 } else { (law.linear[0] - e[0]).max(0.0) };
        let multiplier = gap / local.limits().map(|(slope, _)| slope).sum::<f64>();
        let beyond: [f64; F] = std::array::from_fn(|f| trial[f] - x.s[f]);
        let product = settings.start * settings.start;
        for q in 0..Q {
            let left = law.right[q] - law.limit(q, &x.s);
            let elastic = local.compliance[0] * law.limit(q, &beyond);
            let excess = if is_rigid { multiplier } else { elastic };
            x.set(q, left.max(0.0) - excess.max(0.0), product);
        }
        Self {
            number,
            law,
            x,
            stationarity: [0.0; F],
            defect: [0.0; Q],
            system: LocalSystem::default(),
            responses: [Variables::default(); 2],
            correction: [0.0; Q],
            step: Variables::default(),
        }
    }

    /// Takes forces near the solution, with the multipliers of their stationarity. Slacks and
    /// multipliers are then shifted to equal products: `w - lambda` stays, `w lambda` is the
    /// product.
    pub fn warm(&mut self, u: &[[f64; 3]], forces: &[[f64; 3]], product: f64) {
        let Self { law, x, .. } = self;
        x.s = first(&forces[self.number]);
        let e = law.arms.kinematics(u);
        let left: [f64; F] =
            std::array::from_fn(|f| law.linear[f] + law.compliance[f] * x.s[f] - e[f]);
        let mut multipliers = [0.0; Q];
        let mut gap = left[0];
        let mut slopes = 0.0;
        for k in 0..Law::<F, Q>::PAIRS {
            let slip = -left[Law::<F, Q>::force(k)];
            multipliers[2 * k] = slip.max(0.0);
            multipliers[2 * k + 1] = (-slip).max(0.0);
            gap -= law.slopes[k] * slip.abs();
            slopes += 2.0 * law.slopes[k];
        }
        // The gap less the dilation goes to the limit of tension, or in equal parts to the others.
        if Law::<F, Q>::HAS_TENSION {
            multipliers[Q - 1] = gap;
        } else {
            for multiplier in &mut multipliers {
                *multiplier += gap / slopes;
            }
        }
        for q in 0..Q {
            let left = law.right[q] - law.limit(q, &x.s);
            x.set(q, left - multipliers[q], product);
        }
    }

    /// Makes `length` times the step, evaluates the residuals, and adds the forces to the balance.
    pub fn evaluate(&mut self, length: f64, u: &[[f64; 3]], balance: &mut Rows, size: &mut Sizes) {
        let Self { law, x: Variables { s, w, lambda }, step, .. } = self;
        add_times(s, length, &step.s);
        add_times(w, length, &step.w);
        add_times(lambda, length, &step.lambda);
        law.add_forces(s, 1.0, balance);
        let e = law.arms.kinematics(u);
        let mut r = [0.0; F];
        for f in 0..F {
            let elongation = law.compliance[f] * s[f];
            r[f] = law.linear[f] + elongation - e[f];
            size.linear += law.linear[f] * s[f];
            size.energy += elongation * s[f];
        }
        for q in 0..Q {
            self.defect[q] = w[q] - law.right[q] + law.limit(q, s);
            // The round-off of a limit that is far above all forces may exceed every residual.
            let round_off = f64::EPSILON * (w[q] + law.right[q]);
            size.primal = size.primal.max(self.defect[q].abs() - round_off);
            size.product = size.product.max(w[q] * lambda[q]);
            size.products += w[q] * lambda[q];
            size.strength += law.right[q] * lambda[q];
        }
        for k in 0..Law::<F, Q>::PAIRS {
            let (plus, minus) = (lambda[2 * k], lambda[2 * k + 1]);
            r[0] -= law.slopes[k] * (plus + minus);
            r[Law::<F, Q>::force(k)] += plus - minus;
        }
        if Law::<F, Q>::HAS_TENSION {
            r[0] -= lambda[Q - 1];
        }
        for r in r {
            size.kinematic = size.kinematic.max(r.abs());
        }
        self.stationarity = r;
        size.force = size.force.max(s[0].abs());
    }

    /// Copies forces and multipliers to their places in the program.
    pub fn store(&self, forces: &mut [[f64; 3]], multipliers: &mut [[f64; ROWS]]) {
        forces[self.number][..F].copy_from_slice(&self.x.s);
        multipliers[self.number][..Q].copy_from_slice(&self.x.lambda);
    }

    /// Takes forces and multipliers from their places in the program, and the slacks of the forces.
    pub fn restore(&mut self, forces: &[[f64; 3]], multipliers: &[[f64; ROWS]]) {
        let s = first(&forces[self.number]);
        let w = std::array::from_fn(|q| self.law.right[q] - self.law.limit(q, &s));
        self.x = Variables { s, w, lambda: first(&multipliers[self.number]) };
        self.step = Variables::default();
    }

    /// Copies the steps of the forces to their places in the program.
    pub(crate) fn store_steps(&self, forces: &mut [[f64; 3]]) {
        forces[self.number][..F].copy_from_slice(&self.step.s);
    }

    /// Sets up the system, adds its stiffness to the matrix, and its part to the right sides of the
    /// responses to the residuals and to the products.
    pub(crate) fn condense(
        &mut self,
        min_compliance: f64,
        matrix: &mut Assembly<Cholesky>,
        [of_residuals, of_products]: &mut [Rows; 2],
    ) {
        let Self { law, x, system, .. } = self;
        system.set(law, x, min_compliance);
        matrix.add(self.number, &law.arms.rows, &system.stiffness);
        let e = self.stationarity.map(|r| -r);
        let b = self.defect.map(|d| -d);
        law.add_forces(&system.forces(law, &e, &b), -1.0, of_residuals);
        // The products over the multipliers are the slacks.
        law.add_forces(&system.forces(law, &[0.0; F], &x.w), -1.0, of_products);
    }

    /// The step of the interaction that belongs to a step of the bodies and takes these parts of
    /// the residuals and these products away.
    #[inline]
    fn respond(&self, du: &[[f64; 3]], of_residuals: f64, product: [f64; Q]) -> Variables<F, Q> {
        let mut kinematics = self.law.arms.kinematics(du);
        for (e, r) in kinematics.iter_mut().zip(&self.stationarity) {
            *e -= of_residuals * r;
        }
        let defect = self.defect.map(|d| of_residuals * d);
        self.system.solve(&self.law, &self.x, &kinematics, &defect, &product)
    }

    /// Derivative of the duality gap `f'u - l's - b'lambda - u'Mu - s'Cs` along a step.
    #[inline]
    fn gain(&self, step: &Variables<F, Q>) -> f64 {
        let mut sum = 0.0;
        for f in 0..F {
            sum -= (self.law.linear[f] + 2.0 * self.law.compliance[f] * self.x.s[f]) * step.s[f];
        }
        for q in 0..Q {
            sum -= self.law.right[q] * step.lambda[q];
        }
        sum
    }

    /// Computes the responses to the residuals and to the products from those of the bodies.
    pub(crate) fn set_responses(&mut self, du: [&[[f64; 3]]; 2], gains: &mut Gains) {
        let a = self.respond(du[0], 1.0, [0.0; Q]);
        let b = self.respond(du[1], 0.0, self.x.products());
        gains.of_residuals += self.gain(&a);
        gains.of_products += self.gain(&b);
        for f in 0..F {
            let s = a.s[f] + 2.0 * b.s[f];
            gains.squares += self.system.compliance[f] * s * s;
        }
        for q in 0..Q {
            let w = self.x.w[q] + a.w[q] + 2.0 * b.w[q];
            let lambda = self.x.lambda[q] + a.lambda[q] + 2.0 * b.lambda[q];
            gains.squares += (-w * lambda).max(0.0);
        }
        self.responses = [a, b];
    }

    /// Computes the response to residuals and products together.
    pub(crate) fn set_response(&mut self, du: &[[f64; 3]]) {
        self.responses = [self.respond(du, 1.0, self.x.products()), Variables::default()];
    }

    /// Looks ahead along the predictor, `(1 + rho) A + (1 + 2 rho) B + rho x` at the point x.
    pub fn predict(&mut self, rho: f64, ahead: &mut Ahead) {
        let [a, b] = &self.responses;
        for q in 0..Q {
            let (w, lambda) = self.x.limit(q);
            let along = |x: f64, a: f64, b: f64| (1.0 + rho) * a + (1.0 + 2.0 * rho) * b + rho * x;
            let dw = along(w, a.w[q], b.w[q]);
            let dlambda = along(lambda, a.lambda[q], b.lambda[q]);
            ahead.take(w, lambda, dw, dlambda);
            self.correction[q] = dw * dlambda;
        }
    }

    /// Aims the corrector at the product `target`, with the products of the predictor's steps taken
    /// into account.
    pub fn aim(&mut self, target: f64, right: &mut Rows) {
        self.correction = self.correction.map(|product| product - target);
        let b = std::array::from_fn(|q| self.correction[q] / self.x.lambda[q]);
        let forces = self.system.forces(&self.law, &[0.0; F], &b);
        self.law.add_forces(&forces, -1.0, right);
    }

    /// The gain of the corrector, from that of the bodies.
    pub(crate) fn gain_of_corrector(&self, du: &[[f64; 3]]) -> f64 {
        self.gain(&self.respond(du, 0.0, self.correction))
    }

    /// The whole step for a step of the bodies, with these parts of residuals and products.
    pub(crate) fn set_step(
        &mut self,
        du: &[[f64; 3]],
        parts: [f64; 2],
        rho: f64,
        ahead: &mut Ahead,
    ) {
        let [of_residuals, of_products] = parts;
        let (correction, products) = (self.correction, self.x.products());
        let product = std::array::from_fn(|q| of_products * products[q] + correction[q]);
        self.step = self.respond(du, of_residuals, product);
        for q in 0..Q {
            let ((w, lambda), (dw, dlambda)) = (self.x.limit(q), self.step.limit(q));
            ahead.take(w, lambda, dw + rho * w, dlambda + rho * lambda);
        }
    }

    /// Number of limits that have slack and multiplier, or violate either, by more than `size`.
    pub fn undecided(&self, size: f64) -> usize {
        let Variables { w, lambda, .. } = &self.x;
        (0..Q).filter(|q| !(w[*q].min(lambda[*q]).abs() <= size)).count()
    }

    /// Moves the slacks and multipliers of undecided limits to a product, with their difference as
    /// it is. The step that follows aims at products of zero.
    pub fn decide(&mut self, size: f64, product: f64) {
        self.correction = [0.0; Q];
        for q in 0..Q {
            let (w, lambda) = self.x.limit(q);
            if !(w.min(lambda) <= size && w.min(lambda) > 0.0) {
                let left = self.law.right[q] - self.law.limit(q, &self.x.s);
                self.x.set(q, left - lambda, product);
            }
        }
    }

    /// Subtracts its part of the condensed operator, applied to `du`, from the defect.
    pub(crate) fn take_away(&self, du: &[[f64; 3]], defect: &mut Rows) {
        let e = self.law.arms.kinematics(du);
        let mut s = [0.0; F];
        for f in 0..F {
            for g in 0..F {
                s[f] += self.system.stiffness[f][g] * e[g];
            }
        }
        self.law.add_forces(&s, -1.0, defect);
    }
}
