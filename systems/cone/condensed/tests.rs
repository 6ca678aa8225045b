//! Small programs with closed forms, for the tests of the methods.

use glam::DVec2;

use super::matrix::BodyMatrix;
use super::scaled::Scaled;
use crate::program::{ConeProgram, Dof, FreeDof, Interaction, Limits, ProgramBody};

/// A body that is held.
pub fn held() -> ProgramBody {
    ProgramBody { axis: DVec2::X, dofs: [Dof::Fixed(0.0); 3] }
}

/// A body under loads along x and y. It does not turn.
pub fn loaded(x: f64, y: f64) -> ProgramBody {
    let free = |load| Dof::Free(FreeDof { load, ..FreeDof::default() });
    ProgramBody { axis: DVec2::X, dofs: [free(x), free(y), Dof::Fixed(0.0)] }
}

/// A contact of bodies a and b with a normal, a compliance in both directions, and friction.
pub fn contact(a: u32, b: u32, normal: DVec2, compliance: f64, friction: f64) -> Interaction {
    Interaction {
        normal,
        normal_compliance: compliance,
        tangential_compliance: if friction > 0.0 { compliance } else { 0.0 },
        limits: Limits::new(0.0, friction, 0.0, 0.0),
        ..Interaction::between(a, b)
    }
}

/// Held body 0 below a column of bodies, each with a weight of 1, with contacts of a compliance.
pub fn column(count: u32, compliance: f64) -> ConeProgram {
    ConeProgram {
        bodies: std::iter::once(held()).chain((0..count).map(|_| loaded(0.0, -1.0))).collect(),
        interactions: (0..count).map(|i| contact(i, i + 1, DVec2::Y, compliance, 0.0)).collect(),
        ..ConeProgram::default()
    }
}

/// A program in the order of its matrix, and the place of every body.
pub fn posed(program: &ConeProgram) -> (Scaled, BodyMatrix, Vec<usize>) {
    let pairs: Vec<_> = super::images::pairs(program).collect();
    let mut matrix = BodyMatrix::new(program.bodies.len(), &pairs);
    let place = super::matrix::places(matrix.order());
    let scaled = matrix.pose(program);
    (scaled, matrix, place)
}
