//! The walls of a scene: the catalogue, and the bodies in the world.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;

use super::laws::contact_law;
use super::touching::placed;
use super::wall_pieces::{count, pieces};
use crate::scene::StoredMembrane;
use crate::scene::format as scene;

/// The walls of a scene, for stages that bring them in, with the identity of the first one. It is
/// part of the state of a run: walls of a saved state do not follow from the scene.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    /// Names of the rigid groups of that state, whether they are still there or not. The scene does
    /// not list them.
    pub rigid: Vec<String>,
}

impl WallCatalogue {
    /// Identity of the first piece of a wall; at the end of the list, the first that no wall has.
    pub(crate) fn first_of(&self, index: usize) -> u32 {
        self.first + self.walls[..index].iter().map(count).sum::<u32>()
    }

    /// The wall to which a body belongs.
    pub fn wall(&self, body: BodyId) -> Option<&scene::Wall> {
        let mut ends = self.first;
        let is_of = |wall: &&scene::Wall| {
            ends += count(wall);
            body.0 < ends
        };
        self.walls.iter().find(is_of).filter(|_| body.0 >= self.first)
    }
}

/// Spawns a wall of the catalogue by name: all its pieces. One that comes at the outermost particles
/// and meets none is where it is drawn.
pub fn spawn_wall(world: &mut World, name: &str) {
    let catalogue = world.resource::<WallCatalogue>();
    let Some(index) = catalogue.walls.iter().position(|w| w.name == name) else { return };
    let first = catalogue.first_of(index);
    let drawn = catalogue.walls[index].clone();
    let placed = if drawn.touching { placed(world, &drawn) } else { None };
    let wall = placed.unwrap_or(drawn);
    for (piece, id) in pieces(&wall).into_iter().zip(first..) {
        let mut entity = world.spawn((
            BodyId(id),
            piece.wall,
            WallName(wall.name.clone()),
            BodyPosition(piece.position),
            BodyOrigin(piece.position),
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
    let ordered = walls.iter(world).sort_unstable::<&BodyId>();
    ordered.filter(|(.., of)| of.0 == name).map(|(wall, ..)| wall).collect()
}

/// Two walls by name, if both are there.
pub(crate) fn find_pair(world: &mut World, a: &str, b: &str) -> Option<[Entity; 2]> {
    Some([find_wall(world, a)?, find_wall(world, b)?])
}

/// The length on which a stress acts: the distance of two walls, if they are named and there.
pub(crate) fn length_between(
    world: &mut World,
    between: Option<&(String, String)>,
) -> LoadedLength {
    let pair = between.and_then(|(a, b)| find_pair(world, a, b));
    pair.map_or(LoadedLength::Segment, |[a, b]| LoadedLength::Between(a, b))
}
