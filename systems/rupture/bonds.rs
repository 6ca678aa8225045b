//! Rupture: bonds that reach one of their three limits break permanently (3.4.2 of the paper).
//!
//! A bond is at a limit if its slack is below [`RuptureRules::slack`] of the limit. A limit without
//! compliance (tension, shear and rolling of rigid bonds) may be reached by forces that are
//! not unique. The bond then breaks only if the multiplier is active, that is, if the bodies move
//! relative to each other. This relative motion must exceed [`RuptureRules::multiplier`]. Divided
//! by the maximum motion, it must also exceed the slack divided by the limit. At the apex of the
//! tension limit several limits are active, and tension is reported.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeSolution, Interaction, Limits};

use crate::contact_laws::{Laws, moment_after_rupture, shear_after_rupture};
use crate::schedule::{Increment, IncrementSystems, lap};
use crate::solved::{Solved, SolvedTables};
use clastic_cone::residuals::{Multipliers, displacement_scale, multipliers};

/// Adds [`rupture_bonds`]; it runs only where there are bonds.
pub struct RuptureBondsPlugin;

impl Plugin for RuptureBondsPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(BuiltInRule);
        app.init_resource::<Observation>().add_systems(
            Increment,
            (rupture_bonds.run_if(any_with_component::<Bond>), lap(|t| &mut t.rupture))
                .chain()
                .in_set(IncrementSystems::Rupture),
        );
    }
}

/// Marks a world whose bonds break by the rule of this file, in followed motions as well.
#[derive(Resource)]
pub(crate) struct BuiltInRule;

/// Criterion for reaching a limit that has a compliance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Met {
    /// The slack is below [`RuptureRules::slack`] of the limit. For exact solutions.
    Slack,
    /// The trial force, which a bond of unlimited strength would carry at this motion of its ends,
    /// exceeds the limit: `R = 1 + multiplier/(C limit) > 1`. For steps of a motion: their residual
    /// of 1e-3 makes the slack inaccurate. The larger of slack and overload, each in its own unit,
    /// decides, as for rigid bonds.
    Overload,
}

/// Bonds that the solution brings to a limit, in the order of the contacts.
pub(crate) fn find_ruptures(
    solved: Solved,
    rules: &RuptureRules,
    met: Met,
    increment: u64,
) -> Vec<Rupture> {
    let Solved { bodies, program, solution, .. } = solved;
    let maximum = displacement_scale(program, &solution.displacements);
    let bonds = solved.contacts().filter(|(contact, ..)| contact.bond.is_some());
    bonds
        .filter_map(|(contact, c, f)| {
            let e = program.kinematics(c, &solution.displacements);
            let m = multipliers(solution.law, c, &e, f);
            let mode = mode(rules, met, [program.scales.length, maximum], c, &m, f)?;
            rupture(increment, bodies, contact, f, mode)
        })
        .collect()
}

/// Rupture of the bond of a contact under these forces; `None` without a bond.
pub fn rupture(
    increment: u64,
    bodies: &BodyTable,
    contact: &Contact,
    [p, q, tau]: &[f64; 3],
    mode: RuptureMode,
) -> Option<Rupture> {
    let bond = &bodies.bonds[contact.bond? as usize];
    Some(Rupture {
        increment,
        bond: bond.id,
        a: bodies.ids[bond.a as usize],
        b: bodies.ids[bond.b as usize],
        mode,
        position: contact.point(bodies),
        normal: contact.normal,
        p: *p,
        q: *q,
        tau: *tau,
    })
}

/// Factor by which trials of the event search increase the strengths. As a power of two it can be
/// divided out without round-off.
pub(crate) const UNLIMITED: f64 = 8192.0;

/// Increases the strengths of intact bonds so that no trial reaches them. The limit of a yielding
/// rolling moment does not change.
pub fn lift_strengths(contacts: &[Contact], interactions: &mut [Interaction]) {
    for (contact, c) in contacts.iter().zip(interactions) {
        if contact.bond.is_some() {
            multiply(&mut c.limits, UNLIMITED);
        }
    }
}

/// Restores the strengths of bonds after a trial is accepted, so that the following judges use
/// them. An overloaded bond, which breaks in this increment or later in the avalanche, gets the
/// strength that its forces need.
pub(crate) fn restore_strengths(found: &[Overload], interactions: &mut [Interaction]) {
    for overload in found {
        let needed = overload.value.max(1.0);
        multiply(&mut interactions[overload.contact].limits, needed / UNLIMITED);
    }
}

fn multiply(limits: &mut Limits, factor: f64) {
    limits.cohesion *= factor;
    limits.tension *= factor;
}

/// The overload of a bond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overload {
    /// Index of the bond's contact.
    pub contact: usize,
    /// The overload R.
    pub value: f64,
    /// The limit with the maximum overload.
    pub mode: RuptureMode,
}

/// The overload R of every intact bond of a program with [increased](lift_strengths) strengths. R
/// is the factor on cohesion and tensile strength that puts the forces of the bond on its limit,
/// ```text
/// R = max( -p'/f_t,  (|q| - mu p)/(c A) )
/// ```
///
/// R <= 1 if all limits hold, because one factor scales both. If a yielding rolling limit keeps p
/// above -f_t, p' is the normal force without this limit, `p - lambda_T/C_N`.
pub fn overloads(solved: Solved, factor: f64) -> Vec<Overload> {
    let Solved { program, solution, .. } = solved;
    let is_complete = solution.displacements.len() == program.bodies.len();
    let bonds = solved.contacts().enumerate().filter(|(_, (contact, ..))| contact.bond.is_some());
    bonds
        .map(|(contact, (_, c, f))| {
            let l = &c.limits;
            let [p, q, _] = *f;
            let beyond = if is_complete && l.has_rolling() {
                let e = program.kinematics(c, &solution.displacements);
                multipliers(solution.law, c, &e, f).tension.max(0.0) / c.normal_compliance
            } else {
                0.0
            };
            let tension = factor * (beyond - p) / l.tension;
            let shear = factor * (q.abs() - l.friction * p) / l.cohesion;
            let (value, mode) = if shear > tension {
                (shear, RuptureMode::Shear)
            } else {
                (tension, RuptureMode::Tension)
            };
            Overload { contact, value, mode }
        })
        .collect()
}

/// The overloads R at the start of the increment, by the forces after the last one.
pub(crate) fn overloads_at_start(solved: Solved, factor: f64) -> Vec<Overload> {
    let mut forces = solved.program.last_forces.clone();
    forces.resize(solved.program.interactions.len(), [0.0; 3]);
    let start = ConeSolution { forces, ..ConeSolution::default() };
    overloads(Solved { solution: &start, ..solved }, factor)
}

/// The contact whose bond has the maximum overload R, of the bonds that yield in a program with
/// their own strengths: `R = 1 + multiplier/(C limit)`. `None` if no bond yields.
pub(crate) fn most_yielding(solved: Solved) -> Option<(usize, f64)> {
    let Solved { program, solution, .. } = solved;
    let bonds = solved.contacts().enumerate().filter(|(_, (contact, ..))| contact.bond.is_some());
    let overloads = bonds.map(|(k, (_, c, f))| {
        let m = multipliers(solution.law, c, &program.kinematics(c, &solution.displacements), f);
        let l = &c.limits;
        let tension = m.tension / (c.normal_compliance * l.tension);
        let shear = m.slip.abs() / (c.tangential_compliance * (l.cohesion + l.friction * f[0]));
        // 0/0 of rigid bonds counts as no overload.
        (k, 1.0_f64.max(1.0 + tension).max(1.0 + shear))
    });
    overloads.filter(|(_, overload)| *overload > 1.0).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The limit that an intact bond has reached.
fn mode(
    rules: &RuptureRules,
    how: Met,
    [length, maximum]: [f64; 2],
    c: &Interaction,
    m: &Multipliers,
    f: &[f64; 3],
) -> Option<RuptureMode> {
    let l = &c.limits;
    let [p, q, tau] = *f;
    let moves = rules.multiplier * length;
    // Without compliance a solver makes the product of slack and multiplier small, so the larger of
    // the two decides.
    let met = |slack: f64, limit: f64, compliance: f64, multiplier: f64| {
        if compliance > 0.0 && how == Met::Slack {
            slack <= rules.slack * limit
        } else {
            multiplier > moves && slack * maximum <= multiplier * limit
        }
    };

    let reachable = l.tension > 0.0 && l.min_normal_force() <= -l.tension;
    if reachable && met(p + l.tension, l.tension, c.normal_compliance, m.tension) {
        return Some(RuptureMode::Tension);
    }
    let shear = l.cohesion + l.friction * p;
    let most = l.cohesion + l.friction * p.abs();
    // A bond that opens at the apex of the shear limit does not slip.
    let apex = if shear <= rules.slack * most { m.tension } else { 0.0 };
    let slips = m.slip.abs().max(apex);
    if l.has_shear() && met(shear - q.abs(), most, c.tangential_compliance, slips) {
        return Some(RuptureMode::Shear);
    }
    let roll = l.moment + l.rolling * p;
    let most = l.moment + l.rolling * p.abs();
    let breaks = rules.rolling == RollingLimit::Breaks && l.has_rolling();
    let rolls =
        breaks && met(roll - tau.abs(), most, c.rolling_compliance, length * m.rotation.abs());
    rolls.then_some(RuptureMode::Rolling)
}

/// Collects the bonds on a limit at the end of an increment, which break together where no
/// [event](super::events) is sought. It is the last word on an accepted attempt and objects to none.
pub fn collect(
    rules: Res<RuptureRules>,
    progress: Res<ClasticProgress>,
    tables: SolvedTables,
    mut ruptures: ResMut<Ruptures>,
) {
    let found = find_ruptures(tables.get(), &rules, Met::Slack, progress.increment);
    ruptures.list.extend(found);
}

/// Breaks the bonds that the accepted attempt brought to a limit. Their contacts keep the shear
/// force that friction can carry.
pub fn rupture_bonds(
    ruptures: Res<Ruptures>,
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    materials: Res<Materials>,
    analysis: Res<ClasticAnalysis>,
    mut history: ResMut<ContactHistory>,
    mut record: ResMut<Observation>,
    mut bonds: Query<&mut BondState>,
) {
    for rupture in &ruptures.list {
        let Some(bond) = bodies.bonds.iter().chain(&bodies.broken).find(|b| b.id == rupture.bond)
        else {
            continue;
        };
        if let Ok(mut state) = bonds.get_mut(bond.entity) {
            *state = BondState::Broken(rupture.mode);
        }
        record.ruptures.push(*rupture);
    }
    // Bonds that broke in a followed motion have lost their shear force already.
    let last = ruptures.list.iter().skip(ruptures.on_the_way);
    let laws = Laws { bodies: &bodies, materials: &materials, analysis: &analysis };
    release(last, laws, &contacts, &mut history);
}

/// Reduces the shear force in contacts of broken bonds, and the moment of those that roll
/// elastically, to what friction can carry.
pub fn release<'a>(
    ruptures: impl Iterator<Item = &'a Rupture>,
    laws: Laws,
    contacts: &ContactTable,
    history: &mut ContactHistory,
) {
    for rupture in ruptures {
        let row = |id| laws.bodies.row(id).map(|row| row as u32);
        let (Some(a), Some(b)) = (row(rupture.a), row(rupture.b)) else { continue };
        let key = (a, b);
        let contact = contacts.0.binary_search_by_key(&key, |c| (c.a, c.b));
        let memory = history.0.binary_search_by_key(&key, |m| (m.a, m.b));
        if let (Ok(c), Ok(m)) = (contact, memory) {
            let contact = &contacts.0[c];
            let law = laws.contact(contact);
            let memory = &mut history.0[m];
            memory.q = shear_after_rupture(memory.q, contact.gap, &law);
            if law.rolling_compliance > 0.0 {
                let radius = contact.common_radius(laws.bodies);
                memory.tau = moment_after_rupture(memory.tau, contact.gap, radius, &law);
            }
        }
    }
}
