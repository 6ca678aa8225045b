//! Frames: the state at one moment as arrays, its particles as CSV, and the prepared specimen in
//! the format of stored specimens.

use std::path::Path;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;

use clastic_components::prelude::*;
use clastic_systems::gather_bodies::gather_bodies;

use super::atomic::write_atomic;
use super::csv_file::Row;
use super::run_directory::RunDirectory;
use super::wanted::Wanted;
use super::{OutputError, directory};
use crate::frames::{Frame, FrameTables};
use crate::run::key_results::KeyResults;
use crate::scene::StoredParticle;

/// Columns of a frame as CSV. Displacements are relative to the start of the stage list.
pub const COLUMNS: [&str; 7] = ["id", "x_m", "y_m", "radius_m", "rotation_rad", "ux_m", "uy_m"];

/// The parts of a world that a frame as CSV shows. The [`BodyTable`] must be up to date, as it is
/// after an increment.
#[derive(SystemParam)]
pub(super) struct Particles<'w, 's> {
    bodies: Res<'w, BodyTable>,
    motions: Query<'w, 's, (&'static BodyRotation, &'static BodyOrigin)>,
}

impl Particles<'_, '_> {
    fn text(&self) -> String {
        let mut text = COLUMNS.join(",") + "\n";
        let bodies = &*self.bodies;
        for (i, x) in bodies.positions.iter().take(bodies.particles).enumerate() {
            let motion = self.motions.get(bodies.entities[i]).ok();
            let row = Row::default()
                .with(u64::from(bodies.ids[i].0))
                .and(x.to_array())
                .with(bodies.radii[i])
                .with(motion.map_or(0.0, |(rotation, _)| rotation.0))
                .and(motion.map_or(DVec2::ZERO, |(_, origin)| *x - origin.0).to_array());
            text.push_str(&row.line());
        }
        text
    }
}

/// The particles as a stored specimen. Materials are named only if there are several. A scene that
/// reads the file can then give its only material any name.
pub fn specimen_rows(bodies: &BodyTable, materials: &Materials) -> Vec<StoredParticle> {
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

/// System: writes the frame of the increment, if wanted.
pub(super) fn write_wanted(
    (wanted, observation): (Res<Wanted>, Res<Observation>),
    (particles, tables): (Particles, FrameTables),
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    if !wanted.frame {
        return Ok(());
    }
    let name = format!("frame_{:06}", observation.increment);
    let path = run.path(directory::FRAMES).join(format!("{name}.csv"));
    run.write(path, particles.text())?;
    write(&mut run, &format!("{name}.npz"), &tables.frame())
}

pub(super) fn write_final_particles(world: &mut World) -> Result<(), OutputError> {
    let write = |particles: Particles, run: Res<RunDirectory>| {
        write_atomic(&run.path(directory::FINAL_PARTICLES), particles.text())
    };
    world.run_system_cached(write).unwrap_or_else(|error| panic!("{error}"))
}

/// Frames that may have to be written later. A checkpoint does not have them: they follow from the
/// world, or are on the disk by then.
#[derive(Resource, Debug, Default)]
pub(crate) struct FrameMoments {
    /// State at the start of the reference stage, until its first increment.
    pub(super) start: Option<Frame>,
    /// State at the peak so far, unless it is on the disk.
    peak: Option<Frame>,
}

impl FrameMoments {
    /// Inserts the frames of a run whose reference stage is yet to begin, or has begun. Gathers the
    /// tables, which a world without increments does not have yet; this does not change the run.
    pub(super) fn begin(world: &mut World, has_begun: bool) {
        let _ = world.run_system_cached(gather_bodies);
        let start = (!has_begun).then(|| Frame::take(world));
        world.insert_resource(Self { start, peak: None });
    }
}

/// System: takes the frame of an increment that is the peak so far.
pub(super) fn take_peak(
    (observation, results): (Res<Observation>, Res<KeyResults>),
    tables: FrameTables,
    mut frames: ResMut<FrameMoments>,
) {
    if results.is_peak(observation.increment) {
        frames.peak = Some(tables.frame());
    }
}

/// Writes the frame of the peak so far, unless it is on the disk.
pub(super) fn write_peak(world: &mut World) -> Result<(), OutputError> {
    let Some(frame) = world.resource_mut::<FrameMoments>().peak.take() else { return Ok(()) };
    write(&mut world.resource_mut(), directory::FRAME_PEAK, &frame)
}

pub(super) fn write_end(world: &mut World) -> Result<(), OutputError> {
    let frame = Frame::take(world);
    write(&mut world.resource_mut(), directory::FRAME_END, &frame)
}

pub(super) fn write(run: &mut RunDirectory, name: &str, frame: &Frame) -> Result<(), OutputError> {
    let path = run.path(directory::FRAMES).join(name);
    let bytes = frame.tables().encode().map_err(OutputError::at(&path))?;
    run.write(path, bytes)
}

/// Whether a run directory has the frame of the peak up to `increment`. A run that was killed
/// between this frame and its checkpoint leaves a later peak.
pub(super) fn has_peak(directory: &Path, increment: u64) -> bool {
    let peak = Frame::read(&directory.join(directory::FRAMES).join(directory::FRAME_PEAK));
    peak.is_ok_and(|frame| frame.increment <= increment)
}
