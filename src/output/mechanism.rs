//! `mechanism.csv`: the mechanism by which the specimen collapsed, from the certificate.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::csv_file::Row;
use super::found::Found;
use super::run_directory::RunDirectory;
use super::{OutputError, directory};
use crate::run::key_results::MechanismRecord;

/// Columns. The largest component of the displacements of all bodies, with rotations times the mean
/// radius, is 1: displacements are without dimension, and rotations in rad/m.
const COLUMNS: [&str; 6] = ["body", "x_m", "y_m", "u_x", "u_y", "rotation"];

/// System: writes the mechanism, if the increment was the first collapse that has one. Particles
/// come first, then the existing walls.
pub(super) fn write_first(
    (bodies, observation): (Res<BodyTable>, Res<Observation>),
    (program, solution): (Res<ConeProgram>, Res<ConeSolution>),
    mut found: ResMut<Found>,
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    if observation.status != IncrementStatus::Collapsed || found.mechanism.is_some() {
        return Ok(());
    }
    let certificate = solution.certificate.as_ref();
    let certificate = certificate.filter(|c| c.mechanism.len() == program.bodies.len());
    let Some(certificate) = certificate else { return Ok(()) };
    found.mechanism = Some(MechanismRecord {
        increment: observation.increment,
        margin: certificate.margin,
        defect: certificate.defect,
    });
    let mut text = COLUMNS.join(",") + "\n";
    let walls = bodies.walls.iter().map(|wall| wall.body as usize);
    for body in (0..bodies.particles).chain(walls) {
        let Some(local) = certificate.mechanism.get(body) else { continue };
        let row = Row::default()
            .with(u64::from(bodies.ids[body].0))
            .and(bodies.positions[body].to_array())
            .and(program.bodies[body].to_global(*local));
        text += &row.line();
    }
    let path = run.path(directory::MECHANISM);
    run.write(path, text)
}
