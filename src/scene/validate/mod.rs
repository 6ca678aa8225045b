//! What a scene may mean: checks of values and references, by topic.
//!
//! Every check adds a [`Finding`] and goes on, so that one run reports everything.

mod findings;
mod materials;
mod measures;
mod places;
mod settings;
mod specimen;
mod stages;
mod walls;

use super::diagnostic::Finding;
use super::format::{Scene, Specimen, Stage};
use super::specimen_file::StoredSpecimen;
use findings::Findings;
pub(super) use places::coincident;

/// Most particles of a specimen: beyond, memory runs out before anything is seen.
pub const MOST_PARTICLES: u64 = 5_000_000;

/// Checks a scene, with the stored specimen that it names, that need not come from a text.
#[must_use]
pub fn validate(scene: &Scene, specimen: Option<&StoredSpecimen>) -> Vec<Finding> {
    findings(scene, specimen, &[])
}

/// Checks a scene some values of which, at the paths `made_up`, are not its own.
pub(super) fn findings(
    scene: &Scene,
    specimen: Option<&StoredSpecimen>,
    made_up: &[String],
) -> Vec<Finding> {
    let context = Context::new(scene, specimen);
    let mut findings = Findings::new(made_up);
    settings::check(&context, &mut findings);
    materials::check(&context, &mut findings);
    walls::check(&context, &mut findings);
    specimen::check(&context, &mut findings);
    stages::check(&context, &mut findings);
    measures::check(&context, &mut findings);
    findings.into_list()
}

/// The scene and the names in it.
struct Context<'a> {
    scene: &'a Scene,
    specimen: Option<&'a StoredSpecimen>,
    materials: Vec<&'a str>,
    walls: Vec<&'a str>,
    stages: Vec<&'a str>,
    /// Number of particles, if it is known.
    particles: Option<u64>,
}

impl<'a> Context<'a> {
    fn new(scene: &'a Scene, specimen: Option<&'a StoredSpecimen>) -> Self {
        Self {
            scene,
            specimen,
            materials: scene.materials.keys().map(String::as_str).collect(),
            walls: scene.walls.iter().map(|wall| wall.name.as_str()).collect(),
            stages: scene.stages.iter().map(stage_name).collect(),
            particles: match &scene.specimen {
                Specimen::Particles(list) => Some(list.len() as u64),
                Specimen::Lattice { columns, rows, .. } => {
                    let (columns, rows) = (u64::from(*columns), u64::from(*rows));
                    Some((columns * rows).saturating_sub(rows / 2))
                }
                Specimen::Packing { count, .. } => Some(u64::from(*count)),
                Specimen::File { .. } => specimen.map(|specimen| specimen.rows.len() as u64),
            },
        }
    }
}

fn stage_name(stage: &Stage) -> &str {
    match stage {
        Stage::Compact(stage) => &stage.name,
        Stage::Cement(stage) => &stage.name,
        Stage::Load(stage) => &stage.name,
    }
}
