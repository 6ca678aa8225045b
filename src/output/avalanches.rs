//! `avalanches.csv`: one row per avalanche, if bonds break from event to event.
//!
//! An avalanche is one event of one or more bonds. It begins with the increment that ends at the
//! limit of its first bond. Other bonds may break after it at constant load. It ends with the
//! equilibrium in which all bonds hold. The columns of the state after it are empty if the run
//! ended before, or if loading continued with one round of ruptures.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use serde::{Deserialize, Serialize};

use clastic_components::bond::RuptureMode;
use clastic_components::findings::EventSearch;
use clastic_components::increment::ClasticProgress;
use clastic_components::observation::Observation;
use clastic_cone::program::{ConeProgram, ConeSolution};
use clastic_systems::measures::elastic_energy;

use super::OutputError;
use super::csv_file::Row;
use super::found::Found;
use super::run_directory::RunDirectory;

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

/// The current avalanche of a run.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurrentAvalanche(pub Option<Avalanche>);

/// An avalanche that has not ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Avalanche {
    increment: u64,
    stage: String,
    strain: Option<f64>,
    first_bond: u32,
    /// Number of increments in which bonds broke.
    rounds: u32,
    /// Number of bonds broken in tension, shear and rolling.
    broken: [u32; 3],
    stress: Option<f64>,
    energy: f64,
}

impl Avalanche {
    /// Processes the last increment: begins an avalanche, extends the current one, or ends it.
    /// Returns the row of an ended avalanche and the number of its bonds.
    fn follow(open: &mut Option<Self>, now: &Now) -> Option<(Row, usize)> {
        let observation = &*now.observation;
        if !observation.status.is_committed() {
            return None;
        }
        let is_loaded = observation.fraction > 0.0;
        let is_active = now.search.active;
        let after = (!is_loaded).then(|| (observation.axial_stress, now.elastic_energy()));
        let mut ended = if observation.ruptures.is_empty() {
            open.take().map(|avalanche| avalanche.ended(after))
        } else if is_loaded {
            // Loading continued with one round of ruptures.
            open.take().map(|avalanche| avalanche.ended(None))
        } else {
            None
        };
        if open.is_none() && is_active {
            *open = Self::begun(now);
        }
        if let Some(avalanche) = open {
            avalanche.rounds += 1;
            for rupture in &observation.ruptures {
                let mode = match rupture.mode {
                    RuptureMode::Tension => 0,
                    RuptureMode::Shear => 1,
                    RuptureMode::Rolling => 2,
                };
                avalanche.broken[mode] += 1;
            }
        }
        // The followed motion has come to rest without the bonds that broke in it.
        let is_settled = is_active && !is_loaded && !now.progress.relaxing;
        if is_settled && let Some(avalanche) = open.take() {
            ended = Some(avalanche.ended(after));
        }
        ended
    }

    fn begun(now: &Now) -> Option<Self> {
        let observation = &*now.observation;
        let first = observation.ruptures.first()?;
        Some(Self {
            increment: observation.increment,
            stage: observation.stage.clone(),
            strain: observation.axial_strain,
            first_bond: first.bond.0,
            rounds: 0,
            broken: [0; 3],
            stress: observation.axial_stress,
            energy: now.elastic_energy(),
        })
    }

    /// Row of the avalanche, and number of its bonds. `after` is the axial stress and the elastic
    /// energy after it, if it ended with an equilibrium.
    pub fn ended(self, after: Option<(Option<f64>, f64)>) -> (Row, usize) {
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
        let stress = after.and_then(|after| after.0);
        let row = row.optionals([self.stress, stress]);
        (row.optionals([Some(self.energy), after.map(|after| after.1)]), bonds)
    }
}

/// Data from which the rows of an avalanche follow.
#[derive(SystemParam)]
pub(super) struct Now<'w> {
    observation: Res<'w, Observation>,
    progress: Res<'w, ClasticProgress>,
    search: Res<'w, EventSearch>,
    program: Res<'w, ConeProgram>,
    solution: Res<'w, ConeSolution>,
}

impl Now<'_> {
    /// Elastic energy of the contacts and bonds of the last solution, J.
    fn elastic_energy(&self) -> f64 {
        // Only static increments end avalanches.
        elastic_energy(&self.program, &self.solution, 1.0)
    }
}

/// System: follows the current avalanche, and writes its row when it ends.
pub(super) fn write_ended(
    now: Now,
    mut current: ResMut<CurrentAvalanche>,
    mut found: ResMut<Found>,
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    let Some((row, bonds)) = Avalanche::follow(&mut current.0, &now) else { return Ok(()) };
    found.see_avalanche(bonds);
    run.tables.avalanches.push(row)
}
