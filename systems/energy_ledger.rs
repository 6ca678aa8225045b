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

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::Attempt;
use clastic_components::body::{AngularVelocity, BodyId, Drive, ExternalForce, Position, Velocity};
use clastic_components::contact::{Bodies, Contact, ContactHistory, Contacts};
use clastic_components::energy::{Energies, EnergyLedger};
use clastic_components::increment::{Analysis, AnalysisKind};
use clastic_components::material::Materials;
use clastic_components::program::{ConeProgram, ConeSolution};

use crate::assemble_program::interactions::contact_law;
use crate::schedule::{Increment, IncrementSystems, committed};
use crate::solve_program::residuals::multipliers;

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
                .before(IncrementSystems::Walls),
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
    attempt: Res<Attempt>,
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

    let theta = match analysis.kind {
        AnalysisKind::Dynamic { theta, .. } => theta,
        AnalysisKind::Static | AnalysisKind::LeastMotion { .. } => 1.0,
    };
    // Elastic energy: of the state at the start, by the law of the program at start and end, and
    // of the state at the end. They differ where bonds break.
    let (mut starts, mut ends, mut state) = (0.0, 0.0, 0.0);
    let mut broke_before = false;
    for ((contact, c), f) in contacts.0.iter().zip(&program.interactions).zip(&solution.forces) {
        let m = multipliers(c, &program.kinematics(c, &solution.displacements), f);
        let [p, q, tau] = *f;
        let broken = contact
            .bond
            .map(|k| &bodies.bonds[k as usize])
            .is_some_and(|b| attempt.ruptures.iter().any(|r| r.bond == b.id));
        let as_bond = contact.bond.is_some() && (c.limits.has_strength() || !broken);
        broke_before |= broken && !as_bond;
        let key = (contact.a, contact.b);
        let opening = attempt
            .openings
            .binary_search_by_key(&key, |o| o.0)
            .map_or(0.0, |k| if as_bond { 0.0 } else { attempt.openings[k].1 });

        e.friction += q * m.slip;
        e.rolling += tau * m.rotation;
        let dilates =
            c.limits.friction * m.slip.abs() + c.limits.rolling * m.rotation.abs() - opening;
        e.dilation -= p * dilates;
        if as_bond {
            e.rupture -= p * m.tension;
        }
        let taken = p * (c.offset - opening + c.normal_compliance * p)
            + c.tangential_compliance * q * (q - c.previous_shear);

        let shift = attempt.shear_shift(key, c.tangential_compliance);
        let sheared = c.previous_shear - shift;
        let compliances = [theta * c.normal_compliance, theta * c.tangential_compliance];
        let born = contact.bond.filter(|_| as_bond).map(|k| bodies.bonds[k as usize].initial_gap);
        let gap = gap_at(&bodies, &end, contact);
        let shear = sheared + (q - sheared) / theta;
        let remembered = history.get(contact.a, contact.b).map_or(0.0, |m| m.q);
        let start = stored(compliances, contact.gap, born, sheared);
        let finish = stored(compliances, gap, born, if broken { shear } else { remembered });
        starts += start;
        ends += finish;
        e.numerical += taken - (finish - start);
        state += if broken && as_bond {
            let law = contact_law(&bodies, &materials, &analysis, contact);
            let compliances = [law.normal_compliance, law.tangential_compliance];
            stored(compliances, gap, None, remembered)
        } else {
            finish
        };
    }
    // Interactions that an embedding program added: outside of the specimen.
    let extra = program.interactions.iter().zip(&solution.forces).skip(contacts.0.len());
    for (c, f) in extra {
        let d = program.kinematics(c, &solution.displacements);
        e.external -= f[0] * d[0] + f[1] * d[1] + f[2] * d[2];
    }
    // Bonds that break before the last solve, or cement and settling between two increments.
    let before = ledger.stored.unwrap_or(starts);
    *(if broke_before { &mut e.rupture } else { &mut e.numerical }) += before - starts;
    e.rupture += ends - state;
    e.elastic = state - before;
    ledger.stored = Some(state);
    ledger.increment = e;
    ledger.total += e;
}

/// Gap of a contact at the given positions, m.
fn gap_at(bodies: &Bodies, positions: &[DVec2], contact: &Contact) -> f64 {
    let (a, b) = (contact.a as usize, contact.b as usize);
    match bodies.radii.get(b) {
        Some(radius) => positions[a].distance(positions[b]) - bodies.radii[a] - radius,
        // The normal of a wall points from the particle to the wall.
        None => (positions[b] - positions[a]).dot(contact.normal) - bodies.radii[a],
    }
}

/// Elastic energy of an interaction, J: of a bond that is free of stress at the gap `born`, or of a
/// contact, which only presses.
fn stored([normal, tangential]: [f64; 2], gap: f64, born: Option<f64>, shear: f64) -> f64 {
    let overlap = match born {
        Some(born) => born - gap,
        None => (-gap).max(0.0),
    };
    let pressed = if normal > 0.0 { 0.5 * overlap * overlap / normal } else { 0.0 };
    pressed + 0.5 * tangential * shear * shear
}
