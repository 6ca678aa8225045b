//! The energy ledger: where the work of an increment went.
//!
//! **Time steps.** With the theta-method, `m (v_1 - v_0)/dt = f - G s`. Times the mean velocity
//! `v = (v_0 + v_1)/2` that is, row by row and exactly,
//!
//! ```text
//! dt f . v - dt s . G'v = 1/2 m v_1^2 - 1/2 m v_0^2
//! ```
//!
//! so every interaction takes its impulse times the mean of its relative velocities: the normal impulse of a rigid
//! contact is `collision`, whatever its restitution, the tangential one `friction`, the rolling one `rolling`.
//! Bodies move by `u = dt (theta v_1 + (1 - theta) v_0)`: the loads' work `f . u` exceeds `dt f . v` by
//! `(theta - 1/2) dt f . (v_1 - v_0)`, which is `numerical`. Of loads that are constant it is the change of a function
//! of the velocities and does not add up. An elastic force keeps what its spring stores; the rest is
//! `numerical` as long as the contact is closed (damping by theta > 1/2) and `collision` where it closes or opens.
//!
//! **Static increments.** Forces go from those of the start to those of the end, and so do the loads
//! (`quasi_static`). Stationarity gives, with g and C those of the program,
//!
//! ```text
//! d_n = g + C_N p - a (mu |s_t| + mu_r r |s_r|) - lambda_T
//! d_t = C_T (q - q_0) + s_t
//! ```
//!
//! Sliding takes q s_t. The gap that associated friction opens is there when the next increment begins, beside the
//! force of the contact, which knows nothing of it: closing it takes what opening it gave, as far as the force is
//! the same. `dilation` has both, so that it stays near zero where sliding is steady.
//!
//! A motion that is followed within a static increment ([`motion`](crate::attempt::motion)) is booked step by
//! step. What friction, rolling and rupture leave of the work of the loads is the kinetic energy that was taken
//! out of the motion.

mod dynamic;
mod interactions;
mod quasi_static;
mod steps;
mod unbalanced;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use clastic_components::body::{AngularVelocity, BodyId, ExternalForce, Position, Velocity};
use clastic_components::contact::{Bodies, ContactHistory, Contacts, DraftHistory, KeptRows};
use clastic_components::energy::{Energies, EnergyLedger, MotionEnergies, Released};
use clastic_components::findings::{Corrections, Ruptures};
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::material::Materials;
use clastic_cone::program::{ConeProgram, ConeSolution};

use self::dynamic::book_bodies;
use self::interactions::{Part, Tables, after_rupture, book, gap_at};
use self::quasi_static::Starts;
use crate::schedule::{Increment, IncrementSystems, committed};
use crate::state::RegisterState;

pub(crate) use self::steps::book_step;

/// Adds [`book_energies`]; it runs only where there is an [`EnergyLedger`].
pub struct EnergyLedgerPlugin;

impl Plugin for EnergyLedgerPlugin {
    fn build(&self, app: &mut App) {
        app.register_resource::<EnergyLedger>("energy_ledger");
        let renumber = renumber_released
            .run_if(resource_exists::<EnergyLedger>)
            .in_set(IncrementSystems::Renumber);
        app.add_systems(Increment, renumber).add_systems(
            Increment,
            book_energies
                .run_if(resource_exists::<EnergyLedger>)
                .run_if(committed)
                .after(IncrementSystems::Rupture)
                .before(IncrementSystems::Record),
        );
    }
}

/// Follows bodies to other rows.
fn renumber_released(rows: Res<KeptRows>, mut ledger: ResMut<EnergyLedger>) {
    ledger.released.retain_mut(|released| match (rows.now(released.a), rows.now(released.b)) {
        (Some(a), Some(b)) => {
            (released.a, released.b) = (a, b);
            true
        }
        _ => false,
    });
}

/// A body as the increment leaves it.
type MovedBody = (
    &'static BodyId,
    &'static Position,
    &'static ExternalForce,
    Option<&'static Velocity>,
    Option<&'static AngularVelocity>,
);
type Moved<'w, 's> = Query<'w, 's, MovedBody>;

/// What an increment was solved from and with.
#[derive(SystemParam)]
pub struct Solved<'w> {
    bodies: Res<'w, Bodies>,
    contacts: Res<'w, Contacts>,
    materials: Res<'w, Materials>,
    analysis: Res<'w, Analysis>,
    progress: Res<'w, Progress>,
    program: Res<'w, ConeProgram>,
    solution: Res<'w, ConeSolution>,
    corrections: Res<'w, Corrections>,
    ruptures: Res<'w, Ruptures>,
    /// Memory of the contacts at the start, after a motion that was followed.
    draft: Res<'w, DraftHistory>,
    /// Memory of the contacts at the end.
    history: Res<'w, ContactHistory>,
    motion: Res<'w, MotionEnergies>,
}

/// Books the increment that was just committed.
pub fn book_energies(solved: Solved, moved: Moved, mut ledger: ResMut<EnergyLedger>) {
    let Solved { bodies, analysis, program, solution, ruptures, motion, .. } = &solved;
    if matches!(analysis.kind, AnalysisKind::LeastMotion { .. }) {
        // Its forces are those of a regularisation.
        *ledger = EnergyLedger::default();
        return;
    }
    let mut rows: Vec<_> = moved.iter().collect();
    rows.sort_unstable_by_key(|row| row.0);
    let mut end = bodies.positions.clone();
    for row in &rows {
        if let Some(i) = bodies.row(*row.0) {
            end[i] = row.1.0;
        }
    }
    let tables = Tables {
        bodies,
        contacts: &solved.contacts,
        history: &solved.history,
        materials: &solved.materials,
        analysis,
        fraction: solved.progress.fraction,
        program,
        solution,
        corrections: &solved.corrections,
        end: &end,
    };
    let mut e = Energies::default();
    let is_broken = |bond| ruptures.list.iter().any(|r| r.bond == bond);
    // What moved before the increment was booked step by step.
    let before = motion.stored.or(ledger.stored);
    let mut released = Vec::new();
    let mut release = |part: &Part| {
        if part.breaks && part.is_bond {
            let contact = part.contact;
            let gap = gap_at(bodies, &end, contact);
            let left = after_rupture(&tables, contact, gap, part.forces);
            let forces = [0, 1, 2].map(|k| part.forces[k] - left[k]);
            released.push(Released { a: contact.a, b: contact.b, forces });
        }
    };
    let mut mean = None;
    let stored = if let AnalysisKind::Dynamic { dt, theta } = analysis.kind {
        let dt = dt * solved.progress.fraction;
        let mean = &*mean.insert(book_bodies(&mut e, &tables, dt, theta, &rows));
        book(&mut e, &tables, before, is_broken, |e, part| {
            release(part);
            dynamic::book(e, program, mean, part);
        })
    } else {
        // What a motion has followed is none of the start.
        let ended = if motion.stored.is_some() { &[][..] } else { &ledger.released };
        let mut starts = Starts::new(&solved.draft.0, ended, program, solution);
        let stored = book(&mut e, &tables, before, is_broken, |e, part| {
            release(part);
            starts.book(e, &tables, part);
        });
        unbalanced::book(&mut e, &tables, &starts, before.is_none());
        stored
    };
    // Interactions that an embedding program added: outside of the specimen.
    let extra = program.interactions.iter().zip(&solution.forces).skip(solved.contacts.0.len());
    for (c, f) in extra {
        let d = program.kinematics(c, &solution.displacements);
        let work = |d: [f64; 3]| f[0] * d[0] + f[1] * d[1] + f[2] * d[2];
        e.external -= work(d);
        if let Some(mean) = &mean {
            e.numerical += work(program.kinematics(c, mean)) - work(d);
        }
    }
    e += motion.energies;
    ledger.stored = Some(stored);
    ledger.released = released;
    ledger.increment = e;
    ledger.total += e;
}
