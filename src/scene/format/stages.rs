//! Stages of a run, in order.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};

use super::{Analysis, Bond, Compact, Load, Pour, Record, Select};

/// A stage. A text may also have `Repeat(times: n, stages: [...])`, which stands for its stages one
/// after the other, with `.1`, `.2` and so on after their names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Stage {
    /// Moves a wall against the particles until the packing has the wanted density or height.
    /// Bodies are rigid and frictionless and take the smallest feasible motion. All other walls
    /// stay.
    Compact(Compact),
    /// Bonds every pair with a gap below a length, or the nearest pairs. It has no increments.
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
    pub fn pours(&self) -> bool {
        matches!(self, Self::Pour(_))
    }

    /// Whether the stage has increments.
    pub(crate) fn has_increments(&self) -> bool {
        match self {
            Self::Compact(_) => true,
            Self::Custom(s) => s.increments > 0,
            _ => self.load().is_some_and(|load| load.increments > 0),
        }
    }

    /// What the stage does to walls, particles and groups, and when it stops, if it is a loading
    /// stage or pours.
    pub fn load(&self) -> Option<&Load> {
        match self {
            Self::Load(load) => Some(load),
            Self::Pour(pour) => Some(&pour.load),
            _ => None,
        }
    }

    /// The analysis that the stage gives; that of the scene holds otherwise.
    pub fn analysis(&self) -> Option<Analysis> {
        match self {
            Self::Custom(custom) => custom.analysis,
            _ => self.load()?.analysis,
        }
    }

    /// Conditions that end the stage early.
    pub fn stop(&self) -> &[Stop] {
        match self {
            Self::Compact(s) => &s.stop,
            _ => self.load().map_or(&[], |load| &load.stop),
        }
    }

    /// Recording of the stage; `None` for a stage without increments.
    pub fn record(&self) -> Option<&Record> {
        match self {
            Self::Compact(s) => Some(&s.record),
            Self::Custom(s) => Some(&s.record),
            _ => self.load().map(|load| &load.record),
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
    pub analysis: Option<Analysis>,
    /// Gravity, m/s^2; that of the scene if left out.
    pub gravity: Option<(f64, f64)>,
    /// Parameters of the plugin, by name.
    #[serde(default)]
    pub values: BTreeMap<String, f64>,
    /// Recording.
    #[serde(default)]
    pub record: Record,
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
    /// Whether the periodic cell ends: particles are put back into the cell before the selection,
    /// and contacts and bonds across its sides go.
    #[serde(default)]
    pub open_cell: bool,
    /// Whether the forces and moments that they exerted on other particles stay as loads on these.
    #[serde(default)]
    pub keep_tractions: bool,
}

/// See [`Stage::Cement`](super::Stage::Cement).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Cement {
    /// Name.
    pub name: String,
    /// Bond length g_int, m: pairs with a smaller gap are bonded (3.4.1 of the paper).
    pub length: Option<f64>,
    /// Mean number of new bonds of a particle: the pairs with the smallest gaps are bonded. It
    /// takes the place of the length.
    pub coordination: Option<f64>,
    /// Whether particles are also bonded to walls.
    #[serde(default)]
    pub walls: bool,
    /// Whether particles are bonded to each other.
    #[serde(default = "super::yes")]
    pub particles: bool,
    /// Particles that are bonded, to each other and to walls; all if left out.
    pub select: Option<Select>,
    /// Law of the bonds; that of the materials and walls if left out.
    pub bond: Option<Bond>,
}

/// A condition that ends a stage. A collapse always ends it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Stop {
    /// After its peak, the axial stress falls below this fraction of the peak. The drop must exceed
    /// the error of the stress that `acceptance.residual` allows.
    StressDrop(f64),
    /// The maximum speed of a particle falls below this value, m/s (after the first increment).
    Rest(f64),
    /// A measure, by name, is at or below this value.
    Below(String, f64),
    /// A measure, by name, is at or above this value.
    Above(String, f64),
    /// A measure, by name, lands on this value: the last increment is shortened.
    Until(String, f64),
    /// No grain that is due has found room for this time, s, in a stage that pours.
    Full(f64),
}

impl Stop {
    /// Name of the measure that the condition is about.
    pub fn measure(&self) -> Option<&str> {
        match self {
            Self::StressDrop(_) => Some("axial_stress"),
            Self::Rest(_) | Self::Full(_) => None,
            Self::Below(name, _) | Self::Above(name, _) | Self::Until(name, _) => Some(name),
        }
    }
}

/// Maximum number of stages. A slip in `times` must not fill the memory.
pub(crate) const MAX_STAGES: usize = 100_000;

/// An item of `stages` as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Stage")]
enum Item {
    Compact(Compact),
    Cement(Cement),
    Save(Save),
    Remove(Remove),
    Load(Load),
    Pour(Box<Pour>),
    Custom(CustomStage),
    Repeat(Repeat),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Repeat {
    times: u32,
    stages: Vec<Item>,
}

/// For `#[serde(deserialize_with = "...")]`: the stages one after the other. A stage of the second
/// repetition has `.2` after its name.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<Stage>, D::Error> {
    let items = Vec::<Item>::deserialize(d)?;
    let mut stages = Vec::with_capacity(items.len());
    for item in &items {
        add(item, "", &mut stages);
    }
    Ok(stages)
}

fn add(item: &Item, suffix: &str, stages: &mut Vec<Stage>) {
    let name = |name: &str| format!("{name}{suffix}");
    let stage = match item {
        Item::Compact(of) => Stage::Compact(Compact { name: name(&of.name), ..of.clone() }),
        Item::Cement(of) => Stage::Cement(Cement { name: name(&of.name), ..of.clone() }),
        Item::Save(of) => Stage::Save(Save { name: name(&of.name) }),
        Item::Remove(of) => Stage::Remove(Remove { name: name(&of.name), ..of.clone() }),
        Item::Load(of) => Stage::Load(Load { name: name(&of.name), ..of.clone() }),
        Item::Pour(of) => {
            let load = Load { name: name(&of.load.name), ..of.load.clone() };
            Stage::Pour(Box::new(Pour { load, stream: of.stream.clone() }))
        }
        Item::Custom(of) => Stage::Custom(CustomStage { name: name(&of.name), ..of.clone() }),
        Item::Repeat(Repeat { times, stages: items }) => {
            for k in (1..=*times).filter(|_| !items.is_empty()) {
                if stages.len() > MAX_STAGES {
                    return;
                }
                for item in items {
                    add(item, &format!("{suffix}.{k}"), stages);
                }
            }
            return;
        }
    };
    stages.push(stage);
}
