//! A cone program and its solution as JSON, so that other solvers can check them.

use clastic_cone::program::{
    ConeProgram, ConeSolution, Interaction, ProgramBody, ProgramCell, Scales,
};
use serde::de::Error as _;
use serde::{Deserialize, Serialize};

/// The description of the convex program that every dump contains.
pub const FORMAT: &str = "\
clastic cone program, version 1. SI units: m, rad, N, N m. \
Unknowns: (p, q, tau) of every interaction: normal force (compression positive), shear force, \
rolling moment; and the displacements u of all free degrees of freedom, the multipliers of the \
balance rows. \
Minimise 1/2 sum_dof (m + w) u^2 + sum_c [g p + 1/2 C_N p^2 + 1/2 C_T (q - q_0)^2 - e_n p - e_t q \
- e_r tau] \
subject to, for every free degree of freedom, (m + w) u + G (p, q, tau) = load + w r, and for \
every interaction |q| <= cohesion + friction p, |tau| <= moment + rolling p, p >= -tension; m = \
inertia, momentum = the part of the load that is inertia times the motion of the last increment \
(no force), w = proximal (regularisation; the residuals count its force as an error of the \
balance), r = reference, g = offset, C_N = normal_compliance, C_T = tangential_compliance, q_0 = \
previous_shear; an interaction without cohesion and friction has q = 0 and a free slip, one \
without rolling has tau = 0 and a free rotation. \
G: with n = normal (unit, from a to b) and t = (-n_y, n_x), body a has the rows p n + q t \
(forces) and arm_a q + tau (moment), body b has -(p n + q t) and arm_b q - tau; forces are taken \
along axis and along axis turned by +90 degrees, the two translations of a body. \
Kinematics, the transpose of G: closing d_n = n.(u_a - u_b), slip d_t = t.(u_a - u_b) + arm_a \
alpha_a + arm_b alpha_b, relative rotation d_r = alpha_a - alpha_b; (e_n, e_t, e_r) are (d_n, d_t, \
d_r) of the fixed degrees of freedom alone. \
Optimality: d_n = g + C_N p - friction (l1 + l2) - rolling (l3 + l4) - l5, d_t = C_T (q - q_0) + \
l1 - l2, d_r = l3 - l4 with l1, l2 >= 0 the multipliers of +q and -q, l3, l4 those of +tau and \
-tau, l5 that of p >= -tension. This is solution.law = associated; with coulomb d_n of an \
interaction without cohesion and tension lacks the terms of friction and rolling, and the \
solution is no minimum. \
scales are the magnitudes that a solver may divide by; they change no solution. \
Tables: bodies[i] is body i; solution.forces[k] = (p, q, tau) belongs to interactions[k]; \
solution.displacements[i] = (first translation, second translation, rotation) to bodies[i]. null \
stands for a number that is not finite.";

/// Addition to [`FORMAT`] for a program with a periodic cell.
const OF_CELL: &str = " cell.body is the row of the body that stands for the deformation of a \
periodic cell: with its translations U along the global axes and its rotation T, body b of an \
interaction with image = (x, y) moves by u_b + (x U_x + y cell.arm T, y U_y), and the transpose of \
this gives the force on that body.";

/// What is added to [`FORMAT`] for a program with elastic rolling moments.
const OF_ROLLING: &str = " The objective has 1/2 C_R (tau - tau_0)^2 besides, with C_R = \
rolling_compliance and tau_0 = previous_moment, so that d_r = C_R (tau - tau_0) + l3 - l4; an \
interaction without the two has C_R = tau_0 = 0.";

/// The first words of [`FORMAT`].
const READ: &str = "clastic cone program, version 1. ";

/// A cone program and its solution, with their place in a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Dump {
    format: String,
    /// Increment of the run.
    pub increment: u64,
    /// Stage of the run.
    pub stage: String,
    /// Share of the increment that was solved, 0 to 1.
    pub fraction: f64,
    #[serde(skip_deserializing)]
    units: Option<Units>,
    scales: Scales,
    bodies: Vec<Numbered>,
    interactions: Vec<Interaction>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cell: Option<ProgramCell>,
    /// Solution of the program.
    pub solution: ConeSolution,
}

impl Dump {
    /// The program, without [`ConeProgram::last_forces`], which are no part of the problem.
    pub fn program(&self) -> ConeProgram {
        ConeProgram {
            bodies: self.bodies.iter().map(|numbered| numbered.body).collect(),
            interactions: self.interactions.clone(),
            scales: self.scales,
            cell: self.cell,
            ..ConeProgram::default()
        }
    }
}

#[derive(Clone, Debug, Serialize)]
struct Units {
    length: &'static str,
    rotation: &'static str,
    force: &'static str,
    moment: &'static str,
    compliance: &'static str,
}

const UNITS: Units =
    Units { length: "m", rotation: "rad", force: "N", moment: "N m", compliance: "m/N" };

/// A body with its number, for readers.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Numbered {
    id: usize,
    #[serde(flatten)]
    body: ProgramBody,
}

/// The description of a program.
fn format(program: &ConeProgram) -> String {
    let mut text = FORMAT.to_owned();
    if program.cell.is_some() {
        text += OF_CELL;
    }
    if program.interactions.iter().any(|c| c.rolling_compliance > 0.0) {
        text += OF_ROLLING;
    }
    text
}

/// A program and its solution as one line of JSON.
///
/// # Errors
/// Never for numbers of any value: those that are not finite become `null`.
pub fn to_json(
    increment: u64,
    stage: &str,
    fraction: f64,
    program: &ConeProgram,
    solution: &ConeSolution,
) -> Result<String, serde_json::Error> {
    let numbered = |(id, body): (usize, &ProgramBody)| Numbered { id, body: *body };
    let mut text = serde_json::to_string(&Dump {
        format: format(program),
        increment,
        stage: stage.to_owned(),
        fraction,
        units: Some(UNITS),
        scales: program.scales,
        bodies: program.bodies.iter().enumerate().map(numbered).collect(),
        interactions: program.interactions.clone(),
        cell: program.cell,
        solution: solution.clone(),
    })?;
    text.push('\n');
    Ok(text)
}

/// Reads what [`to_json`] wrote.
///
/// # Errors
/// Where the text is no dump of this version, or has a number that is not finite.
pub fn from_json(text: &str) -> Result<Dump, serde_json::Error> {
    let dump: Dump = serde_json::from_str(text)?;
    if !dump.format.starts_with(READ) {
        return Err(serde_json::Error::custom("not a dump of version 1"));
    }
    Ok(dump)
}
