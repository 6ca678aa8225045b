//! `mechanism.csv`: the mechanism by which the specimen collapsed, from the certificate.

use std::path::Path;

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::IncrementStatus;
use clastic_components::contact::BodyTable;
use clastic_components::observation::Observation;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::atomic::write_atomic;
use super::csv_file::Row;
use super::found::Found;
use super::run_directory::RunDirectory;
use super::{OutputError, names};
use crate::run::key_results::MechanismRecord;

/// Columns. Displacements are divided by the maximum motion and therefore dimensionless. Rotations
/// are divided by it as well and are in rad/m.
pub const COLUMNS: [&str; 6] = ["body", "x_m", "y_m", "u_x", "u_y", "rotation"];

/// A body of a mechanism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MechanismRow {
    /// Identity of the body.
    pub body: usize,
    /// Position of the body, m.
    pub position: DVec2,
    /// Displacement of the body. The largest component of all bodies is 1, with rotations times the
    /// mean radius.
    pub displacement: DVec2,
    /// Rotation of the body, 1/m.
    pub rotation: f64,
}

/// The mechanism of a collapse.
#[derive(Clone, Debug, PartialEq)]
pub struct Mechanism {
    /// Quality of the mechanism.
    pub record: MechanismRecord,
    /// Particles, then existing walls.
    pub rows: Vec<MechanismRow>,
}

impl Mechanism {
    /// Mechanism of the last increment; `None` if it did not collapse, or if the collapse has no
    /// certificate.
    pub fn of(
        observation: &Observation,
        bodies: &BodyTable,
        program: &ConeProgram,
        solution: &ConeSolution,
    ) -> Option<Self> {
        let collapsed = observation.status == IncrementStatus::Collapsed;
        let certificate = solution
            .certificate
            .as_ref()
            .filter(|c| collapsed && c.mechanism.len() == program.bodies.len())?;
        let walls = bodies.walls.iter().map(|wall| wall.body as usize);
        let row = |body: usize| {
            let local = certificate.mechanism.get(body)?;
            let [x, y, rotation] = program.bodies[body].to_global(*local);
            let displacement = DVec2::new(x, y);
            let id = bodies.ids[body].0 as usize;
            Some(MechanismRow {
                body: id,
                position: bodies.positions[body],
                displacement,
                rotation,
            })
        };
        Some(Self {
            record: MechanismRecord {
                increment: observation.increment,
                margin: certificate.margin,
                defect: certificate.defect,
            },
            rows: (0..bodies.particles).chain(walls).filter_map(row).collect(),
        })
    }

    /// Writes it as CSV.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        let mut text = COLUMNS.join(",") + "\n";
        for row in &self.rows {
            let row = Row::default()
                .count(row.body as u64)
                .numbers(row.position.to_array())
                .numbers(row.displacement.to_array())
                .number(row.rotation);
            text.push_str(&row.line());
        }
        write_atomic(path, text)
    }
}

/// System: writes the mechanism, if the increment was the first collapse that has one.
pub(super) fn write_first(
    (bodies, observation): (Res<BodyTable>, Res<Observation>),
    (program, solution): (Res<ConeProgram>, Res<ConeSolution>),
    mut found: ResMut<Found>,
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    let mechanism = Mechanism::of(&observation, &bodies, &program, &solution);
    let Some(mechanism) = mechanism.filter(|of| found.see_mechanism(of.record)) else {
        return Ok(());
    };
    let path = run.path(names::MECHANISM);
    mechanism.write(&path)?;
    run.is_fresh(path);
    Ok(())
}
