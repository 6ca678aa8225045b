//! Reduces a program to its unknowns: leaves out elastic interactions between bodies whose motion
//! is known, bodies that no other interaction touches, and bodies [at rest](super::sleeping).
//!
//! The forces of an elastic interaction between two bodies with known motion are the projection of
//! its trial onto its limits. The free bodies and their neighbours remain, so that a few grains
//! that settle in a large specimen cost as much as a few grains.

use crate::program::{Certificate, ConeProgram, ConeSolution, Dof, Interaction, ProgramCell};

use super::scaled::Scaled;
use super::spring::{Elastic, RollingSpring};

/// The reduced program, with the places of its bodies and interactions in the whole one.
pub(crate) struct Reduced {
    /// The reduced program.
    pub program: ConeProgram,
    /// Its bodies, by their number in the whole program.
    pub bodies: Vec<usize>,
    /// Its interactions, by their number in the whole program.
    interactions: Vec<usize>,
    /// Bodies that keep their place and their forces.
    at_rest: Vec<bool>,
}

impl Reduced {
    /// `None` if the whole program remains. `at_rest` marks whole clusters of free bodies.
    pub fn new(program: &ConeProgram, at_rest: Vec<bool>) -> Option<Self> {
        let free: Vec<bool> =
            program.bodies.iter().zip(&at_rest).map(|(b, rests)| b.is_free() && !rests).collect();
        let free_cell =
            program.cell.is_some_and(|cell| program.bodies[cell.body as usize].is_free());
        let stays = |c: &Interaction| {
            let [a, b] = [c.a as usize, c.b as usize];
            let deforms = c.is_across() && free_cell;
            free[a] || free[b] || deforms || !(at_rest[a] || at_rest[b] || is_known(program, c))
        };
        if program.interactions.iter().all(stays) {
            return None;
        }
        let mut wanted = free.clone();
        let mut interactions = Vec::new();
        for (k, c) in program.interactions.iter().enumerate().filter(|(_, c)| stays(c)) {
            wanted[c.a as usize] = true;
            wanted[c.b as usize] = true;
            interactions.push(k);
        }
        if let Some(cell) = &program.cell {
            wanted[cell.body as usize] = true;
        }
        let bodies: Vec<usize> = (0..wanted.len()).filter(|i| wanted[*i]).collect();
        let mut number = vec![0; wanted.len()];
        for (k, &i) in bodies.iter().enumerate() {
            number[i] = k as u32;
        }
        let of_part = |k: &usize| {
            let c = program.interactions[*k];
            Interaction { a: number[c.a as usize], b: number[c.b as usize], ..c }
        };
        let last = |k: &usize| program.last_forces.get(*k).copied().unwrap_or_default();
        let part = ConeProgram {
            bodies: bodies.iter().map(|i| program.bodies[*i]).collect(),
            interactions: interactions.iter().map(of_part).collect(),
            scales: program.scales,
            last_forces: interactions.iter().map(last).collect(),
            cell: program.cell.map(|cell| ProgramCell { body: number[cell.body as usize], ..cell }),
        };
        Some(Self { program: part, bodies, interactions, at_rest })
    }

    /// The solution of the whole program that follows from a solution of the reduced one.
    pub fn expand(&self, program: &ConeProgram, part: ConeSolution) -> ConeSolution {
        let placed = |of_part: &[[f64; 3]], mut whole: Vec<[f64; 3]>| {
            for (u, &i) in of_part.iter().zip(&self.bodies) {
                whole[i] = *u;
            }
            whole
        };
        let displacements = placed(&part.displacements, program.imposed());
        let mut forces = vec![[0.0; 3]; program.interactions.len()];
        let mut left = self.interactions.iter().zip(&part.forces).peekable();
        for (k, c) in program.interactions.iter().enumerate() {
            forces[k] = match left.next_if(|(place, _)| **place == k) {
                Some((_, f)) => *f,
                None if self.at_rest[c.a as usize] || self.at_rest[c.b as usize] => {
                    program.last_forces.get(k).copied().unwrap_or_default()
                }
                None => alone(program, c),
            };
        }
        let certificate = part.certificate.map(|certificate| {
            let still = vec![[0.0; 3]; program.bodies.len()];
            Certificate { mechanism: placed(&certificate.mechanism, still), ..certificate }
        });
        ConeSolution { forces, displacements, certificate, ..part }
    }
}

/// Whether the forces of an interaction between bodies with known motion follow from that motion:
/// it is elastic, and has no rigid rolling moment unless both bodies turn by one angle.
fn is_known(program: &ConeProgram, c: &Interaction) -> bool {
    let turn = |i: u32| match program.bodies[i as usize].dofs[2] {
        Dof::Fixed(u) => u,
        Dof::Free(_) => f64::NAN,
    };
    let elastic =
        c.normal_compliance > 0.0 && (!c.limits.has_shear() || c.tangential_compliance > 0.0);
    elastic && (!c.limits.has_rolling() || c.rolling_compliance > 0.0 || turn(c.a) == turn(c.b))
}

/// Forces of an interaction between two known bodies.
fn alone(program: &ConeProgram, c: &Interaction) -> [f64; 3] {
    let (a, b) = (c.a as usize, c.b as usize);
    let mut single = Interaction { a: 0, b: 1, ..*c };
    if c.rolling_compliance == 0.0 {
        single.limits.rolling = 0.0;
        single.limits.moment = 0.0;
    }
    let cell = program.cell.filter(|_| c.is_across());
    let of_cell = cell.map(|cell| program.bodies[cell.body as usize]);
    let pair = ConeProgram {
        bodies: [program.bodies[a], program.bodies[b]].into_iter().chain(of_cell).collect(),
        cell: cell.map(|cell| ProgramCell { body: 2, ..cell }),
        interactions: vec![single],
        scales: program.scales,
        ..ConeProgram::default()
    };
    let (_, df) = program.scales.units();
    let s = RollingSpring::new(&Scaled::natural(&pair).locals[0]).respond([0.0; 3]).s;
    [0, 1, 2].map(|f| s[f] * df[f])
}
