//! Elastic energy and rupture of contacts and bonds, in an increment or a step of a motion.

use glam::DVec2;

use clastic_components::energy::Changed;
use clastic_components::prelude::*;
use clastic_cone::program::{Interaction, Kinematics};

use crate::contact_laws::{Laws, moment_after_rupture, shear_after_rupture};
use crate::solved::{Solved, SolvedContact};
use clastic_cone::residuals::{Multipliers, multipliers};

/// Tables of the increment or step: initial and final state.
pub struct Tables<'a> {
    pub solved: Solved<'a>,
    pub laws: Laws<'a>,
    /// Memory of the contacts at the end.
    pub history: &'a ContactHistory,
    /// Fraction of a whole increment.
    pub fraction: f64,
    pub corrections: &'a Corrections,
    /// Positions at the end, m.
    pub end: &'a [DVec2],
    /// The periodic cell at the end.
    pub end_cell: Option<PeriodicCell>,
    /// Loads of the body of the cell along its axes in a whole increment, N, N, N m.
    pub cell_loads: [Ramp; 3],
}

/// An interaction of the program with its stored energy.
pub struct Part<'a> {
    /// Index among the interactions.
    pub index: usize,
    pub contact: &'a Contact,
    pub law: &'a Interaction,
    /// (p, q, tau) of the program.
    pub forces: [f64; 3],
    pub kinematics: Kinematics,
    pub multipliers: Multipliers,
    /// Its dilation under the law of the solution.
    pub dilation: f64,
    /// Whether the interaction is a bond.
    pub is_bond: bool,
    /// Whether it is a bond that is broken at the end.
    pub breaks: bool,
    /// Normal gap relative to the stress-free state at the start, m.
    pub gap: f64,
    /// Elastic energy of the normal force, J: at the start, at the end with the normal of the
    /// program, and at the end.
    pub normal: [f64; 3],
    /// Elastic energy of the shear force at the start and at the end, J.
    pub shear: [f64; 2],
    /// Elastic energy of the rolling moment at the start and at the end, J.
    pub rolling: [f64; 2],
}

impl Part<'_> {
    /// Change of the elastic energy with the normal of the program, J: of normal force, shear force
    /// and rolling moment.
    pub fn change(&self) -> [f64; 3] {
        let [shear, rolling] = [self.shear, self.rolling].map(|[start, end]| end - start);
        [self.normal[1] - self.normal[0], shear, rolling]
    }

    /// Gap that sliding and rolling have opened by dilation, m.
    pub fn opened(&self) -> f64 {
        let (l, m) = (&self.law.limits, &self.multipliers);
        self.dilation * (l.friction * m.slip.abs() + l.rolling * m.rotation.abs())
    }

    /// Whether sliding or rolling can open the gap.
    pub fn dilates(&self) -> bool {
        self.dilation * (self.law.limits.friction + self.law.limits.rolling) > 0.0
    }

    /// Work of opening at the limit of a breaking bond, J.
    pub fn opening(&self) -> f64 {
        if self.breaks { -self.forces[0] * self.multipliers.tension } else { 0.0 }
    }
}

/// Initial state of an increment, or of a step of a motion.
pub struct Before {
    /// Elastic energy, J; `None` before the first increment.
    pub stored: Option<f64>,
    /// Bodies that have come or gone since that energy was computed.
    pub changed: Changed,
}

impl Before {
    /// The state after the motion that was followed so far, or after the last increment.
    pub fn of(motion: &MotionEnergies, ledger: &EnergyLedger) -> Self {
        match motion.stored {
            Some(stored) => Self { stored: Some(stored), changed: Changed::Nothing },
            None => Self { stored: ledger.stored, changed: ledger.changed },
        }
    }
}

/// Adds the change of the elastic energy and the dissipation of broken bonds. Every contact and
/// bond is passed to `work`. Returns the elastic energy at the end, J.
pub fn book(
    e: &mut Energies,
    tables: &Tables,
    before: &Before,
    is_broken: impl Fn(BondId) -> bool,
    mut work: impl FnMut(&mut Energies, &Part),
) -> f64 {
    let bonds = &tables.solved.bodies.bonds;
    // Three elastic energies: at the start and at the end by the law of the program, and at the end
    // by the law of the state. They differ if bonds break.
    let (mut starts, mut ends, mut state) = (0.0, 0.0, 0.0);
    for (index, solved) in tables.solved.contacts().enumerate() {
        let (contact, ..) = solved;
        let breaks = contact.bond.is_some_and(|k| is_broken(bonds[k as usize].id));
        let part = part(tables, index, solved, breaks);
        e.rupture += part.opening();
        work(e, &part);
        starts += part.normal[0] + part.shear[0] + part.rolling[0];
        let finish = part.normal[2] + part.shear[1] + part.rolling[1];
        ends += finish;
        state += if breaks {
            let law = tables.laws.contact(contact);
            let gap = gap_at(tables, contact);
            let memory = tables.history.get(contact.a, contact.b);
            let [q, tau] = memory.map_or([0.0; 2], |m| [m.q, m.tau]);
            pressed(law.normal_compliance, gap, false)
                + 0.5 * law.tangential_compliance * q * q
                + 0.5 * law.rolling_compliance * tau * tau
        } else {
            finish
        };
    }
    // The energies before and at the start differ if bodies have come or gone, or if bonds were
    // cemented between two increments.
    let changed = before.changed != Changed::Nothing;
    let before = before.stored.unwrap_or(starts);
    if changed {
        e.exchange += starts - before;
    } else {
        e.numerical += before - starts;
    }
    e.rupture += ends - state;
    e.elastic = state - before;
    state
}

fn part<'a>(
    tables: &Tables,
    index: usize,
    (contact, c, forces): SolvedContact<'a>,
    breaks: bool,
) -> Part<'a> {
    let (Solved { bodies, program, solution, .. }, corrections) =
        (tables.solved, tables.corrections);
    let theta = tables.laws.analysis.kind.theta();
    let kinematics = program.kinematics(c, &solution.displacements);
    let [p, q, tau] = *forces;
    let is_bond = contact.bond.is_some();
    let born = contact.bond.map_or(0.0, |k| bodies.bonds[k as usize].initial_gap);
    let start = contact.gap - born;
    // The offset of an elastic interaction is divided by theta. The remainder comes from the
    // corrections.
    let [_, lag] = corrections.shift(contact);
    let with_normal = start + (c.offset - start / theta - lag) - kinematics[0];
    let compliance = theta * c.normal_compliance;
    let normal = if breaks {
        // The stored energy follows from the force. Opening beyond it at the limit is dissipated.
        let at_limit = 0.5 * compliance * p * p;
        [pressed(compliance, start, true), at_limit, at_limit]
    } else {
        let end = gap_at(tables, contact) - born;
        [start, with_normal, end].map(|gap| pressed(compliance, gap, is_bond))
    };
    let tangential = theta * c.tangential_compliance;
    let shift = corrections.shear_shift((contact.a, contact.b), c.tangential_compliance);
    let sheared = c.previous_shear - shift;
    let twisted = c.previous_moment;
    let at_end = if breaks {
        [sheared + (q - sheared) / theta, twisted + (tau - twisted) / theta]
    } else {
        tables.history.get(contact.a, contact.b).map_or([0.0; 2], |m| [m.q, m.tau])
    };
    let rolling = theta * c.rolling_compliance;
    Part {
        index,
        contact,
        law: c,
        forces: *forces,
        kinematics,
        multipliers: multipliers(solution.law, c, &kinematics, forces),
        dilation: solution.law.dilation(c),
        is_bond,
        breaks,
        gap: start,
        normal,
        shear: [sheared, at_end[0]].map(|q| 0.5 * tangential * q * q),
        rolling: [twisted, at_end[1]].map(|tau| 0.5 * rolling * tau * tau),
    }
}

/// Gap of a contact at the end, m.
fn gap_at(tables: &Tables, contact: &Contact) -> f64 {
    let Solved { bodies, solution, .. } = tables.solved;
    let (a, b) = (contact.a as usize, contact.b as usize);
    let apart = tables.end[b] - tables.end[a];
    if let Some(radius) = bodies.radii.get(b) {
        let way = tables.end_cell.map_or(apart, |cell| apart + cell.shift(apart));
        return way.length() - bodies.radii[a] - radius;
    }
    let turned = solution.displacements.get(b).map_or(0.0, |u| u[2]);
    let distance = match bodies.wall(contact.b).filter(|wall| !wall.is_line() || turned != 0.0) {
        Some(wall) => wall.turned(turned).nearest(tables.end[b], tables.end[a]).distance,
        // The normal of a wall contact points from the particle to the wall.
        None => apart.dot(contact.normal),
    };
    distance - bodies.radii[a]
}

/// Elastic energy of the normal force at a gap relative to the stress-free state, J. A contact
/// carries compression only.
fn pressed(compliance: f64, gap: f64, pulls: bool) -> f64 {
    let overlap = if pulls { -gap } else { (-gap).max(0.0) };
    if compliance > 0.0 { 0.5 * overlap * overlap / compliance } else { 0.0 }
}

/// Forces of the contact after its bond has broken at the end, from the forces of the bond.
pub(crate) fn after_rupture(tables: &Tables, contact: &Contact, [p, q, tau]: [f64; 3]) -> [f64; 3] {
    let (law, gap) = (tables.laws.contact(contact), gap_at(tables, contact));
    let radius = contact.common_radius(tables.solved.bodies);
    let p = if law.normal_compliance > 0.0 {
        (-gap / law.normal_compliance).max(0.0)
    } else {
        p.max(0.0)
    };
    let tau = if law.rolling_compliance > 0.0 {
        moment_after_rupture(tau, gap, radius, &law)
    } else {
        let limit = law.rolling_friction * radius * p;
        tau.clamp(-limit, limit)
    };
    [p, shear_after_rupture(q, gap, &law), tau]
}
