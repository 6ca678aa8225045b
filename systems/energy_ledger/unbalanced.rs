//! Work of the loads of a static increment, and of the out-of-balance force at its start.

use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Dof, Interaction};

use super::dynamic::turned_work;
use super::interactions::Tables;
use super::quasi_static::Starts;
use crate::assemble_program::cell::set_images;
use crate::assemble_program::groups::{self, join};
use crate::solved::Solved;

/// Adds the work of loads that vary linearly from start to end. The out-of-balance force at the
/// start does work until equilibrium is reached. This is `motion` after a sudden change (`is_jump`:
/// the first increment, or a removed body), and `turning` otherwise.
pub fn book(e: &mut Energies, tables: &Tables, starts: &Starts, is_jump: bool) {
    let Solved { bodies, program, solution, contacts } = tables.solved;
    let zero = vec![[0.0; 3]; program.bodies.len()];
    let (mut before, mut after) = (zero.clone(), zero);
    program.add_forces(&starts.forces, &mut before);
    program.add_forces(&solution.forces, &mut after);
    // Bonds that broke and whose bodies are no longer a potential contact.
    for released in starts.released {
        if contacts.0.binary_search_by_key(&(released.a, released.b), |c| (c.a, c.b)).is_err() {
            let mut c = [bond_of(bodies, released)];
            set_images(bodies, &mut c);
            join(bodies, None, &[], &mut c);
            let [c] = c;
            add(program, &c, &released.forces, &mut before);
            let d = program.kinematics(&c, &solution.displacements);
            e.motion += (0..3).map(|k| 0.5 * released.forces[k] * d[k]).sum::<f64>();
        }
    }
    let mut walls = bodies.walls.iter().peekable();
    let (gravity, guess) = (tables.laws.analysis.gravity, &tables.corrections.guesses.last);
    let turning = groups::turning(bodies, contacts, program, tables.fraction, gravity, guess);
    for turning in &turning {
        let row = turning.group.body as usize;
        let turn = solution.displacements[row][2];
        let is_free = matches!(program.bodies[row].dofs[2], Dof::Free(_));
        let lost = if is_free { turning.lost_at(turn) } else { 0.0 };
        let aside = turned_work(tables, turning.group) + 0.5 * lost * turn;
        e.turning += aside;
        e.external += aside;
    }
    let mut unbalanced = 0.0;
    for (i, body) in program.bodies.iter().enumerate() {
        let wall = walls.next_if(|wall| wall.body as usize == i);
        let u = solution.displacements[i];
        let group = bodies.group_at(i);
        if i < bodies.particles {
            let weight = bodies.static_weight(i, gravity);
            e.gravity += weight.dot(DVec2::new(u[0], u[1]));
        }
        for k in 0..3 {
            match &body.dofs[k] {
                Dof::Fixed(u) => e.external += 0.5 * (before[i][k] + after[i][k]) * u,
                Dof::Free(free) => {
                    let end = free.load - free.inertia * u[k];
                    // Loads of an embedding program count as constant.
                    let grown = match (wall, group) {
                        (Some(wall), _) => bodies.wall_drive(wall).load().unwrap_or_default(),
                        (None, Some(group)) => {
                            let at = |part| bodies.load_on_group(group, part, DVec2::ZERO)[k];
                            Ramp { from: at(0.0), to: at(1.0) }
                        }
                        (None, None) if i >= bodies.positions.len() => tables.cell_loads[k],
                        (None, None) => bodies.loads[i][k],
                    };
                    let grown = grown.at(tables.fraction) - grown.at(0.0);
                    let turning =
                        group.filter(|_| k == 2).map(|_| &turning[i - bodies.first_group()]);
                    let lost = turning.map_or(0.0, |turning| turning.lost_at(0.0));
                    let start = if starts.is_rigid { end } else { free.load + lost - grown };
                    e.external += 0.5 * (start + end) * u[k];
                    unbalanced += 0.5 * (start - before[i][k]) * u[k];
                }
            }
        }
    }
    // Loads contain the weight.
    e.external -= e.gravity;
    *(if is_jump { &mut e.motion } else { &mut e.turning }) += unbalanced;
}

/// The bond that broke at the end of the last increment, in the current geometry.
fn bond_of(bodies: &BodyTable, released: &Released) -> Interaction {
    let (a, b) = (released.a as usize, released.b as usize);
    let wall = bodies.wall(released.b);
    let apart =
        if wall.is_some() { bodies.positions[b] - bodies.positions[a] } else { bodies.way(a, b) };
    let other = bodies.radii.get(b).copied().unwrap_or_default();
    let (normal, distance) = match wall {
        Some(wall) if !wall.is_line() => {
            let near = wall.nearest(bodies.positions[b], bodies.positions[a]);
            (-near.outward, near.distance)
        }
        Some(wall) => (-wall.inward, -apart.dot(wall.inward)),
        None => (apart.normalize(), apart.dot(apart.normalize())),
    };
    let half_gap = 0.5 * (distance - bodies.radii[a] - other);
    let c = Interaction {
        normal,
        arm_a: bodies.radii[a] + half_gap,
        arm_b: if wall.is_some() { 0.0 } else { other + half_gap },
        ..Interaction::between(released.a, released.b)
    };
    let turns = |wall: &WallRow| {
        matches!(bodies.wall_drive(wall), WallDrive::Turning { .. }) || bodies.group(b).is_some()
    };
    if wall.is_some_and(turns) {
        let lever = normal * (bodies.radii[a] + half_gap) - apart;
        return c.carried_by(false, released.b, lever);
    }
    c
}

/// Adds the forces of an interaction to the resistance of its bodies.
fn add(program: &ConeProgram, c: &Interaction, f: &[f64; 3], rows: &mut [[f64; 3]]) {
    for (body, g) in program.rows(c) {
        for (row, g) in rows[body].iter_mut().zip(&g) {
            *row += g[0] * f[0] + g[1] * f[1] + g[2] * f[2];
        }
    }
}
