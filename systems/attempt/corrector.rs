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
//! the angular momentum, `x_1 x v_1 - x_0 x v_0 = (x_0 + (1 - theta) u) x (v_1 - v_0)`.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::findings::{Correction, Corrections};
use clastic_components::increment::{Analysis, AnalysisKind, Corrector};
use clastic_components::rigid_group::GroupRow;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::closed_pairs::moved_positions;
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
        AnalysisKind::LeastMotion { .. } => return,
    };
    if corrector.passes == 0 {
        return;
    }
    let end = moved_positions(&bodies, &program, &solution);
    let unit = displacement_scale(&program, &solution.displacements);
    let carrying = Carrying::new(&program, &solution);
    let mut corrections = Vec::new();
    let mut change = 0.0_f64;
    for (k, (contact, c)) in contacts.0.iter().zip(&program.interactions).enumerate() {
        let (a, b) = (contact.a as usize, contact.b as usize);
        // The normal of a wall is constant.
        if b >= bodies.particles {
            continue;
        }
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
        let at = start + place * moved;
        let moved = if is_grouped { linear(b) - linear(a) } else { moved };
        let (length, far) = (at.length(), finish.length());
        if !(length > 0.0 && far > 0.0 && start.length() > 0.0) {
            continue;
        }
        let normal = at / length;
        let radii = bodies.radii[a] + bodies.radii[b];
        let gap = far - radii;
        let new = Correction {
            pair: (contact.a, contact.b),
            normal,
            gap: length - radii,
            offset: gap - normal.dot(moved),
            slip: normal.perp().dot(moved) - length * start.angle_to(finish),
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
                    radii + old.map_or(contact.gap, |o| o.gap)
                } else {
                    c.arm_a + c.arm_b
                };
                let last = slip(c.normal, arms, old.map_or(0.0, |o| o.slip));
                change = change.max((slip(normal, length, new.slip) - last).abs() / unit);
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
