//! `program_000123.json`: the cone program of an increment and its solution.

use std::path::Path;

use bevy_ecs::prelude::*;

use clastic_components::observation::Observation;
use clastic_cone::dump::{Dump, from_json, to_json};
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::OutputError;
use super::atomic::write_atomic;

/// Writes the program and the solution of the last increment.
///
/// # Errors
/// If the file cannot be written.
pub fn write_program(path: &Path, world: &World) -> Result<(), OutputError> {
    let observation = world.resource::<Observation>();
    let text = to_json(
        observation.increment,
        &observation.stage,
        observation.fraction,
        world.resource::<ConeProgram>(),
        world.resource::<ConeSolution>(),
    );
    write_atomic(path, text.map_err(OutputError::at(path))?)
}

/// Reads what [`write_program`] wrote.
///
/// # Errors
/// If the file cannot be read, is no dump of this version, or contains a non-finite number.
pub fn read_program(path: &Path) -> Result<Dump, OutputError> {
    let text = std::fs::read_to_string(path).map_err(OutputError::at(path))?;
    from_json(&text).map_err(|error| OutputError::at(path)(std::io::Error::other(error)))
}
