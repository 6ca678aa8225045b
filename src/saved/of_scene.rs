//! What a scene that starts from a saved state needs to know of it.

use std::collections::BTreeMap;

use clastic_components::body::{BodyId, BodyPosition};
use clastic_components::membrane::Course;
use clastic_components::rigid_group::RigidGroup;
use clastic_components::wall::Wall as WallLine;
use clastic_systems::membranes::{MEMBRANES, MembraneStates};
use clastic_systems::state::StateError;
use glam::DVec2;

use super::{SavedState, find};
use crate::run::wall_pieces::{moved, pieces};
use crate::run::walls::WallCatalogue;
use crate::scene::StoredMembrane;
use crate::scene::format::Wall;

impl SavedState {
    /// The membranes, with the names of their walls.
    ///
    /// # Errors
    /// If the entry of the world is of another type.
    pub fn membranes(&self) -> Result<Vec<StoredMembrane>, StateError> {
        let catalogue = self.catalogue();
        let name = |id| catalogue.wall(id).map_or_else(String::new, |wall| wall.name.clone());
        let membranes: Option<MembraneStates> = find(&self.world, MEMBRANES)?;
        let seen = membranes.into_iter().flat_map(|all| all.0).map(|membrane| {
            let between = match membrane.course {
                Course::Closed => None,
                Course::Between { first, second, .. } => Some((name(first), name(second))),
            };
            StoredMembrane { name: membrane.name, between }
        });
        Ok(seen.collect())
    }

    /// Names of the rigid groups that have walls.
    ///
    /// # Errors
    /// If the world does not have them.
    pub(crate) fn groups_with_walls(&self) -> Result<Vec<String>, StateError> {
        let walls = self.world.components::<BodyId, WallLine>("wall")?;
        let is_wall = |id: &BodyId| walls.binary_search_by_key(id, |(id, _)| *id).is_ok();
        self.groups_with(|group| group.members.iter().any(is_wall))
    }

    /// Names of some rigid groups, in the order of identities.
    pub(crate) fn groups_with(
        &self,
        has: impl Fn(&RigidGroup) -> bool,
    ) -> Result<Vec<String>, StateError> {
        let groups = self.world.components::<BodyId, RigidGroup>("rigid_group")?.into_iter();
        Ok(groups.filter(|(_, group)| has(group)).map(|(_, group)| group.name).collect())
    }

    /// The walls of the scene where they are now. Those that are not there are as it drew them.
    ///
    /// # Errors
    /// If the world does not have them.
    pub(crate) fn walls_now(&self) -> Result<Vec<Wall>, StateError> {
        let lines: BTreeMap<BodyId, WallLine> =
            self.world.components("wall")?.into_iter().collect();
        let middles: BTreeMap<BodyId, BodyPosition> =
            self.world.components("position")?.into_iter().collect();
        let catalogue = self.catalogue();
        let now = self.walls.iter().enumerate().map(|(k, wall)| {
            let id = BodyId(catalogue.first_of(k));
            match (lines.get(&id), middles.get(&id), pieces(wall).first()) {
                (Some(line), Some(middle), _) if wall.shape.is_line() => {
                    let half = line.tangent * line.half_length;
                    let (start, end) = ((middle.0 - half).into(), (middle.0 + half).into());
                    Wall { start, end, ..wall.clone() }
                }
                (Some(now), Some(middle), Some(drawn)) => {
                    let tangent = drawn.wall.tangent;
                    let by = DVec2::new(tangent.dot(now.tangent), tangent.perp_dot(now.tangent));
                    // A wall that has not turned keeps its digits.
                    let by = if tangent == now.tangent { DVec2::X } else { by };
                    moved(wall, drawn.position, by, middle.0)
                }
                _ => wall.clone(),
            }
        });
        Ok(now.collect())
    }

    fn catalogue(&self) -> WallCatalogue {
        WallCatalogue {
            first: self.first_wall,
            walls: self.walls.clone(),
            ..WallCatalogue::default()
        }
    }
}
