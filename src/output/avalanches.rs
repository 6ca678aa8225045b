//! `avalanches.csv`: one row an avalanche, where bonds break from event to event.
//!
//! An avalanche begins with the increment that ends at the limit of its first bond. Others may break after it at
//! constant load; it ends with the equilibrium in which all bonds hold, or with the run.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::bond::RuptureMode;
use clastic_components::findings::EventSearch;
use clastic_components::observation::Observation;
use clastic_components::program::{ConeProgram, ConeSolution};

use super::csv_file::Row;

/// Columns.
pub const COLUMNS: [&str; 12] = [
    "increment",
    "stage",
    "axial_strain",
    "first_bond",
    "rounds",
    "broken_tension",
    "broken_shear",
    "broken_rolling",
    "axial_stress_before_pa",
    "axial_stress_after_pa",
    "elastic_energy_before_j",
    "elastic_energy_after_j",
];

/// An avalanche under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Avalanche {
    increment: u64,
    stage: String,
    strain: Option<f64>,
    first_bond: u32,
    /// Increments in which bonds broke.
    rounds: u32,
    /// In tension, shear and rolling.
    broken: [u32; 3],
    stress: Option<f64>,
    energy: f64,
}

impl Avalanche {
    /// Takes up what the last increment says of avalanches: begins one, adds to the one under way, or ends it. Returns
    /// the row of one that has ended and the number of its bonds.
    pub fn follow(open: &mut Option<Self>, world: &World) -> Option<(Row, usize)> {
        let observation = world.resource::<Observation>();
        if !world.resource::<EventSearch>().active && open.is_none() {
            return None;
        }
        let Some(first) = observation.ruptures.first() else {
            return open.take().map(|avalanche| avalanche.ended(world));
        };
        let avalanche = open.get_or_insert_with(|| Self {
            increment: observation.increment,
            stage: observation.stage.clone(),
            strain: observation.axial_strain,
            first_bond: first.bond.0,
            rounds: 0,
            broken: [0; 3],
            stress: observation.axial_stress,
            energy: elastic_energy(world),
        });
        avalanche.rounds += 1;
        for rupture in &observation.ruptures {
            let mode = match rupture.mode {
                RuptureMode::Tension => 0,
                RuptureMode::Shear => 1,
                RuptureMode::Rolling => 2,
            };
            avalanche.broken[mode] += 1;
        }
        None
    }

    fn ended(self, world: &World) -> (Row, usize) {
        let bonds = self.broken.iter().sum::<u32>() as usize;
        let mut row = Row::default()
            .count(self.increment)
            .text(&self.stage)
            .optional(self.strain)
            .count(self.first_bond)
            .count(self.rounds);
        for count in self.broken {
            row = row.count(count);
        }
        let after = world.resource::<Observation>().axial_stress;
        let row = row.optionals([self.stress, after]);
        (row.numbers([self.energy, elastic_energy(world)]), bonds)
    }
}

/// Elastic energy of the contacts and bonds of the last solution, `1/2 sum (C_N p^2 + C_T q^2)`, J.
fn elastic_energy(world: &World) -> f64 {
    let (program, solution) = (world.resource::<ConeProgram>(), world.resource::<ConeSolution>());
    let interactions = program.interactions.iter().zip(&solution.forces);
    let energies = interactions.map(|(c, [p, q, _])| {
        0.5 * (c.normal_compliance * p * p + c.tangential_compliance * q * q)
    });
    energies.sum()
}
