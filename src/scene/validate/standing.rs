//! Loads that stages find and keep: those of a saved state, and those that earlier stages have left.

use std::collections::BTreeSet;

use clastic_components::body::{BodyId, LoadControl};
use clastic_components::particle::Particle;
use clastic_components::rigid_group::RigidGroup;
use clastic_components::wall::WallName;
use clastic_systems::state::WorldState;
use clastic_systems::wall_states::{ControlState, ControlStates, WALL_CONTROL};

use crate::scene::format::{Load, ParticleControl, RigidControl, Select, Table, WallControl};

use super::{Context, membranes};

/// Stands in place of a selection for the loads that particles have in a saved state.
const OF_STATE: &str = "the saved state";

/// Loads between two stages.
#[derive(Clone, Default)]
pub(super) struct Standing {
    /// Names of loaded walls.
    pub walls: BTreeSet<String>,
    /// Names of membranes.
    pub membranes: BTreeSet<String>,
    /// By the names of rigid groups.
    rigid: Owners,
    /// By selections as text: the same text selects the same particles.
    particles: Owners,
}

/// Owners of forces and of moments.
#[derive(Clone, Default)]
struct Owners {
    forces: BTreeSet<String>,
    moments: BTreeSet<String>,
}

impl Owners {
    /// Takes note of an entry; `None` keeps what is there.
    fn set(&mut self, name: &str, force: Option<(f64, f64)>, moment: Option<f64>) {
        if let Some(force) = force {
            set(&mut self.forces, name, force != (0.0, 0.0));
        }
        if let Some(moment) = moment {
            set(&mut self.moments, name, moment != 0.0);
        }
    }

    fn remove(&mut self, name: &str) {
        self.forces.remove(name);
        self.moments.remove(name);
    }

    /// All owners, each once.
    fn names(&self) -> BTreeSet<&str> {
        self.forces.union(&self.moments).map(String::as_str).collect()
    }
}

impl Standing {
    /// Loads with which the first stage begins.
    pub(super) fn at_start(context: &Context) -> Self {
        let membranes = membranes::inherited(context.specimen);
        let membranes = membranes.into_iter().map(|(name, _)| name).collect();
        let mut standing = Self { membranes, ..Self::default() };
        let state = context.specimen.and_then(|stored| stored.state.as_ref());
        if let Some(state) = state
            && let Some(saved) = &state.saved
        {
            standing.add_loads_of_bodies(&saved.world);
            if state.gives_walls {
                standing.walls = loaded_walls(&saved.world);
            }
        }
        standing
    }

    /// Adds the loads on particles and rigid groups of a state.
    fn add_loads_of_bodies(&mut self, world: &WorldState) {
        let loads = world.components::<BodyId, LoadControl>("load_control").unwrap_or_default();
        let particles = world.components::<BodyId, Particle>("particle").unwrap_or_default();
        let groups = world.components::<BodyId, RigidGroup>("rigid_group").unwrap_or_default();
        for (id, LoadControl([x, y, moment])) in loads {
            let [x, y, moment] = [x, y, moment].map(|(_, end)| end);
            if (x, y, moment) == (0.0, 0.0, 0.0) {
                continue;
            }
            if particles.binary_search_by_key(&id, |(id, _)| *id).is_ok() {
                // A particle without a load does not take away that of another one.
                let force = ((x, y) != (0.0, 0.0)).then_some((x, y));
                let moment = (moment != 0.0).then_some(moment);
                self.particles.set(OF_STATE, force, moment);
            } else if let Some((_, group)) = groups.iter().find(|(group, _)| *group == id) {
                self.rigid.set(&group.name, Some((x, y)), Some(moment));
            }
        }
    }

    /// Follows a stage to its end.
    pub(super) fn follow(&mut self, stage: &Load) {
        for name in &stage.remove_walls {
            self.walls.remove(name);
        }
        for (name, control) in &stage.walls {
            set(&mut self.walls, name, has_load(control));
        }
        for name in &stage.remove_membranes {
            self.membranes.remove(name);
        }
        self.membranes.extend(stage.membranes.keys().cloned());
        for name in &stage.release {
            self.rigid.remove(name);
        }
        for (name, c) in &stage.rigid {
            self.rigid.set(name, c.total_force(1.0), c.moment);
        }
        for c in &stage.particles {
            if c.select == Select::All {
                // It replaces the loads of all other selections.
                if c.force.is_some() {
                    self.particles.forces.clear();
                }
                if c.moment.is_some() {
                    self.particles.moments.clear();
                }
            }
            self.particles.set(&text(&c.select), c.force, c.moment);
        }
    }

    /// Rigid groups whose loads the stage keeps.
    pub(super) fn kept_by_groups<'a>(&'a self, stage: &'a Load) -> impl Iterator<Item = &'a str> {
        let is_here = |name: &str| stage.rigid.get(name).is_some_and(loads_group);
        let goes = |name: &str| stage.release.iter().any(|other| other == name);
        self.rigid.names().into_iter().filter(move |name| !is_here(name) && !goes(name))
    }

    /// Where the loads come from that particles keep in the stage, in words.
    pub(super) fn kept_by_particles(&self, stage: &Load) -> BTreeSet<&'static str> {
        let is_here = |selection: &str| {
            let mut own = stage.particles.iter().filter(|c| loads_particles(c));
            own.any(|c| c.select == Select::All || text(&c.select) == selection)
        };
        let kept = self.particles.names().into_iter().filter(|selection| !is_here(selection));
        kept.map(|s| if s == OF_STATE { OF_STATE } else { "an earlier stage" }).collect()
    }
}

/// Names of the walls that are under load in a state.
fn loaded_walls(world: &WorldState) -> BTreeSet<String> {
    let Ok(controls) = world.get::<ControlStates>(WALL_CONTROL) else { return BTreeSet::new() };
    let names = world.components::<BodyId, WallName>("wall_name").unwrap_or_default();
    let is_loaded = |id: &BodyId| {
        controls.0.iter().any(|(other, control)| {
            other == id
                && matches!(
                    control,
                    ControlState::Force(..)
                        | ControlState::ForceTable
                        | ControlState::Stress(..)
                        | ControlState::StressTable(_)
                )
        })
    };
    names.into_iter().filter(|(id, _)| is_loaded(id)).map(|(_, name)| name.0).collect()
}

fn text(select: &Select) -> String {
    format!("{select:?}")
}

fn set(names: &mut BTreeSet<String>, name: &str, is_in: bool) {
    if is_in {
        names.insert(name.to_owned());
    } else {
        names.remove(name);
    }
}

pub(super) fn loads_particles(c: &ParticleControl) -> bool {
    c.force.is_some() || c.moment.is_some()
}

pub(super) fn loads_group(c: &RigidControl) -> bool {
    c.force.is_some() || c.moment.is_some() || c.stress.is_some()
}

pub(super) fn has_load(control: &WallControl) -> bool {
    // A wall keeps the last load of its table.
    let of_table = matches!(control, WallControl::Follow(Table::Force(_) | Table::Stress { .. }));
    of_table
        || matches!(
            control,
            WallControl::Force(_) | WallControl::Stress { .. } | WallControl::Lid { .. }
        )
}
