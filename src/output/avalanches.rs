//! `avalanches.csv`: one row per avalanche, if bonds break from event to event.
//!
//! An avalanche is one event of one or more bonds. It begins with the increment that ends at the
//! limit of its first bond. Other bonds may break after it at constant load. It ends with the
//! equilibrium in which all bonds hold. The columns of the state after it are empty if the run
//! ended before, or if loading continued with one round of ruptures.
//!
//! It releases the elastic energy that the specimen loses and the work that the constant loads do
//! meanwhile, `W + U_before - U_after`: what bonds, friction and the motion to the new equilibrium
//! dissipate.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;
use clastic_cone::program::Dof;
use clastic_systems::measures::elastic_energy_left;
use clastic_systems::solved::SolvedTables;

use super::OutputError;
use super::csv_file::{Column, Field, row};
use super::found::Found;
use super::run_directory::RunDirectory;

/// An avalanche that has ended, with the axial stress and the elastic energy after it if it ended
/// with an equilibrium.
pub(super) struct Ended(pub Avalanche, pub Option<(Option<f64>, f64)>);

impl Ended {
    pub fn write(&self, found: &mut Found, run: &mut RunDirectory) -> Result<(), OutputError> {
        found.avalanches += 1;
        found.largest_avalanche = found.largest_avalanche.max(self.0.bonds() as usize);
        run.tables.avalanches.push(row(&COLUMNS, self))
    }
}

pub(super) const COLUMNS: [Column<Ended>; 16] = [
    ("increment", |Ended(of, _)| of.increment.into()),
    ("stage", |Ended(of, _)| of.stage.as_str().into()),
    ("axial_strain", |Ended(of, _)| of.strain.into()),
    ("first_bond", |Ended(of, _)| Field::Count(of.first_bond.into())),
    ("rounds", |Ended(of, _)| Field::Count(of.rounds.into())),
    ("broken_tension", |Ended(of, _)| Field::Count(of.broken[0].into())),
    ("broken_shear", |Ended(of, _)| Field::Count(of.broken[1].into())),
    ("broken_rolling", |Ended(of, _)| Field::Count(of.broken[2].into())),
    ("axial_stress_before_pa", |Ended(of, _)| of.stress.into()),
    ("axial_stress_after_pa", |Ended(_, after)| after.and_then(|(stress, _)| stress).into()),
    ("elastic_energy_before_j", |Ended(of, _)| of.energy.into()),
    ("elastic_energy_after_j", |Ended(_, after)| after.map(|(_, energy)| energy).into()),
    ("x_m", |Ended(of, _)| of.place.x.into()),
    ("y_m", |Ended(of, _)| of.place.y.into()),
    ("extent_m", |Ended(of, _)| (of.spread / f64::from(of.bonds())).sqrt().into()),
    ("released_j", |Ended(of, after)| {
        let released = of.work.zip(*after).map(|(work, (_, after))| work + of.energy - after);
        released.into()
    }),
];

#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct CurrentAvalanche(pub Option<Avalanche>);

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
    /// Work of the constant loads so far, J, if it is known.
    work: Option<f64>,
    /// Mean of the contact points of the broken bonds, m.
    place: DVec2,
    /// Sum of the squares of their distances from it, m^2.
    spread: f64,
}

impl Avalanche {
    /// Processes the last increment: begins an avalanche, extends the current one, or ends it.
    fn follow(open: &mut Option<Self>, now: &Now) -> Option<Ended> {
        let observation = &*now.observation;
        if !observation.status.is_committed() {
            return None;
        }
        let is_loaded = observation.fraction > 0.0;
        let is_active = now.search.active;
        // Of contacts and bonds, J. Only static increments begin and end avalanches.
        let energy = || elastic_energy_left(now.tables.get(), &now.corrections);
        let after = (!is_loaded).then(|| (observation.axial_stress, energy()));
        if let Some(avalanche) = open.as_mut().filter(|_| !is_loaded) {
            avalanche.work = avalanche.work.zip(now.work()).map(|(before, more)| before + more);
        }
        let mut ended = None;
        // Loading may have continued with one round of ruptures; there is no state after it then.
        if observation.ruptures.is_empty() || is_loaded {
            ended = open.take().map(|avalanche| Ended(avalanche, after));
        }
        if let (None, true, Some(first)) = (&*open, is_active, observation.ruptures.first()) {
            *open = Some(Self {
                increment: observation.increment,
                stage: observation.stage.clone(),
                strain: observation.axial_strain,
                first_bond: first.bond.0,
                rounds: 0,
                broken: [0; 3],
                stress: observation.axial_stress,
                energy: energy(),
                work: Some(0.0),
                place: first.position,
                spread: 0.0,
            });
        }
        if let Some(avalanche) = open {
            avalanche.rounds += 1;
            for rupture in &observation.ruptures {
                avalanche.add(rupture, now.cell.as_deref());
            }
        }
        // The followed motion has come to rest without the bonds that broke in it.
        let is_settled = is_active && !is_loaded && !now.progress.relaxing;
        if is_settled && let Some(avalanche) = open.take() {
            ended = Some(Ended(avalanche, after));
        }
        ended
    }

    fn bonds(&self) -> u32 {
        self.broken.iter().sum()
    }

    /// Adds a broken bond. In a periodic cell its image nearest to the mean so far counts.
    fn add(&mut self, rupture: &Rupture, cell: Option<&PeriodicCell>) {
        self.broken[rupture.mode as usize] += 1;
        let apart = rupture.position - self.place;
        let apart = cell.map_or(apart, |cell| apart + cell.shift(apart));
        let moved = apart / f64::from(self.bonds());
        self.place += moved;
        self.spread += apart.dot(apart - moved);
    }
}

/// Data from which the rows of an avalanche follow.
#[derive(SystemParam)]
pub(super) struct Now<'w> {
    observation: Res<'w, Observation>,
    progress: Res<'w, ClasticProgress>,
    search: Res<'w, EventSearch>,
    tables: SolvedTables<'w>,
    corrections: Res<'w, Corrections>,
    ledger: Option<Res<'w, EnergyLedger>>,
    cell: Option<Res<'w, PeriodicCell>>,
}

impl Now<'_> {
    /// Work of the loads in the last increment, which was made at constant load, J. Without loads
    /// it is 0, else the energy ledger has it.
    fn work(&self) -> Option<f64> {
        if let Some(ledger) = &self.ledger {
            return Some(ledger.increment.external + ledger.increment.gravity);
        }
        let mut dofs = self.tables.get().program.bodies.iter().flat_map(|body| &body.dofs);
        let is_loaded = dofs.any(|dof| matches!(dof, Dof::Free(free) if free.load != 0.0));
        (!is_loaded).then_some(0.0)
    }
}

/// System: follows the current avalanche, and writes its row when it ends.
pub(super) fn write_ended(
    now: Now,
    mut current: ResMut<CurrentAvalanche>,
    mut found: ResMut<Found>,
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    match Avalanche::follow(&mut current.0, &now) {
        Some(ended) => ended.write(&mut found, &mut run),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use clastic_components::body::BodyId;
    use clastic_components::bond::{BondId, RuptureMode};

    use super::*;

    fn place_and_extent(places: &[DVec2], cell: Option<&PeriodicCell>) -> (DVec2, f64) {
        let rupture = |position| Rupture {
            increment: 1,
            bond: BondId(0),
            a: BodyId(0),
            b: BodyId(1),
            mode: RuptureMode::Tension,
            position,
            normal: DVec2::X,
            p: -1.0,
            q: 0.0,
            tau: 0.0,
        };
        let mut avalanche = Avalanche {
            increment: 1,
            stage: String::new(),
            strain: None,
            first_bond: 0,
            rounds: 1,
            broken: [0; 3],
            stress: None,
            energy: 0.0,
            work: None,
            place: places[0],
            spread: 0.0,
        };
        for place in places {
            avalanche.add(&rupture(*place), cell);
        }
        (avalanche.place, (avalanche.spread / places.len() as f64).sqrt())
    }

    /// Four bonds at the corners of a rectangle of 2 by 4 cm, about a corner of a sheared cell too.
    #[test]
    fn bonds_on_both_sides_of_a_cell_are_near_one_another() {
        let corners = [(0.01, 0.02), (-0.01, 0.02), (-0.01, -0.02), (0.01, -0.02)];
        let corners = corners.map(|(x, y)| DVec2::new(x, y));
        let (place, extent) = place_and_extent(&corners, None);
        assert!(place.length() < 1e-15 && (extent - 5.0e-4_f64.sqrt()).abs() < 1e-15);

        let cell = PeriodicCell {
            width: 1.0,
            height: 0.8,
            tilt: 0.3,
            shear: 0.0,
            stress: [0.0; 3],
            controls: Default::default(),
            by_mean: false,
        };
        let (place, extent) =
            place_and_extent(&corners.map(|corner| cell.wrapped(corner)), Some(&cell));
        assert!((place + cell.shift(place)).length() < 1e-14, "{place}");
        assert!((extent - 5.0e-4_f64.sqrt()).abs() < 1e-14, "{extent}");
    }
}
