//! Stages that choose their increments by an accuracy.

use std::fmt::Arguments;

use crate::scene::format::{Load, Stage};

use super::findings::Findings;

/// Checks `accuracy` of the stage at an index. Bonds of a saved state are only known when the stage
/// begins.
pub(super) fn check(path: Arguments, stage: &Load, findings: &mut Findings) {
    let Some(accuracy) = stage.accuracy else { return };
    let scene = findings.context.scene;
    let path = format_args!("{path}.accuracy");
    let allowed = |value| value > 0.0 && value < 1.0;
    let what = "an error of the stress over the stress, between 0 and 1";
    findings.number(path, accuracy, allowed, what);
    if !findings.is_timeless() && findings.is_sure_of("analysis") {
        let help = "choose `dt` of a dynamic stage instead";
        findings.add(path, "an accuracy in a dynamic stage", help);
    }
    let earlier = scene.stages.iter().take(findings.stage);
    let is_cemented = earlier.into_iter().any(|stage| matches!(stage, Stage::Cement(_)));
    if (is_cemented || !scene.bonds.is_empty()) && findings.is_sure_of("stages") {
        let help = "leave it out: with `rupture: (order: Events)` the strength hardly depends on the \
                    increment";
        findings.add(path, "an accuracy in a stage with bonds", help);
    }
}
