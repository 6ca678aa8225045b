//! All particles at one moment as CSV, and the prepared specimen in the format of stored specimens.

use std::path::Path;

use bevy_ecs::prelude::*;

use clastic_components::contact::Bodies;
use clastic_components::material::Materials;
use clastic_components::observation::Observation;

use super::atomic::{atomically, write_atomic};
use super::caption::caption;
use super::csv_file::Row;
use super::run_directory::RunDirectory;
use super::snapshot::{Moments, Scenery, Snapshot};
use super::wanted::Wanted;
use super::{OutputError, directory, plots};
use crate::run::stages::Script;
use crate::scene::specimen_file::{self, StoredParticle};

/// Columns of a frame. Displacements are relative to the start of the stage list.
pub const COLUMNS: [&str; 7] = ["id", "x_m", "y_m", "radius_m", "rotation_rad", "ux_m", "uy_m"];

/// Writes a frame.
///
/// # Errors
/// If the file cannot be written.
pub fn write_frame(path: &Path, snapshot: &Snapshot) -> Result<(), OutputError> {
    let mut text = COLUMNS.join(",") + "\n";
    for (i, x) in snapshot.positions.iter().enumerate() {
        let row = Row::default()
            .count(u64::from(snapshot.ids[i]))
            .numbers(x.to_array())
            .numbers([snapshot.radii[i], snapshot.rotations[i]])
            .numbers(snapshot.displacements[i].to_array());
        text.push_str(&row.line());
    }
    write_atomic(path, text)
}

/// The particles as a stored specimen. Materials are named only if there are several. A scene that
/// reads the file can then give its only material any name.
#[must_use]
pub fn specimen_rows(bodies: &Bodies, materials: &Materials) -> Vec<StoredParticle> {
    let name = |i: usize| materials.0.get(bodies.materials[i] as usize).map(|m| m.name.clone());
    (0..bodies.particles)
        .map(|i| StoredParticle {
            x: bodies.positions[i].x,
            y: bodies.positions[i].y,
            r: bodies.radii[i],
            material: if materials.0.len() > 1 { name(i) } else { None },
        })
        .collect()
}

/// Writes a stored specimen.
///
/// # Errors
/// If the file cannot be written.
pub fn write_specimen(path: &Path, rows: &[StoredParticle]) -> Result<(), OutputError> {
    atomically(path, |temporary| specimen_file::write(temporary, rows))
}

/// System: writes the frame of the increment and its picture, if wanted.
pub(super) fn write_wanted(
    wanted: Res<Wanted>,
    (script, observation): (Res<Script>, Res<Observation>),
    (scenery, moments): (Scenery, Res<Moments>),
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    if !wanted.frame {
        return Ok(());
    }
    let now = scenery.snapshot();
    let path = directory::frame(run.directory(), observation.increment);
    write_frame(&path, &now)?;
    let (title, caption) = (&script.scene.title, caption(&observation));
    let field = plots::specimen::Field::of(&script.scene);
    if moments.are_drawn
        && let Some(picture) =
            plots::specimen::svg(&now, &moments.start, field, title, &caption, true)
    {
        let path = path.with_extension("svg");
        write_atomic(&path, picture)?;
        run.is_fresh(path);
    }
    run.is_fresh(path);
    Ok(())
}
