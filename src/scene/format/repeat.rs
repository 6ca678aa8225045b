//! `Repeat`: stages that come several times. The scene has each of them.

use serde::{Deserialize, Deserializer};

use super::pour::Pour;
use super::{Cement, Compact, CustomStage, Load, Remove, Save, Stage};

/// Maximum number of stages. A slip in `times` must not fill the memory.
pub const MAX_STAGES: usize = 100_000;

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
    let mut stage = match item {
        Item::Compact(stage) => Stage::Compact(stage.clone()),
        Item::Cement(stage) => Stage::Cement(stage.clone()),
        Item::Save(stage) => Stage::Save(stage.clone()),
        Item::Remove(stage) => Stage::Remove(stage.clone()),
        Item::Load(stage) => Stage::Load(stage.clone()),
        Item::Pour(stage) => Stage::Pour(stage.clone()),
        Item::Custom(stage) => Stage::Custom(stage.clone()),
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
    stage.name_mut().push_str(suffix);
    stages.push(stage);
}
