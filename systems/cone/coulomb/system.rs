//! The complementarity system of all interactions and bodies, its residual, and linear solves with
//! its derivative.

use crate::program::{ConeProgram, Interaction, SlidingLaw};

use super::super::condensed::interior::max_magnitude;
use super::super::condensed::matrix::UnsymmetricMatrix;
use super::super::condensed::scaled::{Local, Scaled, add_times};
use super::cell::{Cell, Entry, times};
use super::settings::CoulombSettings;

/// A point, a step, or a residual: displacements (in a residual the balance) by place, and the
/// interactions.
#[derive(Clone, Debug, Default)]
pub struct Vector {
    pub u: Vec<[f64; 3]>,
    pub cells: Vec<Entry>,
}

impl Vector {
    /// A vector of zeros with the sizes of another.
    pub fn zeros(like: &Self) -> Self {
        Self { u: vec![[0.0; 3]; like.u.len()], cells: vec![Entry::default(); like.cells.len()] }
    }

    /// Adds `factor` times another vector.
    pub fn add(&mut self, factor: f64, other: &Self) {
        add_times(self.u.as_flattened_mut(), factor, other.u.as_flattened());
        for (x, y) in self.cells.iter_mut().zip(&other.cells) {
            add_times(&mut x.s, factor, &y.s);
            add_times(&mut x.w, factor, &y.w);
            add_times(&mut x.lambda, factor, &y.lambda);
        }
    }
}

/// The system with the matrix of its last linearisation.
pub struct System<'a> {
    pub program: Scaled,
    pub cells: Vec<Cell>,
    /// Units of the displacements and of the forces.
    pub units: ([f64; 3], [f64; 3]),
    pub matrix: &'a mut UnsymmetricMatrix,
    /// Number of limits.
    pub limits: f64,
    /// Factorisations so far.
    pub factorisations: u32,
    /// Regularisation of the matrix, as a part of the usual compliances.
    pub regularisation: f64,
    refined: f64,
}

impl<'a> System<'a> {
    /// The system of a program in units of its scales.
    pub fn new(
        program: &ConeProgram,
        matrix: &'a mut UnsymmetricMatrix,
        settings: &CoulombSettings,
    ) -> Self {
        let scaled = matrix.pose(program);
        let typical = typical_compliance(&scaled.locals);
        let damped = program.is_damped();
        let usual = |local: &Local| match local.compliance[0] {
            _ if damped => of_weights(local, &scaled),
            own if own > 0.0 => [own; 3],
            _ => [typical; 3],
        };
        let cell = |(local, c): (&Local, &Interaction)| {
            Cell::new(local.clone(), SlidingLaw::Coulomb.dilation(c), usual(local))
        };
        let cells: Vec<Cell> = scaled.locals.iter().zip(&program.interactions).map(cell).collect();
        Self {
            limits: cells.iter().flat_map(Cell::each_limit).count().max(1) as f64,
            program: scaled,
            cells,
            units: program.scales.units(),
            matrix,
            factorisations: 0,
            regularisation: 0.0,
            refined: settings.refined,
        }
    }

    /// Slack and multiplier of every limit at a point, each with its change in a step.
    pub fn along(&self, z: &Vector, step: &Vector) -> impl Iterator<Item = [(f64, f64); 2]> {
        let entries = z.cells.iter().zip(&step.cells);
        self.cells.iter().zip(entries).flat_map(|(cell, (x, d))| {
            cell.each_limit().map(move |q| [(x.w[q], d.w[q]), (x.lambda[q], d.lambda[q])])
        })
    }

    /// The point near forces and displacements with all products `product`.
    pub fn near(&self, u: &[[f64; 3]], s: &[[f64; 3]], product: f64) -> Vector {
        let cells = self.cells.iter().zip(s);
        let mut u = u[..self.program.free.len()].to_vec();
        self.program.images.extend(&mut u);
        let cells = cells.map(|(cell, s)| cell.near(*s, &cell.arms().kinematics(&u), product));
        Vector { cells: cells.collect(), u }
    }

    /// The residual: balance, stationarity of the forces, limits and products.
    pub fn residual(&self, z: &Vector) -> Vector {
        let mut out = Vector::zeros(z);
        self.program.balance_of_bodies(&z.u, &mut out.u);
        for ((cell, x), r) in self.cells.iter().zip(&z.cells).zip(&mut out.cells) {
            cell.arms().add_forces(&x.s, 1.0, &mut out.u);
            *r = cell.residual(x, &cell.arms().kinematics(&z.u));
        }
        self.program.images.fold(&mut out.u);
        out
    }

    /// Factorises the derivative at a point; whether it has an inverse.
    pub fn factorise(&mut self, z: &Vector) -> bool {
        self.matrix.clear();
        let mut values = self.matrix.assembly();
        values.add_weights(&self.program, 0.0);
        for (k, (cell, x)) in self.cells.iter_mut().zip(&z.cells).enumerate() {
            cell.linearise(x, self.regularisation);
            values.add(k, &cell.arms().rows, &cell.stiffness);
        }
        self.factorisations += 1;
        self.matrix.factorise()
    }

    /// The step `dz` with `J dz = -r`, for the derivative J that was factorised at `z`.
    pub fn solve(&mut self, z: &Vector, r: &Vector) -> Vector {
        let mut right: Vec<[f64; 3]> = r.u.iter().map(|b| b.map(|x| -x)).collect();
        for (cell, (x, r)) in self.cells.iter().zip(z.cells.iter().zip(&r.cells)) {
            cell.arms().add_forces(&cell.forces_at_rest(x, r), -1.0, &mut right);
        }
        self.program.images.fold(&mut right);
        self.program.clear_fixed(&mut right);
        let du = self.solve_bodies(right);
        let cells = self.cells.iter().zip(z.cells.iter().zip(&r.cells));
        let cells = cells.map(|(cell, (x, r))| cell.step(x, r, &cell.arms().kinematics(&du)));
        Vector { cells: cells.collect(), u: du }
    }

    /// Solves the condensed system, with refinement.
    fn solve_bodies(&mut self, right: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
        let mut x = right.clone();
        self.matrix.solve(&mut x);
        let scale = max_magnitude(&right);
        let Self { program, cells, matrix, refined, .. } = self;
        let set = |x: &[[f64; 3]], defect: &mut [[f64; 3]]| {
            defect.copy_from_slice(&right);
            for ((d, weight), x) in defect.iter_mut().zip(&program.weight).zip(x) {
                for k in 0..3 {
                    d[k] -= weight[k] * x[k];
                }
            }
            for cell in cells.iter() {
                let s = times(&cell.stiffness, &cell.arms().kinematics(x));
                cell.arms().add_forces(&s, -1.0, defect);
            }
        };
        matrix.refine(*refined * scale, &mut x, &mut right.clone(), set);
        x
    }
}

/// Median of the normal compliances above 0; 1 if all are rigid.
fn typical_compliance(locals: &[Local]) -> f64 {
    let mut all: Vec<f64> = locals.iter().map(|l| l.compliance[0]).filter(|c| *c > 0.0).collect();
    all.sort_unstable_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(1.0)
}

/// Compliance that the weights of its bodies give an interaction: the diagonal of `G' M^-1 G`.
fn of_weights(local: &Local, program: &Scaled) -> [f64; 3] {
    let mut out = [0.0; 3];
    for (rows, body) in local.arms.rows.iter().zip(local.arms.bodies) {
        let body = program.images.body(body as usize);
        for (row, weight) in rows.iter().zip(program.weight[body]) {
            if weight > 0.0 {
                for f in 0..3 {
                    out[f] += row[f] * row[f] / weight;
                }
            }
        }
    }
    out.map(|x| x.max(1e-12))
}
