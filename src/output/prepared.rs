//! System: the prepared specimen, `specimen.csv`, and the state at the start of the reference
//! stage.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::cell::PeriodicCell;
use clastic_components::contact::BodyTable;
use clastic_components::increment::ClasticProgress;
use clastic_components::material::Materials;
use clastic_components::observation::{Measures, Observation};
use clastic_components::wall::Wall;
use clastic_systems::gather_bodies::gather_bodies;

use super::atomic::atomically;
use super::found::{Found, Settled};
use super::frames::FrameMoments;
use super::run_directory::RunDirectory;
use super::{OutputError, directory, frames, platens, porosity};
use crate::run::stages::{CurrentStage, Script};
use crate::scene::format::Stage;
use crate::scene::{StoredParticle, specimen_file};

/// Decrease of the porosity that counts as settling: a jammed packing loses less.
const SETTLED: f64 = 1e-3;

/// The prepared specimen.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PreparedSpecimen {
    /// The state after the last increment, then that at the start of the reference stage, until its
    /// first increment. Its reference lengths exist only after that, which moves the particles.
    pub waiting: Option<Prepared>,
    /// Moment of `specimen.csv`, if it has been written.
    pub written: Option<String>,
}

/// A specimen as it is stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Prepared {
    /// Rows of the stored specimen.
    pub rows: Vec<StoredParticle>,
    /// Area of the periodic cell, m^2.
    pub cell_area: Option<f64>,
}

impl Prepared {
    pub(super) fn now(bodies: &BodyTable, materials: &Materials) -> Self {
        Self {
            rows: frames::specimen_rows(bodies, materials),
            cell_area: bodies.cell.as_ref().map(PeriodicCell::area),
        }
    }
}

/// System: takes the specimen and its frame where the reference stage begins, as earlier stages
/// leave it: those without increments as well. Exclusive, because it gathers the tables.
pub(super) fn take_start(world: &mut World) {
    let is_reference =
        world.resource::<ClasticProgress>().stage == world.resource::<Script>().reference_stage();
    if is_reference && world.resource::<PreparedSpecimen>().waiting.is_some() {
        FrameMoments::begin(world, false);
        let prepared = Prepared::now(world.resource(), world.resource());
        world.resource_mut::<PreparedSpecimen>().waiting = Some(prepared);
    }
}

/// System: follows the specimen up to the reference stage. Writes it, and its frame, after the first
/// increment of that stage.
pub fn prepare(
    (script, progress, observation): (Res<Script>, Res<ClasticProgress>, Res<Observation>),
    (bodies, materials, measures): (Res<BodyTable>, Res<Materials>, Res<Measures>),
    walls: Query<&Wall>,
    mut specimen: ResMut<PreparedSpecimen>,
    (mut found, mut frames): (ResMut<Found>, ResMut<FrameMoments>),
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    let is_reference = progress.stage >= script.reference_stage();
    let now = || Prepared::now(&bodies, &materials);
    if let Some(before) = &specimen.waiting
        && just_compacted(&script)
        && observation.motion_steps > 0
        && !is_cut(&script)
        && let Some(porosity_before) = porosity::in_cell_or_box(before)
        && let Some(porosity_after) = porosity::in_cell_or_box(&now())
        && porosity_before - porosity_after > SETTLED
    {
        found.settled = Some(Settled { porosity_before, porosity_after });
    }
    if !is_reference {
        specimen.waiting = Some(now());
    } else if let Some(prepared) = specimen.waiting.take() {
        let stage = script.stage(script.reference_stage()).map_or("", Stage::name);
        specimen.written = Some(format!(
            "at the start of the reference stage `{stage}`, before its first increment"
        ));
        write(&mut run, &prepared.rows)?;
        if let Some(frame) = frames.start.take() {
            frames::write(&mut run, directory::FRAME_START, &frame)?;
        }
        if !script.scene.stages.iter().any(Stage::pours) {
            found.porosity = if is_cut(&script) {
                porosity::within(&prepared.rows)
            } else {
                porosity::porosity(&measures, &walls, &prepared)
            };
            let span = |porosity| platens::span(&measures, &walls, &prepared, porosity);
            found.overhang = !found.porosity.is_none_or(span);
        }
    }
    Ok(())
}

/// System: writes the packing where a compaction ends. Exclusive, because it gathers the tables.
pub(super) fn write_packing(world: &mut World) -> Result<(), OutputError> {
    let Stage::Compact(stage) = &world.resource::<CurrentStage>().0 else { return Ok(()) };
    let moment = format!("at the end of the compaction `{}`", stage.name);
    let _ = world.run_system_cached(gather_bodies);
    let packing = Prepared::now(world.resource(), world.resource());
    world.resource_mut::<PreparedSpecimen>().written = Some(moment);
    write(&mut world.resource_mut(), &packing.rows)?;
    let script = world.resource::<Script>();
    if world.resource::<ClasticProgress>().stage >= script.reference_stage() {
        // The scene has no loading stage, so its result is the packing.
        world.resource_mut::<Found>().porosity = porosity::in_cell_or_box(&packing);
    }
    Ok(())
}

/// Whether a compaction came right before the stage whose first increment has just been made.
fn just_compacted(script: &Script) -> bool {
    let Some((now, before)) = script.ends.split_last() else { return false };
    let last = before.iter().rev().find(|end| end.rows > 0);
    let stage = last.and_then(|last| script.scene.stages.iter().find(|s| s.name() == last.stage));
    now.rows == 1 && matches!(stage, Some(Stage::Compact(_)))
}

/// Whether the specimen of the reference stage was cut out of another one.
fn is_cut(script: &Script) -> bool {
    let before = script.scene.stages.iter().take(script.reference_stage());
    script.scene.keep.is_some() || before.into_iter().any(|s| matches!(s, Stage::Remove(_)))
}

fn write(run: &mut RunDirectory, rows: &[StoredParticle]) -> Result<(), OutputError> {
    let path = run.path(directory::SPECIMEN);
    atomically(&path, |temporary| specimen_file::write(temporary, rows))?;
    run.is_fresh(path);
    Ok(())
}
