//! Settings of the world: analysis, acceptance, rules of rupture.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use clastic_components::domain::{
    AGITATION, BRITTLENESS, DENSITY_OF_RUPTURES, FACTOR, GRAVITY, MOTION_STEP, OVERLOAD, PART,
    RESIDUAL, THETA, THICKNESS, TIME_STEP, TURN,
};
use clastic_components::prelude::*;

use super::bad::{Bad, finite, not_negative, outside};

/// The settings with numbers that an increment depends on.
#[derive(SystemParam)]
pub(crate) struct Settings<'w> {
    pub(super) analysis: Res<'w, ClasticAnalysis>,
    acceptance: Res<'w, Acceptance>,
    rules: Res<'w, RuptureRules>,
    law: Res<'w, FrictionLaw>,
    progress: Res<'w, ClasticProgress>,
}

impl Settings<'_> {
    /// The first value without a meaning, with the name of its resource.
    pub(super) fn bad(&self) -> Option<(&'static str, Bad)> {
        let of = |name, bad: Option<Bad>| bad.map(|bad| (name, bad));
        of("ClasticAnalysis", analysis(&self.analysis))
            .or_else(|| of("Acceptance", acceptance(&self.acceptance)))
            .or_else(|| of("RuptureRules", rules(&self.rules)))
            .or_else(|| of("FrictionLaw", law(&self.law)))
            .or_else(|| of("ClasticProgress", progress(&self.progress)))
    }
}

fn analysis(analysis: &ClasticAnalysis) -> Option<Bad> {
    let kind = || match analysis.kind {
        AnalysisKind::Dynamic { dt, theta } => {
            outside("dt", dt, TIME_STEP).or_else(|| outside("theta", theta, THETA))
        }
        AnalysisKind::Compaction { agitation, .. } => outside("agitation", agitation, AGITATION),
        AnalysisKind::Static => None,
    };
    kind()
        .or_else(|| outside("path_theta", analysis.path_theta?, THETA))
        .or_else(|| outside("strength", analysis.strength, FACTOR))
        .or_else(|| outside("gravity x", analysis.gravity.x, GRAVITY))
        .or_else(|| outside("gravity y", analysis.gravity.y, GRAVITY))
        .or_else(|| outside("thickness", analysis.thickness, THICKNESS))
}

fn acceptance(acceptance: &Acceptance) -> Option<Bad> {
    outside("residual", acceptance.residual, RESIDUAL)
        .or_else(|| outside("turn", acceptance.turn, TURN))
        .or_else(|| outside("motion_step", acceptance.motion_step, MOTION_STEP))
        .or_else(|| outside("overlap", acceptance.overlap, PART))
        .or_else(|| outside("regularisation", acceptance.regularisation, PART))
}

fn rules(rules: &RuptureRules) -> Option<Bad> {
    outside("tolerance", rules.tolerance, OVERLOAD)
        .or_else(|| outside("density", rules.density, DENSITY_OF_RUPTURES))
        .or_else(|| outside("brittleness", rules.brittleness, BRITTLENESS))
        .or_else(|| outside("slack", rules.slack, PART))
        .or_else(|| outside("multiplier", rules.multiplier, PART))
}

fn law(law: &FrictionLaw) -> Option<Bad> {
    let none =
        [law.in_statics, law.in_dynamics].into_iter().flatten().find(|c| c.factorisations == 0)?;
    Some(Bad::new("factorisations", none.factorisations, "a number of factorisations of 1 or more"))
}

fn progress(progress: &ClasticProgress) -> Option<Bad> {
    let ClasticProgress { total, done, tried, ref course, .. } = *progress;
    if !course.is_sorted_by(|a, b| a[0] < b[0]) {
        return Some(Bad::new("course", course, "points in ascending order"));
    }
    let finite = |share| finite("course", share, "finite points");
    if let Some(bad) = course.iter().flatten().copied().find_map(finite) {
        return Some(bad);
    }
    [("total", total), ("done", done), ("tried", tried)]
        .into_iter()
        .find_map(|(name, value)| not_negative(name, value, "a number of increments, not below 0"))
}
