//! Changes between two increments: laws, loads, walls, bodies and bonds. The engine checks the
//! values in the next increment, and says what is wrong with them.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use clastic::components::bond::{Bond, BondId, BondState};
use clastic::components::material::{BondLaw, ContactLaw, Materials};
use clastic::components::wall::WallRotation;
use clastic::prelude::{
    BodyDrive, BodyDrives, BodyId, BodyPosition, BodyVelocity, LoadControl, LoadedLength,
    MaterialIndex, Particle, WallControl, WallSlide,
};
use clastic::run::cement::bond_pairs;
use clastic::run::spawn::{find_wall, find_walls};
use glam::DVec2;

use crate::errors::Error;
use crate::model::Model;

/// Values by the names of a scene's fields.
pub type Fields = BTreeMap<String, f64>;
/// One value for each bond, or one for all.
pub type Columns = BTreeMap<String, Vec<f64>>;

fn value<T>(message: String) -> Result<T, Error> {
    Err(Error::Value(message))
}

/// Compliance of a stiffness; infinity is rigid.
fn compliance(stiffness: f64) -> f64 {
    stiffness.recip()
}

fn set_contact(law: &mut ContactLaw, fields: &Fields) -> Result<(), Error> {
    for (name, x) in fields {
        match name.as_str() {
            "normal_stiffness" => law.normal_compliance = compliance(*x),
            "tangential_stiffness" => law.tangential_compliance = compliance(*x),
            "rolling_stiffness" => law.rolling_compliance = compliance(*x),
            "friction" => law.friction = *x,
            "rolling_friction" => law.rolling_friction = *x,
            "restitution" => law.restitution = *x,
            _ => {
                return value(format!(
                    "a contact has no `{name}`; it has normal_stiffness, tangential_stiffness, \
                     rolling_stiffness, friction, rolling_friction and restitution"
                ));
            }
        }
    }
    Ok(())
}

fn set_bond(law: &mut BondLaw, name: &str, x: f64) -> Result<(), Error> {
    match name {
        "normal_stiffness" => law.normal_compliance = compliance(x),
        "tangential_stiffness" => law.tangential_compliance = compliance(x),
        "rolling_stiffness" => law.rolling_compliance = compliance(x),
        "friction" => law.friction = x,
        "rolling_friction" => law.rolling_friction = x,
        "cohesion" => law.cohesion = x,
        "tensile_strength" => law.tensile_strength = x,
        _ => {
            return value(format!(
                "a bond has no `{name}`; it has normal_stiffness, tangential_stiffness, \
                 rolling_stiffness, friction, rolling_friction, cohesion and tensile_strength"
            ));
        }
    }
    Ok(())
}

/// Value in row `k` of a column, which may hold one value for all rows.
fn at(name: &str, column: &[f64], k: usize, rows: usize) -> Result<f64, Error> {
    match column {
        [one] => Ok(*one),
        _ if column.len() == rows => Ok(column[k]),
        _ => value(format!("`{name}` has {} values; give one, or {rows}", column.len())),
    }
}

/// A control of a wall.
pub enum Control {
    /// It stays.
    Fixed,
    /// Displacement per increment, m.
    Displacement(DVec2),
    /// Velocity, m/s.
    Velocity(DVec2),
    /// Point and angle per increment, rad.
    Rotation(DVec2, f64),
    /// Force along the inward normal, N.
    Force(f64),
    /// Stress along the inward normal, Pa, and the walls between which its length lies.
    Stress(f64, Option<(String, String)>),
}

impl Model {
    /// Changes the law of the contacts of a material, or of a wall.
    pub fn change_contact(&mut self, of: &str, fields: &Fields) -> Result<(), Error> {
        let world = self.world();
        let mut materials = world.resource_mut::<Materials>();
        if let Some(material) = materials.0.iter_mut().find(|material| material.name == of) {
            let mut law = material.contact;
            set_contact(&mut law, fields)?;
            material.contact = law;
            return Ok(());
        }
        let names: Vec<_> = materials.0.iter().map(|m| format!("`{}`", m.name)).collect();
        let walls = find_walls(world, of);
        if walls.is_empty() {
            return value(format!(
                "no material and no wall is called `{of}`; materials are {}",
                names.join(", ")
            ));
        }
        for wall in walls {
            let mut law = world.get::<ContactLaw>(wall).copied().unwrap_or_default();
            set_contact(&mut law, fields)?;
            world.entity_mut(wall).insert(law);
        }
        Ok(())
    }

    /// Changes the law of bonds, of all or of those with these identities.
    pub fn change_bonds(&mut self, ids: Option<&[u32]>, columns: &Columns) -> Result<(), Error> {
        let mut bonds = self.bonds(ids)?;
        let rows = bonds.len();
        let world = self.world();
        for (k, (_, bond)) in bonds.iter_mut().enumerate() {
            for (name, column) in columns {
                set_bond(&mut bond.law, name, at(name, column, k, rows)?)?;
            }
        }
        for (entity, bond) in bonds {
            world.entity_mut(entity).insert(bond);
        }
        Ok(())
    }

    /// Bonds by identity; all that are intact without a list.
    fn bonds(&mut self, ids: Option<&[u32]>) -> Result<Vec<(Entity, Bond)>, Error> {
        let world = self.world();
        let mut query = world.query::<(Entity, &BondId, &Bond, &BondState)>();
        let mut all: Vec<_> = query.iter(world).map(|(e, id, b, s)| (id.0, e, *b, *s)).collect();
        all.sort_unstable_by_key(|(id, ..)| *id);
        let Some(ids) = ids else {
            let intact = all.into_iter().filter(|(.., state)| *state == BondState::Intact);
            return Ok(intact.map(|(_, entity, bond, _)| (entity, bond)).collect());
        };
        let find = |id: &u32| match all.binary_search_by_key(id, |(id, ..)| *id) {
            Ok(k) => Ok((all[k].1, all[k].2)),
            Err(_) => value(format!("no bond has the identity {id}")),
        };
        ids.iter().map(find).collect()
    }

    /// Takes bonds away, as if they had never been: they do not count as broken.
    pub fn remove_bonds(&mut self, ids: &[u32]) -> Result<(), Error> {
        for (entity, _) in self.bonds(Some(ids))? {
            self.world().despawn(entity);
        }
        Ok(())
    }

    /// Bonds pairs of particles by the laws of their materials. Returns the identities of all new
    /// bonds.
    pub fn cement(&mut self, pairs: &[(u32, u32)]) -> Result<Vec<u32>, Error> {
        let ids: Vec<u32> = pairs.iter().flat_map(|(a, b)| [*a, *b]).collect();
        self.particles(&ids)?;
        if let Some((a, _)) = pairs.iter().find(|(a, b)| a == b) {
            return value(format!("particle {a} cannot be bonded with itself"));
        }
        let bodies = self.bodies();
        let row = |id: u32| bodies.row(BodyId(id)).map_or(0, |row| row as u32);
        let rows: Vec<_> = pairs.iter().map(|(a, b)| (row(*a), row(*b))).collect();
        let world = self.world();
        let before = bond_ids(world);
        bond_pairs(world, rows.into_iter());
        Ok(bond_ids(world).into_iter().filter(|id| before.binary_search(id).is_err()).collect())
    }

    /// Takes particles away with their contacts and bonds.
    pub fn remove(&mut self, ids: &[u32]) -> Result<(), Error> {
        let entities = self.particles(ids)?;
        if entities.len() >= self.bodies().particles {
            return value("nothing would be left; remove fewer particles".to_owned());
        }
        for entity in entities {
            self.world().despawn(entity);
        }
        Ok(())
    }

    /// Adds disks: centre, radius, velocity. Returns their identities.
    pub fn add(&mut self, disks: &[[f64; 5]], material: &str) -> Result<Vec<u32>, Error> {
        let thickness = self.loaded.scene.thickness;
        let world = self.world();
        let materials = &world.resource::<Materials>().0;
        let Some(index) = materials.iter().position(|m| m.name == material) else {
            let names: Vec<_> = materials.iter().map(|m| format!("`{}`", m.name)).collect();
            return value(format!(
                "no material is called `{material}`: there is {}",
                names.join(", ")
            ));
        };
        let density = materials[index].density;
        let spawn = |[x, y, radius, vx, vy]: &[f64; 5]| {
            let disk = world.spawn((
                Particle::disk(*radius, density, thickness),
                BodyPosition(DVec2::new(*x, *y)),
                BodyVelocity(DVec2::new(*vx, *vy)),
                MaterialIndex(index as u32),
            ));
            disk.id()
        };
        let entities: Vec<_> = disks.iter().map(spawn).collect();
        world.flush();
        let id = |entity: Entity| world.get::<BodyId>(entity).map_or(u32::MAX, |id| id.0);
        Ok(entities.into_iter().map(id).collect())
    }

    /// Loads particles with forces (N) and moments (N m), constant until they change.
    pub fn load(&mut self, ids: &[u32], loads: &[[f64; 3]]) -> Result<(), Error> {
        for (entity, load) in self.particles(ids)?.into_iter().zip(loads) {
            self.world().entity_mut(entity).insert(LoadControl::constant(*load));
        }
        Ok(())
    }

    /// Drives particles by displacements (m) and rotations (rad) per increment; not a number is
    /// free.
    pub fn drive(&mut self, ids: &[u32], motions: &[[f64; 3]]) -> Result<(), Error> {
        let drive = |u: f64| if u.is_nan() { BodyDrive::Free } else { BodyDrive::Imposed(u) };
        for (entity, motion) in self.particles(ids)?.into_iter().zip(motions) {
            self.world().entity_mut(entity).insert(BodyDrives(motion.map(drive)));
        }
        Ok(())
    }

    /// Controls all pieces of a wall.
    pub fn control_wall(&mut self, name: &str, control: &Control) -> Result<(), Error> {
        let world = self.world();
        let walls = find_walls(world, name);
        if walls.is_empty() {
            return value(format!("no wall is called `{name}`"));
        }
        let mut find = |name: &str| match find_wall(world, name) {
            Some(wall) => Ok(wall),
            None => value(format!("no wall is called `{name}`")),
        };
        let between = match control {
            Control::Stress(_, Some((a, b))) => Some((find(a)?, find(b)?)),
            _ => None,
        };
        for wall in walls {
            let before = world.get::<WallControl>(wall).copied();
            let control = match control {
                Control::Fixed => WallControl::Fixed,
                Control::Displacement(u) => WallControl::Displacement(*u),
                Control::Velocity(v) => WallControl::Velocity(*v),
                Control::Rotation(about, angle) => {
                    WallControl::Rotation { about: *about, angle: *angle }
                }
                Control::Force(force) => WallControl::Force { from: *force, to: *force },
                Control::Stress(stress, _) => WallControl::Stress {
                    from: *stress,
                    to: *stress,
                    length: match (between, before) {
                        (Some((a, b)), _) => LoadedLength::Between(a, b),
                        (None, Some(WallControl::Stress { length, .. })) => length,
                        (None, _) => LoadedLength::Segment,
                    },
                },
            };
            let mut wall = world.entity_mut(wall);
            wall.insert(control).remove::<WallSlide>();
            if let WallControl::Rotation { .. } = control {
                wall.entry::<WallRotation>().or_default();
            }
        }
        Ok(())
    }
}

fn bond_ids(world: &mut World) -> Vec<u32> {
    let mut query = world.query::<&BondId>();
    let mut ids: Vec<u32> = query.iter(world).map(|id| id.0).collect();
    ids.sort_unstable();
    ids
}
