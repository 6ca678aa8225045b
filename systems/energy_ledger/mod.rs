//! The energy ledger: where the work of an increment went.
//!
//! It rests on two identities. With the theta-method, `m (v_1 - v_0)/dt = f - G s` and
//! `u = dt (theta v_1 + (1 - theta) v_0)` give, row by row,
//!
//! ```text
//! f . u - s . G'u = 1/2 m v_1^2 - 1/2 m v_0^2 + (theta - 1/2) m (v_1 - v_0)^2
//! ```
//!
//! and stationarity gives for every interaction, with g and C those of the program,
//!
//! ```text
//! s . G'u = p (g + C_N p) + C_T q (q - q_0)          elastic energy and (theta - 1/2) d^2/C
//!         + q s_t + tau s_r                          friction and rolling
//!         - p (mu |s_t| + mu_r r |s_r|)              dilation of the associated law
//!         - p lambda_T                               f_t lambda_T: a bond at its tension limit
//! ```
//!
//! A spring that closes by d takes `k (theta o_1 + (1 - theta) o_0) d = 1/2 k (o_1^2 - o_0^2) +
//! (theta - 1/2) k d^2`. At theta = 1/2 nothing is lost, above it nothing is gained, as long as
//! normals stand still; static increments are those of theta = 1.
//!
//! A motion that is followed within a static increment ([`motion`](crate::attempt::motion)) is booked step by
//! step with the same terms. What they leave of the work of the loads is the kinetic energy that was taken out of
//! the motion.

mod interactions;
mod steps;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::body::{AngularVelocity, BodyId, Drive, ExternalForce, Position, Velocity};
use clastic_components::contact::{Bodies, ContactHistory, Contacts};
use clastic_components::energy::{Energies, EnergyLedger, MotionEnergies};
use clastic_components::findings::{Corrections, Ruptures};
use clastic_components::increment::{Analysis, AnalysisKind};
use clastic_components::material::Materials;
use clastic_components::program::{ConeProgram, ConeSolution};

use self::interactions::{Tables, book};
use crate::schedule::{Increment, IncrementSystems, committed};

pub(crate) use self::steps::book_step;

/// Adds [`book_energies`]; it runs only where there is an [`EnergyLedger`].
pub struct EnergyLedgerPlugin;

impl Plugin for EnergyLedgerPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Increment,
            book_energies
                .run_if(resource_exists::<EnergyLedger>)
                .run_if(committed)
                .after(IncrementSystems::Rupture)
                .before(IncrementSystems::Record),
        );
    }
}

type Moved<'w, 's> = Query<
    'w,
    's,
    (
        &'static BodyId,
        &'static Position,
        &'static ExternalForce,
        Option<&'static Velocity>,
        Option<&'static AngularVelocity>,
    ),
>;

/// Books the increment that was just committed.
pub fn book_energies(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    history: Res<ContactHistory>,
    materials: Res<Materials>,
    analysis: Res<Analysis>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    findings: (Res<Ruptures>, Res<Corrections>),
    motion: Res<MotionEnergies>,
    moved: Moved,
    mut ledger: ResMut<EnergyLedger>,
) {
    if matches!(analysis.kind, AnalysisKind::LeastMotion { .. }) {
        // Its forces are those of a regularisation.
        *ledger = EnergyLedger::default();
        return;
    }
    let mut e = Energies::default();
    let mut rows: Vec<_> = moved.iter().collect();
    rows.sort_unstable_by_key(|row| row.0);
    let mut end = bodies.positions.clone();
    for (id, position, force, velocity, spin) in rows {
        let i = id.index();
        end[i] = position.0;
        let u = program.bodies[i].to_global(solution.displacements[i]);
        e.external += (0..3).map(|k| force.0[k] * u[k]).sum::<f64>();
        if i >= bodies.particles {
            continue;
        }
        e.gravity += bodies.masses[i] * analysis.gravity.dot(DVec2::new(u[0], u[1]));
        if analysis.path_theta.is_some() {
            // The identity is that of the program; the work is that on the path.
            let aside = end[i] - bodies.positions[i] - DVec2::new(u[0], u[1]);
            let by_gravity = bodies.masses[i] * analysis.gravity.dot(aside);
            let by_loads = force.0[0] * aside.x + force.0[1] * aside.y;
            e.gravity += by_gravity;
            e.external += by_loads;
            e.numerical += by_gravity + by_loads;
        }
        if let (AnalysisKind::Dynamic { theta, .. }, Some(v), Some(spin)) =
            (analysis.kind, velocity, spin)
        {
            let before =
                [bodies.velocities[i].x, bodies.velocities[i].y, bodies.angular_velocities[i]];
            let after = [v.0.x, v.0.y, spin.0];
            for k in 0..3 {
                let mass = if k < 2 { bodies.masses[i] } else { bodies.inertias[i] };
                let change = after[k] - before[k];
                e.kinetic += 0.5 * mass * change * (after[k] + before[k]);
                // An imposed velocity holds from the start of the increment, as with theta = 1.
                let theta = if bodies.drives[i][k] == Drive::Free { theta } else { 1.0 };
                e.numerical += (theta - 0.5) * mass * change * change;
            }
        }
    }

    let (ruptures, corrections) = findings;
    let tables = Tables {
        bodies: &bodies,
        contacts: &contacts,
        history: &history,
        materials: &materials,
        analysis: &analysis,
        program: &program,
        solution: &solution,
        corrections: &corrections,
        end: &end,
    };
    let is_broken = |bond| ruptures.list.iter().any(|r| r.bond == bond);
    // What moved before the increment was booked step by step.
    let before = motion.stored.or(ledger.stored);
    ledger.stored = Some(book(&mut e, &tables, before, is_broken));
    // Interactions that an embedding program added: outside of the specimen.
    let extra = program.interactions.iter().zip(&solution.forces).skip(contacts.0.len());
    for (c, f) in extra {
        let d = program.kinematics(c, &solution.displacements);
        e.external -= f[0] * d[0] + f[1] * d[1] + f[2] * d[2];
    }
    e += motion.energies;
    ledger.increment = e;
    ledger.total += e;
}
