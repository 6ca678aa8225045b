//! The data of one interaction in the interior-point method, and its part of an iteration.
//!
//! An iteration passes over all interactions several times, and these passes wait for memory.
//! Interactions of a kind therefore lie together, without room for forces and limits that the kind
//! does not have.

use super::super::matrix::Assembly;
use super::super::scaled::{Kind, Local, ROWS};
use super::super::settings::InteriorSettings;
use super::law::{Law, Rows, first};
use super::local_system::LocalSystem;
use super::point::{Warm, slack};
use super::slacks::Slacks;

/// One interaction.
#[derive(Clone)]
pub struct Cell<const F: usize, const Q: usize> {
    /// Its place in the program.
    number: usize,
    law: Law<F, Q>,
    /// Forces.
    s: [f64; F],
    /// Steps of the forces.
    ds: [f64; F],
    /// Residuals of stationarity.
    stationarity: [f64; F],
    slacks: Slacks<Q>,
    system: LocalSystem<F, Q>,
}

/// Interactions, by their kind.
#[derive(Default)]
pub struct Cells {
    pub normal: Vec<Cell<1, 1>>,
    pub friction: Vec<Cell<2, 2>>,
    pub bond: Vec<Cell<2, 3>>,
    pub rolling: Vec<Cell<3, 4>>,
    pub wheel: Vec<Cell<3, 2>>,
}

/// Evaluates an expression for every interaction.
macro_rules! for_each {
    ($cell:ident of $cells:expr => $what:expr) => {{
        let cells: &mut $crate::condensed::interior::cell::Cells = $cells;
        for $cell in &mut cells.normal {
            $what;
        }
        for $cell in &mut cells.friction {
            $what;
        }
        for $cell in &mut cells.bond {
            $what;
        }
        for $cell in &mut cells.rolling {
            $what;
        }
        for $cell in &mut cells.wheel {
            $what;
        }
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
        match local.kind {
            Kind::Normal => self.normal.push(Cell::new(number, local, u, settings)),
            Kind::Friction => self.friction.push(Cell::new(number, local, u, settings)),
            Kind::Bond => self.bond.push(Cell::new(number, local, u, settings)),
            Kind::Rolling => self.rolling.push(Cell::new(number, local, u, settings)),
            Kind::Wheel => self.wheel.push(Cell::new(number, local, u, settings)),
        }
    }
}

/// Maxima over interactions: residuals of kinematics and limits, force, product; and the sum of all
/// products.
#[derive(Default)]
pub struct Sizes {
    pub kinematic: f64,
    pub primal: f64,
    pub force: f64,
    pub products: f64,
    pub product: f64,
}

impl Sizes {
    /// The sizes of two sets of interactions together.
    pub fn and(self, other: Self) -> Self {
        Self {
            kinematic: self.kinematic.max(other.kinematic),
            primal: self.primal.max(other.primal),
            force: self.force.max(other.force),
            products: self.products + other.products,
            product: self.product.max(other.product),
        }
    }
}

/// The length of a step to the boundary, and the products along it.
pub struct Ahead {
    /// Maximum length, at most 1, that leaves all slacks and multipliers positive.
    pub length: f64,
    /// Sum of products, and its derivatives by the length: first, and half the second.
    products: [f64; 3],
}

impl Default for Ahead {
    fn default() -> Self {
        Self { length: 1.0, products: [0.0; 3] }
    }
}

impl Ahead {
    /// The step of two sets of interactions together.
    pub fn and(self, other: Self) -> Self {
        let products = [0, 1, 2].map(|k| self.products[k] + other.products[k]);
        Self { length: self.length.min(other.length), products }
    }

    pub fn products_after(&self) -> f64 {
        let [constant, linear, quadratic] = self.products;
        (constant + self.length * (linear + self.length * quadratic)).max(0.0)
    }
}

/// The products of slacks and multipliers that a step aims at.
#[derive(Clone, Copy)]
pub enum Aim {
    /// Zero (predictor).
    Zero,
    /// This product, with the products of the predictor's steps taken into account (corrector).
    Target(f64),
}

impl<const F: usize, const Q: usize> Cell<F, Q> {
    /// Forces, slacks and multipliers near the elastic trial at the displacements.
    fn new(number: usize, local: &Local, u: &[[f64; 3]], settings: &InteriorSettings) -> Self {
        let law = Law::<F, Q>::new(local);
        let e = law.kinematics(u);
        let mut trial = [0.0; F];
        for f in (0..F).filter(|f| local.has[*f]) {
            let c = law.compliance[f];
            trial[f] = if c > 0.0 { (e[f] - law.linear[f]) / c } else { 0.0 };
        }
        let mut slacks = Slacks::default();
        // The trial clamped to the limits: normal force first, then the others at that normal force.
        let lowest = (0..Q)
            .map(|q| (law.right[q], -local.limits[q][0]))
            .filter(|(_, slope)| *slope > 0.0)
            .map(|(right, slope)| -right / slope)
            .fold(f64::NEG_INFINITY, f64::max);
        let mut s = [0.0; F];
        s[0] = trial[0].max(lowest);
        for k in 0..Law::<F, Q>::PAIRS {
            let strength = (law.right[2 * k] + law.slopes[k] * s[0]).max(0.0);
            let f = Law::<F, Q>::force(k);
            s[f] = trial[f].clamp(-strength, strength);
        }
        // Inside of a limit the distance to it is the slack; outside, the excess is the multiplier.
        // A contact that is far softer than the others must not start with far larger products.
        let is_rigid = law.compliance[0] == 0.0;
        let compliance =
            if is_rigid { 1.0 } else { law.compliance[0].min(settings.max_start_compliance) };
        // The multipliers of a rigid open contact add up to its gap: the stationarity of p. Near
        // rest gaps are thousands of displacements, and smaller multipliers would shorten the steps
        // of all other interactions. An interaction with strength does not open by itself.
        let has_strength = law.right.iter().any(|right| *right > 0.0);
        let gap = if has_strength { 0.0 } else { (law.linear[0] - e[0]).max(0.0) };
        let multiplier = gap / (0..Q).map(|q| -local.limits[q][0]).sum::<f64>();
        let beyond: [f64; F] = std::array::from_fn(|f| trial[f] - s[f]);
        let start = settings.start;
        for q in 0..Q {
            let slack = law.right[q] - law.limit(q, &s);
            let excess = if is_rigid { multiplier } else { law.limit(q, &beyond) };
            let x = slack.max(0.0) - excess.max(0.0);
            let root = x.hypot(2.0 * start);
            slacks.w[q] = 0.5 * if x > 0.0 { x + root } else { 4.0 * start * start / (root - x) };
            slacks.lambda[q] = start * start / slacks.w[q] * compliance;
        }
        Self {
            number,
            law,
            s,
            ds: [0.0; F],
            stationarity: [0.0; F],
            slacks,
            system: LocalSystem::default(),
        }
    }

    /// Takes forces near the solution, with the multipliers of their stationarity. Slacks and
    /// multipliers are then shifted to equal products: `w - lambda` stays, `w lambda` is the
    /// product.
    pub fn warm(&mut self, u: &[[f64; 3]], warm: Warm) {
        let law = &self.law;
        self.s = first(&warm.forces[self.number]);
        let e = law.kinematics(u);
        let left: [f64; F] =
            std::array::from_fn(|f| law.linear[f] + law.compliance[f] * self.s[f] - e[f]);
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
        // The gap less the dilation of the slips goes to the limit of tension, or in equal parts to
        // the other limits.
        if Law::<F, Q>::HAS_TENSION {
            multipliers[Q - 1] = gap;
        } else {
            for multiplier in &mut multipliers {
                *multiplier += gap / slopes;
            }
        }
        for q in 0..Q {
            let left = law.right[q] - law.limit(q, &self.s);
            let w = slack(left - multipliers[q], warm.product);
            self.slacks.w[q] = w;
            self.slacks.lambda[q] = warm.product / w;
        }
    }

    /// Its normal force.
    pub fn normal_force(&self) -> f64 {
        self.s[0]
    }

    /// Makes `length` times the step, evaluates the residuals, and adds the forces to the balance.
    pub fn evaluate(&mut self, length: f64, u: &[[f64; 3]], balance: &mut Rows, size: &mut Sizes) {
        for f in 0..F {
            self.s[f] += length * self.ds[f];
        }
        let slacks = &mut self.slacks;
        for q in 0..Q {
            slacks.w[q] += length * slacks.dw[q];
            slacks.lambda[q] += length * slacks.dlambda[q];
        }
        let law = &self.law;
        law.add_forces(&self.s, 1.0, balance);
        let e = law.kinematics(u);
        let mut r = [0.0; F];
        for f in 0..F {
            r[f] = law.linear[f] + law.compliance[f] * self.s[f] - e[f];
        }
        for q in 0..Q {
            let (w, lambda) = (slacks.w[q], slacks.lambda[q]);
            let defect = w - law.right[q] + law.limit(q, &self.s);
            slacks.defect[q] = defect;
            size.primal = size.primal.max(defect.abs());
            size.products += w * lambda;
            size.product = size.product.max(w * lambda);
        }
        for k in 0..Law::<F, Q>::PAIRS {
            let (plus, minus) = (slacks.lambda[2 * k], slacks.lambda[2 * k + 1]);
            r[0] -= law.slopes[k] * (plus + minus);
            r[Law::<F, Q>::force(k)] += plus - minus;
        }
        if Law::<F, Q>::HAS_TENSION {
            r[0] -= slacks.lambda[Q - 1];
        }
        for f in 0..F {
            size.kinematic = size.kinematic.max(r[f].abs());
        }
        self.stationarity = r;
        size.force = size.force.max(self.s[0].abs());
    }

    /// Copies forces and multipliers to their places in the program.
    pub fn store(&self, forces: &mut [[f64; 3]], multipliers: &mut [[f64; ROWS]]) {
        forces[self.number][..F].copy_from_slice(&self.s);
        multipliers[self.number][..Q].copy_from_slice(&self.slacks.lambda);
    }

    /// Sets up the system, adds its stiffness to the matrix, and aims the predictor.
    pub fn condense(&mut self, matrix: &mut Assembly, right: &mut Rows) {
        self.system.set(&self.law, &self.slacks);
        matrix.add(self.number, &self.law.rows, &self.system.stiffness);
        self.aim(Aim::Zero, right);
    }

    /// Sets the aim, and adds its part to the right side of the condensed system.
    #[inline]
    pub fn aim(&mut self, aim: Aim, right: &mut Rows) {
        let slacks = &mut self.slacks;
        for q in 0..Q {
            slacks.product[q] = slacks.w[q] * slacks.lambda[q]
                + match aim {
                    Aim::Zero => 0.0,
                    Aim::Target(target) => slacks.dw[q] * slacks.dlambda[q] - target,
                };
        }
        let e = self.stationarity.map(|r| -r);
        self.law.add_forces(&self.system.forces(&self.law, &e, slacks), -1.0, right);
    }

    /// Steps of forces, slacks and multipliers that belong to steps of the displacements.
    pub fn step(&mut self, du: &[[f64; 3]], ahead: &mut Ahead) {
        let mut e = self.law.kinematics(du);
        for (e, r) in e.iter_mut().zip(&self.stationarity) {
            *e -= r;
        }
        let slacks = &mut self.slacks;
        self.ds = self.system.solve(&self.law, &e, slacks);
        for q in 0..Q {
            let (w, lambda) = (slacks.w[q], slacks.lambda[q]);
            let (dw, dlambda) = (slacks.dw[q], slacks.dlambda[q]);
            if w + ahead.length * dw < 0.0 {
                ahead.length = -w / dw;
            }
            if lambda + ahead.length * dlambda < 0.0 {
                ahead.length = -lambda / dlambda;
            }
            ahead.products[0] += w * lambda;
            ahead.products[1] += w * dlambda + lambda * dw;
            ahead.products[2] += dw * dlambda;
        }
    }

    /// Subtracts its part of the condensed operator, applied to `du`, from the defect.
    pub fn take_away(&self, du: &[[f64; 3]], defect: &mut Rows) {
        let e = self.law.kinematics(du);
        let mut s = [0.0; F];
        for f in 0..F {
            for g in 0..F {
                s[f] += self.system.stiffness[f][g] * e[g];
            }
        }
        self.law.add_forces(&s, -1.0, defect);
    }
}
