//! The deformation of a periodic cell in the program: a body with the change of its width, of its
//! height and its shear as degrees of freedom, of which each is imposed or free under a stress.

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Dof, FreeDof, Interaction, ProgramBody};

use super::balance::Rows;

impl Rows<'_> {
    /// The body of the cell. The stress acts on the area at the start of the increment.
    pub(super) fn cell(&self, cell: &PeriodicCell) -> ProgramBody {
        let Self { bodies, analysis, progress, .. } = *self;
        let factors = cell.factors(bodies.mean_radius);
        let loads = cell.loads_of_controls(bodies.mean_radius, analysis.thickness);
        let dof = |k: usize| match cell.controls[k] {
            CellControl::Imposed(_) if bodies.drives_stopped => Dof::Fixed(0.0),
            CellControl::Imposed(u) => Dof::Fixed(progress.fraction * u * factors[k]),
            CellControl::Stress { from, to } => {
                let stress = progress.ramp(from, to).at(progress.fraction);
                Dof::Free(FreeDof { load: stress * loads[k], ..FreeDof::default() })
            }
        };
        ProgramBody { axis: cell.axis(), dofs: [dof(0), dof(1), dof(2)] }
    }
}

/// Sets the shifts of images, and the cell of the program.
pub(crate) fn set_images(bodies: &BodyTable, interactions: &mut [Interaction]) {
    let Some(cell) = &bodies.cell else { return };
    for c in interactions {
        c.image = bodies.shift(c.a as usize, c.b as usize) / cell.length();
    }
}

/// Holds one particle, because nothing else keeps the specimen from moving as a whole: the particle
/// that carried the largest normal forces, or touches the largest number of others.
pub(crate) fn hold_one(bodies: &BodyTable, history: &ContactHistory, program: &mut ConeProgram) {
    if bodies.cell.is_none() {
        return;
    }
    let mut carried = vec![0.0; bodies.particles];
    for m in &history.0 {
        for i in [m.a, m.b] {
            carried[i as usize] += m.p.abs();
        }
    }
    if history.0.is_empty() {
        for c in program.interactions.iter().filter(|c| c.offset <= 0.0) {
            for i in [c.a, c.b] {
                carried[i as usize] += 1.0;
            }
        }
    }
    let is_free =
        |i: &usize| program.bodies[*i].dofs[..2].iter().all(|d| matches!(d, Dof::Free(_)));
    // Ties go to the first particle.
    let most = (0..bodies.particles)
        .rev()
        .filter(is_free)
        .max_by(|a, b| carried[*a].total_cmp(&carried[*b]));
    if let Some(i) = most {
        for dof in &mut program.bodies[i].dofs[..2] {
            *dof = Dof::Fixed(0.0);
        }
    }
}

/// Loads of the body in the whole increment that was just committed: the stresses of the controls
/// on the area at its start. Zero along an imposed strain and without a cell.
pub fn loads(
    bodies: &BodyTable,
    analysis: &ClasticAnalysis,
    progress: &ClasticProgress,
) -> [Ramp; 3] {
    let Some(cell) = &bodies.cell else { return [Ramp::default(); 3] };
    let start = ClasticProgress { done: progress.done - progress.fraction, ..progress.clone() };
    let factors = cell.loads_of_controls(bodies.mean_radius, analysis.thickness);
    [0, 1, 2].map(|k| match cell.controls[k] {
        CellControl::Imposed(_) => Ramp::default(),
        CellControl::Stress { from, to } => start.ramp(from, to).times(factors[k]),
    })
}
