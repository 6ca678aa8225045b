//! Checks of values and references in a scene, by topic.
//!
//! Every check adds a [`Finding`] and goes on, so that one run reports everything.

mod bonds;
mod carried;
mod cell;
mod cuts;
mod findings;
mod load;
mod materials;
mod measures;
mod membranes;
mod parts;
mod places;
mod pour;
mod rigid;
mod select;
mod settings;
mod sizes;
mod specimen;
mod stages;
mod stops;
mod wall_controls;
mod walls;

use std::collections::BTreeSet;

use super::format::{Particle, Scene, Specimen, Stage, Wall};
use super::memory;
use super::stored_state::{StoredSpecimen, StoredState};
use crate::run::minerals::specimen as cut_specimen;
use crate::run::particles::BOUNDARY;
use crate::text::diagnostic::Finding;
use findings::Findings;
pub(crate) use places::is_behind;

/// Checks a scene, with the stored specimen that it names, and made-up values at the paths `made_up`.
pub(super) fn findings(
    scene: &Scene,
    specimen: Option<&StoredSpecimen>,
    made_up: &[String],
) -> Vec<Finding> {
    let context = Context::new(scene, specimen);
    let mut findings = Findings::new(&context, made_up);
    let at = &mut findings.root();
    settings::check(at);
    materials::check(at);
    walls::check(at);
    specimen::check(at);
    cell::check(at);
    cuts::check(at);
    walls::beside_thin(at);
    select::groups(at);
    stages::check(at);
    materials::restitution(at);
    places::crossing(at);
    walls::added(at);
    select::regions(at);
    measures::check(at);
    findings.list
}

/// The scene and the names in it.
struct Context<'a> {
    scene: &'a Scene,
    specimen: Option<&'a StoredSpecimen>,
    materials: Vec<&'a str>,
    walls: Vec<&'a str>,
    stages: Vec<&'a str>,
    measures: Vec<&'a str>,
    /// Names of the membranes that stages make, and of those of a saved state.
    membranes: Vec<&'a str>,
    /// Number of particles, if known.
    particles: Option<u64>,
    /// The specimen after `minerals` and `keep`, if it has any and its particles are known.
    seeds: Option<Vec<Particle>>,
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
            measures: scene.measures.iter().map(|measure| measure.name.as_str()).collect(),
            membranes: membranes::names(scene, specimen),
            particles: match &scene.specimen {
                Specimen::File { .. } | Specimen::State { .. } if specimen.is_none() => None,
                of => Some(memory::particles(of, specimen)),
            },
            seeds: None,
        }
    }

    fn wall(&self, name: &str) -> Option<&'a Wall> {
        self.scene.walls.iter().find(|wall| wall.name == name)
    }

    /// The saved state from which the scene starts, whose walls or cell it may take.
    fn state(&self) -> Option<&'a StoredState> {
        self.specimen?.state.as_ref()
    }

    /// Whether the walls of the scene are those of that state.
    fn takes_walls(&self) -> bool {
        self.specimen.and_then(StoredSpecimen::gives_walls).is_some()
    }

    /// Whether the specimen is that of a run that is resumed.
    fn is_resumed(&self) -> bool {
        self.specimen.is_some_and(StoredSpecimen::is_resumed)
    }

    /// Whether the specimen is known: one in a file has been read.
    fn is_read(&self) -> bool {
        self.specimen.is_some() || !matches!(self.scene.specimen, Specimen::File { .. })
    }

    fn listed(&self) -> &'a [Particle] {
        if let Specimen::Particles(list) = &self.scene.specimen { list } else { &[] }
    }

    /// Names of the groups to which particles of the specimen belong, but for those of a state.
    fn groups_of_specimen(&self) -> BTreeSet<&'a str> {
        let listed = self.listed().iter().filter_map(|particle| particle.group.as_deref());
        let stored = self.specimen.into_iter().flat_map(|stored| &stored.groups).flatten();
        let is_lattice = matches!(self.scene.specimen, Specimen::Lattice { .. });
        listed.chain(stored.map(String::as_str)).chain(is_lattice.then_some(BOUNDARY)).collect()
    }

    fn at_start(&self) -> Vec<Particle> {
        cut_specimen(self.scene, self.specimen)
    }
}
