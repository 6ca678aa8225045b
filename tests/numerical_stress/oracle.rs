//! An independent check of committed increments: geometry from the positions, laws from the scene,
//! balance, limits and kinematics from the forces and the motion that happened. From the tables of
//! the engine it takes the forces and the state at the start of an increment (shear history,
//! openings).

use std::collections::BTreeMap;
use std::fmt;

use clastic::components::attempt::{Attempt, IncrementStatus};
use clastic::components::body::{
    BodyDrive, BodyDrives, BodyExternalForce, BodyId, BodyPosition, LastMotion,
};
use clastic::components::bond::{Bond, BondState};
use clastic::components::contact::{BodyTable, ContactTable};
use clastic::components::findings::{Corrections, Pushed, Sliding};
use clastic::components::increment::{AnalysisKind, ClasticAnalysis};
use clastic::components::observation::Observation;
use clastic::components::particle::{MaterialIndex, Particle};
use clastic::components::wall::{Wall, WallControl};
use clastic::cone::program::{ConeProgram, ConeSolution, Dof, Limits};
use clastic::run::Simulation;
use clastic::scene::format::{Bond as BondLaw, Contact as ContactLaw, FrictionLaw, Scene, Stage};
use glam::DVec2;

use crate::common::{State, states};

/// Bounds of the residuals, and the round-off of computing them in another way.
const RESIDUAL: f64 = 1e-8;
const SECOND_WAY: f64 = 1.001;
const ROUND_OFF: f64 = 1e-12;

/// The maximum of each error, and the errors beyond their bounds.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    pub complaints: Vec<String>,
    pub worst: BTreeMap<&'static str, f64>,
}

impl Findings {
    /// Books an error; complains where it is above `accepted` or not a number.
    fn book(&mut self, name: &'static str, error: f64, accepted: f64, increment: u64) {
        let worst = self.worst.entry(name).or_default();
        if !(error <= *worst) {
            *worst = error;
        }
        if !(error <= accepted) && self.complaints.len() < 10 {
            self.complaints
                .push(format!("increment {increment}: {name} {error:.2e} > {accepted:.1e}"));
        }
    }

    /// Books the error of the energy ledger over its bound.
    pub fn energy(&mut self, error: f64, increment: u64) {
        self.book("energy over accepted", error, 1.0, increment);
    }

    fn complain(&mut self, increment: u64, what: String) {
        if self.complaints.len() < 10 {
            self.complaints.push(format!("increment {increment}: {what}"));
        }
    }

    pub fn merge(&mut self, other: &Self) {
        for (name, error) in &other.worst {
            let worst = self.worst.entry(name).or_default();
            if !(error <= worst) {
                *worst = *error;
            }
        }
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.worst.iter().try_for_each(|(name, error)| write!(f, "{name} {error:.2e}; "))
    }
}

/// The state before an increment.
pub struct Oracle {
    particles: Vec<State>,
    walls: BTreeMap<u32, DVec2>,
    /// A compaction ends at rest.
    compacting: bool,
}

/// A body in the middle of the check.
#[derive(Debug)]
struct Body {
    start: DVec2,
    motion: [f64; 3],
    radius: f64,
}

fn wall_positions(simulation: &mut Simulation) -> BTreeMap<u32, DVec2> {
    let world = simulation.world_mut();
    let mut query = world.query::<(&BodyId, &Wall, &BodyPosition)>();
    query.iter(world).map(|(id, _, x)| (id.0, x.0)).collect()
}

impl Oracle {
    pub fn before(simulation: &mut Simulation, scene: &Scene) -> Self {
        let kind = simulation.world().resource::<ClasticAnalysis>().kind;
        // A compaction takes all velocities away, even one that is at its target and has no
        // increment.
        let begins = simulation.world().resource::<Observation>().increment == 0
            && matches!(scene.stages.first(), Some(Stage::Compact(_)));
        let compacting = begins || matches!(kind, AnalysisKind::Compaction { .. });
        Self { particles: states(simulation), walls: wall_positions(simulation), compacting }
    }

    pub fn after(
        &self,
        simulation: &mut Simulation,
        scene: &Scene,
        record: &Observation,
        findings: &mut Findings,
    ) {
        let n = record.increment;
        let now = states(simulation);
        let finite = |s: &State| {
            s.position.is_finite()
                && s.velocity.is_finite()
                && s.rotation.is_finite()
                && s.spin.is_finite()
        };
        if !now.iter().all(finite) {
            findings.complain(n, "a state that is not finite".into());
        }
        if !record.kinetic_energy.is_finite() {
            findings.complain(n, format!("kinetic energy {}", record.kinetic_energy));
        }
        if matches!(record.status, IncrementStatus::Solved | IncrementStatus::Capped) {
            // A body this far away was thrown by a wrong solution.
            let far = |x: DVec2| !(x.length() < 1e6);
            if now.iter().any(|s| far(s.position))
                || wall_positions(simulation).values().any(|x| far(*x))
            {
                findings.complain(n, "a body further than 1000 km away".into());
            }
            let capped = record.status == IncrementStatus::Capped;
            let limit = if capped { Sliding::BOUND } else { RESIDUAL };
            findings.book("reported residual", record.residuals.worst(), limit, n);
            // A pass takes normals and gaps at the end of the increment, and the oracle knows those
            // at its start. Such increments are checked by residuals, ledger and finite numbers
            // only.
            let passes = simulation.world().resource::<Corrections>().passes;
            if passes == 0 {
                self.check_committed(simulation, scene, record, &now, findings);
            }
        } else {
            let walls = wall_positions(simulation);
            let unmoved = self.walls.iter().all(|(id, x)| walls.get(id).is_none_or(|y| x == y));
            let same =
                |(a, b): (&State, &State)| a.position == b.position && a.rotation == b.rotation;
            if !unmoved || !now.iter().zip(&self.particles).all(same) {
                findings.complain(n, format!("{} committed a motion", record.status.name()));
            }
        }
    }

    /// Checks a committed increment against laws and balance, to the accepted residual, or to the
    /// reported residual of a capped increment.
    fn check_committed(
        &self,
        simulation: &mut Simulation,
        scene: &Scene,
        record: &Observation,
        now: &[State],
        findings: &mut Findings,
    ) {
        let n = record.increment;
        let residual = RESIDUAL.max(record.residuals.worst());
        let world = simulation.world_mut();
        let analysis = *world.resource::<ClasticAnalysis>();
        let motion_steps = world.resource::<Attempt>().motion_steps;
        let is_pushed = world.resource::<Pushed>().0.is_some();
        let corrections = world.resource::<Corrections>().clone();
        let mut program = world.resource::<ConeProgram>().clone();
        let forces = world.resource::<ConeSolution>().forces.clone();
        let mut contacts = world.resource::<ContactTable>().0.clone();
        // Rows of the tables become identities.
        let ids = world.resource::<BodyTable>().ids.clone();
        let row = |id: u32| ids.iter().position(|found| found.0 == id).unwrap();
        for c in &mut program.interactions {
            (c.a, c.b) = (ids[c.a as usize].0, ids[c.b as usize].0);
        }
        for c in &mut contacts {
            (c.a, c.b) = (ids[c.a as usize].0, ids[c.b as usize].0);
        }
        let fraction = world.resource::<Observation>().fraction;
        let (dynamic, dt, theta) = match analysis.kind {
            AnalysisKind::Dynamic { dt, theta } => (true, dt * fraction, theta),
            _ => (false, 0.0, 1.0),
        };
        let is_compaction = matches!(analysis.kind, AnalysisKind::Compaction { .. });
        let coulomb = match scene.friction_law {
            FrictionLaw::Associated => false,
            FrictionLaw::ByAnalysis => dynamic,
            FrictionLaw::Coulomb { .. } => true,
        };

        // Where bodies came from.
        let mut bodies: BTreeMap<u32, Body> = BTreeMap::new();
        let mut query = world.query::<(&BodyId, &BodyPosition, &LastMotion, Option<&Particle>)>();
        for (id, x, u, particle) in query.iter(world) {
            let start = x.0 - DVec2::new(u.0[0], u.0[1]);
            let radius = particle.map_or(0.0, |p| p.radius);
            bodies.insert(id.0, Body { start, motion: u.0, radius });
        }
        let mean_radius = if now.is_empty() {
            1.0
        } else {
            now.iter().map(|s| s.radius).sum::<f64>() / now.len() as f64
        };
        let extent = bodies.values().map(|b| b.start.length()).fold(mean_radius, f64::max);
        let furthest = bodies.values().map(|b| b.motion[0].hypot(b.motion[1])).fold(0.0, f64::max);
        let bits = ROUND_OFF * extent.max(furthest);
        if motion_steps == 0 {
            for (i, before) in self.particles.iter().enumerate() {
                let moved = before.position.distance(bodies[&(i as u32)].start);
                findings.book("place at the start, m", moved, bits, n);
            }
        }
        let mut query = world.query::<(&BodyId, &Wall)>();
        let inward: BTreeMap<u32, DVec2> =
            query.iter(world).map(|(id, wall)| (id.0, wall.inward())).collect();
        let mut query = world.query::<(&Bond, &BondState)>();
        let bonds: BTreeMap<(u32, u32), (f64, bool)> = query
            .iter(world)
            .map(|(b, state)| ((b.a.0, b.b.0), (b.initial_gap, *state == BondState::Intact)))
            .collect();
        let mut query = world.query::<(&BodyId, &MaterialIndex)>();
        let mut materials: Vec<_> = query.iter(world).map(|(id, m)| (id.0, m.0)).collect();
        materials.sort_unstable();
        let law = |i: u32| scene.materials.values().nth(materials[i as usize].1 as usize).unwrap();

        // Scales of the errors.
        let max_motion = bodies
            .values()
            .map(|b| b.motion[0].hypot(b.motion[1]))
            .fold(1e-6 * mean_radius, f64::max)
            .min(mean_radius);
        let mut query = world.query::<(&BodyId, &BodyDrives, &BodyExternalForce)>();
        let outside: BTreeMap<u32, ([BodyDrive; 3], [f64; 3])> =
            query.iter(world).map(|(id, d, f)| (id.0, (d.0, f.0))).collect();
        // Displacement of a free particle under the loads, where bodies were in motion.
        let free_motion = now
            .iter()
            .enumerate()
            .filter(|_| dynamic && program.has_momentum())
            .map(|(i, s)| {
                let (drives, external) = outside[&(i as u32)];
                let load = |k: usize| match drives[k] {
                    BodyDrive::Free => external[k] + s.mass * analysis.gravity[k],
                    BodyDrive::Imposed(_) => 0.0,
                };
                load(0).hypot(load(1)) * theta * dt * dt / s.mass
            })
            .filter(|motion| *motion > 0.0)
            .fold(f64::INFINITY, f64::min);
        let free_motion = if free_motion.is_finite() { free_motion.min(mean_radius) } else { 0.0 };
        // A force between bodies that are both held along its direction is not unique.
        let feels = |id: u32, direction: DVec2| match outside.get(&id) {
            Some((drives, _)) => {
                (0..2).any(|k| drives[k] == BodyDrive::Free && direction[k].abs() > 1e-9)
            }
            None => matches!(program.bodies[row(id)].dofs[0], Dof::Free(_)),
        };
        let loads = program.bodies.iter().flat_map(|b| &b.dofs[..2]).map(|dof| match dof {
            Dof::Free(free) => free.load.abs(),
            Dof::Fixed(_) => 0.0,
        });
        let mut contact_force = loads.fold(1e-2 * program.scales.force, f64::max);
        for (contact, f) in contacts.iter().zip(&forces) {
            for (direction, f) in [(contact.normal, f[0]), (contact.normal.perp(), f[1])] {
                if feels(contact.a, direction) || feels(contact.b, direction) {
                    contact_force = contact_force.max(f.abs());
                }
            }
        }
        let mut force = contact_force;
        let mut resist: BTreeMap<u32, [f64; 3]> = bodies.keys().map(|id| (*id, [0.0; 3])).collect();

        // Restoring force of taut bonds: their tension at the start, or that of the pass before, turned with
        // their axis.
        for (c, f) in program.interactions.iter().zip(&forces).skip(contacts.len()) {
            let (a, b) = (&bodies[&c.a], &bodies[&c.b]);
            let d = b.start - a.start;
            let laws = law(c.a).bond.zip(law(c.b).bond).filter(|_| bonds.contains_key(&(c.a, c.b)));
            let Some((la, lb)) = laws else {
                findings.complain(n, format!("a tie of {} and {} without a bond", c.a, c.b));
                continue;
            };
            let bond = between_bonds(la, lb);
            let strength = 2.0 * a.radius.min(b.radius) * scene.thickness * bond.tensile_strength;
            let k = contacts.iter().position(|contact| (contact.a, contact.b) == (c.a, c.b));
            let last = -k.map_or(0.0, |k| program.last_forces[k][0]);
            let pair = (row(c.a) as u32, row(c.b) as u32);
            let tension = corrections.of(pair).map_or(last, |guess| guess.tension).min(strength);
            let along = d.normalize().perp();
            let moved = DVec2::new(a.motion[0] - b.motion[0], a.motion[1] - b.motion[1]);
            let expected = (tension / d.length() * moved.dot(along)).max(-tension);
            let error = (f[0] * c.normal.dot(along) - expected).abs() / contact_force;
            findings.book("taut bond", error, 1e2 * residual, n);
            for (id, sign) in [(c.a, 1.0), (c.b, -1.0)] {
                let r = resist.get_mut(&id).unwrap();
                r[0] += sign * c.normal.x * f[0];
                r[1] += sign * c.normal.y * f[0];
            }
        }

        for ((contact, f), c) in contacts.iter().zip(&forces).zip(&program.interactions) {
            let (a, b) = (&bodies[&contact.a], &bodies[&contact.b]);
            let wall = inward.get(&contact.b);
            let (normal, gap) = match wall {
                Some(inward) => (-*inward, (a.start - b.start).dot(*inward) - a.radius),
                None => {
                    let d = b.start - a.start;
                    let normal = if d.length() > 0.0 { d.normalize() } else { DVec2::X };
                    (normal, d.length() - a.radius - b.radius)
                }
            };
            findings.book("gap, m", (gap - contact.gap).abs(), 4.0 * bits, n);
            // Coincident centres have any normal.
            if a.start.distance(b.start) > 1e-3 * mean_radius {
                let turned = normal.distance(contact.normal) * mean_radius;
                findings.book("normal", turned / bits, 1e4, n);
            }
            let tangent = contact.normal.perp();
            let normal = contact.normal;
            let arms =
                [a.radius + 0.5 * gap, if wall.is_some() { 0.0 } else { b.radius + 0.5 * gap }];
            let [p, q, tau] = *f;
            for (id, sign, arm) in [(contact.a, 1.0, arms[0]), (contact.b, -1.0, arms[1])] {
                let g = (normal * p + tangent * q) * sign;
                let r = resist.get_mut(&id).unwrap();
                r[0] += g.x;
                r[1] += g.y;
                r[2] += arm * q + sign * tau;
            }
            // A motion that separates overlaps does not follow from forces.
            if is_compaction || is_pushed {
                continue;
            }

            // The law, from the scene.
            let radius = if wall.is_some() { a.radius } else { a.radius.min(b.radius) };
            let key = (contact.a, contact.b);
            let other = |id: u32| wall.is_none().then(|| law(id));
            let area = 2.0 * radius * scene.thickness;
            let as_bond = bonds.get(&key).map(|(born, _)| {
                let la = law(contact.a).bond;
                let lb = other(contact.b).map_or(la, |m| m.bond);
                // A bond to a wall has the law of the wall, or that of the particle's material.
                let own = (contact.b as usize)
                    .checked_sub(materials.len())
                    .and_then(|wall| scene.walls[wall].bond);
                let of_pair = || {
                    let on = |bond: BondLaw, of: u32| on_contact(bond, law(of).contact);
                    let lb =
                        lb.map(
                            |lb| if wall.is_none() { on(lb, contact.b) } else { on(lb, contact.a) },
                        );
                    between_bonds(on(la.unwrap(), contact.a), lb.unwrap())
                };
                let wall = (contact.b as usize).checked_sub(materials.len());
                let bond = own.unwrap_or_else(of_pair);
                let bond = wall.map_or(bond, |wall| on_contact(bond, scene.walls[wall].contact));
                let limits = [
                    bond.cohesion * area,
                    bond.friction,
                    bond.tensile_strength * area,
                    bond.rolling_friction * radius,
                ];
                let stiffness = compliances([
                    bond.normal_stiffness,
                    bond.tangential_stiffness,
                    bond.rolling_stiffness,
                ]);
                (stiffness, limits, gap - born)
            });
            let as_contact = {
                let la = law(contact.a).contact;
                let contact_law = match other(contact.b) {
                    Some(material) => between_contacts(la, material.contact),
                    None => scene.walls[(contact.b - materials.len() as u32) as usize].contact,
                };
                let limits =
                    [0.0, contact_law.friction, 0.0, contact_law.rolling_friction * radius];
                let stiffness = compliances([
                    contact_law.normal_stiffness,
                    contact_law.tangential_stiffness,
                    contact_law.rolling_stiffness,
                ]);
                (stiffness, limits, gap)
            };
            // Two bodies with imposed motions that do not close: no solution can remove their
            // overlap.
            let is_driven = |id: u32| {
                let dofs = &program.bodies[row(id)].dofs[..2];
                dofs.iter().all(|dof| matches!(dof, Dof::Fixed(_)))
            };
            let apart =
                normal.dot(DVec2::new(b.motion[0] - a.motion[0], b.motion[1] - a.motion[1]));
            if c.limits == Limits::default()
                && c.normal_compliance == 0.0
                && gap < 0.0
                && is_driven(contact.a)
                && is_driven(contact.b)
                && apart >= -1e-9 * mean_radius
            {
                findings.book("limit", p.hypot(q) / contact_force, residual * SECOND_WAY, n);
                continue;
            }
            let l = &c.limits;
            let listed = [l.cohesion, l.friction, l.tension, l.rolling];
            // A bond above its limit has the strength that it needed: it breaks now, or later in an
            // avalanche.
            let breaks = record.ruptures.iter().any(|r| (r.a.0, r.b.0) == key);
            let is_listed = |limits: &[f64; 4]| {
                let needed = if breaks || record.in_avalanche {
                    (listed[2] / limits[2]).max(1.0)
                } else {
                    1.0
                };
                let times = [needed, 1.0, needed, 1.0];
                let limits = [0, 1, 2, 3].map(|k| times[k] * limits[k]);
                limits.iter().zip(listed).all(|(x, y)| (x - y).abs() <= 1e-12 * y.abs())
            };
            let bonded = match bonds.get(&key) {
                Some((_, true)) => true,
                // Broken in this increment, before or after its last solve; or long ago.
                Some((_, false)) => {
                    record.ruptures.iter().any(|r| (r.a.0, r.b.0) == key)
                        && as_bond.is_some_and(|bond| {
                            let offset = if bond.0[0] > 0.0 { bond.2 / theta } else { bond.2 };
                            is_listed(&bond.1) && (offset - c.offset).abs() <= 4.0 * bits / theta
                        })
                }
                None => false,
            };
            let ([cn, ct, cr], limits, offset) = if bonded { as_bond.unwrap() } else { as_contact };
            if !is_listed(&limits) {
                findings.complain(n, format!("limits {listed:?} instead of {limits:?}"));
            }
            let strength = limits[2];
            let [cohesion, friction, tension, rolling] = listed;
            let dilation = if l.has_strength() || !coulomb { 1.0 } else { 0.0 };

            let shear = cohesion + friction * p;
            let roll = rolling * (p + strength);
            let limit = residual * SECOND_WAY;
            findings.book("limit", (-(p + tension) / contact_force).max(0.0), limit, n);
            findings.book("limit", (q.abs() - shear.max(0.0)) / contact_force, limit, n);
            let over = (tau.abs() - roll.max(0.0)) / (contact_force * mean_radius);
            findings.book("limit", over, limit, n);

            // Kinematics of the motion that happened; elastic interactions hold the average of the
            // increment.
            let relative = DVec2::new(a.motion[0] - b.motion[0], a.motion[1] - b.motion[1]);
            let closing = normal.dot(relative);
            let spin_b = if wall.is_some() { 0.0 } else { b.motion[2] };
            let slip = tangent.dot(relative) + arms[0] * a.motion[2] + arms[1] * spin_b;
            let turn = a.motion[2] - spin_b;
            let slides = cohesion > 0.0 || friction > 0.0;
            let plastic = if slides { slip - ct / theta * (q - c.previous_shear) } else { 0.0 };
            let twist = cr / theta * (tau - c.previous_moment);
            let rolls = if rolling > 0.0 { turn - twist } else { 0.0 };
            let start = if cn > 0.0 { offset / theta } else { offset };
            // Section 4 of the formulation: in static increments an overlap of rigid bodies below
            // this is round-off of the last increment.
            let left = -1e-9 * mean_radius..0.0;
            let start = if cn == 0.0 && !dynamic && !is_compaction && left.contains(&start) {
                0.0
            } else {
                start
            };
            let rest = start + cn / theta * p
                - closing
                - dilation * (friction * plastic.abs() + rolling * rolls.abs());
            // Section 10 of the formulation: rigid bodies near rest.
            let unit = if cn == 0.0 { max_motion.max(free_motion) } else { max_motion };
            let name = if dynamic { "closing (dynamic)" } else { "closing (static)" };
            let accepted = limit + 10.0 * bits / unit;
            if std::env::var_os("CLASTIC_SEED").is_some() && -rest / unit > accepted {
                println!(
                    "{contact:?} {c:?} {f:?} {closing} {plastic} {rolls} {dilation} {offset} {cn} {a:?} {b:?} U {unit} motion steps {motion_steps}",
                );
            }
            findings.book(name, (-rest / unit).max(0.0), accepted, n);
            let apex = if friction > 0.0 { cohesion / friction } else { f64::INFINITY };
            // A bond above its limit does not go beyond the point at which its rolling moment
            // vanishes.
            let apex = if rolling > 0.0 { apex.min(strength) } else { apex };
            // Distance from a limit above the maximum force.
            let above = ((p + tension.min(apex)).abs() / contact_force).min(1.0);
            let name =
                if dynamic { "complementarity (dynamic)" } else { "complementarity (static)" };
            findings.book(name, above * rest.max(0.0) / unit, accepted, n);
            let slack = ((shear - q * plastic.signum()).abs() / contact_force).min(1.0);
            findings.book(name, slack * plastic.abs() / unit, accepted, n);
            let most = mean_radius * contact_force;
            let slack = (roll - tau * rolls.signum()).abs().min(most) / contact_force;
            findings.book(name, slack * rolls.abs() / unit, accepted, n);
        }

        // Balance of every particle that is free to move.
        let (mut defects, mut turning) = (Vec::new(), 0.0_f64);
        for body in &program.bodies[now.len()..] {
            if let Dof::Free(wall) = body.dofs[0] {
                force = force.max(wall.load.abs());
            }
        }
        for (i, s) in now.iter().enumerate() {
            let id = i as u32;
            let (drives, external) = outside[&id];
            let mut before = self.particles[i];
            if self.compacting {
                (before.velocity, before.spin) = (DVec2::ZERO, 0.0);
            }
            for k in 0..3 {
                if drives[k] != BodyDrive::Free || is_compaction {
                    continue;
                }
                let mass = if k < 2 { s.mass } else { s.inertia };
                let weight = if k < 2 { s.mass * analysis.gravity[k] } else { 0.0 };
                let (v0, v1) =
                    if k < 2 { (before.velocity[k], s.velocity[k]) } else { (before.spin, s.spin) };
                let inertial = if dynamic { mass * (v1 - v0) / dt } else { 0.0 };
                let load = external[k] + weight;
                if k < 2 {
                    let carried = if dynamic { mass * v0.abs() / (theta * dt) } else { 0.0 };
                    force = force.max(load.abs()).max(carried);
                }
                let unit = if k < 2 { 1.0 } else { mean_radius };
                if k == 2 && dynamic {
                    turning =
                        turning.max(mass * v0.abs().max(v1.abs()) / (theta * dt) / mean_radius);
                }
                defects.push((inertial + resist[&id][k] - load) / unit);
            }
        }
        let name = if dynamic { "balance (dynamic)" } else { "balance (static)" };
        for defect in defects {
            // In dynamics the motion follows from the forces, to round-off.
            let accepted = if dynamic { 1e-11 } else { residual * SECOND_WAY };
            let unit = if dynamic { force.max(turning) } else { force };
            findings.book(name, defect.abs() / unit, accepted, n);
        }
        let mut query = world.query::<(&BodyId, &Wall, &WallControl, &BodyExternalForce)>();
        for (id, wall, control, external) in query.iter(world) {
            let loaded = matches!(control, WallControl::Force { .. } | WallControl::Stress { .. });
            if loaded && !is_compaction {
                // Its force is the sum of the forces of its contacts, whatever its control.
                let sum = DVec2::new(resist[&id.0][0], resist[&id.0][1]);
                let given = DVec2::new(external.0[0], external.0[1]);
                let off = (sum - given).dot(wall.inward()).abs() / force;
                findings.book("force of a wall", off, ROUND_OFF, n);
            }
        }

        // Rigid, unbonded pairs do not overlap at the end, whether in the program or not.
        let rigid_pair = |a: u32, b: u32| {
            let (la, lb) = (law(a).contact, law(b).contact);
            is_compaction || (la.normal_stiffness.is_none() && lb.normal_stiffness.is_none())
        };
        for a in 0..now.len() as u32 {
            let x = now[a as usize].position;
            for b in 0..a {
                let overlap = now[a as usize].radius + now[b as usize].radius
                    - x.distance(now[b as usize].position);
                let joined = bonds.get(&(b, a)).is_some_and(|bond| bond.1)
                    || record.ruptures.iter().any(|r| (r.a.0, r.b.0) == (b, a));
                let held = |i: u32| outside[&i].0[..2].iter().any(|d| *d != BodyDrive::Free);
                let free = !held(a) || !held(b);
                if free && rigid_pair(a, b) && !joined {
                    findings.book("overlap of rigid disks, radii", overlap / mean_radius, 2e-6, n);
                }
            }
        }
    }
}

fn compliances(stiffnesses: [Option<f64>; 3]) -> [f64; 3] {
    stiffnesses.map(|stiffness| stiffness.map_or(0.0, f64::recip))
}

/// Springs in series.
fn series(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    let c = 0.5 * (a.map_or(0.0, f64::recip) + b.map_or(0.0, f64::recip));
    (c > 0.0).then(|| 1.0 / c)
}

fn between_contacts(a: ContactLaw, b: ContactLaw) -> ContactLaw {
    ContactLaw {
        normal_stiffness: series(a.normal_stiffness, b.normal_stiffness),
        tangential_stiffness: series(a.tangential_stiffness, b.tangential_stiffness),
        rolling_stiffness: series(a.rolling_stiffness, b.rolling_stiffness),
        friction: a.friction.min(b.friction),
        rolling_friction: a.rolling_friction.min(b.rolling_friction),
        restitution: a.restitution.min(b.restitution),
    }
}

/// A stiffness that the bond does not name is that of its contact.
fn on_contact(bond: BondLaw, contact: ContactLaw) -> BondLaw {
    BondLaw {
        normal_stiffness: bond.normal_stiffness.or(contact.normal_stiffness),
        tangential_stiffness: bond.tangential_stiffness.or(contact.tangential_stiffness),
        rolling_stiffness: bond.rolling_stiffness.or(contact.rolling_stiffness),
        ..bond
    }
}

fn between_bonds(a: BondLaw, b: BondLaw) -> BondLaw {
    BondLaw {
        normal_stiffness: series(a.normal_stiffness, b.normal_stiffness),
        tangential_stiffness: series(a.tangential_stiffness, b.tangential_stiffness),
        rolling_stiffness: series(a.rolling_stiffness, b.rolling_stiffness),
        friction: a.friction.min(b.friction),
        rolling_friction: a.rolling_friction.min(b.rolling_friction),
        cohesion: a.cohesion.min(b.cohesion),
        tensile_strength: a.tensile_strength.min(b.tensile_strength),
        scatter: None,
    }
}
