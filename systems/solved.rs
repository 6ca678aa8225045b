//! The tables of a trial after its solve, which judges, measures and the ledger read together.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use clastic_components::contact::{BodyTable, Contact, ContactTable};
use clastic_cone::program::{ConeProgram, ConeSolution, Interaction};

/// A solution with all that it belongs to.
#[derive(Clone, Copy)]
pub struct Solved<'a> {
    /// Bodies at the start of the trial.
    pub bodies: &'a BodyTable,
    /// Their potential contacts.
    pub contacts: &'a ContactTable,
    /// The program: one interaction per contact, then those of links, of ties and of plugins.
    pub program: &'a ConeProgram,
    /// Its solution.
    pub solution: &'a ConeSolution,
}

/// What a contact is in the program, and (p, q, tau) in the solution.
pub(crate) type SolvedContact<'a> = (&'a Contact, &'a Interaction, &'a [f64; 3]);

impl<'a> Solved<'a> {
    /// The tables of a world.
    pub fn of(world: &'a World) -> Self {
        Self {
            bodies: world.resource(),
            contacts: world.resource(),
            program: world.resource(),
            solution: world.resource(),
        }
    }

    /// The contacts in their order.
    pub fn contacts(self) -> impl Iterator<Item = SolvedContact<'a>> {
        let interactions = self.program.interactions.iter().zip(&self.solution.forces);
        self.contacts.0.iter().zip(interactions).map(|(contact, (c, f))| (contact, c, f))
    }
}

/// [`Solved`] as a parameter of systems.
#[derive(SystemParam)]
pub struct SolvedTables<'w> {
    bodies: Res<'w, BodyTable>,
    contacts: Res<'w, ContactTable>,
    program: Res<'w, ConeProgram>,
    solution: Res<'w, ConeSolution>,
}

impl SolvedTables<'_> {
    /// The tables.
    pub fn get(&self) -> Solved<'_> {
        let Self { bodies, contacts, program, solution } = self;
        Solved { bodies, contacts, program, solution }
    }
}
