//! Driven walls and rigid groups that carry no force in a whole stage: a press that never reaches
//! the specimen, or a wall that is drawn on the wrong side of it.

use std::collections::BTreeSet;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::body::BodyExternalForce;
use clastic_components::increment::ClasticProgress;
use clastic_components::rigid_group::{ContactForce, RigidGroup};
use clastic_components::wall::WallName;
use clastic_cone::program::{ConeProgram, ConeSolution};
use clastic_cone::residuals::{displacement_scale, force_scale};

use crate::run::script::{EndedBy, Script};
use crate::run::wall_pieces::pieces;
use crate::scene::format::{
    Analysis, Load, Motion, Particle, Scene, Slide, Specimen, Stage, Strain, Table, Wall,
    WallControl,
};
use crate::text::shown::label;

/// Name of [`Untouched`] in a state.
pub(crate) const UNTOUCHED: &str = "sanity.untouched";

/// The driven walls and rigid groups that have carried no force. A run has it from the first stage
/// on that drives any.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Untouched {
    /// Index of the stage of the last increment.
    stage: usize,
    /// What this stage drives and what has carried no force in it, by name.
    now: BTreeSet<String>,
    /// Names of earlier stages, each with what it drove and what carried no force in it.
    before: Vec<(String, BTreeSet<String>)>,
}

/// Forces on driven bodies in the last increment.
#[derive(SystemParam)]
pub(crate) struct Carried<'w, 's> {
    program: Res<'w, ConeProgram>,
    solution: Res<'w, ConeSolution>,
    walls: Query<'w, 's, (&'static WallName, &'static BodyExternalForce)>,
    groups: Query<'w, 's, (&'static RigidGroup, &'static ContactForce)>,
}

impl Carried<'_, '_> {
    /// Whether a wall or a group carries a force above the error that `acceptance.residual` allows:
    /// that of the maximum force, and that of a gap times the maximum stiffness.
    fn is_felt(&self, name: &str) -> bool {
        let stiff = self.program.interactions.iter().map(|c| c.normal_compliance);
        let stiff =
            stiff.filter(|compliance| *compliance > 0.0).map(f64::recip).fold(0.0, f64::max);
        let error = self.solution.tolerance
            * (force_scale(&self.program, &self.solution.forces)
                + stiff * displacement_scale(&self.program, &self.solution.displacements));
        let length = self.program.scales.length;
        let is_felt =
            |[x, y, moment]: [f64; 3]| x.hypot(y) > error || moment.abs() > error * length;
        self.walls.iter().any(|(wall, force)| wall.0 == name && is_felt(force.0))
            || self.groups.iter().any(|(group, force)| group.name == name && is_felt(force.0))
    }
}

/// Takes an increment into account.
pub(crate) fn follow_driven(
    script: Res<Script>,
    progress: Res<ClasticProgress>,
    carried: Carried,
    untouched: Option<ResMut<Untouched>>,
    mut commands: Commands,
) {
    let stages = &script.scene.stages;
    let driven = || {
        let load = stages.get(progress.stage).and_then(Stage::load);
        load.map(|load| driven(&script.scene, load)).unwrap_or_default()
    };
    let felt = |name: &String| carried.is_felt(name);
    let Some(mut untouched) = untouched else {
        let mut now = driven();
        if !now.is_empty() {
            now.retain(|name| !felt(name));
            let (stage, before) = (progress.stage, Vec::new());
            commands.insert_resource(Untouched { stage, now, before });
        }
        return;
    };
    if untouched.stage != progress.stage {
        let last = std::mem::replace(&mut untouched.stage, progress.stage);
        let names = std::mem::replace(&mut untouched.now, driven());
        if let Some(stage) = stages.get(last).filter(|_| !names.is_empty()) {
            untouched.before.push((stage.name().to_owned(), names));
        }
    }
    untouched.now.retain(|name| !felt(name));
}

impl Untouched {
    /// Warnings about the stages that have ended.
    pub fn warnings(&self, script: &Script) -> Vec<String> {
        let last = script.scene.stages.get(self.stage).map(Stage::name);
        let end = script.ends.iter().find(|end| Some(end.stage.as_str()) == last);
        let ends = [Some(EndedBy::AllIncrements), Some(EndedBy::Stop)];
        let last =
            end.filter(|end| ends.contains(&end.ended_by)).map(|end| (&end.stage, &self.now));
        let before = self.before.iter().map(|(stage, names)| (stage, names));
        let all = before.chain(last).filter(|(_, names)| !names.is_empty());
        all.map(|(stage, names)| warning(stage, names, "carries no force in the whole stage"))
            .collect()
    }
}

fn warning(stage: &str, names: &BTreeSet<String>, what: &str) -> String {
    let names: Vec<_> = names.iter().map(|name| label(name).to_string()).collect();
    format!(
        "stage {}: {} is moved and {what}; draw it nearer to the specimen, bring it there in a stage \
         that `stop: [Above(...)]` of its `WallForce` ends, or move it the other way",
        label(stage),
        names.join(", ")
    )
}

/// Walls and rigid groups that a stage moves, by name. A wall that is only moved away from its
/// inward side carries no force by intention, unless the axial strain is measured from it.
fn driven(scene: &Scene, load: &Load) -> BTreeSet<String> {
    let moves = |motion: &Motion| match motion {
        Motion::Displacement(u) | Motion::Velocity(u) => *u != 0.0,
        Motion::Free | Motion::Held => false,
    };
    let groups = load.rigid.iter().filter(|(_, of)| [of.x, of.y, of.rotation].iter().any(moves));
    let wall = |name: &str| scene.walls.iter().find(|wall| wall.name == name);
    let walls = load.walls.iter().filter(|(name, control)| match control {
        WallControl::Displacement(x, y) | WallControl::Velocity(x, y) => {
            let motion = DVec2::new(*x, *y);
            let is_platen = || match scene.strain("axial_strain") {
                Some(Strain::Walls(a, b)) => motion != DVec2::ZERO && (a == *name || b == *name),
                _ => false,
            };
            wall(name).is_none_or(|wall| comes_near(wall, motion)) || is_platen()
        }
        WallControl::Rotation { angle: u, .. } | WallControl::Spin { angular_velocity: u, .. } => {
            *u != 0.0
        }
        WallControl::Follow(Table::Displacement(_) | Table::Rotation { .. }) => true,
        WallControl::Lid { slide: Slide::Displacement(u) | Slide::Velocity(u), .. } => *u != 0.0,
        _ => false,
    });
    walls.map(|(name, _)| name).chain(groups.map(|(name, _)| name)).cloned().collect()
}

/// Whether a motion has a part along the wall or towards its inward side.
fn comes_near(wall: &Wall, motion: DVec2) -> bool {
    let chord = DVec2::from(wall.end) - DVec2::from(wall.start);
    let is_whole = chord == DVec2::ZERO || pieces(wall).len() > 1;
    motion != DVec2::ZERO && (is_whole || chord.perp().dot(motion) >= 0.0)
}

/// Whether only walls and the cell may move particles in a stage.
fn is_at_rest(scene: &Scene, load: &Load) -> bool {
    load.gravity.unwrap_or(scene.gravity) == (0.0, 0.0)
        && load.particles.is_empty()
        && load.rigid.is_empty()
        && load.membranes.is_empty()
        && !matches!(scene.specimen, Specimen::State { .. })
}

/// Warning before the run: no stage has anything that moves or loads particles, as where gravity was forgotten.
pub(super) fn nothing_acts(scene: &Scene, seeds: &[Particle]) -> Option<String> {
    let acts = |stage: &Stage| match stage {
        Stage::Load(load) => {
            let is_held = |control: &WallControl| *control == WallControl::Fixed;
            !is_at_rest(scene, load) || load.cell.is_some() || !load.walls.values().all(is_held)
        }
        Stage::Pour(_) | Stage::Custom(_) => true,
        _ => false,
    };
    let flies = |seed: &Particle| seed.velocity != (0.0, 0.0) || seed.angular_velocity != 0.0;
    let mut loads = scene.stages.iter().filter(|stage| matches!(stage, Stage::Load(_)));
    let is_quiet = !scene.stages.iter().any(acts) && !seeds.iter().any(flies);
    let name = label(loads.next().filter(|_| is_quiet)?.name());
    Some(format!(
        "stages.{name}: nothing moves or loads a particle in it or in a later stage; give the scene a `gravity`, down is \
         (0.0, -9.81), or a wall a motion or a load"
    ))
}

/// Warning before the run: in the first stage that loads the specimen no wall reaches a particle,
/// and nothing else could bring particles to the walls.
pub(super) fn out_of_reach(scene: &Scene, seeds: &[Particle]) -> Option<String> {
    let takes_no_increment =
        |stage: &&Stage| matches!(stage, Stage::Cement(_) | Stage::Save(_) | Stage::Remove(_));
    let first = scene.stages.iter().position(|stage| !takes_no_increment(&stage))?;
    let Stage::Load(load) = &scene.stages[first] else { return None };
    // A wall that is glued to grains need not come nearer.
    let glues = |stage: &Stage| matches!(stage, Stage::Cement(cement) if cement.walls);
    if scene.stages[..first].iter().any(glues) {
        return None;
    }
    let is_static = load.analysis.unwrap_or(scene.analysis) == Analysis::Static;
    if !is_static || !is_at_rest(scene, load) {
        return None;
    }
    let moved = driven(scene, load);
    let mut names = BTreeSet::new();
    // Nothing moves before a wall touches a particle.
    for (name, control) in &load.walls {
        let u = match control {
            WallControl::Fixed => continue,
            WallControl::Displacement(x, y) => DVec2::new(*x, *y),
            _ => return None,
        };
        let wall = scene.walls.iter().find(|wall| wall.name == *name)?;
        let way = if comes_near(wall, u) { u.length() * f64::from(load.increments) } else { 0.0 };
        let reaches = |seed: &Particle| {
            let place = seed.position.into();
            pieces(wall).iter().any(|piece| piece.distance(place) - seed.radius <= way)
        };
        if seeds.iter().any(reaches) {
            return None;
        }
        if moved.contains(name) {
            names.insert(name.clone());
        }
    }
    (!names.is_empty()).then(|| warning(load.name.as_str(), &names, "does not reach a particle"))
}
