//! Judge: with a [`Corrector`], the increment is solved again with the normals and gaps of the
//! resulting geometry, until the geometry no longer changes.
//!
//! Normals, arms and gaps of the start are accurate for small rotations: a bond of length L that
//! turns by alpha is elongated by `L alpha^2/2`. The last solution u gives the exact gap and slip
//! of every pair of particles,
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

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, Contact, Contacts};
use clastic_components::findings::{Correction, Corrections};
use clastic_components::increment::{Analysis, AnalysisKind, Corrector};
use clastic_components::rigid_group::GroupRow;
use clastic_components::wall::WallDrive;
use clastic_components::wall_shape::Curve;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::closed_pairs::Moved;
use clastic_cone::residuals::{Carrying, displacement_scale};

/// Requests another pass until gap, slip and normal of loaded contacts agree with the solution.
pub fn judge(
    corrector: Res<Corrector>,
    analysis: Res<Analysis>,
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut state: ResMut<Corrections>,
    mut attempt: ResMut<Attempt>,
) {
    let place = match analysis.kind {
        AnalysisKind::Static => 1.0,
        AnalysisKind::Dynamic { theta, .. } => 1.0 - theta,
        AnalysisKind::Compaction { .. } => return,
    };
    if corrector.passes == 0 {
        return;
    }
    let end = Moved::by(&bodies, &program, &solution.displacements, 1.0).positions;
    let unit = displacement_scale(&program, &solution.displacements);
    let carrying = Carrying::new(&program, &solution);
    let mut corrections = Vec::new();
    let mut change = 0.0_f64;
    for (k, (contact, c)) in contacts.0.iter().zip(&program.interactions).enumerate() {
        let (a, b) = (contact.a as usize, contact.b as usize);
        let start = bodies.positions[b] - bodies.positions[a];
        let finish = end[b] - end[a];
        // The motion of the program, in which a rigid group turns to first order.
        let linear = |i: usize| -> DVec2 {
            let Some(group) = bodies.group(i) else { return end[i] - bodies.positions[i] };
            let u = solution.displacements[group.body as usize];
            let [x, y, _] = GroupRow::carried_linearly(u, bodies.lever(group, i));
            DVec2::new(x, y)
        };
        let is_grouped = bodies.group(a).is_some() || bodies.group(b).is_some();
        let moved = finish - start;
        let way = [start, start + place * moved, finish];
        let exact = if b < bodies.particles {
            of_pair(&bodies, [a, b], way)
        } else {
            of_wall(&bodies, contact, way)
        };
        let Some(exact) = exact else { continue };
        let (normal, gap) = (exact.normal, exact.gaps[1]);
        let moved = if is_grouped { linear(b) - linear(a) } else { moved };
        let new = Correction {
            pair: (contact.a, contact.b),
            normal,
            gap: exact.gaps[0],
            offset: gap - normal.dot(moved),
            slip: exact.slip,
        };
        let old = state.of(new.pair);
        let carries = carrying.is_carrying(k) || contact.bond.is_some();
        if carries || gap < 0.0 {
            let expected = old.map_or(contact.gap, |o| o.offset) + c.normal.dot(moved);
            change = change.max((gap - expected).abs() / unit);
            change = change.max(normal.distance(c.normal));
            if c.tangential_compliance > 0.0 {
                let slip = |normal: DVec2, arms: f64, shift: f64| {
                    let turn = solution.displacements[a][2] + solution.displacements[b][2];
                    shift - normal.perp().dot(moved) + 0.5 * arms * turn
                };
                let arms = if is_grouped {
                    // The arms of a group are about its centre.
                    let other = bodies.radii.get(b).copied();
                    let apart = bodies.radii[a] + old.map_or(contact.gap, |o| o.gap);
                    apart + other.unwrap_or(bodies.radii[a])
                } else if b < bodies.particles {
                    c.arm_a + c.arm_b
                } else {
                    // Only the particle has an arm at a wall.
                    2.0 * c.arm_a
                };
                let last = slip(c.normal, arms, old.map_or(0.0, |o| o.slip));
                change = change.max((slip(normal, exact.arms, new.slip) - last).abs() / unit);
            }
        }
        corrections.push(new);
    }
    state.residual = change;
    if change <= corrector.tolerance {
        return;
    }
    if state.passes >= corrector.passes || !change.is_finite() {
        state.capped = true;
        return;
    }
    state.passes += 1;
    state.list = corrections;
    attempt.verdict = Verdict::Again;
}

/// Geometry of a contact on its way from the start to the end of the increment.
struct Exact {
    /// Normal at the place of the increment where it counts.
    normal: DVec2,
    /// Gap there and at the end, m.
    gaps: [f64; 2],
    /// Slip minus its linear expression, m.
    slip: f64,
    /// Sum of the arms; twice the arm of the particle at a wall, m.
    arms: f64,
}

/// Two particles. The three vectors are the position of b relative to a at the start, where the
/// normal counts, and at the end.
fn of_pair(bodies: &Bodies, [a, b]: [usize; 2], [start, at, finish]: [DVec2; 3]) -> Option<Exact> {
    let (length, far) = (at.length(), finish.length());
    if !(length > 0.0 && far > 0.0 && start.length() > 0.0) {
        return None;
    }
    let normal = at / length;
    let radii = bodies.radii[a] + bodies.radii[b];
    Some(Exact {
        normal,
        gaps: [length - radii, far - radii],
        slip: normal.perp().dot(finish - start) - length * start.angle_to(finish),
        arms: length,
    })
}

/// A particle and a wall with curves or ends. The normal of a line is constant. A wall that turns is
/// left to [`turning`](crate::assemble_program::turning), and one in a rigid group to the frozen
/// normals of its group.
fn of_wall(bodies: &Bodies, contact: &Contact, way: [DVec2; 3]) -> Option<Exact> {
    let k = bodies.walls.binary_search_by_key(&contact.b, |w| w.body).ok()?;
    let wall = bodies.walls.get(k).filter(|wall| !wall.is_line())?;
    let is_grouped = bodies.group(contact.b as usize).is_some();
    if is_grouped || matches!(bodies.wall_drive(wall), WallDrive::Turning { .. }) {
        return None;
    }
    let radius = bodies.radii[contact.a as usize];
    let [start, at, finish] = way.map(|to_wall| wall.nearest(to_wall, DVec2::ZERO));
    let normal = -at.outward;
    let moved = way[2] - way[0];
    // The slip along a circle is the way of the particle about its centre.
    let turn = |centre: DVec2| {
        let arms = way.map(|to_wall| to_wall + centre);
        arms[1].length() * arms[0].angle_to(arms[2])
    };
    let slip = match (start.curve, finish.curve) {
        (Curve::Round(c), Curve::Round(d)) if c == d => normal.perp().dot(moved) - turn(c),
        (Curve::Hollow(c), Curve::Hollow(d)) if c == d => normal.perp().dot(moved) + turn(c),
        _ => 0.0,
    };
    let gaps = [at.distance - radius, finish.distance - radius];
    Some(Exact { normal, gaps, slip, arms: 2.0 * radius + gaps[0] })
}
