//! From a study to its runs: every combination of settings, each checked before anything runs.

use std::fs;
use std::path::{Path, PathBuf};

use super::format::{Runs, Study, StudyError};
use crate::output::run_record::{CLASTIC_VERSION, sha256};
use crate::scene::LoadedScene;
use crate::scene::format::Specimen;

/// Number of hexadecimal digits of the hash that name a directory: two of a million runs have
/// one name with a probability of 2e-3.
const DIGITS: usize = 12;

/// The runs of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Names that differ between runs, in the order of the study.
    pub names: Vec<String>,
    /// The runs, in the order of the study.
    pub runs: Vec<PlannedRun>,
}

/// A run of a study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedRun {
    /// Values in RON, in the order of [`Plan::names`]; empty where the run does not have the name.
    pub values: Vec<String>,
    /// Settings of the scene, `PATH=VALUE`.
    pub sets: Vec<String>,
    /// Name of its directory: the hash of what runs.
    pub directory: String,
}

impl PlannedRun {
    /// The run in one line: its names and values.
    #[must_use]
    pub fn label(&self, names: &[String]) -> String {
        let parts = names.iter().zip(&self.values).filter(|(_, value)| !value.is_empty());
        parts.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
    }
}

/// Plans a study. `file` is that of the study; `load` reads its scene with settings.
///
/// # Errors
/// If the table of a study cannot be read, if a setting leads nowhere or does not fit, if a scene
/// with its settings is wrong, or if two runs are equal.
pub fn plan<E: std::fmt::Display>(
    study: &Study,
    file: &Path,
    load: impl Fn(&[String]) -> Result<LoadedScene, E>,
) -> Result<Plan, StudyError> {
    let Combinations { names, rows } = combinations(study, file)?;
    for (name, fields) in &study.settings.0 {
        if !names.contains(name) {
            let message =
                format!("settings: no run has `{name}`; give it values in `runs`, or leave it out");
            return Err(StudyError::new(file, message));
        }
        if fields.is_empty() {
            let message = format!(
                "settings.{name}: no field; name the fields of the scene that it stands for"
            );
            return Err(StudyError::new(file, message));
        }
    }
    if rows.is_empty() {
        return Err(StudyError::new(file, "runs: there are none; give at least one"));
    }
    let mut runs: Vec<PlannedRun> = Vec::new();
    for (k, values) in rows.into_iter().enumerate() {
        let mut sets = study.set.clone();
        for (name, value) in names.iter().zip(&values).filter(|(_, value)| !value.is_empty()) {
            sets.extend(study.sets(name, value));
        }
        let mut run = PlannedRun { values, sets, directory: String::new() };
        let what = || format!("run {} ({})", k + 1, run.label(&names));
        let loaded = load(&run.sets)
            .map_err(|error| StudyError::new(file, format!("{}:\n{error}", what())))?;
        let directory = directory(&loaded)
            .map_err(|error| StudyError::new(file, format!("{}: {error}", what())))?;
        if let Some(twin) = runs.iter().position(|other| other.directory == directory) {
            let message =
                format!("{} is the same as run {}; leave one of them out", what(), twin + 1);
            return Err(StudyError::new(file, message));
        }
        run.directory = directory;
        runs.push(run);
    }
    Ok(Plan { names, runs })
}

/// Name of the directory of a run: a hash of the program's version, of the scene with its settings,
/// and of the stored specimen.
fn directory(loaded: &LoadedScene) -> std::io::Result<String> {
    let mut content = format!("clastic {CLASTIC_VERSION}\n{}\n", loaded.text).into_bytes();
    if let Specimen::File { path, .. } = &loaded.scene.specimen {
        let path = loaded.path.parent().unwrap_or(Path::new("")).join(path);
        // A shipped specimen is part of the program and of its version.
        if path.exists() {
            content.extend(sha256(&fs::read(path)?).into_bytes());
        }
    }
    Ok(sha256(&content)[..DIGITS].to_owned())
}

struct Combinations {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

fn combinations(study: &Study, file: &Path) -> Result<Combinations, StudyError> {
    match &study.runs {
        Runs::Grid(axes) => {
            let names = axes.0.iter().map(|(name, _)| name.clone()).collect();
            let mut rows = vec![Vec::new()];
            for (_, values) in &axes.0 {
                rows = rows
                    .iter()
                    .flat_map(|row| {
                        values.iter().map(move |value| {
                            let mut row = row.clone();
                            row.push(value.get_ron().trim().to_owned());
                            row
                        })
                    })
                    .collect();
            }
            Ok(Combinations { names, rows })
        }
        Runs::List(list) => {
            let mut names: Vec<String> = Vec::new();
            for (name, _) in list.iter().flat_map(|run| &run.0) {
                if !names.contains(name) {
                    names.push(name.clone());
                }
            }
            let value = |run: &super::ordered::Ordered<Box<ron::value::RawValue>>,
                         name: &String| {
                let entry = run.0.iter().find(|(known, _)| known == name);
                entry.map(|(_, value)| value.get_ron().trim().to_owned()).unwrap_or_default()
            };
            let rows = list.iter().map(|run| names.iter().map(|n| value(run, n)).collect());
            Ok(Combinations { rows: rows.collect(), names })
        }
        Runs::Table(path) => table(&file.parent().unwrap_or(Path::new("")).join(path)),
    }
}

fn table(path: &PathBuf) -> Result<Combinations, StudyError> {
    let wrong = |error: csv::Error| StudyError::new(path, error.to_string());
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(wrong)?;
    let names: Vec<String> = reader.headers().map_err(wrong)?.iter().map(str::to_owned).collect();
    if let Some(twice) = names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)) {
        let message = format!("column `{}` stands twice; leave one of them out", twice.1);
        return Err(StudyError::new(path, message));
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        rows.push(record.map_err(wrong)?.iter().map(str::to_owned).collect());
    }
    Ok(Combinations { names, rows })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{LoadError, from_str};

    const SCENE: &str = r#"(
        version: 1, title: "two disks",
        materials: { "m": (contact: (normal_stiffness: 1.0e6, friction: 0.5)) },
        specimen: Particles([(position: (0.0, 0.0), radius: 1.0), (position: (2.0, 0.0), radius: 1.0)]),
        stages: [Load(name: "load", increments: 1)],
    )"#;

    fn load(sets: &[String]) -> Result<LoadedScene, LoadError> {
        from_str(SCENE, Path::new("two.ron"), Path::new(""), sets)
    }

    fn planned(runs: &str) -> Result<Plan, String> {
        let text = format!(
            "(version: 1, title: \"t\", scene: \"two.ron\", settings: {{ \"mu\": [\"materials.m.contact.friction\"] }}, runs: {runs})"
        );
        let file = Path::new("study.ron");
        let study = Study::read(&text, file).map_err(|e| e.to_string())?;
        plan(&study, file, load).map_err(|e| e.to_string())
    }

    #[test]
    fn a_grid_has_every_combination_and_the_last_name_changes_fastest() -> Result<(), String> {
        let plan = planned(r#"Grid({ "mu": [0.2, 0.4], "gravity": [(0.0, -9.81), (0.0, 0.0)] })"#)?;
        assert_eq!(plan.names, ["mu", "gravity"]);
        let values: Vec<_> = plan.runs.iter().map(|run| run.values.join(" ")).collect();
        assert_eq!(
            values,
            ["0.2 (0.0, -9.81)", "0.2 (0.0, 0.0)", "0.4 (0.0, -9.81)", "0.4 (0.0, 0.0)"]
        );
        assert_eq!(plan.runs[0].sets, ["materials.m.contact.friction=0.2", "gravity=(0.0, -9.81)"]);
        let mut names: Vec<_> = plan.runs.iter().map(|run| run.directory.clone()).collect();
        names.dedup();
        assert_eq!(names.len(), 4);
        Ok(())
    }

    #[test]
    fn a_run_of_a_list_may_lack_a_name() -> Result<(), String> {
        let plan = planned(r#"List([{ "mu": 0.2 }, { "mu": 0.3, "thickness": 2.0 }])"#)?;
        assert_eq!(plan.runs[0].values, ["0.2", ""]);
        assert_eq!(plan.runs[1].label(&plan.names), "mu 0.3, thickness 2.0");
        Ok(())
    }

    #[test]
    fn the_same_run_has_the_same_directory_in_every_study() -> Result<(), String> {
        let grid = planned(r#"Grid({ "mu": [0.2, 0.4] })"#)?;
        let list = planned(r#"List([{ "mu": 0.4 }])"#)?;
        assert_eq!(grid.runs[1].directory, list.runs[0].directory);
        Ok(())
    }

    #[test]
    fn a_mistake_in_one_run_is_told_before_anything_runs() {
        for (runs, expected) in [
            (r#"Grid({ "mu": [0.2, -1.0] })"#, "run 2 (mu -1.0)"),
            (r#"Grid({ "mu": [0.2], "materials.m.contact.frction": [1.0] })"#, "frction"),
            (r#"Grid({ "mu": [0.2, 0.2] })"#, "run 2 (mu 0.2) is the same as run 1"),
            (r#"Grid({ "mu": [] })"#, "runs: there are none"),
            (r#"Grid({ "thickness": [1.0] })"#, "no run has `mu`"),
            (r#"List([{ "mu": 1.0, "mu": 2.0 }])"#, "`mu` stands twice"),
            (r#"Grit({ "mu": [0.2] })"#, "study.ron:1:"),
        ] {
            let found = planned(runs).err().unwrap_or_default();
            assert!(found.contains(expected), "{runs}: {found}");
        }
    }
}
