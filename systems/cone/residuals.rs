//! KKT residuals of a solution, from forces and displacements alone.
//!
//! The multipliers of the limits follow from the displacements: with `e = (d_n, d_t, d_r)` the
//! kinematics of an interaction and a its dilation, stationarity (equation 34 of the paper) gives
//!
//! ```text
//! s_t = d_t - C_T (q - q_0)                       lambda_q = |s_t|, at the limit of its sign
//! s_r = d_r                                       lambda_r = |s_r|, at the limit of its sign
//! lambda_T = g + C_N p - d_n - a (mu lambda_q + mu_r r lambda_r)         of p >= -f_t
//! ```
//!
//! Two errors are left: a negative `lambda_T` (kinematics), and a multiplier of a limit with slack
//! (complementarity; kinematics if the slack exceeds the maximum force). If the apex of the shear
//! limit is above the tension limit (`c A < mu f_t`), both shear rows are active there and share
//! `lambda_T`.

use glam::DVec2;

use crate::program::{
    ConeProgram, ConeSolution, Dof, Interaction, Kinematics, ProgramBody, Residuals,
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

/// The multipliers that follow from the kinematics `e` and the forces `f` of an interaction.
#[must_use]
pub fn multipliers(c: &Interaction, e: &Kinematics, f: &[f64; 3]) -> Multipliers {
    let l = &c.limits;
    let slip = if l.has_shear() {
        e[1] - c.tangential_compliance * (f[1] - c.previous_shear)
    } else {
        0.0
    };
    let rotation = if l.has_rolling() { e[2] } else { 0.0 };
    let tension = c.offset + c.normal_compliance * f[0]
        - e[0]
        - c.dilation * (l.friction * slip.abs() + l.rolling * rotation.abs());
    Multipliers { tension, slip, rotation }
}

/// Maximum unit of force over the maximum of expected and applied forces. Rigid bodies that are
/// locked into each other carry any force. Relative to such a force, an unbalanced load on another
/// body would not show.
/// would not show.
const MAX_FORCE: f64 = 1e5;

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
    #[must_use]
    pub fn new(program: &'a ConeProgram, solution: &'a ConeSolution) -> Self {
        let force = force_scale(program, &solution.forces);
        let dynamic = program.is_dynamic();
        let relative =
            if dynamic { program.tolerance.max(MIN_RELATIVE_FORCE) } else { MIN_RELATIVE_FORCE };
        let threshold = relative * force;
        let units = (dynamic && solution.displacements.len() == program.bodies.len())
            .then(|| [force, displacement_scale(program, &solution.displacements)]);
        Self { program, solution, threshold, units }
    }

    /// Whether interaction `k` carries a normal force.
    #[must_use]
    pub fn is_carrying(&self, k: usize) -> bool {
        let (c, f) = (&self.program.interactions[k], &self.solution.forces[k]);
        let p = f[0].abs();
        p > self.threshold
            && self.units.is_none_or(|[force, displacement]| {
                let e = self.program.kinematics(c, &self.solution.displacements);
                p * displacement >= multipliers(c, &e, f).tension * force
            })
    }
}

/// Normal force, over the maximum force, below which an interaction carries none.
const MIN_RELATIVE_FORCE: f64 = 1e-9;

/// Maximum force of the program, contact or applied, N; at least 1 % of the force scale.
///
/// Contact forces count if they act on a free degree of freedom. Between a rigid wall and a disk
/// that is held against it any force is a solution, and relative to 1e24 N no error would show.
#[must_use]
pub fn force_scale(program: &ConeProgram, forces: &[[f64; 3]]) -> f64 {
    let felt = |body: u32, direction: DVec2, normal_arm: f64| {
        let body = &program.bodies[body as usize];
        let axes = [body.axis, body.axis.perp()];
        let free = |k: usize| matches!(body.dofs[k], Dof::Free(_));
        (0..2).any(|k| free(k) && axes[k].dot(direction).abs() > 1e-9)
            || (normal_arm != 0.0 && free(2))
    };
    // An arm of the normal force goes with a body that turns, on which both forces act.
    let either = |c: &Interaction, direction| {
        felt(c.a, direction, c.normal_arm_a) || felt(c.b, direction, c.normal_arm_b)
    };
    let mut contact = 0.0_f64;
    for (c, f) in program.interactions.iter().zip(forces) {
        for (direction, f) in [(c.normal, f[0].abs()), (c.normal.perp(), f[1].abs())] {
            if f > contact && either(c, direction) {
                contact = f;
            }
        }
    }
    let applied = applied_force(program);
    // If all forces are zero (a bond has broken, a specimen is unloaded), the round-off of forces
    // that were there before must not count as an error.
    let expected = applied.max(program.scales.force);
    contact.min(MAX_FORCE * expected).max(applied).max(1e-2 * program.scales.force)
}

/// Maximum applied force, N.
pub(super) fn applied_force(program: &ConeProgram) -> f64 {
    program
        .bodies
        .iter()
        .flat_map(|b| &b.dofs[..2])
        .map(|d| if let Dof::Free(f) = d { (f.load - f.momentum).abs() } else { 0.0 })
        .fold(0.0, f64::max)
}

/// Maximum displacement, m, between 1e-6 and 1 mean radii: relative to a body that a solver throws
/// far away every error of the other bodies would look small.
#[must_use]
pub fn displacement_scale(program: &ConeProgram, displacements: &[[f64; 3]]) -> f64 {
    let length = program.scales.length;
    displacements.iter().map(|u| u[0].hypot(u[1])).fold(1e-6 * length, f64::max).min(length)
}

/// Displacement that the loads of an increment would give the bodies if nothing held them, m: the
/// minimum over the bodies that have a load; 0 in statics, and where no body was in motion.
///
/// The displacements of rigid bodies near rest are the small difference between this displacement
/// and that of the contact forces. Relative to the difference alone, a force that is exact to 1e-12
/// would leave a residual of any size.
fn free_displacement(program: &ConeProgram) -> f64 {
    if !program.has_momentum() {
        return 0.0;
    }
    let free = |body: &ProgramBody| {
        let mut squares = 0.0;
        for dof in &body.dofs[..2] {
            if let Dof::Free(f) = dof
                && f.inertia > 0.0
            {
                squares += ((f.load - f.momentum) / f.inertia).powi(2);
            }
        }
        squares.sqrt()
    };
    let minimum =
        program.bodies.iter().map(free).filter(|u| *u > 0.0).fold(f64::INFINITY, f64::min);
    if minimum.is_finite() { minimum } else { 0.0 }
}

/// The four residuals of a solution. The force of a regularisation counts as an error of the
/// balance.
#[must_use]
pub fn residuals(
    program: &ConeProgram,
    forces: &[[f64; 3]],
    displacements: &[[f64; 3]],
) -> Residuals {
    evaluate(program, forces, displacements, 0.0)
}

/// The residuals of the program that the solver was given: the force of a regularisation is part of
/// the balance.
#[must_use]
pub fn regularised_residuals(
    program: &ConeProgram,
    forces: &[[f64; 3]],
    displacements: &[[f64; 3]],
) -> Residuals {
    evaluate(program, forces, displacements, 1.0)
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
#[must_use]
pub fn choose_displacements(
    program: &ConeProgram,
    solution: &mut ConeSolution,
    tolerance: f64,
) -> Residuals {
    let of = |s: &ConeSolution| regularised_residuals(program, &s.forces, &s.displacements);
    let own = solution.displacements.clone();
    program.displacements_from_forces(solution);
    let following = of(solution);
    let has_springs = program.interactions.iter().any(|c| c.normal_compliance > 0.0);
    if following.worst() <= tolerance || !has_springs || !program.is_dynamic() {
        return following;
    }
    let other = std::mem::replace(&mut solution.displacements, own);
    let balanced = of(solution);
    if balanced.worst() <= tolerance && balanced.balance <= MAX_BALANCE {
        return balanced;
    }
    solution.displacements = other;
    following
}

fn evaluate(
    program: &ConeProgram,
    forces: &[[f64; 3]],
    displacements: &[[f64; 3]],
    regularisation: f64,
) -> Residuals {
    let units = Units::of(program, forces, displacements);
    let mut out = Residuals::default();
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(forces, &mut rows);
    for ((body, row), u) in program.bodies.iter().zip(&rows).zip(displacements) {
        units.of_balance(body, row, u, regularisation, &mut out);
    }
    for (c, f) in program.interactions.iter().zip(forces) {
        units.of_interaction(c, &program.kinematics(c, displacements), f, &mut out);
    }
    out
}

/// The bodies at the maximum residual of a solution: one body twice if it is a residual of the
/// balance, else the two bodies of an interaction. `None` for a solution without forces and
/// displacements.
#[must_use]
pub fn worst_bodies(program: &ConeProgram, solution: &ConeSolution) -> Option<[usize; 2]> {
    let (forces, displacements) = (&solution.forces, &solution.displacements);
    if forces.len() != program.interactions.len() || displacements.len() != program.bodies.len() {
        return None;
    }
    let units = Units::of(program, forces, displacements);
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(forces, &mut rows);
    let balance = program.bodies.iter().zip(&rows).zip(displacements).enumerate();
    let balance = balance.map(|(i, ((body, row), u))| {
        let mut out = Residuals::default();
        units.of_balance(body, row, u, 0.0, &mut out);
        (out.worst(), [i, i])
    });
    let laws = program.interactions.iter().zip(forces).map(|(c, f)| {
        let mut out = Residuals::default();
        units.of_interaction(c, &program.kinematics(c, displacements), f, &mut out);
        (out.worst(), [c.a as usize, c.b as usize])
    });
    balance.chain(laws).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, bodies)| bodies)
}

/// Maximum of the natural map of the contacts without strength, without dimension. With P, Q, T the
/// forces and s_n, s_t, s_r the gap, slip and rotation of the law, each over its unit, the map is
///
/// ```text
/// |min(P, s_n)|,   |Q - clamp(Q + s_t, -mu P, mu P)|,   |T - clamp(T + s_r, -mu_r r P, mu_r r P)|
/// ```
///
/// Unlike a product of force and gap it is not small where both are small and neither vanishes.
#[must_use]
pub fn natural_map(program: &ConeProgram, forces: &[[f64; 3]], displacements: &[[f64; 3]]) -> f64 {
    let units = Units::of(program, forces, displacements);
    let Units { force, length, .. } = units;
    let interactions = program.interactions.iter().zip(forces);
    let of = |(c, f): (&Interaction, &[f64; 3])| {
        let m = multipliers(c, &program.kinematics(c, displacements), f);
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
    // f64::max drops NaN.
    let larger = |m: f64, x: f64| if x <= m || m.is_nan() { m } else { x };
    interactions.filter(|(c, _)| !c.limits.has_strength()).map(of).fold(0.0, larger)
}

/// The units that residuals are relative to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Units {
    /// Force, N.
    pub(super) force: f64,
    /// Displacement, m.
    pub(super) displacement: f64,
    /// Displacement of rigid contacts, m: at least that of free bodies.
    pub(super) rigid: f64,
    /// Length by which a moment is divided, m.
    pub(super) length: f64,
}

impl Units {
    /// The units of a program with these forces and displacements.
    pub(super) fn of(
        program: &ConeProgram,
        forces: &[[f64; 3]],
        displacements: &[[f64; 3]],
    ) -> Self {
        let (displacement, length) =
            (displacement_scale(program, displacements), program.scales.length);
        Self {
            force: force_scale(program, forces),
            displacement,
            rigid: displacement.max(free_displacement(program).min(length)),
            length,
        }
    }

    /// Unit of the displacements of an interaction, m. The error of a spring is an error of its
    /// force.
    fn displacement_of(&self, c: &Interaction) -> f64 {
        if c.normal_compliance == 0.0 { self.rigid } else { self.displacement }
    }

    /// Raises the residual of the balance to that of a body; `row` is the force of its
    /// interactions.
    pub(super) fn of_balance(
        &self,
        body: &ProgramBody,
        row: &[f64; 3],
        u: &[f64; 3],
        regularisation: f64,
        out: &mut Residuals,
    ) {
        for k in 0..3 {
            if let Dof::Free(f) = &body.dofs[k] {
                let pull = regularisation * f.proximal * (u[k] - f.reference);
                let defect = f.inertia * u[k] + pull + row[k] - f.load;
                let unit = if k < 2 { self.force } else { self.force * self.length };
                worsen(&mut out.balance, defect.abs() / unit);
            }
        }
    }

    /// Raises the other residuals to those of an interaction.
    pub(super) fn of_interaction(
        &self,
        c: &Interaction,
        e: &Kinematics,
        f: &[f64; 3],
        out: &mut Residuals,
    ) {
        let Units { force, length, .. } = *self;
        let displacement = self.displacement_of(c);
        let m = multipliers(c, e, f);
        let l = &c.limits;
        let [p, q, tau] = *f;
        worsen(&mut out.kinematics, -m.tension / displacement);

        let shear = l.cohesion + l.friction * p;
        let roll = l.moment + l.rolling * p;
        worsen(&mut out.cone, (q.abs() - shear.max(0.0)) / force);
        worsen(&mut out.cone, (tau.abs() - roll.max(0.0)) / (force * length));
        worsen(&mut out.cone, -(p + l.tension) / force);
        if l.has_shear() {
            worsen(&mut out.cone, -shear / force);
        }

        // A limit further away than the maximum force is not active: its multiplier is zero, and
        // the remainder of the stationarity row is an error of the kinematics. Multiplied by a
        // strength of 1e6 times the forces, round-off of that row would look like an error.
        let mut product = |multiplier: f64, slack: f64, length: f64| {
            if slack.abs() > force * length {
                worsen(&mut out.kinematics, (multiplier * length).abs() / displacement);
            } else {
                worsen(
                    &mut out.complementarity,
                    (multiplier * slack).abs() / (force * displacement),
                );
            }
        };
        product(m.tension.max(0.0), p - l.min_normal_force(), 1.0);
        product(m.slip, shear - q * m.slip.signum(), 1.0);
        product(m.rotation, roll - tau * m.rotation.signum(), length);
    }
}

/// Raises a residual to a value; NaN stays NaN.
fn worsen(residual: &mut f64, value: f64) {
    if residual.is_finite() && (value > *residual || !value.is_finite()) {
        *residual = if value.is_finite() { value } else { f64::NAN };
    }
}
