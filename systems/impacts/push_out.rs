//! Judge: separates rigid bodies that overlap at the start of a dynamic increment by displacements
//! that give no velocity.
//!
//! A displacement `u = g < 0` in one increment would mean a velocity `g/dt`, which grows without
//! bound as the increment decreases. The increment is therefore solved twice. The first solution
//! includes the overlaps and moves the bodies. The second solution treats an overlap as a contact
//! that just touches, and gives forces and velocities. Both conserve momentum.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_cone::program::ConeProgram;

use crate::solved::{Solved, SolvedTables};

/// Maximum overlap that counts as a residual of the last increment, over the tolerance times the
/// mean radius. The residual of a gap is relative to the displacements, which are at most one mean
/// radius here.
const MARGIN: f64 = 10.0;

/// Maximum overlap that counts as a residual, m.
pub(crate) fn residual_overlap(acceptance: &Acceptance, bodies: &BodyTable) -> f64 {
    MARGIN * acceptance.residual * bodies.mean_radius
}

/// Keeps the motion of the first solution and requests the second one.
pub fn judge(
    analysis: Res<ClasticAnalysis>,
    acceptance: Res<Acceptance>,
    tables: SolvedTables,
    mut pushed: ResMut<Pushed>,
    mut attempt: ResMut<Attempt>,
) {
    let AnalysisKind::Dynamic { .. } = analysis.kind else { return };
    let Solved { bodies, contacts, program, solution } = tables.get();
    if pushed.0.is_none() && overlaps(&acceptance, bodies, contacts, program) {
        pushed.0 = Some(solution.displacements.clone());
        attempt.verdict = Verdict::Again;
    }
}

/// Whether rigid bodies overlap at the start.
pub(crate) fn overlaps(
    acceptance: &Acceptance,
    bodies: &BodyTable,
    contacts: &ContactTable,
    program: &ConeProgram,
) -> bool {
    let residual = residual_overlap(acceptance, bodies);
    contacts.0.iter().zip(&program.interactions).any(|(contact, c)| {
        c.normal_compliance == 0.0 && !c.limits.has_strength() && contact.gap < -residual
    })
}
