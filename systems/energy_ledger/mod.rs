//! The energy ledger: balance of supplied, stored and dissipated energy in an increment.
//!
//! **Time steps.** With the theta-method, `m (v_1 - v_0)/dt = f - G s`. Multiplied by the mean
//! velocity `v = (v_0 + v_1)/2`, each row gives exactly
//!
//! ```text
//! dt f . v - dt s . G'v = 1/2 m v_1^2 - 1/2 m v_0^2
//! ```
//!
//! Every interaction therefore absorbs its impulse times the mean of its relative velocities before
//! and after. The normal impulse of a rigid contact is booked as `collision`, whatever its
//! restitution, the tangential one as `friction`, and the rolling one as `rolling`. Bodies move by
//! `u = dt (theta v_1 + (1 - theta) v_0)`. The work `f . u` of the loads exceeds `dt f . v` by
//! `(theta - 1/2) dt f . (v_1 - v_0)`, which is `numerical`. For constant loads this is the change
//! of a function of the velocities and does not accumulate. An elastic force stores the energy of
//! its spring. The rest is `numerical`: damping by theta > 1/2, and the error where it closes or
//! opens within a step.
//!
//! **Static increments.** Forces and loads go from their values at the start to those at the end
//! (`quasi_static`). Stationarity gives, with g and C of the program,
//!
//! ```text
//! d_n = g + C_N p - a (mu |s_t| + mu_r r |s_r|) - lambda_T
//! d_t = C_T (q - q_0) + s_t
//! ```
//!
//! Sliding dissipates q s_t. The gap that associated friction opens persists in the next increment,
//! but the force of the contact does not contain it. Closing this gap takes the energy that opening
//! it gave, as long as the force is constant. `dilation` contains both, so that it stays near zero
//! in steady sliding.
//!
//! **A periodic cell** is a body of the program like others. Its loads are the stresses times the
//! area at the start of the increment, and its reactions do the work of imposed strains. In time
//! steps the ledger has no term for it, so that scenes may not ask for both.
//!
//! A followed motion within a static increment ([`motion`](crate::attempt::motion)) is booked step
//! by step. The work of the loads minus friction, rolling and rupture is the kinetic energy that
//! was removed from the motion.

mod dynamic;
mod interactions;
mod quasi_static;
mod steps;
mod unbalanced;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use clastic_components::energy::Changed;
use clastic_components::prelude::*;
use glam::DVec2;

use self::dynamic::book_bodies;
use self::interactions::{Before, Part, Tables, after_rupture, book};
use self::quasi_static::Starts;
use crate::assemble_program::{cell, taut};
use crate::contact_laws::Laws;
use crate::schedule::{ClasticHalted, Increment, IncrementSystems, committed};
use crate::solved::{Solved, SolvedTables};
use crate::state::RegisterState;

pub(crate) use self::steps::book_step;

/// Adds [`book_energies`]. It runs only in a world with an [`EnergyLedger`].
pub struct EnergyLedgerPlugin;

impl Plugin for EnergyLedgerPlugin {
    fn build(&self, app: &mut App) {
        app.register_resource::<EnergyLedger>("energy_ledger");
        let renumber = renumber_released
            .run_if(resource_exists::<EnergyLedger>)
            .in_set(IncrementSystems::Renumber);
        let note = note_change
            .run_if(resource_exists::<EnergyLedger>)
            .run_if(not(resource_exists::<ClasticHalted>))
            .after(IncrementSystems::Gather)
            .before(IncrementSystems::Renumber);
        app.add_systems(Increment, (note, renumber)).add_systems(
            Increment,
            book_energies
                .run_if(resource_exists::<EnergyLedger>)
                .run_if(committed)
                .after(IncrementSystems::Rupture)
                .before(IncrementSystems::Record),
        );
    }
}

/// Notes that bodies have come or gone, until an increment is committed. Their elastic energy is
/// known only when the next program has its contacts.
fn note_change(rows: Res<KeptRows>, mut ledger: ResMut<EnergyLedger>) {
    if rows.has_lost() {
        ledger.changed = Changed::Went;
    } else if rows.has_changed() && ledger.changed == Changed::Nothing {
        ledger.changed = Changed::Came;
    }
}

/// Updates the rows of bodies.
fn renumber_released(rows: Res<KeptRows>, mut ledger: ResMut<EnergyLedger>) {
    rows.renumber(&mut ledger.released, |released| [&mut released.a, &mut released.b]);
}

/// A body after the increment.
struct BookedBody {
    row: usize,
    /// m.
    place: DVec2,
    /// Force and moment of the outside world, N, N, N m.
    force: [f64; 3],
    /// Velocity and angular velocity, m/s, m/s, rad/s; `None` of a wall or a rigid group.
    rates: Option<[f64; 3]>,
}

/// What the increment followed from, and what it left.
#[derive(SystemParam)]
pub struct BookedIncrement<'w> {
    tables: SolvedTables<'w>,
    materials: Res<'w, Materials>,
    analysis: Res<'w, ClasticAnalysis>,
    progress: Res<'w, ClasticProgress>,
    corrections: Res<'w, Corrections>,
    ruptures: Res<'w, Ruptures>,
    /// Memory of the contacts at the start, after a followed motion.
    draft: Res<'w, DraftHistory>,
    /// Memory of the contacts at the end.
    history: Res<'w, ContactHistory>,
    motion: Res<'w, MotionEnergies>,
}

/// Books the increment that was just committed.
pub fn book_energies(
    committed: BookedIncrement,
    after: Query<(
        &BodyId,
        &BodyPosition,
        &BodyExternalForce,
        Option<&BodyVelocity>,
        Option<&BodyAngularVelocity>,
    )>,
    mut ledger: ResMut<EnergyLedger>,
) {
    let BookedIncrement { materials, analysis, progress, ruptures, motion, .. } = &committed;
    let solved = committed.tables.get();
    let Solved { bodies, contacts, program, solution } = solved;
    if matches!(analysis.kind, AnalysisKind::Compaction { .. }) {
        // The forces of a compaction come from its regularisation.
        *ledger = EnergyLedger::default();
        return;
    }
    let mut rows: Vec<_> = after.iter().collect();
    rows.sort_unstable_by_key(|row| row.0);
    let row = |(id, x, force, v, spin): (&BodyId, &BodyPosition, &BodyExternalForce, _, _)| {
        let rates = |(v, spin): (&BodyVelocity, &BodyAngularVelocity)| [v.0.x, v.0.y, spin.0];
        let rates = Option::zip(v, spin).map(rates);
        Some(BookedBody { row: bodies.row(*id)?, place: x.0, force: force.0, rates })
    };
    let moved: Vec<BookedBody> = rows.into_iter().filter_map(row).collect();
    let mut end = bodies.positions.clone();
    for moved in &moved {
        end[moved.row] = moved.place;
    }
    let moved_cell = program.cell.map(|cell| {
        let row = cell.body as usize;
        program.bodies[row].to_global(solution.displacements[row])
    });
    let tables = Tables {
        solved,
        laws: Laws { bodies, materials, analysis },
        history: &committed.history,
        fraction: progress.fraction,
        corrections: &committed.corrections,
        end: &end,
        end_cell: bodies.deformed_cell(moved_cell),
        cell_loads: cell::loads(bodies, analysis, progress),
    };
    let mut e = Energies::default();
    let is_broken = |bond| ruptures.list.iter().any(|r| r.bond == bond);
    // Motions before the equilibrium were booked step by step.
    let before = Before::of(motion, &ledger);
    exchange_kinetic(&mut e, &tables, &moved, &mut ledger);
    let mut released = Vec::new();
    let mut release = |part: &Part| {
        if part.breaks {
            let contact = part.contact;
            let left = after_rupture(&tables, contact, part.forces);
            let forces = [0, 1, 2].map(|k| part.forces[k] - left[k]);
            released.push(Released { a: contact.a, b: contact.b, forces });
        }
    };
    let mut mean = None;
    let stored = if let AnalysisKind::Dynamic { dt, theta } = analysis.kind {
        let dt = dt * progress.fraction;
        let mean = &*mean.insert(book_bodies(&mut e, &tables, dt, theta, &moved));
        book(&mut e, &tables, &before, is_broken, |e, part| {
            release(part);
            dynamic::book(e, program, mean, part);
        })
    } else {
        // Forces that ended before a followed motion were booked in that motion.
        let ended = if motion.stored.is_some() { &[][..] } else { &ledger.released };
        let mut starts = Starts::new(&committed.draft.0, ended, &tables);
        let stored = book(&mut e, &tables, &before, is_broken, |e, part| {
            release(part);
            starts.book(e, &tables, part);
        });
        let is_jump = before.stored.is_none() || before.changed == Changed::Went;
        unbalanced::book(&mut e, &tables, &starts, is_jump);
        stored
    };
    // Interactions of an embedding program lie outside the specimen.
    let ties: Vec<_> = taut::ties(solved).map(|(_, tie)| tie).collect();
    for k in contacts.0.len()..program.interactions.len() {
        let (c, f) = (&program.interactions[k], &solution.forces[k]);
        let d = program.kinematics(c, &solution.displacements);
        let work = |d: [f64; 3]| f[0] * d[0] + f[1] * d[1] + f[2] * d[2];
        if ties.binary_search(&k).is_ok() {
            // The energy of the bond that the turn of its normal stores.
            e.turning += 0.5 * work(d);
            continue;
        }
        e.external -= work(d);
        if let Some(mean) = &mean {
            e.numerical += work(program.kinematics(c, mean)) - work(d);
        }
    }
    e += motion.energies;
    ledger.stored = Some(stored);
    ledger.changed = Changed::Nothing;
    ledger.released = released;
    ledger.increment = e;
    ledger.total += e;
}

/// Adds the kinetic energy that has come or gone since the last increment, and stores the present
/// value. Static increments do not change velocities.
fn exchange_kinetic(
    e: &mut Energies,
    tables: &Tables,
    moved: &[BookedBody],
    ledger: &mut EnergyLedger,
) {
    let bodies = tables.solved.bodies;
    let is_dynamic = matches!(tables.laws.analysis.kind, AnalysisKind::Dynamic { .. });
    let (mut start, mut end) = (0.0, 0.0);
    for &BookedBody { row: i, rates, .. } in moved {
        let Some(now) = rates else { continue };
        let of = |[x, y, spin]: [f64; 3]| {
            0.5 * bodies.masses[i] * (x * x + y * y) + 0.5 * bodies.inertias[i] * spin * spin
        };
        end += of(now);
        start += of(if is_dynamic { bodies.rates(i) } else { now });
    }
    let change = start - ledger.kinetic.unwrap_or(start);
    e.exchange += change;
    e.kinetic += change;
    ledger.kinetic = Some(end);
}
