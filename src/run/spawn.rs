//! Fills a world with a scene: settings, materials, particles, walls, explicit bonds, stages.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use clastic_components::body::{AngularVelocity, BodyId, Group, Origin, Position, Probe, Velocity};
use clastic_components::energy::EnergyLedger;
use clastic_components::identity::{Identities, NextIdentities};
use clastic_components::increment as inc;
use clastic_components::material::{BondLaw, ContactLaw, Material, Materials};
use clastic_components::observation::{Measures, Observation};
use clastic_components::particle::{MaterialIndex, Particle};
use clastic_components::wall::WallName;
use clastic_components::wall_shape::WallShape;
use clastic_cone::clarabel::Clarabel;
use clastic_cone::condensed::Condensed;
use clastic_systems::solve_program::Solver;

use super::cement::bond_pairs;
use super::key_results::KeyResults;
use super::minerals::specimen;
use super::sanity::Sanity;
use super::stages::Script;
use super::start;
use super::wall_pieces::{count, pieces};
use crate::scene::StoredMembrane;
use crate::scene::format as scene;
use crate::scene::specimen_file::StoredSpecimen;

/// The walls of a scene, for stages that bring them in, with the identity of the first one.
#[derive(Resource, Clone, Debug, Default)]
pub struct WallCatalogue {
    /// Identity of the first wall: the number of particles.
    pub first: u32,
    /// All walls of the scene, present or not.
    pub walls: Vec<scene::Wall>,
    /// The same walls where the run began, if they are those of a saved state.
    /// [`walls`](Self::walls) are as the scene of that state drew them, which is where a stage
    /// brings them in.
    pub inherited: Option<Vec<scene::Wall>>,
    /// The membranes that came with these walls.
    pub membranes: Vec<StoredMembrane>,
}

impl WallCatalogue {
    /// Identity of the first piece of a wall; at the end of the list, the first that no wall has.
    #[must_use]
    pub fn first_of(&self, index: usize) -> u32 {
        self.first + self.walls[..index].iter().map(count).sum::<u32>()
    }

    /// The wall to which a body belongs.
    #[must_use]
    pub fn wall(&self, body: BodyId) -> Option<&scene::Wall> {
        let mut ends = self.first;
        let is_of = |wall: &&scene::Wall| {
            ends += count(wall);
            body.0 < ends
        };
        self.walls.iter().find(is_of).filter(|_| body.0 >= self.first)
    }
}

/// The bond laws of the materials as the scene has them, with their scatter.
#[derive(Resource, Clone, Debug, Default)]
pub struct BondsOfMaterials(pub Vec<Option<scene::Bond>>);

/// Inserts the settings of a scene: all resources that no increment changes, and the analysis of
/// stages that name none.
pub fn insert_settings(world: &mut World, scene: &scene::Scene, particles: u32) {
    world.insert_resource(WallCatalogue {
        first: particles,
        walls: scene.walls.clone(),
        inherited: None,
        membranes: Vec::new(),
    });
    world.insert_resource(analysis(scene, scene.analysis, scene.gravity));
    world.insert_resource(inc::FrictionLaw::from(scene.friction_law));
    world.insert_resource(scene.rupture);
    world.insert_resource(scene.corrector.unwrap_or(inc::Corrector::OFF));
    world.insert_resource(scene.acceptance);
    world.insert_resource(Solver(match &scene.solver {
        scene::Solver::Condensed(settings) => Box::new(Condensed::new(**settings)),
        &scene::Solver::Clarabel { tolerance, max_iterations } => {
            Box::new(Clarabel { tolerance, max_iterations, ..Default::default() })
        }
    }));
    let bonds = scene.materials.values().map(|material| material.bond);
    world.insert_resource(BondsOfMaterials(bonds.collect()));
    world.insert_resource(Materials(
        scene
            .materials
            .iter()
            .map(|(name, m)| Material {
                name: name.clone(),
                density: m.density,
                contact: contact_law(&m.contact),
                bond: m.bond.as_ref().map(bond_law),
            })
            .collect(),
    ));
}

/// Fills `world` with a scene. The world must have the resources of
/// [`ClasticPlugins`](crate::ClasticPlugins).
///
/// # Panics
/// If the world has bodies already. A world holds one scene: bodies are numbered from 0, and the
/// bodies of two scenes would have the same numbers.
pub fn spawn_scene(world: &mut World, scene: &scene::Scene, stored: Option<&StoredSpecimen>) {
    let bodies = world.query::<&BodyId>().iter(world).count();
    assert!(
        bodies == 0,
        "spawn_scene: the world has {bodies} bodies already, and a world holds one scene; use a new world"
    );
    if let Some(state) = stored.and_then(|stored| stored.state.as_ref())
        && let Some(saved) = &state.saved
    {
        return start::from_saved(world, scene, state, saved);
    }
    let seeds = specimen(scene, stored);
    insert_settings(world, scene, seeds.len() as u32);
    let names: Vec<&String> = scene.materials.keys().collect();
    let probes: BTreeMap<u32, &String> = scene.probes.iter().map(|(name, i)| (*i, name)).collect();
    for (i, seed) in seeds.iter().enumerate() {
        let index =
            seed.material.as_ref().and_then(|m| names.iter().position(|n| *n == m)).unwrap_or(0);
        let density = scene.materials.get(names[index]).map_or(0.0, |m| m.density);
        let mut entity = world.spawn((
            BodyId(i as u32),
            Particle::disk(seed.radius, density, scene.thickness),
            Position(seed.position),
            Origin(seed.position),
            Velocity(seed.velocity),
            AngularVelocity(seed.angular_velocity),
            MaterialIndex(index as u32),
        ));
        if let Some(group) = &seed.group {
            entity.insert(Group(group.clone()));
        }
        if let Some(probe) = seed.probe.as_ref().or(probes.get(&(i as u32)).copied()) {
            entity.insert(Probe(probe.clone()));
        }
    }

    if let Some(cell) = &scene.cell {
        super::cell::spawn(world, cell);
    }
    for wall in scene.walls.iter().filter(|w| w.present) {
        spawn_wall(world, &wall.name);
    }
    // Walls that come later have the identities after the particles too.
    let body = world.resource::<WallCatalogue>().first_of(scene.walls.len());
    world.get_resource_or_init::<Identities>().skip_to(NextIdentities { body, bond: 0 });
    if scene.output.energy {
        world.insert_resource(EnergyLedger::default());
    }
    begin_script(world, scene);
}

/// Adds the bonds that the scene lists, and its stages, to a world that has its bodies.
pub(super) fn begin_script(world: &mut World, scene: &scene::Scene) {
    bond_pairs(world, scene.bonds.iter().map(|bond| (bond.a, bond.b)));
    // The stages look at the record, whoever writes it.
    world.init_resource::<Observation>();
    world.init_resource::<Measures>();
    world.insert_resource(KeyResults::of_scene(scene));
    world.init_resource::<Sanity>();
    world.insert_resource(Script::new(scene));
}

/// Analysis of a stage.
#[must_use]
pub fn analysis(scene: &scene::Scene, kind: scene::Analysis, gravity: (f64, f64)) -> inc::Analysis {
    let (kind, path_theta) = match kind {
        scene::Analysis::Static => (inc::AnalysisKind::Static, None),
        // With theta below 1 rigid contacts have a rebound of their own.
        scene::Analysis::Dynamic { dt, theta } if scene.has_restitution() => {
            (inc::AnalysisKind::Dynamic { dt, theta: 1.0 }, Some(theta))
        }
        scene::Analysis::Dynamic { dt, theta } => (inc::AnalysisKind::Dynamic { dt, theta }, None),
    };
    inc::Analysis { kind, gravity: gravity.into(), thickness: scene.thickness, path_theta }
}

fn compliance(stiffness: Option<f64>) -> f64 {
    stiffness.map_or(0.0, f64::recip)
}

/// The engine's law for a scene's contact.
#[must_use]
pub fn contact_law(contact: &scene::Contact) -> ContactLaw {
    ContactLaw {
        normal_compliance: compliance(contact.normal_stiffness),
        tangential_compliance: compliance(contact.tangential_stiffness),
        friction: contact.friction,
        rolling_friction: contact.rolling_friction,
        restitution: contact.restitution,
    }
}

/// The engine's law for a scene's bond.
#[must_use]
pub fn bond_law(bond: &scene::Bond) -> BondLaw {
    BondLaw {
        normal_compliance: compliance(bond.normal_stiffness),
        tangential_compliance: compliance(bond.tangential_stiffness),
        friction: bond.friction,
        rolling_friction: bond.rolling_friction,
        cohesion: bond.cohesion,
        tensile_strength: bond.tensile_strength,
    }
}

/// Spawns a wall of the catalogue by name: all its pieces.
pub fn spawn_wall(world: &mut World, name: &str) {
    let catalogue = world.resource::<WallCatalogue>();
    let Some(index) = catalogue.walls.iter().position(|w| w.name == name) else { return };
    let first = catalogue.first_of(index);
    let wall = catalogue.walls[index].clone();
    for (piece, id) in pieces(&wall).into_iter().zip(first..) {
        let mut entity = world.spawn((
            BodyId(id),
            piece.wall,
            WallName(wall.name.clone()),
            Position(piece.position),
            Origin(piece.position),
            contact_law(&wall.contact),
        ));
        if piece.shape != WallShape::Line {
            entity.insert(piece.shape);
        }
        if let Some(probe) = &wall.probe {
            entity.insert(Probe(probe.clone()));
        }
    }
}

/// The wall with the given name, if it is there: the first piece of a polyline.
pub fn find_wall(world: &mut World, name: &str) -> Option<Entity> {
    find_walls(world, name).first().copied()
}

/// The pieces of the wall with the given name that are there, by identity.
pub fn find_walls(world: &mut World, name: &str) -> Vec<Entity> {
    let mut walls = world.query::<(Entity, &BodyId, &WallName)>();
    let named = walls.iter(world).filter(|(.., n)| n.0 == name);
    let mut found: Vec<_> = named.map(|(e, id, _)| (*id, e)).collect();
    found.sort_unstable_by_key(|(id, _)| *id);
    found.into_iter().map(|(_, e)| e).collect()
}
