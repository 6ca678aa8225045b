//! `program_000123.json`: the cone program of an increment and its solution, for whoever wants to
//! check it with another solver.

use std::borrow::Cow;
use std::io;
use std::path::Path;

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::observation::Observation;
use clastic_components::program::{
    Certificate, ConeProgram, ConeSolution, Dof, FreeDof, Interaction, Limits, ProgramBody,
    Residuals, Scales, SolveStatus,
};

use super::OutputError;
use super::atomic::write_atomic;

/// The convex program in words; it stands in every dump.
pub const FORMAT: &str = "\
clastic cone program, version 2. SI units: m, rad, N, N m. \
Unknowns: (p, q, tau) of every interaction: normal force (compression positive), shear force, \
rolling moment; and the displacements u of all free degrees of freedom, the multipliers of the \
balance rows. \
Minimise 1/2 sum_dof (m + w) u^2 + sum_c [g p + 1/2 C_N p^2 + 1/2 C_T (q - q_0)^2 - e_n p - e_t q \
- e_r tau] \
subject to, for every free degree of freedom, (m + w) u + G (p, q, tau) = load + w r, \
and for every interaction |q| <= cohesion + friction p, |tau| <= moment + rolling p, \
p >= -tension; \
m = inertia, momentum = the part of the load that is inertia times the motion of the last increment \
(no force), w = proximal (regularisation; the residuals count its force as an error of the \
balance), r = reference, g = offset, C_N = normal_compliance, \
C_T = tangential_compliance, q_0 = previous_shear; an interaction without cohesion and friction has \
q = 0 and a free slip, one without rolling has tau = 0 and a free rotation. \
G: with n = normal (unit, from a to b) and t = (-n_y, n_x), body a has the rows p n + q t (forces) \
and arm_a q + tau (moment), body b has -(p n + q t) and arm_b q - tau; forces are taken along axis and \
along axis turned by +90 degrees, the two translations of a body. \
Kinematics, the transpose of G: closing d_n = n.(u_a - u_b), slip d_t = t.(u_a - u_b) + arm_a alpha_a + \
arm_b alpha_b, relative rotation d_r = alpha_a - alpha_b; (e_n, e_t, e_r) are (d_n, d_t, d_r) of the \
fixed degrees of freedom alone. \
Optimality: d_n = g + C_N p - friction (l1 + l2) - rolling (l3 + l4) - l5, \
d_t = C_T (q - q_0) + l1 - l2, d_r = l3 - l4 with l1, l2 >= 0 the multipliers of +q and -q, l3, l4 those of \
+tau and -tau, l5 that of p >= -tension. \
scales are the magnitudes that a solver may divide by; they change no solution. \
Tables: bodies[i] is body i; solution.forces[k] = (p, q, tau) belongs to interactions[k]; \
solution.displacements[i] = (first translation, second translation, rotation) to bodies[i]. \
null stands for a number that is not finite.";

#[derive(Serialize, Deserialize)]
struct Dump<'a> {
    format: Cow<'a, str>,
    increment: u64,
    stage: Cow<'a, str>,
    fraction: f64,
    units: Units,
    scales: ScalesDump,
    bodies: Vec<BodyDump>,
    interactions: Vec<InteractionDump>,
    solution: SolutionDump<'a>,
}

#[derive(Serialize, Deserialize)]
struct Units {
    length: String,
    rotation: String,
    force: String,
    moment: String,
    compliance: String,
}

impl Default for Units {
    fn default() -> Self {
        let [length, rotation, force, moment, compliance] =
            ["m", "rad", "N", "N m", "m/N"].map(str::to_owned);
        Self { length, rotation, force, moment, compliance }
    }
}

#[derive(Serialize, Deserialize)]
struct ScalesDump {
    length: f64,
    displacement: f64,
    force: f64,
}

#[derive(Serialize, Deserialize)]
struct BodyDump {
    id: usize,
    axis: [f64; 2],
    dofs: [DofDump; 3],
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum DofDump {
    Fixed(f64),
    Free {
        load: f64,
        #[serde(default)]
        momentum: f64,
        inertia: f64,
        proximal: f64,
        reference: f64,
    },
}

#[derive(Serialize, Deserialize)]
struct InteractionDump {
    a: u32,
    b: u32,
    normal: [f64; 2],
    arm_a: f64,
    arm_b: f64,
    offset: f64,
    normal_compliance: f64,
    tangential_compliance: f64,
    previous_shear: f64,
    limits: LimitsDump,
    #[serde(default = "associated")]
    dilation: f64,
}

/// The dilation of dumps that do not say it.
fn associated() -> f64 {
    1.0
}

#[derive(Serialize, Deserialize)]
struct LimitsDump {
    cohesion: f64,
    friction: f64,
    tension: f64,
    rolling: f64,
    moment: f64,
}

#[derive(Serialize, Deserialize)]
struct SolutionDump<'a> {
    status: Cow<'a, str>,
    message: Cow<'a, str>,
    iterations: u32,
    residuals: ResidualsDump,
    forces: Cow<'a, [[f64; 3]]>,
    displacements: Cow<'a, [[f64; 3]]>,
    certificate: Option<CertificateDump<'a>>,
}

#[derive(Serialize, Deserialize)]
struct ResidualsDump {
    balance: f64,
    kinematics: f64,
    cone: f64,
    complementarity: f64,
}

/// The mechanism of a collapse: displacements in the bodies' own axes, without scale.
#[derive(Serialize, Deserialize)]
struct CertificateDump<'a> {
    mechanism: Cow<'a, [[f64; 3]]>,
    margin: f64,
    defect: f64,
}

/// Writes the program and the solution of the last increment.
///
/// # Errors
/// Where the file cannot be written.
pub fn write_program(path: &Path, world: &World) -> Result<(), OutputError> {
    let observation = world.resource::<Observation>();
    let program = world.resource::<ConeProgram>();
    let solution = world.resource::<ConeSolution>();
    let r = &solution.residuals;
    let dump = Dump {
        format: FORMAT.into(),
        increment: observation.increment,
        stage: (&observation.stage).into(),
        fraction: observation.fraction,
        units: Units::default(),
        scales: ScalesDump {
            length: program.scales.length,
            displacement: program.scales.displacement,
            force: program.scales.force,
        },
        bodies: program
            .bodies
            .iter()
            .enumerate()
            .map(|(id, body)| BodyDump {
                id,
                axis: DVec2::to_array(&body.axis),
                dofs: body.dofs.map(dof),
            })
            .collect(),
        interactions: program.interactions.iter().map(interaction).collect(),
        solution: SolutionDump {
            status: name(solution.status).into(),
            message: (&solution.message).into(),
            iterations: solution.iterations,
            residuals: ResidualsDump {
                balance: r.balance,
                kinematics: r.kinematics,
                cone: r.cone,
                complementarity: r.complementarity,
            },
            forces: (&solution.forces).into(),
            displacements: (&solution.displacements).into(),
            certificate: solution.certificate.as_ref().map(|c| CertificateDump {
                mechanism: (&c.mechanism).into(),
                margin: c.margin,
                defect: c.defect,
            }),
        },
    };
    let mut text = serde_json::to_string(&dump).map_err(OutputError::at(path))?;
    text.push('\n');
    write_atomic(path, text)
}

fn dof(dof: Dof) -> DofDump {
    match dof {
        Dof::Fixed(value) => DofDump::Fixed(value),
        Dof::Free(f) => DofDump::Free {
            load: f.load,
            momentum: f.momentum,
            inertia: f.inertia,
            proximal: f.proximal,
            reference: f.reference,
        },
    }
}

fn interaction(c: &Interaction) -> InteractionDump {
    InteractionDump {
        a: c.a,
        b: c.b,
        normal: c.normal.to_array(),
        arm_a: c.arm_a,
        arm_b: c.arm_b,
        offset: c.offset,
        normal_compliance: c.normal_compliance,
        tangential_compliance: c.tangential_compliance,
        previous_shear: c.previous_shear,
        limits: LimitsDump {
            cohesion: c.limits.cohesion,
            friction: c.limits.friction,
            tension: c.limits.tension,
            rolling: c.limits.rolling,
            moment: c.limits.moment,
        },
        dilation: c.dilation,
    }
}

const NAMES: [(SolveStatus, &str); 4] = [
    (SolveStatus::Solved, "solved"),
    (SolveStatus::Collapsed, "collapsed"),
    (SolveStatus::Locked, "locked"),
    (SolveStatus::Stalled, "stalled"),
];

fn name(status: SolveStatus) -> &'static str {
    NAMES.iter().find(|n| n.0 == status).map_or("", |n| n.1)
}

/// Reads what [`write_program`] wrote: a program and its solution, for benchmarks and for trying
/// solvers on the programs of a run.
///
/// # Errors
/// Where the file cannot be read, is no dump of this version, or has a number that is not finite.
pub fn read_program(path: &Path) -> Result<(ConeProgram, ConeSolution), OutputError> {
    let text = std::fs::read_to_string(path).map_err(OutputError::at(path))?;
    let dump: Dump = serde_json::from_str(&text).map_err(OutputError::at(path))?;
    let status = NAMES.iter().find(|n| n.1 == dump.solution.status).map(|n| n.0);
    let (true, Some(status)) = (dump.format == FORMAT, status) else {
        let error = io::Error::new(io::ErrorKind::InvalidData, "not a dump of this version");
        return Err(OutputError::at(path)(error));
    };
    let program = ConeProgram {
        bodies: dump
            .bodies
            .iter()
            .map(|b| ProgramBody {
                axis: DVec2::from_array(b.axis),
                dofs: b.dofs.each_ref().map(read_dof),
            })
            .collect(),
        interactions: dump.interactions.iter().map(read_interaction).collect(),
        scales: Scales {
            length: dump.scales.length,
            displacement: dump.scales.displacement,
            force: dump.scales.force,
        },
        tolerance: 0.0,
        last_forces: Vec::new(),
    };
    let s = dump.solution;
    let solution = ConeSolution {
        status,
        forces: s.forces.into_owned(),
        displacements: s.displacements.into_owned(),
        residuals: Residuals {
            balance: s.residuals.balance,
            kinematics: s.residuals.kinematics,
            cone: s.residuals.cone,
            complementarity: s.residuals.complementarity,
        },
        iterations: s.iterations,
        certificate: s.certificate.map(|c| Certificate {
            mechanism: c.mechanism.into_owned(),
            margin: c.margin,
            defect: c.defect,
        }),
        message: s.message.into_owned(),
    };
    Ok((program, solution))
}

fn read_dof(dof: &DofDump) -> Dof {
    match *dof {
        DofDump::Fixed(value) => Dof::Fixed(value),
        DofDump::Free { load, momentum, inertia, proximal, reference } => {
            Dof::Free(FreeDof { load, momentum, inertia, proximal, reference })
        }
    }
}

fn read_interaction(c: &InteractionDump) -> Interaction {
    Interaction {
        a: c.a,
        b: c.b,
        normal: DVec2::from_array(c.normal),
        arm_a: c.arm_a,
        arm_b: c.arm_b,
        offset: c.offset,
        normal_compliance: c.normal_compliance,
        tangential_compliance: c.tangential_compliance,
        previous_shear: c.previous_shear,
        limits: Limits {
            cohesion: c.limits.cohesion,
            friction: c.limits.friction,
            tension: c.limits.tension,
            rolling: c.limits.rolling,
            moment: c.limits.moment,
        },
        dilation: c.dilation,
    }
}
