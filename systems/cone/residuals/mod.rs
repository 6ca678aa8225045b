//! KKT residuals of a solution, from forces and displacements alone.
//!
//! The multipliers of the limits follow from the displacements: with `e = (d_n, d_t, d_r)` the
//! kinematics of an interaction and a its [dilation](SlidingLaw::dilation), stationarity (equation
//! 34 of the paper) gives
//!
//! ```text
//! s_t = d_t - C_T (q - q_0)                       lambda_q = |s_t|, at the limit of its sign
//! s_r = d_r - C_R (tau - tau_0)                   lambda_r = |s_r|, at the limit of its sign
//! lambda_T = g + C_N p - d_n - a (mu lambda_q + mu_r r lambda_r)         of p >= -f_t
//! ```
//!
//! Two errors are left: a negative `lambda_T` (kinematics), and a multiplier of a limit with slack
//! (complementarity; kinematics if the slack exceeds the maximum force). If the apex of the shear
//! limit is above the tension limit (`c A < mu f_t`), both shear rows are active there and share
//! `lambda_T`.

mod units;

use self::units::larger;
pub(crate) use self::units::{Units, applied_force, max_or_nan, min_force};
pub use self::units::{displacement_scale, force_scale};
use crate::program::{
    ConeProgram, ConeSolution, Interaction, Kinematics, Residuals, SlidingLaw, SolveStatus,
};

/// Multipliers of the limits of one interaction, m, m, rad: tension, slip (signed), rotation
/// (signed).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multipliers {
    /// `lambda_T` of `p >= -f_t`.
    pub tension: f64,
    /// Inelastic slip `s_t`.
    pub slip: f64,
    /// Inelastic rotation `s_r`.
    pub rotation: f64,
}

/// The multipliers under a law that follow from the kinematics `e` and the forces `f` of an
/// interaction.
pub fn multipliers(law: SlidingLaw, c: &Interaction, e: &Kinematics, f: &[f64; 3]) -> Multipliers {
    let l = &c.limits;
    let slip = if l.has_shear() {
        e[1] - c.tangential_compliance * (f[1] - c.previous_shear)
    } else {
        0.0
    };
    let rotation = if l.has_rolling() {
        e[2] - c.rolling_compliance * (f[2] - c.previous_moment)
    } else {
        0.0
    };
    let tension = c.offset + c.normal_compliance * f[0]
        - e[0]
        - law.dilation(c) * (l.friction * slip.abs() + l.rolling * rotation.abs());
    Multipliers { tension, slip, rotation }
}

/// The four residuals of a solution. The force of a regularisation counts as an error of the
/// balance.
pub fn residuals(program: &ConeProgram, solution: &ConeSolution) -> Residuals {
    evaluate(program, solution, 0.0)
}

/// The residuals of the program that the solver was given: the force of a regularisation is part of
/// the balance.
pub fn regularised_residuals(program: &ConeProgram, solution: &ConeSolution) -> Residuals {
    evaluate(program, solution, 1.0)
}

/// Residual of the balance up to which momentum counts as conserved to round-off, where displacements
/// cannot follow from the forces.
pub const MAX_BALANCE: f64 = 1e-11;

/// Decides which displacements the solution of a dynamic program has, and returns its residuals.
///
/// Displacements that [follow from the forces](ConeProgram::displacements_from_forces) keep the
/// momentum to round-off, but the error of a force moves a body by its ratio to `m/(theta dt^2)`.
/// Near rest, where displacements vanish and forces do not, this exceeds any tolerance: a spring
/// with `k dt^2/m = 1e7` turns it into 1e7 times as much force. Inertia is negligible there. The
/// displacements of the solver are kept if they solve the program and the residual of its balance
/// is at most [`MAX_BALANCE`]. Rigid contacts have the unit of free motion instead.
pub fn choose_displacements(
    program: &ConeProgram,
    solution: &mut ConeSolution,
    tolerance: f64,
) -> Residuals {
    let own = solution.displacements.clone();
    program.displacements_from_forces(solution);
    let following = regularised_residuals(program, solution);
    let has_springs = program.interactions.iter().any(|c| c.normal_compliance > 0.0);
    if following.worst() <= tolerance || !has_springs || !program.is_dynamic() {
        return following;
    }
    let other = std::mem::replace(&mut solution.displacements, own);
    let balanced = regularised_residuals(program, solution);
    if balanced.worst() <= tolerance && balanced.balance <= MAX_BALANCE {
        return balanced;
    }
    solution.displacements = other;
    following
}

/// Gives a solution the displacements that are [chosen](choose_displacements), its residuals, and its
/// status: solved if they are within the tolerance, else stalled.
pub(crate) fn settle(program: &ConeProgram, solution: &mut ConeSolution, tolerance: f64) {
    solution.residuals = choose_displacements(program, solution, tolerance);
    let is_solved = solution.residuals.worst() <= tolerance;
    solution.status = if is_solved { SolveStatus::Solved } else { SolveStatus::Stalled };
}

fn evaluate(program: &ConeProgram, solution: &ConeSolution, regularisation: f64) -> Residuals {
    let all = each(program, solution, regularisation);
    all.fold(Residuals::default(), |worst, (_, own)| larger(worst, own))
}

/// The residuals of the balance of every body, which comes twice, and of every interaction with its
/// two bodies.
fn each(
    program: &ConeProgram,
    solution: &ConeSolution,
    regularisation: f64,
) -> impl Iterator<Item = ([usize; 2], Residuals)> {
    let ConeSolution { law, forces, displacements, .. } = solution;
    let units = Units::of(program, forces, displacements);
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(forces, &mut rows);
    let bodies = program.bodies.iter().zip(rows).zip(displacements).enumerate();
    let of_bodies = bodies.map(move |(i, ((body, row), u))| {
        ([i, i], units.of_balance(body, &row, u, regularisation))
    });
    let interactions = program.interactions.iter().zip(forces);
    of_bodies.chain(interactions.map(move |(c, f)| {
        let e = program.kinematics(c, displacements);
        ([c.a as usize, c.b as usize], units.of_interaction(*law, c, &e, f))
    }))
}

/// The bodies at the maximum residual of a solution: one body twice if it is a residual of the
/// balance, else the two bodies of an interaction. `None` for a solution without forces and
/// displacements.
pub fn worst_bodies(program: &ConeProgram, solution: &ConeSolution) -> Option<[usize; 2]> {
    let ConeSolution { forces, displacements, .. } = solution;
    if forces.len() != program.interactions.len() || displacements.len() != program.bodies.len() {
        return None;
    }
    let all = each(program, solution, 0.0).map(|(bodies, own)| (bodies, own.worst()));
    all.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(bodies, _)| bodies)
}

/// Maximum of the natural map of the contacts without strength, without dimension. With P, Q, T the
/// forces and s_n, s_t, s_r the gap, slip and rotation of the law, each over its unit, the map is
///
/// ```text
/// |min(P, s_n)|,   |Q - clamp(Q + s_t, -mu P, mu P)|,   |T - clamp(T + s_r, -mu_r r P, mu_r r P)|
/// ```
///
/// Unlike a product of force and gap it is not small where both are small and neither vanishes.
pub fn natural_map(program: &ConeProgram, solution: &ConeSolution) -> f64 {
    let ConeSolution { law, forces, displacements, .. } = solution;
    let units = Units::of(program, forces, displacements);
    let Units { force, length, .. } = units;
    let interactions = program.interactions.iter().zip(forces);
    let of = |(c, f): (&Interaction, &[f64; 3])| {
        let m = multipliers(*law, c, &program.kinematics(c, displacements), f);
        let displacement = units.displacement_of(c);
        let (p, q, t) = (f[0] / force, f[1] / force, f[2] / (force * length));
        let projected = |x: f64, step: f64, slope: f64| {
            let limit = slope * p.max(0.0);
            (x - (x + step).clamp(-limit, limit)).abs()
        };
        let l = &c.limits;
        let mut out = p.min(m.tension / displacement).abs();
        if l.has_shear() {
            out = out.max(projected(q, m.slip / displacement, l.friction));
        }
        if l.has_rolling() {
            out = out.max(projected(t, m.rotation * length / displacement, l.rolling / length));
        }
        out
    };
    interactions.filter(|(c, _)| !c.limits.has_strength()).map(of).fold(0.0, max_or_nan)
}

/// Normal force, over the maximum force, below which an interaction carries none.
const MIN_RELATIVE_FORCE: f64 = 1e-9;

/// Tells which interactions carry a normal force. An interior point leaves a small force on open
/// contacts: the complementarity product over the gap.
pub struct Carrying<'a> {
    program: &'a ConeProgram,
    solution: &'a ConeSolution,
    /// Maximum normal force that counts as zero, N.
    threshold: f64,
    /// Maximum force, N, and displacement, m, if gaps count too.
    units: Option<[f64; 2]>,
}

impl<'a> Carrying<'a> {
    /// The interactions of a solution.
    ///
    /// In statics an interaction carries a force above 1e-9 of the maximum force. In dynamics a
    /// solution may have products up to the tolerance, and the force must also exceed the gap, each
    /// over its maximum.
    pub fn new(program: &'a ConeProgram, solution: &'a ConeSolution) -> Self {
        let force = force_scale(program, &solution.forces);
        let dynamic = program.is_dynamic();
        let products = if dynamic { solution.tolerance } else { 0.0 };
        let threshold = products.max(MIN_RELATIVE_FORCE) * force;
        let units = (dynamic && solution.displacements.len() == program.bodies.len())
            .then(|| [force, displacement_scale(program, &solution.displacements)]);
        Self { program, solution, threshold, units }
    }

    /// Whether interaction `k` carries a normal force.
    pub fn is_carrying(&self, k: usize) -> bool {
        let (c, f) = (&self.program.interactions[k], &self.solution.forces[k]);
        let p = f[0].abs();
        p > self.threshold
            && self.units.is_none_or(|[force, displacement]| {
                let e = self.program.kinematics(c, &self.solution.displacements);
                p * displacement >= multipliers(self.solution.law, c, &e, f).tension * force
            })
    }
}
