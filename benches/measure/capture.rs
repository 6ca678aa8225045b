//! Cone programs taken from scenes that run.

use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;
use clastic::cone::program::ConeProgram;
use clastic::run::{Simulation, Step};
use clastic::scene::LoadedScene;

use crate::BenchError;

/// The program of an increment and that of the preceding increment, which gives the solver its
/// start.
#[derive(Clone, Debug)]
pub struct Captured {
    /// Name of the problem.
    pub name: String,
    /// Program of the increment before, as it was last solved.
    pub before: Option<ConeProgram>,
    /// Program of the increment, as it was last solved.
    pub program: ConeProgram,
}

/// An increment of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment<'a> {
    /// The nth increment of a stage, from 1.
    Increment(&'a str, u32),
    /// The one with the maximum axial stress.
    Peak,
    /// The first one after the peak with less than half its stress.
    AfterPeak,
}

/// Runs a scene and captures the programs of some increments, in the given order. A run that ends
/// before one of them is an error.
///
/// # Errors
/// If one of the increments does not occur.
pub fn capture(
    scene: &LoadedScene,
    wanted: &[(&str, Moment)],
) -> Result<Vec<Captured>, BenchError> {
    let mut simulation = Simulation::new(&scene.scene, scene.specimen.as_ref());
    let mut found: Vec<Option<Captured>> = vec![None; wanted.len()];
    let mut before: Option<ConeProgram> = None;
    let (mut stage, mut count, mut peak) = (String::new(), 0, 0.0);
    let last_stage = scene.scene.stages.last().map_or("", |s| s.name());
    // The peak is known only after it has passed.
    let follows_peak = wanted.iter().any(|w| matches!(w.1, Moment::Peak | Moment::AfterPeak));
    while found.iter().any(Option::is_none) || follows_peak {
        let Step::Increment = simulation.step() else { break };
        let world = simulation.world();
        let record = world.resource::<Observation>();
        if matches!(record.status, IncrementStatus::Undecided) {
            break;
        }
        if record.stage != stage {
            stage.clone_from(&record.stage);
            count = 0;
        }
        count += 1;
        let stress = record.axial_stress.filter(|_| stage == last_stage);
        let is_peak = stress.is_some_and(|s| s > peak);
        let is_after = stress.is_some_and(|s| s < 0.5 * peak);
        if is_peak {
            peak = stress.unwrap_or(peak);
        }
        let program = world.resource::<ConeProgram>();
        for ((name, moment), slot) in wanted.iter().zip(&mut found) {
            let here = match *moment {
                Moment::Increment(wanted, n) => stage == wanted && count == n,
                Moment::Peak => is_peak,
                Moment::AfterPeak => is_after && slot.is_none(),
            };
            if here {
                *slot = Some(Captured {
                    name: (*name).to_owned(),
                    before: before.take(),
                    program: program.clone(),
                });
            }
        }
        if is_after && found.iter().all(Option::is_some) {
            break;
        }
        before = Some(program.clone());
    }
    let missing =
        |k: usize| BenchError::Run(format!("{}: the run ends before it gets there", wanted[k].0));
    found.into_iter().enumerate().map(|(k, c)| c.ok_or_else(|| missing(k))).collect()
}
