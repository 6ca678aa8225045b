//! Stages of a run, in order.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{
    Analysis, Bond, CellControl, MembraneControl, ParticleControl, Pour, Record, RigidControl,
    Select, WallControl,
};
use crate::scene::unique_keys;

/// A stage. A text may also have `Repeat(times: n, stages: [...])`, which stands for its stages one
/// after the other, with `.1`, `.2` and so on after their names.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Stage {
    /// Moves a wall against the particles until the packing has the wanted density or height.
    /// Bodies are rigid and frictionless and take the smallest feasible motion. All other walls
    /// stay.
    Compact(Compact),
    /// Bonds every pair with a gap below a length, free of stress. It has no increments.
    Cement(Cement),
    /// Keeps the state as a file from which another scene starts. It has no increments.
    Save(Save),
    /// Takes particles away. It has no increments.
    Remove(Remove),
    /// Increments with controlled walls and particles.
    Load(Load),
    /// Increments like those of [`Load`](Self::Load), in which grains come in through an opening.
    Pour(Box<Pour>),
    /// A stage of a kind that a plugin provides.
    Custom(CustomStage),
}

impl Stage {
    /// Name of the stage.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Compact(s) => &s.name,
            Self::Cement(s) => &s.name,
            Self::Save(s) => &s.name,
            Self::Remove(s) => &s.name,
            Self::Load(s) => &s.name,
            Self::Pour(s) => &s.load.name,
            Self::Custom(s) => &s.name,
        }
    }

    /// Whether grains pour in.
    #[must_use]
    pub fn pours(&self) -> bool {
        matches!(self, Self::Pour(_))
    }

    /// Name of the stage, for changes.
    pub fn name_mut(&mut self) -> &mut String {
        match self {
            Self::Compact(s) => &mut s.name,
            Self::Save(s) => &mut s.name,
            Self::Remove(s) => &mut s.name,
            Self::Cement(s) => &mut s.name,
            Self::Load(s) => &mut s.name,
            Self::Pour(s) => &mut s.load.name,
            Self::Custom(s) => &mut s.name,
        }
    }

    /// What the stage does to walls, particles and groups, and when it stops, if it is a loading
    /// stage or pours.
    #[must_use]
    pub fn load(&self) -> Option<&Load> {
        match self {
            Self::Load(load) => Some(load),
            Self::Pour(pour) => Some(&pour.load),
            Self::Compact(_)
            | Self::Cement(_)
            | Self::Save(_)
            | Self::Remove(_)
            | Self::Custom(_) => None,
        }
    }

    /// Recording of the stage; `None` for a stage without increments.
    #[must_use]
    pub fn record(&self) -> Option<&Record> {
        match self {
            Self::Compact(s) => Some(&s.record),
            Self::Cement(_) | Self::Save(_) | Self::Remove(_) => None,
            Self::Load(s) => Some(&s.record),
            Self::Pour(s) => Some(&s.load.record),
            Self::Custom(s) => Some(&s.record),
        }
    }
}

/// See [`Stage::Custom`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CustomStage {
    /// Name.
    pub name: String,
    /// Kind of the stage, which a plugin provides.
    pub kind: String,
    /// Number of increments; 0 for a stage that only changes the specimen.
    #[serde(default)]
    pub increments: u32,
    /// Analysis; that of the scene if left out.
    #[serde(default)]
    pub analysis: Option<Analysis>,
    /// Gravity, m/s^2; that of the scene if left out.
    #[serde(default)]
    pub gravity: Option<(f64, f64)>,
    /// Parameters of the plugin, by name.
    #[serde(default, deserialize_with = "unique_keys::deserialize")]
    pub values: BTreeMap<String, f64>,
    /// Recording.
    #[serde(default)]
    pub record: Record,
}

/// See [`Stage::Compact`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Compact {
    /// Name.
    pub name: String,
    /// The wall that moves, along its inward normal. A periodic cell has none: it shrinks along both
    /// of its vectors.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub wall: String,
    /// The fixed wall opposite, which is the reference of the height.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub base: String,
    /// Target that ends the compaction.
    pub target: CompactTarget,
    /// What moves.
    #[serde(default, skip_serializing_if = "CompactBy::is_default")]
    pub by: CompactBy,
    /// Maximum motion of the wall, change of the width or height of a cell, or growth of the
    /// largest radius, in an increment, m.
    pub step: f64,
    /// Reference motion of particles that nothing pushes.
    #[serde(default)]
    pub rest: CompactRest,
    /// Shaking: maximum random part of the reference motion in an increment, in mean radii. Without
    /// it a random packing jams before it is dense.
    #[serde(default)]
    pub agitation: f64,
    /// Seed of the shaking.
    #[serde(default)]
    pub seed: u64,
    /// Recording.
    #[serde(default)]
    pub record: Record,
}

/// Target of a compaction.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum CompactTarget {
    /// Distance between the two walls, m.
    Height(f64),
    /// Porosity between the two walls over the length of the base, or of the cell.
    Porosity(f64),
}

/// What brings the packing to its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum CompactBy {
    /// The wall, or the cell, moves.
    #[default]
    Boundary,
    /// All radii grow by the same factor, while walls and cell stand still (radius expansion).
    Radii,
}

impl CompactBy {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Reference motion of a compaction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum CompactRest {
    /// Particles move with the wall in proportion to their height, which gives a uniform packing.
    #[default]
    Affine,
    /// Particles stay until they are pushed, so that the packing grows from the moving wall.
    Still,
}

/// See [`Stage::Cement`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Cement {
    /// Name.
    pub name: String,
    /// Bond length g_int, m: pairs with a smaller gap are bonded (3.4.1 of the paper).
    pub length: f64,
    /// Whether particles are also bonded to walls.
    #[serde(default)]
    pub walls: bool,
    /// Whether particles are bonded to each other.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub particles: bool,
    /// Particles that are bonded, to each other and to walls; all if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub select: Option<Select>,
    /// Law of the bonds; that of the materials and walls if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bond: Option<Bond>,
}

fn yes() -> bool {
    true
}

fn is_true(value: &bool) -> bool {
    *value
}

/// See [`Stage::Save`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Save {
    /// Name, which is part of the name of the file.
    pub name: String,
}

impl Save {
    /// Name of the file: `state_NAME.npz`. Characters that may not be in the name of a file are
    /// replaced by `_`.
    #[must_use]
    pub fn file(&self) -> String {
        let fits = |c: char| c.is_alphanumeric() || "_-.".contains(c);
        let name: String = self.name.chars().map(|c| if fits(c) { c } else { '_' }).collect();
        format!("state_{name}.npz")
    }
}

/// See [`Stage::Remove`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Remove {
    /// Name.
    pub name: String,
    /// Particles that are taken away, with their contacts and bonds.
    pub select: Select,
}

/// See [`Stage::Load`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Name.
    pub name: String,
    /// Number of increments.
    pub increments: u32,
    /// Analysis of this stage; that of the scene if left out.
    #[serde(default)]
    pub analysis: Option<Analysis>,
    /// Gravity of this stage, m/s^2; that of the scene if left out.
    #[serde(default)]
    pub gravity: Option<(f64, f64)>,
    /// Control of walls by name. A wall without an entry keeps its load if it is loaded, and
    /// otherwise stays where it is.
    #[serde(default, deserialize_with = "unique_keys::deserialize")]
    pub walls: BTreeMap<String, WallControl>,
    /// Walls that are removed at the start.
    #[serde(default)]
    pub remove_walls: Vec<String>,
    /// Walls that are added at the start.
    #[serde(default)]
    pub add_walls: Vec<String>,
    /// Controls of particles. Particles that no control selects are free.
    #[serde(default)]
    pub particles: Vec<ParticleControl>,
    /// Rigid groups by name. An entry with `select` makes a group, an entry without it controls a
    /// group that exists. A group without an entry keeps its loads, and stands still along the
    /// degrees of freedom that were held or driven.
    #[serde(
        default,
        deserialize_with = "unique_keys::deserialize",
        skip_serializing_if = "BTreeMap::is_empty"
    )]
    pub rigid: BTreeMap<String, RigidControl>,
    /// Rigid groups that end at the start: their members move on their own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub release: Vec<String>,
    /// Flexible membranes by name. The first entry of a name makes a membrane, later ones change its
    /// pressure. A membrane without an entry keeps its pressure.
    #[serde(
        default,
        deserialize_with = "unique_keys::deserialize",
        skip_serializing_if = "BTreeMap::is_empty"
    )]
    pub membranes: BTreeMap<String, MembraneControl>,
    /// Membranes that are removed at the start.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remove_membranes: Vec<String>,
    /// Control of the periodic cell, boxed since few stages have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<Box<CellControl>>,
    /// Conditions that end the stage early.
    #[serde(default)]
    pub stop: Vec<Stop>,
    /// Recording.
    #[serde(default)]
    pub record: Record,
}

/// A condition that ends a stage. A collapse always ends it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Stop {
    /// Axial strain reaches this value. Version 1; in version 2 it is `Above("axial_strain", e)`.
    AxialStrain(f64),
    /// After its peak, the axial stress falls below this fraction of the peak. The drop must exceed
    /// the error of the stress that `acceptance.residual` allows.
    StressDrop(f64),
    /// Time reaches this value, s.
    Time(f64),
    /// The maximum speed of a particle falls below this value, m/s (after the first increment).
    Rest(f64),
    /// A measure, by name, is at or below this value. Version 2.
    Below(String, f64),
    /// A measure, by name, is at or above this value. Version 2.
    Above(String, f64),
    /// A measure, by name, lands on this value: the last increments are shortened. Version 2.
    Until(String, f64),
    /// No grain that is due has found room for this time, s, in a stage that pours.
    Full(f64),
}

impl Stop {
    /// Name of the measure that the condition is about.
    #[must_use]
    pub fn measure(&self) -> Option<&str> {
        match self {
            Self::AxialStrain(_) => Some("axial_strain"),
            Self::StressDrop(_) => Some("axial_stress"),
            Self::Time(_) | Self::Rest(_) | Self::Full(_) => None,
            Self::Below(name, _) | Self::Above(name, _) | Self::Until(name, _) => Some(name),
        }
    }
}
