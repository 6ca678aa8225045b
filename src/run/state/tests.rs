//! Nothing that lives in a world is forgotten: every component and resource of the engine stands in
//! the table below, and one that does not fails the test.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Stored in a [`WorldState`](super::WorldState).
const STORED: &[&str] = &[
    "Analysis",
    "AngularVelocity",
    "AppliedLoad",
    "Bond",
    "BondCounter",
    "BondId",
    "BondState",
    "BodyId",
    "ContactHistory",
    "ContactLaw",
    "Drives",
    "EnergyLedger",
    "ExternalForce",
    "Group",
    "LastMotion",
    "LoadControl",
    "MaterialIndex",
    "Observation",
    "Origin",
    "Particle",
    "Position",
    "Probe",
    "Progress",
    "Rotation",
    "RuptureCount",
    "Swinging",
    "Velocity",
    "Wall",
    "WallControl",
    "WallDrive",
    "WallName",
    // All but its scene and an outcome, after which there is nothing to resume.
    "Script",
    // What is measured follows from the scene; the reference lengths are stored.
    "Measures",
    // Its memory; which one it is follows from the scene.
    "Solver",
];

/// Made of the scene, settings that are applied on resuming included.
const OF_THE_SCENE: &[&str] = &[
    "Acceptance",
    "BuiltInRule",
    "Corrector",
    "FrictionLaw",
    "Materials",
    "RuptureRules",
    "WallCatalogue",
];

/// Made anew in every increment before anything reads it.
const OF_THE_INCREMENT: &[&str] = &[
    "AddedPairs",
    "Attempt",
    "Before",
    "Bodies",
    "Centre",
    "Closest",
    "Contacts",
    "Corrections",
    "DraftHistory",
    "EventSearch",
    "Impacts",
    "MotionEnergies",
    "Pushed",
    "Restraints",
    "Ruptures",
    "Sliding",
    "TrialLoads",
];

/// What no result depends on: the clock, and lists of pairs that are as good as new ones.
const WITHOUT_INFLUENCE: &[&str] = &["Candidates", "Lap", "SlidingSolver", "Timings"];

/// Rust files below a directory.
fn sources(directory: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(directory).unwrap_or_else(|e| panic!("{}: {e}", directory.display()))
    {
        let path = entry.unwrap_or_else(|e| panic!("{e}")).path();
        if path.is_dir() && !path.ends_with("target") {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

/// Names of the types that a source derives `Component` or `Resource` for.
fn kept_types(source: &str) -> Vec<String> {
    let mut names = Vec::new();
    for (at, _) in source.match_indices("#[derive(") {
        let rest = &source[at + "#[derive(".len()..];
        let Some((derived, rest)) = rest.split_once(")]") else { continue };
        if !derived.split(',').any(|d| ["Component", "Resource"].contains(&d.trim())) {
            continue;
        }
        let name = ["struct ", "enum "]
            .iter()
            .filter_map(|keyword| rest.find(keyword).map(|k| (k, k + keyword.len())))
            .min()
            .map(|(_, k)| rest[k..].chars().take_while(|c| c.is_alphanumeric()).collect());
        names.extend(name);
    }
    names
}

#[test]
fn every_component_and_resource_is_accounted_for() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = BTreeSet::new();
    for directory in ["components", "systems", "src"] {
        for path in sources(&root.join(directory)) {
            let source = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{e}"));
            found.extend(kept_types(&source));
        }
    }
    let known: Vec<&str> = [STORED, OF_THE_SCENE, OF_THE_INCREMENT, WITHOUT_INFLUENCE].concat();
    let known: BTreeSet<String> = known.into_iter().map(str::to_owned).collect();
    let forgotten: Vec<_> = found.difference(&known).collect();
    assert!(
        forgotten.is_empty(),
        "{forgotten:?}: does the next increment depend on it? Then store it in `WorldState`; in any \
         case add it to a table of this file"
    );
    let gone: Vec<_> = known.difference(&found).collect();
    assert!(gone.is_empty(), "{gone:?}: no such component or resource");
}
