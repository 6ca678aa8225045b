//! Primal-dual interior-point method on the condensed system (predictor and corrector after
//! Mehrotra).
//!
//! An interaction's forces and multipliers are eliminated through its own small system
//! ([`local_system`](super::local_system)): `ds = T (G' du) + ds_0`, which leaves
//! `(M + G T G') du = r` for the bodies.

use super::local_system::{LocalSystem, Right, Slacks};
use super::matrix::BodyMatrix;
use super::scaled::{Local, ROWS, Scaled, add_forces, by_kind, kinematics};

/// An interior point.
pub struct Interior {
    /// Displacements by body.
    pub u: Vec<[f64; 3]>,
    /// Forces by interaction.
    pub s: Vec<[f64; 3]>,
    /// Multipliers of the limits.
    pub lambda: Vec<[f64; ROWS]>,
    /// Factorisations.
    pub iterations: u32,
    /// Residual of the point, as the method measures it.
    pub merit: f64,
}

const MAX_ITERATIONS: u32 = 80;
/// Where the residual falls to no less than this fraction in so many iterations it will not get there.
const PATIENCE: usize = 20;
const LITTLE: f64 = 0.1;
/// Complementarity product of the starting point.
const START: f64 = 0.3;
/// Greatest compliance that the starting point counts with, in units of displacement over force.
const SOFT: f64 = 10.0;
/// Weight of the proximal term by the mean product, and what is left of it in the end.
const PROXIMAL: f64 = 1e-3;
const LEAST_PROXIMAL: f64 = 1e-10;
/// The products aimed at are what the predictor leaves of them to the third (Mehrotra). Squared, products
/// fall more slowly and the other residuals faster: fewer iterations where the goal is above this.
const LOOSE: f64 = 1e-8;
/// Steps of refinement at most, and the relative defect at which there is no need of one.
const MAX_REFINEMENTS: usize = 3;
const REFINED: f64 = 1e-4;
/// Weight of the greatest complementarity product beside the other residuals.
const PRODUCT: f64 = 0.02;
/// What is enough where there is little progress, over the residual at which it is done.
const ENOUGH: f64 = 10.0;

/// All that the method knows of one interaction.
#[derive(Clone, Default)]
struct Cell {
    /// Forces.
    s: [f64; 3],
    /// Steps of the forces.
    ds: [f64; 3],
    /// Residuals of stationarity.
    stationarity: [f64; 3],
    slacks: Slacks,
    system: LocalSystem,
    right: Right,
}

/// Forces, slacks and multipliers near the elastic trial at the starting displacements.
fn start_local(local: &Local, u: &[[f64; 3]]) -> Cell {
    let e = Scaled::kinematics(local, u);
    let mut trial = [0.0; 3];
    for f in (0..2).filter(|f| local.has[*f]) {
        let c = local.compliance[f];
        trial[f] = if c > 0.0 { (e[f] - local.linear[f]) / c } else { 0.0 };
    }
    let mut s = Slacks { w: [1.0; ROWS], ..Slacks::default() };
    // The trial clamped to the limits: normal force first, then shear at that normal force.
    let lowest = (0..local.count)
        .filter(|q| local.limits[*q][0] < 0.0)
        .map(|q| local.right[q] / local.limits[q][0])
        .fold(f64::NEG_INFINITY, f64::max);
    let mut force = [trial[0].max(lowest), 0.0, 0.0];
    if local.has[1] {
        let strength = local.right[0] - local.limits[0][0] * force[0];
        force[1] = trial[1].clamp(-strength.max(0.0), strength.max(0.0));
    }
    // Slack where it is inside; where it was clamped, the excess is the multiplier.
    // What is far softer than the rest must not start with products far greater than theirs.
    let compliance = if local.compliance[0] > 0.0 { local.compliance[0].min(SOFT) } else { 1.0 };
    for q in 0..local.count {
        let a = &local.limits[q];
        let slack = local.right[q] - a[0] * force[0] - a[1] * force[1];
        let excess = a[0] * (trial[0] - force[0]) + a[1] * (trial[1] - force[1]);
        let x = slack.max(0.0) - excess.max(0.0);
        let root = x.hypot(2.0 * START);
        s.w[q] = 0.5 * if x > 0.0 { x + root } else { 4.0 * START * START / (root - x) };
        s.lambda[q] = START * START / s.w[q] * compliance;
    }
    Cell { s: force, slacks: s, ..Cell::default() }
}

/// Runs the method from the displacements `start` until the residual is at most `goal`, or no longer
/// falls: the best point on the way. `None` if there is none.
#[must_use]
pub fn solve(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    goal: f64,
) -> Option<Interior> {
    let n = program.free.len();
    let mut u: Vec<[f64; 3]> = (0..n)
        .map(|i| {
            [0, 1, 2].map(|k| if program.free[i][k] { start[i][k] } else { program.known[i][k] })
        })
        .collect();
    let mut cells: Vec<Cell> = program.locals.iter().map(|l| start_local(l, &u)).collect();
    let limits: usize = program.locals.iter().map(|l| l.count).sum();
    let limits = limits.max(1) as f64;
    let mut best: Option<Interior> = None;
    let mut since_best = 0;
    let mut iterations = 0;
    let mut last_merit = f64::INFINITY;
    let mut merits = Vec::new();
    // Of the step that the interactions have still to make: every pass over them costs.
    let mut length = 0.0;
    let mut balance = vec![[0.0; 3]; n];
    let mut right = vec![[0.0; 3]; n];
    let mut du = vec![[0.0; 3]; n];
    let mut defect = vec![[0.0; 3]; n];
    let mut weight = vec![[0.0; 3]; n];
    loop {
        // Residuals.
        program.balance_of_bodies(&u, &mut balance);
        let mut size = Sizes::default();
        for (cell, local) in cells.iter_mut().zip(&program.locals) {
            by_kind!(local.kind, evaluate(cell, local, length, &u, &mut balance, &mut size));
        }
        let mu = size.products / limits;
        let unbalance = greatest(&balance);
        let force = size.force.max(1e-3);
        let sum = unbalance + size.kinematic + size.primal + mu;
        // Products count by the greatest: started near a solution most of them are nothing.
        let merit = (unbalance.max(size.primal) / force)
            .max(size.kinematic)
            .max(PRODUCT * size.product / force);
        if !sum.is_finite() {
            break;
        }
        if best.as_ref().is_none_or(|b| merit < b.merit) {
            let s = cells.iter().map(|c| c.s).collect();
            let lambda = cells.iter().map(|c| c.slacks.lambda).collect();
            best = Some(Interior { u: u.clone(), s, lambda, iterations, merit });
            since_best = 0;
        } else {
            since_best += 1;
        }
        merits.push(best.as_ref().map_or(merit, |b| b.merit));
        let earlier = merits.len().checked_sub(PATIENCE + 1).map_or(f64::INFINITY, |k| merits[k]);
        let slow = merit > 0.3 * last_merit;
        last_merit = merit;
        if merit <= goal
            || (merit <= ENOUGH * goal && slow)
            || iterations >= MAX_ITERATIONS
            || (since_best > 8 && merit > 1e3 * best.as_ref().map_or(0.0, |b| b.merit))
            || since_best > 15
            || merits[merits.len() - 1] > LITTLE * earlier
        {
            break;
        }
        iterations += 1;

        // The condensed matrix.
        matrix.clear();
        // A vanishing proximal weight keeps what nothing holds from going to infinity.
        let proximal = LEAST_PROXIMAL + PROXIMAL * mu.min(1.0);
        for i in 0..n {
            for k in 0..3 {
                weight[i][k] = program.weight[i][k] + proximal;
                let diagonal = if program.free[i][k] { weight[i][k] } else { 1.0 };
                matrix.add_diagonal(i, k, diagonal);
            }
        }
        // The predictor takes all products away; it only aims the corrector.
        set_negative(&mut right, &balance);
        for (k, (cell, local)) in cells.iter_mut().zip(&program.locals).enumerate() {
            by_kind!(local.kind, condense(cell, local, k, matrix, &mut right));
        }
        if !factorise(matrix) {
            break;
        }
        du.clone_from(&right);
        matrix.solve(&mut du);
        let ahead = steps(program, &mut cells, &du);
        let after = ahead.products_after() / limits;
        let ratio = if mu > 0.0 { after / mu } else { 0.0 };
        let exponent = if goal > LOOSE { 2 } else { 3 };
        let target = ratio.powi(exponent).min(1.0) * mu;

        set_negative(&mut right, &balance);
        for (cell, local) in cells.iter_mut().zip(&program.locals) {
            by_kind!(local.kind, aim(cell, local, true, target, &mut right));
        }
        du.clone_from(&right);
        matrix.solve(&mut du);
        refine(program, matrix, &cells, &weight, &right, &mut du, &mut defect);
        let step = steps(program, &mut cells, &du).length;
        length = if step < 1.0 { step * (1.0 - mu.min(0.01)).clamp(0.99, 0.9995) } else { 1.0 };
        for (u, du) in u.iter_mut().zip(&du) {
            for k in 0..3 {
                u[k] += length * du[k];
            }
        }
    }
    let mut point = best?;
    point.iterations = iterations;
    Some(point)
}

/// Greatest residuals, greatest force, and products.
#[derive(Default)]
struct Sizes {
    kinematic: f64,
    primal: f64,
    force: f64,
    products: f64,
    product: f64,
}

fn greatest(rows: &[[f64; 3]]) -> f64 {
    rows.iter().flatten().map(|r| r.abs()).fold(0.0, f64::max)
}

fn set_negative(rows: &mut [[f64; 3]], of: &[[f64; 3]]) {
    for (row, of) in rows.iter_mut().zip(of) {
        *row = of.map(|r| -r);
    }
}

/// Makes the step of an interaction, up to `length`, and evaluates its residuals; its forces go to the
/// balance.
fn evaluate<const F: usize, const Q: usize>(
    cell: &mut Cell,
    local: &Local,
    length: f64,
    u: &[[f64; 3]],
    balance: &mut [[f64; 3]],
    size: &mut Sizes,
) {
    for f in 0..F {
        cell.s[f] += length * cell.ds[f];
    }
    let slacks = &mut cell.slacks;
    for q in 0..Q {
        slacks.w[q] += length * slacks.dw[q];
        slacks.lambda[q] += length * slacks.dlambda[q];
    }
    add_forces::<F>(local, &cell.s, 1.0, balance);
    let e = kinematics::<F>(local, u);
    let mut r = [0.0; 3];
    for f in 0..F {
        r[f] = local.linear[f] + local.compliance[f] * cell.s[f] - e[f];
    }
    for q in 0..Q {
        let a = &local.limits[q];
        let (w, lambda) = (slacks.w[q], slacks.lambda[q]);
        let mut defect = w - local.right[q];
        for f in 0..F {
            r[f] += a[f] * lambda;
            defect += a[f] * cell.s[f];
        }
        slacks.defect[q] = defect;
        size.primal = size.primal.max(defect.abs());
        size.products += w * lambda;
        size.product = size.product.max(w * lambda);
    }
    for f in 0..F {
        size.kinematic = size.kinematic.max(r[f].abs());
    }
    cell.stationarity = r;
    size.force = size.force.max(cell.s[0].abs());
}

/// Sets up the system of an interaction, adds what is left of it to the matrix, and aims the predictor.
fn condense<const F: usize, const Q: usize>(
    cell: &mut Cell,
    local: &Local,
    number: usize,
    matrix: &mut BodyMatrix,
    right: &mut [[f64; 3]],
) {
    cell.system.set::<F, Q>(local, &cell.slacks);
    matrix.add::<F>(number, local.bodies, &local.rows, &cell.system.stiffness);
    aim::<F, Q>(cell, local, false, 0.0, right);
}

/// Adds what an interaction has in the right side of the condensed system: for the predictor, or for
/// the corrector, which leaves products of `target` and takes the second order of the predictor's steps
/// into account.
#[inline]
fn aim<const F: usize, const Q: usize>(
    cell: &mut Cell,
    local: &Local,
    corrector: bool,
    target: f64,
    right: &mut [[f64; 3]],
) {
    let slacks = &mut cell.slacks;
    for q in 0..Q {
        let second = if corrector { slacks.dw[q] * slacks.dlambda[q] } else { 0.0 };
        slacks.product[q] = slacks.w[q] * slacks.lambda[q] - target + second;
    }
    cell.right = cell.system.right::<F, Q>(local, &cell.stationarity, slacks);
    add_forces::<F>(local, &cell.system.forces::<F, Q>(&cell.right), -1.0, right);
}

/// How far one can go along a step, and what becomes of the products on the way.
struct Ahead {
    /// The step that leaves all slacks and multipliers positive, at most 1.
    length: f64,
    /// Sum of products, and its derivatives by the length: first, and half the second.
    products: [f64; 3],
}

impl Ahead {
    fn products_after(&self) -> f64 {
        let [constant, linear, quadratic] = self.products;
        (constant + self.length * (linear + self.length * quadratic)).max(0.0)
    }
}

/// Steps of forces, slacks and multipliers that belong to steps of the displacements.
fn steps(program: &Scaled, cells: &mut [Cell], du: &[[f64; 3]]) -> Ahead {
    let mut ahead = Ahead { length: 1.0, products: [0.0; 3] };
    for (cell, local) in cells.iter_mut().zip(&program.locals) {
        by_kind!(local.kind, steps_of_one(cell, local, du, &mut ahead));
    }
    ahead
}

fn steps_of_one<const F: usize, const Q: usize>(
    cell: &mut Cell,
    local: &Local,
    du: &[[f64; 3]],
    ahead: &mut Ahead,
) {
    let e = kinematics::<F>(local, du);
    let slacks = &mut cell.slacks;
    cell.ds = cell.system.solve::<F, Q>(local, &e, &cell.right, slacks);
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

/// Factorises, with a larger diagonal where round-off has cost positive definiteness.
pub(super) fn factorise(matrix: &mut BodyMatrix) -> bool {
    if matrix.factorise() {
        return true;
    }
    let greatest = matrix.greatest_diagonal();
    for shift in [1e-14, 1e-12, 1e-10] {
        for body in 0..matrix.bodies() {
            for k in 0..3 {
                matrix.add_diagonal(body, k, shift * greatest);
            }
        }
        if matrix.factorise() {
            return true;
        }
    }
    false
}

/// Steps of refinement on the condensed operator, with the weights of the degrees of freedom.
fn refine(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    cells: &[Cell],
    weight: &[[f64; 3]],
    right: &[[f64; 3]],
    du: &mut [[f64; 3]],
    defect: &mut [[f64; 3]],
) {
    let scale = greatest(right);
    for _ in 0..MAX_REFINEMENTS {
        for (i, defect) in defect.iter_mut().enumerate() {
            for k in 0..3 {
                defect[k] =
                    if program.free[i][k] { right[i][k] - weight[i][k] * du[i][k] } else { 0.0 };
            }
        }
        for (cell, local) in cells.iter().zip(&program.locals) {
            by_kind!(local.kind, take_away(cell, local, du, defect));
        }
        if greatest(defect) <= REFINED * scale {
            return;
        }
        matrix.solve(defect);
        for (du, d) in du.iter_mut().zip(&*defect) {
            for k in 0..3 {
                du[k] += d[k];
            }
        }
    }
}

/// Takes what an interaction adds to the condensed operator away from the defect.
fn take_away<const F: usize, const Q: usize>(
    cell: &Cell,
    local: &Local,
    du: &[[f64; 3]],
    defect: &mut [[f64; 3]],
) {
    let e = kinematics::<F>(local, du);
    let mut s = [0.0; 3];
    for f in 0..F {
        for g in 0..F {
            s[f] += cell.system.stiffness[f][g] * e[g];
        }
    }
    add_forces::<F>(local, &s, -1.0, defect);
}
