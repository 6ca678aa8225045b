//! The exact geometry of contacts where an increment ends.
//!
//! Normals, arms and gaps of the start are accurate for small rotations: a bond of length L that
//! turns by alpha is elongated by `L alpha^2/2`. A motion u gives the exact gap and slip of every
//! pair of particles,
//!
//! ```text
//! g_1 = |x_b + u_b - x_a - u_a| - r_a - r_b      slip = l_a alpha_a + l_b alpha_b - L phi
//! ```
//!
//! with phi the rotation of the line of centres. They are linearised about u with the normal at
//! `x + (1 - theta) u`. In static analysis (theta = 0) this is the end of the increment, where
//! forces are in equilibrium. In dynamics it is the position about which normal impulses conserve
//! the angular momentum, `x_1 x v_1 - x_0 x v_0 = (x_0 + (1 - theta) u) x (v_1 - v_0)`. An arc or
//! an end point of a wall is a circle in the same sense, with L the distance of its centre.

use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Interaction};

use crate::assemble_program::groups::{self, Turning};
use crate::assemble_program::taut;
use crate::moved::Moved;
use crate::solved::{Solved, SolvedContact};

/// Tables of an increment and the place of its geometry.
pub struct Increment<'a> {
    /// Bodies and contacts at the start, and the program that was solved.
    pub solved: Solved<'a>,
    /// Theta of a time step; `None` in static analysis.
    pub theta: Option<f64>,
    /// Part of the increment that was solved.
    pub fraction: f64,
    /// Gravity, m/s^2.
    pub gravity: DVec2,
}

/// What the geometry at the end changes about a solution.
pub struct Ending {
    /// Forces that are out of balance, N and N m, by body in its own axes, without those of misfits.
    pub loads: Vec<[f64; 3]>,
    /// Closing and slip beyond those of the program, m, by interaction.
    pub misfits: Vec<[f64; 2]>,
    /// Maximum out-of-balance force of a particle or rigid group, held ones included, N. The moment on a
    /// group in statics counts as a force at its [extent](GroupRow::extent).
    pub imbalance: f64,
    /// Work that elastic contacts do in a time step beside what they store, J.
    pub by_closing: f64,
}

impl Increment<'_> {
    /// The geometry of every pair about the motion `u`, to which the solution has led, sorted by pair.
    /// The next program has the levers of the guess `last`.
    pub fn about(&self, u: &[[f64; 3]], last: &[[f64; 3]]) -> Vec<Correction> {
        let end = Moved::by(self.solved, u, 1.0).positions;
        let correction = |(contact, c, [p, ..]): SolvedContact| {
            let (exact, moved) = self.exact(contact, c, u, &end, last)?;
            Some(Correction {
                pair: (contact.a, contact.b),
                normal: exact.normal,
                gap: exact.gaps[0],
                offset: exact.gaps[1] - exact.normal.dot(moved),
                slip: exact.slip,
                tie: -exact.normal.perp().dot(moved),
                tension: -p,
                lag: self.closing(contact, c, &exact).map_or(0.0, |closing| closing.lag),
            })
        };
        self.solved.contacts().filter_map(correction).collect()
    }

    /// What the geometry at the end of a solution changes about the interactions that `counts` names.
    /// The program has the geometry of `corrections`.
    pub fn ending(&self, corrections: &Corrections, counts: &[bool]) -> Ending {
        let Solved { bodies, program, solution, .. } = self.solved;
        let (u, guess) = (&solution.displacements, &corrections.guesses.last);
        let end = Moved::by(self.solved, u, 1.0).positions;
        let mut loads = vec![[0.0; 3]; program.bodies.len()];
        let mut all = loads.clone();
        let mut misfits = vec![[0.0; 2]; program.interactions.len()];
        let mut by_closing = 0.0;
        for (k, (contact, c, f)) in self.solved.contacts().enumerate() {
            if !counts[k] {
                continue;
            }
            let Some((exact, moved)) = self.exact(contact, c, u, &end, guess) else { continue };
            let dilates = solution.law.dilation(c) > 0.0 && c.limits.slides(f);
            if let Some(closing) = self.closing(contact, c, &exact)
                && !dilates
            {
                by_closing += (f[0] - closing.force).abs() * (exact.gaps[1] - contact.gap).abs();
            }
            let old = corrections.of((contact.a, contact.b));
            let expected = old.map_or(contact.gap, |o| o.offset) + c.normal.dot(moved);
            let turn = u[c.a as usize][2] + u[c.b as usize][2];
            let arms = 0.5 * (exact.arms - self.arms(contact, c, old)) * turn;
            let along = exact.normal.perp() - c.normal.perp();
            let slip = exact.slip - old.map_or(0.0, |o| o.slip) - along.dot(moved) + arms;
            misfits[k] = [expected - exact.gaps[1], slip];
            let mut answer = [0.0; 2];
            if c.normal_compliance > 0.0 {
                answer[0] = misfits[k][0] / c.normal_compliance;
                if !c.limits.has_strength() {
                    answer[0] = answer[0].max(-f[0]);
                }
            }
            if c.tangential_compliance > 0.0 && !c.limits.slides(f) {
                answer[1] = slip / c.tangential_compliance;
            }
            let half = 0.5 * (exact.gaps[0] - old.map_or(contact.gap, |o| o.gap));
            let by_turn = f[0] * (exact.normal - c.normal) + f[1] * along;
            let by_misfit = answer[0] * exact.normal + answer[1] * exact.normal.perp();
            let force = f[0] * c.normal + f[1] * c.normal.perp();
            for (body, member, sign) in [(c.a, contact.a, -1.0), (c.b, contact.b, 1.0)] {
                let row = body as usize;
                let moment = |by: DVec2| match self.levers(member as usize, u, guess) {
                    Some([old, new]) => sign * (new.perp_dot(by) + (new - old).perp_dot(force)),
                    None if row < bodies.particles => -half * f[1],
                    None => 0.0,
                };
                add(program, &mut loads, row, sign * by_turn, moment(by_turn));
                let by = by_turn + by_misfit;
                add(program, &mut all, row, sign * by, moment(by));
            }
        }
        // A tie represents the turned force of its bond.
        for (k, tie) in taut::ties(self.solved) {
            let (c, f) = (&program.interactions[tie], &solution.forces[tie]);
            let Contact { a, b, .. } = self.solved.contacts.0[k];
            for (body, member, sign) in [(c.a, a, 1.0), (c.b, b, -1.0)] {
                let force = sign * f[0] * c.normal;
                let lever = self.levers(member as usize, u, guess).map_or(DVec2::ZERO, |l| l[0]);
                for sums in [&mut loads, &mut all] {
                    add(program, sums, body as usize, force, lever.perp_dot(force));
                }
            }
        }
        for (row, moment) in self.turned_loads(u, guess) {
            loads[row][2] += moment;
            all[row][2] += moment;
        }
        // The force on a wall is the sum of many, so that it would hide what is wrong at one of them.
        let is_wall = |row: usize| bodies.wall(row as u32).is_some();
        let forces = all.iter().enumerate().filter(|(row, _)| !is_wall(*row));
        let size = |(row, r): (usize, &[f64; 3])| {
            let force = r[0].hypot(r[1]);
            match bodies.group_at(row).filter(|_| self.theta.is_none()) {
                Some(group) if group.extent > 0.0 => force.max(r[2].abs() / group.extent),
                _ => force,
            }
        };
        let imbalance = forces.map(size).fold(0.0, f64::max);
        Ending { loads, misfits, imbalance, by_closing }
    }

    /// Levers of a particle in a rigid group in statics: of the program, and at the end.
    fn levers(&self, member: usize, u: &[[f64; 3]], guess: &[[f64; 3]]) -> Option<[DVec2; 2]> {
        let bodies = self.solved.bodies;
        let group = bodies.group(member).filter(|_| member < bodies.particles)?;
        let lever = |of| groups::lever(bodies, group, member, None, of);
        self.theta.is_none().then(|| [lever(guess), lever(u)])
    }

    /// What the loads on the members of each rigid group that turns in statics change about its moment
    /// from the program to the end, N m, by row.
    fn turned_loads(&self, u: &[[f64; 3]], guess: &[[f64; 3]]) -> Vec<(usize, f64)> {
        let Self { solved: Solved { bodies, contacts, program, .. }, fraction, gravity, theta } =
            *self;
        if theta.is_some() {
            return Vec::new();
        }
        let all = groups::turning(bodies, contacts, program, fraction, gravity, guess);
        let is_free = |group: &GroupRow| bodies.group_drive(group, 2) == BodyDrive::Free;
        let moment = |turning: Turning| {
            let (group, row) = (turning.group, turning.group.body as usize);
            let lost = groups::lost_at(bodies, group, fraction, gravity, u[row][2]);
            (row, turning.lost_at(u[row][2]) - lost)
        };
        all.into_iter().filter(|turning| is_free(turning.group)).map(moment).collect()
    }

    /// The mean force of an elastic contact over a time step in which it touches.
    fn closing(&self, contact: &Contact, c: &Interaction, exact: &Exact) -> Option<Closing> {
        let theta = self.theta?;
        let overlaps = [-contact.gap, -exact.gaps[1]];
        let touches = overlaps.iter().any(|o| *o > 0.0);
        if c.normal_compliance == 0.0 || c.limits.has_strength() || !touches {
            return None;
        }
        let line = overlaps[0] + theta * (overlaps[1] - overlaps[0]);
        let mean = exact.along * mean_overlap(overlaps, theta);
        let compliance = theta * c.normal_compliance;
        Some(Closing { force: mean / compliance, lag: (line - mean) / theta })
    }

    /// Sum of the arms of the program; twice the arm of the particle at a wall. The arms of a group
    /// are about its centre.
    fn arms(&self, contact: &Contact, c: &Interaction, old: Option<&Correction>) -> f64 {
        let bodies = self.solved.bodies;
        let (a, b) = (contact.a as usize, contact.b as usize);
        if bodies.group(a).is_some() || bodies.group(b).is_some() {
            let other = bodies.radii.get(b).unwrap_or(&bodies.radii[a]);
            bodies.radii[a] + other + old.map_or(contact.gap, |o| o.gap)
        } else if b < bodies.particles {
            c.arm_a + c.arm_b
        } else {
            2.0 * c.arm_a
        }
    }

    /// Geometry of a contact during the motion `u`, and the motion of b relative to a in the
    /// program about a `guess`, in which a rigid group turns to first order.
    fn exact(
        &self,
        contact: &Contact,
        c: &Interaction,
        u: &[[f64; 3]],
        end: &[DVec2],
        guess: &[[f64; 3]],
    ) -> Option<(Exact, DVec2)> {
        let (Solved { bodies, program, .. }, theta) = (self.solved, self.theta);
        // Normals count at this place: 0 is the start, 1 the end.
        let place = theta.map_or(1.0, |theta| 1.0 - theta);
        let (a, b) = (contact.a as usize, contact.b as usize);
        let is_pair = b < bodies.particles;
        // Constant normals keep rigid disks apart: |x| >= n . x.
        let is_rigid = c.normal_compliance == 0.0 && !c.limits.has_strength();
        if theta.is_some() && is_pair && is_rigid {
            return None;
        }
        let is_grouped = bodies.group(a).is_some() || bodies.group(b).is_some();
        let start =
            if is_pair { bodies.way(a, b) } else { bodies.positions[b] - bodies.positions[a] };
        let mut moved = end[b] - end[a] - (bodies.positions[b] - bodies.positions[a]);
        if c.is_across()
            && let Some(cell) = &program.cell
        {
            let row = cell.body as usize;
            moved += cell.shift(c.image, program.bodies[row].to_global(u[row]));
        }
        let way = [start, start + place * moved, start + moved];
        let exact = if is_pair {
            of_pair(bodies, [a, b], way)
        } else {
            of_wall(bodies, contact, way, theta.is_some())
        }?;
        if is_grouped {
            let linear = |i: usize| -> DVec2 {
                let Some(group) = bodies.group(i) else { return end[i] - bodies.positions[i] };
                let u = u[group.body as usize];
                let lever = groups::lever(bodies, group, i, theta, guess);
                let [x, y, _] = GroupRow::carried_linearly(u, lever);
                DVec2::new(x, y)
            };
            moved = linear(b) - linear(a);
        }
        Some((exact, moved))
    }
}

/// An elastic contact that touches in a time step.
struct Closing {
    /// Mean normal force, N.
    force: f64,
    /// [Lag](Correction::lag), m.
    lag: f64,
}

/// Mean overlap `o`, m, with which a spring of overlaps `o_0` and `o_1` (negative: open) does the work
/// that it stores in a time step, and with theta > 1/2 the damping of the scheme, as in the
/// energy-momentum method of Simo and Tarnow (ZAMP 43, 1992):
///
/// ```text
/// o (o_1 - o_0) = 1/2 max(o_1, 0)^2 - 1/2 max(o_0, 0)^2 + (theta - 1/2) (max(o_1, 0) - max(o_0, 0)) (o_1 - o_0)
/// ```
fn mean_overlap(overlaps: [f64; 2], theta: f64) -> f64 {
    let [start, end] = overlaps.map(|o| o.max(0.0));
    let both = 0.5 * (start + end);
    let stored = if overlaps.iter().all(|o| *o > 0.0) {
        both
    } else {
        both * (end - start) / (overlaps[1] - overlaps[0])
    };
    (stored + (theta - 0.5) * (end - start)).max(0.0)
}

/// Angle from one vector to another, rad. An arccosine would leave half of the digits of a small one.
fn angle(from: DVec2, to: DVec2) -> f64 {
    from.perp_dot(to).atan2(from.dot(to))
}

/// Adds a force and a moment on a body, in its own axes.
fn add(program: &ConeProgram, rows: &mut [[f64; 3]], body: usize, force: DVec2, moment: f64) {
    let of = &program.bodies[body];
    let along = [force.dot(of.axis), force.dot(of.axis.perp()), moment];
    for k in 0..3 {
        rows[body][k] += along[k];
    }
}

/// Geometry of a contact between the start and the end of the increment.
struct Exact {
    /// Normal at the place of the increment where it counts.
    normal: DVec2,
    /// Gap there and at the end, m.
    gaps: [f64; 2],
    /// Slip minus its linear expression, m.
    slip: f64,
    /// Sum of the arms; twice the arm of the particle at a wall, m.
    arms: f64,
    /// Change of the gap over the motion along the normal at the middle of the increment: the cosine of
    /// half the turn.
    along: f64,
}

/// Two particles. The three vectors are the position of b relative to a at the start, where the
/// normal counts, and at the end.
fn of_pair(
    bodies: &BodyTable,
    [a, b]: [usize; 2],
    [start, at, finish]: [DVec2; 3],
) -> Option<Exact> {
    let (length, far) = (at.length(), finish.length());
    if !(length > 0.0 && far > 0.0 && start.length() > 0.0) {
        return None;
    }
    let normal = at / length;
    let radii = bodies.radii[a] + bodies.radii[b];
    Some(Exact {
        normal,
        gaps: [length - radii, far - radii],
        slip: normal.perp().dot(finish - start) - length * angle(start, finish),
        arms: length,
        along: 2.0 * length / (start.length() + far),
    })
}

/// A particle and a wall. The normal of a line is constant, so that it matters only in time steps.
/// A wall that turns is left to [`turning`](crate::assemble_program::turning), one in a rigid group
/// to the frozen normals of its group, and an end that a particle passes in a time step to those of
/// the start: the next wall may take over there.
fn of_wall(
    bodies: &BodyTable,
    contact: &Contact,
    way: [DVec2; 3],
    is_time_step: bool,
) -> Option<Exact> {
    let wall = bodies.wall(contact.b).filter(|wall| is_time_step || !wall.is_line())?;
    let is_grouped = bodies.group(contact.b as usize).is_some();
    if is_grouped || matches!(bodies.wall_drive(wall), WallDrive::Turning { .. }) {
        return None;
    }
    let radius = bodies.radii[contact.a as usize];
    let [start, at, finish] = way.map(|to_wall| wall.nearest(to_wall, DVec2::ZERO));
    if is_time_step && start.curve != finish.curve {
        return None;
    }
    let normal = -at.outward;
    let moved = way[2] - way[0];
    // The slip along a circle is the arc that the particle travels about its centre.
    let turn = |centre: DVec2| {
        let arms = way.map(|to_wall| to_wall + centre);
        arms[1].length() * angle(arms[0], arms[2])
    };
    let slip = match (start.curve, finish.curve) {
        (Curve::Round(c), Curve::Round(d)) if c == d => normal.perp().dot(moved) - turn(c),
        (Curve::Hollow(c), Curve::Hollow(d)) if c == d => normal.perp().dot(moved) + turn(c),
        _ => 0.0,
    };
    let gaps = [at.distance - radius, finish.distance - radius];
    Some(Exact { normal, gaps, slip, arms: 2.0 * radius + gaps[0], along: 1.0 })
}
