//! What a scene may mean: checks of values and references, by topic.
//!
//! Every check adds a [`Finding`] and goes on, so that one run reports everything.

mod crossing;
mod findings;
mod materials;
mod measures;
mod places;
mod restitution;
mod selections;
mod settings;
mod specimen;
mod stages;
mod walls;

use super::diagnostic::Finding;
use super::format::{Scene, Specimen, Stage};
use super::memory;
use super::specimen_file::StoredSpecimen;
use findings::Findings;
pub(super) use findings::{GREATEST, SMALLEST};
pub(super) use places::coincident;

/// Most particles of a specimen. The identities of bodies and the time that a run takes allow no
/// more; what fits into the memory of a machine is a matter of [`memory`].
pub const MOST_PARTICLES: u64 = 5_000_000;

/// Most memory of a scene, bytes, on whatever machine: 5 million bonded disks take 50 GB.
pub const MOST_MEMORY: f64 = 100e9;

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
    restitution::check(&context, &mut findings);
    crossing::check(&context, &mut findings);
    selections::check(&context, &mut findings);
    measures::check(&context, &mut findings);
    findings.into_list()
}

/// Normals of opposite walls may deviate from each other by this much (1 - cos).
const ASKEW: f64 = 1e-9;

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
            stages: scene.stages.iter().map(Stage::name).collect(),
            particles: match &scene.specimen {
                Specimen::File { .. } if specimen.is_none() => None,
                of => Some(memory::particles(of, specimen)),
            },
        }
    }
}
