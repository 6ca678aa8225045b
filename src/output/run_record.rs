//! `run.json`: the scene and settings, the outcome, and the key results.

use std::collections::BTreeMap;
use std::path::Path;

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::OutputError;
use super::atomic::write_atomic;
use super::drive::PeakForce;
use super::found::Settled;
use super::history::rigid_groups;
use crate::run::key_results::Results;
use crate::run::sanity::Report;
use crate::run::{Collapse, CollapsedBy, Outcome, StageEnd};
use crate::scene::LoadedScene;
use crate::scene::files::read_at_most;
use crate::scene::format::{Acceptance, Analysis, FrictionLaw, Rupture, Solver, Specimen, Stage};

/// Version of this program.
pub const CLASTIC_VERSION: &str = env!("CARGO_PKG_VERSION");

/// Content of `run.json`.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct RunRecord {
    clastic_version: &'static str,
    format_version: u32,
    title: String,
    scene_file: String,
    scene_sha256: String,
    specimen_sha256: Option<String>,
    overrides: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    resumed: Vec<Resumed>,
    settings: Settings,
    /// Seeds by purpose: the specimen, or `stage NAME` of a compaction.
    seeds: BTreeMap<String, u64>,
    /// How the run ended.
    pub outcome: OutcomeRecord,
    /// How the stages ended. The list is incomplete during the run.
    pub stages: Vec<StageEnd>,
    /// Number of increments. It equals the number of rows of the history unless stages record fewer
    /// rows.
    pub increments: u64,
    /// Number of increments with the status `capped`, which did not converge.
    pub capped_increments: u64,
    /// Moment of `specimen.csv`; `None` if the file does not exist.
    pub specimen_csv: Option<String>,
    /// How a packing settled in the first increment after its compaction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settled: Option<Settled>,
    /// Physical sanity of the test.
    pub sanity: Report,
    /// Peak of the force of a run without an axial stress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_force: Option<PeakForce>,
    /// Key results.
    pub results: Results,
    conventions: IndexMap<&'static str, &'static str>,
}

/// Facts about a run that are not part of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunFacts {
    /// Name of the scene's file.
    pub scene_file: String,
    /// Hash of the stored specimen, if the scene names one.
    pub specimen_sha256: Option<String>,
    /// Settings that were applied to the scene before the run.
    pub overrides: Vec<String>,
    /// Points at which the run was resumed with changes.
    pub resumed: Vec<Resumed>,
}

impl RunFacts {
    /// Facts of a run that begins.
    ///
    /// # Errors
    /// If the stored specimen can no longer be read.
    pub fn new(loaded: &LoadedScene, overrides: &[String]) -> Result<Self, OutputError> {
        let specimen = match loaded.specimen_file() {
            Some(path) => read_at_most(&path, u64::MAX).map_err(OutputError::at(&path))?,
            None => None,
        };
        let file = loaded.path.file_name().unwrap_or_default();
        Ok(Self {
            scene_file: file.to_string_lossy().into_owned(),
            specimen_sha256: specimen.as_deref().map(sha256),
            overrides: overrides.to_vec(),
            resumed: Vec::new(),
        })
    }
}

/// A resumption with other settings or another version of the program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resumed {
    /// Last increment before the resumption.
    pub after_increment: u64,
    /// Version of the program after the resumption.
    pub clastic_version: String,
    /// Settings that were applied to the scene.
    pub settings: Vec<String>,
}

#[derive(Clone, Debug, Default, Serialize)]
struct Settings {
    analysis: Analysis,
    friction_law: FrictionLaw,
    /// The law that `friction_law` means in this scene, by kind of stage.
    friction: IndexMap<&'static str, &'static str>,
    rupture: Rupture,
    solver: Solver,
    acceptance: Acceptance,
    thickness_m: f64,
    gravity_m_s2: (f64, f64),
    reference_stage: String,
    /// Probes whose force is that of the contacts on the body, against the motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    rigid_groups: Vec<String>,
}

/// How a run ended.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct OutcomeRecord {
    /// `running`, `completed`, `collapsed`, `interrupted`, `undecided` or `refused`.
    pub status: &'static str,
    /// Last stage, or the stage of the first collapse if any.
    pub stage: Option<String>,
    /// Increment of the outcome.
    pub increment: Option<u64>,
    /// Evidence of a collapse: `proof` or `motion`.
    pub collapsed_by: Option<CollapsedBy>,
    /// Explanation of the outcome.
    pub message: Option<String>,
}

impl OutcomeRecord {
    /// Outcome of a run whose last stage and increment are given.
    pub fn new(outcome: Option<&Outcome>, stage: String, increment: u64) -> Self {
        let at = |status, stage, increment, message: Option<String>| Self {
            status,
            stage: Some(stage),
            increment: Some(increment),
            collapsed_by: None,
            message,
        };
        let Some(outcome) = outcome else { return at("interrupted", stage, increment, None) };
        match outcome.clone() {
            Outcome::Completed => at("completed", stage, increment, None),
            Outcome::Collapsed(Collapse { stage, increment, by, reason }) => {
                Self { collapsed_by: Some(by), ..at("collapsed", stage, increment, Some(reason)) }
            }
            Outcome::Undecided { increment, message } => {
                at("undecided", stage, increment, Some(message))
            }
            Outcome::Halted(message) => at("interrupted", stage, increment, Some(message)),
            Outcome::Refused { stage, message } => at("refused", stage, increment, Some(message)),
        }
    }
}

const CONVENTIONS: [(&str, &str); 5] = [
    (
        "strain",
        "positive in contraction; engineering strain from distances at the start of the reference \
         stage; volumetric strain 1 - (1 - axial)(1 - lateral)",
    ),
    ("stress", "positive in compression; Pa, over the out-of-plane thickness"),
    ("rotation", "positive anticlockwise"),
    (
        "units",
        "SI, as the names say; null and empty fields are values that the scene does not define",
    ),
    (
        "residuals",
        "maximum over all rows, without dimension: balance over the maximum force, or 1 % of the \
         expected one if that is more (moments: force x mean radius), kinematics over the maximum \
         displacement, violation of a limit over that force, slack x multiplier over force x \
         displacement",
    ),
];

impl RunRecord {
    /// Record of a run that has not ended.
    pub fn new(loaded: &LoadedScene, facts: &RunFacts) -> Self {
        let scene = &loaded.scene;
        let reference_stage = scene.stages.get(scene.reference_stage()).map_or("", Stage::name);
        let law = scene.friction_law.by_analysis();
        let name = |coulomb: bool| if coulomb { "Coulomb" } else { "associated" };
        let mut seeds = BTreeMap::new();
        if let Specimen::Packing { seed, .. } = scene.specimen {
            seeds.insert("specimen".to_owned(), seed);
        }
        for stage in &scene.stages {
            let seed = match stage {
                Stage::Compact(compact) => compact.seed,
                Stage::Pour(pour) => pour.stream.seed,
                _ => continue,
            };
            seeds.insert(format!("stage {}", stage.name()), seed);
        }
        Self {
            clastic_version: CLASTIC_VERSION,
            format_version: scene.version,
            title: scene.title.clone(),
            scene_file: facts.scene_file.clone(),
            scene_sha256: sha256(loaded.text.as_bytes()),
            specimen_sha256: facts.specimen_sha256.clone(),
            overrides: facts.overrides.clone(),
            resumed: facts.resumed.clone(),
            settings: Settings {
                analysis: scene.analysis,
                friction_law: scene.friction_law,
                friction: IndexMap::from([
                    ("static", name(law.in_statics.is_some())),
                    ("dynamic", name(law.in_dynamics.is_some())),
                ]),
                rupture: scene.rupture,
                solver: scene.solver.clone(),
                acceptance: scene.acceptance,
                thickness_m: scene.thickness,
                gravity_m_s2: scene.gravity,
                reference_stage: reference_stage.to_owned(),
                rigid_groups: rigid_groups(scene),
            },
            seeds,
            outcome: OutcomeRecord { status: "running", ..OutcomeRecord::default() },
            conventions: IndexMap::from(CONVENTIONS),
            ..Self::default()
        }
    }

    /// Writes the record. A reader sees the old or the new one, and never an incomplete one.
    pub(super) fn write(&self, path: &Path) -> Result<(), OutputError> {
        let mut text = serde_json::to_string_pretty(self).map_err(OutputError::at(path))?;
        text.push('\n');
        write_atomic(path, text)
    }
}

/// SHA-256 hash of some bytes, in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_sha256sum() {
        let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        assert_eq!(sha256(b""), empty);
    }
}
