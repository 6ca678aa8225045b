//! Ends the output of a run: final particles, outcome, key results, the page.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use super::avalanches::{CurrentAvalanche, Ended};
use super::drive::PeakForce;
use super::found::Found;
use super::prepared::PreparedSpecimen;
use super::read_history::History;
use super::run_directory::RunDirectory;
use super::run_record::OutcomeRecord;
use super::save::{save, save_the_end};
use super::{OutputError, directory, frames, states};
use crate::run::key_results::{KeyResults, Results};
use crate::run::sanity;
use crate::run::stages::Script;
use crate::run::{Outcome, StageEnd};
use crate::scene::format::Stage;

/// Force, over the largest contact force, up to which it is round-off: as that of an open contact.
const ROUND_OFF: f64 = 1e-9;

/// Ends the output of a run, and returns its key results. Without an outcome the user or the system
/// stopped the run after a whole increment. The tables stay open until [`RunDirectory`] is removed
/// from the world.
///
/// # Errors
/// If something cannot be written.
pub fn finish(world: &mut World, outcome: Option<&Outcome>) -> Result<Results, OutputError> {
    states::write_kept(world)?;
    if needs_checkpoint(world, outcome) {
        save(world)?;
    }
    let has_ended = matches!(outcome, Some(Outcome::Completed | Outcome::Collapsed(_)));
    if has_ended {
        // The avalanche of a specimen that collapsed in one is still open here.
        save_the_end(world)?;
    }
    states::write_final(world)?;
    frames::write_peak(world)?;
    frames::write_end(world)?;
    frames::write_final_particles(world)?;
    world.resource_scope(|world, mut run: Mut<RunDirectory>| {
        // The avalanche of an interrupted run continues after it is resumed.
        if outcome.is_some()
            && let Some(avalanche) = world.resource_mut::<CurrentAvalanche>().0.take()
        {
            Ended(avalanche, None).write(&mut world.resource_mut(), &mut run)?;
        }
        let scene = &world.resource::<Script>().scene;
        let results = world.resource::<KeyResults>().results();
        let pours = scene.stages.iter().any(Stage::pours);
        let results = world.resource::<Found>().complete(results, pours);
        // The page comes last, so that the numbers are complete if it fails.
        write_record(&mut run, world, outcome, &results)?;
        #[cfg(feature = "report")]
        if scene.output.plots {
            let named = (scene.title.clone(), run.directory().to_owned());
            super::report::write(&[named], &run.path(directory::REPORT))?;
        }
        if has_ended {
            // The checkpoint is removed last, because a run with a checkpoint counts as not ended.
            directory::remove_if_there(&run.path(directory::CHECKPOINT))?;
        }
        Ok(results)
    })
}

/// Whether a checkpoint must be written at the end of the run.
fn needs_checkpoint(world: &World, outcome: Option<&Outcome>) -> bool {
    let run = world.resource::<RunDirectory>();
    let goes_on = world.resource::<Script>().outcome.is_none();
    let made = world.resource::<ClasticProgress>().increment;
    let is_interrupted = goes_on && outcome.is_none() && run.saved != Some(made);
    // The checkpoint precedes a refused stage, which can begin after its settings are changed.
    is_interrupted || matches!(outcome, Some(Outcome::Refused { .. }))
}

fn write_record(
    run: &mut RunDirectory,
    world: &World,
    outcome: Option<&Outcome>,
    results: &Results,
) -> Result<(), OutputError> {
    let observation = world.resource::<Observation>();
    let path = run.path(directory::RUN);
    let record = &mut run.record;
    record.outcome = OutcomeRecord::new(outcome, observation.stage.clone(), observation.increment);
    record.stages = world.resource::<Script>().ends.clone();
    record.capped_increments = record.stages.iter().map(|end| end.capped).sum();
    record.specimen_csv = world.resource::<PreparedSpecimen>().written.clone();
    if record.outcome.message.is_none() {
        let warnings: Vec<_> = record.stages.iter().filter_map(StageEnd::warning).collect();
        record.outcome.message = Some(warnings.join("; ")).filter(|m| !m.is_empty());
    }
    record.sanity = sanity::after(world);
    record.settled = world.resource::<Found>().settled;
    record.results = results.clone();
    if results.peak_stress_pa.is_none() && !run.probes.is_empty() {
        let record = serde_json::to_value(&run.record).map_err(OutputError::at(&path))?;
        let history = History::of_record(run.directory(), &record)?;
        // Below, a force is round-off of those of the specimen.
        let least = ROUND_OFF * world.resource::<Found>().largest_force;
        let radius = world.resource::<BodyTable>().mean_radius;
        run.record.peak_force = PeakForce::of(&history, [least, least * radius]);
    }
    run.record.write(&path)
}
