//! Writes the mechanism of the first collapse and its picture.

use bevy_ecs::prelude::*;

use clastic_components::contact::BodyTable;
use clastic_components::observation::Observation;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::atomic::write_atomic;
use super::found::Found;
use super::mechanism::Mechanism;
use super::run_directory::RunDirectory;
use super::snapshot::{Moments, Scenery};
use super::{OutputError, names, plots};
use crate::run::stages::Script;

/// System: writes the mechanism and its picture, if the increment was the first collapse.
pub(super) fn write(
    (script, observation): (Res<Script>, Res<Observation>),
    (bodies, program, solution): (Res<BodyTable>, Res<ConeProgram>, Res<ConeSolution>),
    (scenery, moments): (Scenery, Res<Moments>),
    mut found: ResMut<Found>,
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    let Some(mechanism) = Mechanism::of(&observation, &bodies, &program, &solution) else {
        return Ok(());
    };
    if !found.see_mechanism(mechanism.record) {
        return Ok(());
    }
    let path = run.path(names::MECHANISM);
    mechanism.write(&path)?;
    run.is_fresh(path);
    if moments.are_drawn {
        let caption = format!(
            "mechanism of the collapse in increment {} of stage {}",
            observation.increment, observation.stage
        );
        let (now, title) = (scenery.snapshot(), &script.scene.title);
        if let Some(svg) = plots::mechanism::svg(&mechanism, &now, title, &caption) {
            let path = run.path(plots::MECHANISM);
            write_atomic(&path, svg)?;
            run.is_fresh(path);
        }
    }
    Ok(())
}
