//! The scene format: types of a RON scene.
//!
//! Units are SI throughout: m, s, kg, N, Pa, rad. Compression, contraction and anticlockwise
//! rotation are positive. `some(x)` may be written as plain `x`, and `None` left out; newtype
//! variants need no second pair of parentheses. Unknown fields are errors.

mod analysis;
mod cell;
mod compact;
mod load;
mod materials;
mod measures;
mod output;
mod particle_control;
mod pour;
mod specimen;
mod stages;
mod walls;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

// The scene says these as the engine has them.
pub use clastic_components::increment::{
    Acceptance, Avalanche, RollingLimit, RuptureOrder, RuptureRules as Rupture,
};
pub use clastic_components::measure::{
    CrackPart as Cracks, FabricComponent, ForceComponent as Along, FragmentPart as Fragments,
    GrainAmount as Amount, GroupAlong, MembraneValue, Modes, Network, RingValue,
};
pub use clastic_components::membrane::Sides;
pub use clastic_components::observation::{
    CellStrain, StrainComponent, StressComponent as Component,
};
pub use clastic_components::wall::WallSlide as Slide;

pub use crate::text::VERSION;
pub use analysis::{Analysis, FrictionLaw, Solver};
pub use cell::{Cell, CellControl, CellTarget};
pub use compact::{Compact, CompactBy, CompactTarget};
pub use load::{Load, MembraneControl, RigidControl, Scale, Traction};
pub use materials::{Bond, Contact, Material, Scatter, Spread};
pub use measures::{Area, Length, Measure, Quantity, ROLES, Strain, Stress};
pub use output::{Output, Record};
pub use particle_control::{Motion, ParticleControl, Select};
pub use pour::{Opening, Pour, Rate, Stream};
pub use specimen::{ExplicitBond, Mineral, Particle, Sizes, Specimen};
pub(super) use stages::MAX_STAGES;
pub use stages::{Cement, CustomStage, Remove, Save, Stage, Stop};
pub use walls::{LidLoad, Table, Wall, WallControl, WallShape};

/// A scene: materials, a specimen, walls, and stages.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Version of the format: [`VERSION`].
    pub version: u32,
    /// One line that says what the scene shows.
    pub title: String,
    /// Values with names, which stand for numbers of the scene. The text has their values in place
    /// of the names before it is read.
    #[serde(default, rename = "let")]
    pub values: BTreeMap<String, f64>,
    /// Out-of-plane thickness h, m.
    #[serde(default = "one")]
    pub thickness: f64,
    /// Acceleration of gravity (x, y), m/s^2.
    #[serde(default)]
    pub gravity: (f64, f64),
    /// Static or dynamic; stages may differ.
    #[serde(default)]
    pub analysis: Analysis,
    /// Friction law of unbonded contacts.
    #[serde(default)]
    pub friction_law: FrictionLaw,
    /// Rules of rupture.
    #[serde(default)]
    pub rupture: Rupture,
    /// The solver.
    #[serde(default)]
    pub solver: Solver,
    /// Criteria for committing an increment.
    #[serde(default)]
    pub acceptance: Acceptance,
    /// Particle materials by name.
    pub materials: BTreeMap<String, Material>,
    /// The particles.
    pub specimen: Specimen,
    /// Layers and minerals: materials of particles of the specimen, where several select one the
    /// last.
    #[serde(default)]
    pub minerals: Vec<Mineral>,
    /// Particles of the specimen that the run has; all if left out. Indices count these.
    pub keep: Option<Select>,
    /// Bonds at the start, free of stress. Cementing stages add more.
    #[serde(default)]
    pub bonds: Vec<ExplicitBond>,
    /// Names under which the history records particles, by index, for specimens that do not list
    /// particles one by one.
    #[serde(default)]
    pub probes: BTreeMap<String, u32>,
    /// Named groups of particles, for selections.
    #[serde(default)]
    pub groups: BTreeMap<String, Select>,
    /// Periodic cell of the specimen, instead of walls.
    pub cell: Option<Cell>,
    /// Walls.
    #[serde(default)]
    pub walls: Vec<Wall>,
    /// Rigid groups that are there from the start, of the saved state from which the scene starts.
    /// The text has none of them.
    #[serde(skip)]
    pub rigid_at_start: Vec<String>,
    /// Stages, in order.
    #[serde(deserialize_with = "stages::deserialize")]
    pub stages: Vec<Stage>,
    /// Stage at whose start strains are zero; the last stage if left out.
    pub reference_stage: Option<String>,
    /// Definitions of strain and stress, and further measures.
    #[serde(default)]
    pub measures: Vec<Measure>,
    /// Output.
    #[serde(default)]
    pub output: Output,
}

fn one() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}

impl Scene {
    /// Index of the stage at whose start strains are zero: the one that the scene names, else the
    /// last stage that does more than keep the state.
    pub fn reference_stage(&self) -> usize {
        let named = self
            .reference_stage
            .as_deref()
            .and_then(|name| self.stages.iter().position(|s| s.name() == name));
        let last = || self.stages.iter().rposition(|stage| !matches!(stage, Stage::Save(_)));
        named.or_else(last).unwrap_or(0)
    }

    /// What the measure of a name measures. Of two with the same name the first counts.
    pub fn measure(&self, name: &str) -> Option<&Quantity> {
        self.measures.iter().find(|measure| measure.name == name).map(|measure| &measure.of)
    }

    /// The measures that are none of [`ROLES`].
    pub fn further_measures(&self) -> impl Iterator<Item = &Measure> {
        self.measures.iter().filter(|measure| !ROLES.contains(&measure.name.as_str()))
    }

    /// The strain of a name; `None` if there is none, or the measure is no strain.
    pub fn strain(&self, name: &str) -> Option<&Strain> {
        if let Some(Quantity::Strain(strain)) = self.measure(name) { Some(strain) } else { None }
    }

    /// The stress of a name; `None` if there is none, or the measure is no stress.
    pub fn stress(&self, name: &str) -> Option<&Stress> {
        if let Some(Quantity::Stress(stress)) = self.measure(name) { Some(stress) } else { None }
    }

    /// Laws of contacts and bonds, with kind and name of their owner: materials, walls, stages that cement.
    pub fn laws(
        &self,
    ) -> impl Iterator<Item = (&'static str, &str, Option<Contact>, Option<Bond>)> + Clone {
        let materials = self.materials.iter();
        let materials =
            materials.map(|(name, of)| ("material", &**name, Some(of.contact), of.bond));
        let walls = self.walls.iter().map(|of| ("wall", &*of.name, Some(of.contact), of.bond));
        let stages = self.stages.iter().filter_map(|stage| match stage {
            Stage::Cement(of) => Some(("stage", &*of.name, None, of.bond)),
            _ => None,
        });
        materials.chain(walls).chain(stages)
    }

    /// Normal, tangential and rolling stiffness of each of these laws.
    pub fn stiffnesses(&self) -> impl Iterator<Item = [Option<f64>; 3]> + Clone {
        self.laws().flat_map(|(_, _, contact, bond)| {
            let of_contact = contact.map(|contact| contact.stiffnesses());
            of_contact.into_iter().chain(bond.map(|bond| bond.stiffnesses()))
        })
    }

    /// Whether there may be bonds when a stage begins, by its index.
    pub(crate) fn has_bonds(&self, stage: usize) -> bool {
        let makes = |stage: &Stage| matches!(stage, Stage::Cement(_) | Stage::Custom(_));
        !self.bonds.is_empty()
            || matches!(self.specimen, Specimen::State { .. })
            || self.stages.iter().take(stage).any(makes)
    }

    /// Whether a contact law of the scene has restitution. Velocities of dynamic stages are then
    /// those of theta = 1.
    pub fn has_restitution(&self) -> bool {
        self.laws().any(|(_, _, contact, _)| contact.is_some_and(|of| of.restitution > 0.0))
    }
}
