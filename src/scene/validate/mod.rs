//! Checks of values and references in a scene, by topic.
//!
//! Every check adds a [`Finding`] and goes on, so that one run reports everything.

mod accuracy;
mod added_walls;
mod bonds;
mod carried;
mod cell;
mod crossing;
mod cuts;
mod findings;
mod materials;
mod measures;
mod membranes;
mod outline;
mod parts;
mod places;
mod pour;
mod references;
mod restitution;
mod rigid;
mod select;
mod selections;
mod settings;
mod sizes;
mod specimen;
mod stages;
mod state;
mod stops;
mod thin_walls;
mod wall_controls;
mod walls;

use super::diagnostic::Finding;
use super::format::{Scene, Specimen, Stage};
use super::memory;
use super::specimen_file::StoredSpecimen;
use crate::run::minerals::specimen as cut_specimen;
use crate::run::particles::ParticleSeed;
use findings::Findings;
pub(crate) use places::is_behind;

/// Checks a scene, with the stored specimen that it names. The scene need not come from a text.
#[must_use]
pub fn validate(scene: &Scene, specimen: Option<&StoredSpecimen>) -> Vec<Finding> {
    findings(scene, specimen, &[])
}

/// Checks a scene with made-up values at the paths `made_up`.
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
    cell::check(&context, &mut findings);
    specimen::check(&context, &mut findings);
    cuts::check(&context, &mut findings);
    thin_walls::check(&context, &mut findings);
    select::groups(&context, &mut findings);
    stages::check(&context, &mut findings);
    restitution::check(&context, &mut findings);
    crossing::check(&context, &mut findings);
    added_walls::check(&context, &mut findings);
    selections::check(&context, &mut findings);
    measures::check(&context, &mut findings);
    findings.into_list()
}

/// Maximum deviation of the normals of opposite walls (1 - cos).
const ASKEW: f64 = 1e-9;

/// The scene and the names in it.
struct Context<'a> {
    scene: &'a Scene,
    specimen: Option<&'a StoredSpecimen>,
    materials: Vec<&'a str>,
    walls: Vec<&'a str>,
    stages: Vec<&'a str>,
    /// Names of the membranes that stages make, and of those of a saved state.
    membranes: Vec<&'a str>,
    /// Number of particles, if known.
    particles: Option<u64>,
    /// The specimen after `minerals` and `keep`, if it has any and its particles are known.
    seeds: Option<Vec<ParticleSeed>>,
}

impl<'a> Context<'a> {
    fn new(scene: &'a Scene, specimen: Option<&'a StoredSpecimen>) -> Self {
        let seeds = cuts::is_manageable(scene, specimen).then(|| cut_specimen(scene, specimen));
        let whole = Self::uncut(scene, specimen);
        let particles = match &seeds {
            Some(seeds) => Some(seeds.len() as u64),
            // Of a run that is resumed the particles are those that are left.
            None if scene.keep.is_some() => {
                specimen.filter(|stored| stored.is_resumed()).map(|stored| stored.rows.len() as u64)
            }
            None => whole.particles,
        };
        Self { particles, seeds, ..whole }
    }

    /// The context before `minerals` and `keep`.
    fn uncut(scene: &'a Scene, specimen: Option<&'a StoredSpecimen>) -> Self {
        Self {
            scene,
            specimen,
            materials: scene.materials.keys().map(String::as_str).collect(),
            walls: scene.walls.iter().map(|wall| wall.name.as_str()).collect(),
            stages: scene.stages.iter().map(Stage::name).collect(),
            membranes: membranes::names(scene, specimen),
            particles: match &scene.specimen {
                Specimen::File { .. } | Specimen::State { .. } if specimen.is_none() => None,
                of => Some(memory::particles(of, specimen)),
            },
            seeds: None,
        }
    }

    /// Whether the scene starts from a saved state that was read. A run that is resumed does not
    /// read it again, and its particles are elsewhere.
    fn starts_here(&self) -> bool {
        let state = self.specimen.and_then(|stored| stored.state.as_ref());
        state.is_some_and(|state| state.saved.is_some())
    }
}
