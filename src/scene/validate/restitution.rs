//! Restitution: laws and analyses that permit it.

use std::fmt::Arguments;

use clastic_components::domain;

use crate::scene::format::{Analysis, Contact, Scene, Stage};

use super::findings::Findings;

/// Checks the restitution of a contact law of a material or a wall.
pub(super) fn law(path: Arguments, contact: Contact, findings: &mut Findings) {
    let of = contact.restitution;
    let path = format_args!("{path}.restitution");
    let fine = findings.within(path, of, domain::RESTITUTION);
    let Contact { normal_stiffness, tangential_stiffness, rolling_stiffness, .. } = contact;
    let elastic = [normal_stiffness, tangential_stiffness, rolling_stiffness] != [None; 3];
    if fine && of > 0.0 && elastic {
        let message = format!("restitution of an elastic contact ({of:?})");
        let help = "leave out the stiffnesses, for a rigid contact, or the restitution: the springs of a \
                    contact determine how it rebounds";
        findings.add(path, message, help);
    }
}

/// Checks theta of dynamic stages. With restitution velocities have theta = 1, and springs require
/// theta = 1 as well.
pub(super) fn check(findings: &mut Findings) {
    let scene = findings.context.scene;
    let parts = ["materials", "walls", "analysis", "stages"];
    if !scene.has_restitution() || !has_springs(scene) || !findings.are_sure_of(&parts) {
        return;
    }
    let has_analysis = |stage: &Stage| stage.load().is_some() || matches!(stage, Stage::Custom(_));
    if scene.stages.iter().any(|stage| has_analysis(stage) && stage.analysis().is_none()) {
        theta(format_args!("analysis"), scene.analysis, findings);
    }
    for (i, stage) in scene.stages.iter().enumerate() {
        if let Some(analysis) = stage.analysis() {
            theta(format_args!("stages[{i}].analysis"), analysis, findings);
        }
    }
}

fn theta(path: Arguments, analysis: Analysis, findings: &mut Findings) {
    if let Analysis::Dynamic { theta, .. } = analysis
        && theta > 0.0
        && theta < 1.0
    {
        let message = format!("theta below 1 ({theta:?}) in a scene with restitution and springs");
        let help = "give 1.0: impacts need velocities at the end of the increment, and theta weighs the forces \
                    of springs at its start; or leave out the restitution, or the stiffnesses of contacts and bonds";
        findings.add(format_args!("{path}.theta"), message, help);
    }
}

/// Whether a law of the scene has a stiffness.
fn has_springs(scene: &Scene) -> bool {
    let materials = scene.materials.values().map(|m| (m.contact, m.bond));
    let walls = scene.walls.iter().map(|w| (w.contact, w.bond));
    materials.chain(walls).any(|(contact, bond)| {
        let of_bond =
            bond.map(|b| [b.normal_stiffness, b.tangential_stiffness, b.rolling_stiffness]);
        let of_contact =
            [contact.normal_stiffness, contact.tangential_stiffness, contact.rolling_stiffness];
        of_contact.into_iter().chain(of_bond.into_iter().flatten()).any(|k| k.is_some())
    })
}
