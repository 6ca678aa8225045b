//! From a study to its runs: every combination of settings, each checked before anything runs.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::combinations::combinations;
use super::format::{Preparation, SCENE, Study, StudyError, sets};
use super::planned::{Plan, PlannedRun, Start, Wanted};
use crate::output::directory;
use crate::output::run_record::{CLASTIC_VERSION, sha256};
use crate::scene::LoadedScene;
use crate::scene::format::{Save, Scene, Specimen, Stage};
use crate::text::spans::join;
use crate::text::suggest;

/// Number of hexadecimal digits of the hash that name a directory: two of a million runs have
/// one name with a probability of 2e-3.
const DIGITS: usize = 12;

/// Setting that gives a scene its saved state.
pub(crate) fn state_at(path: &Path) -> String {
    // A path in RON is a string, in which `\` begins an escape.
    format!("specimen.path={:?}", path.display().to_string())
}

/// Reads a scene with settings.
type Load<'a> = &'a dyn Fn(Wanted<'_>) -> Result<LoadedScene, String>;

/// Plans a study. `file` is that of the study.
pub fn plan(study: &Study, file: &Path, load: Load<'_>) -> Result<Plan, StudyError> {
    let wrong = |path: &str, message: String| study.wrong(file, path, &message);
    let mut rows = combinations(&study.runs, "runs");
    if rows.is_empty() {
        return Err(wrong("runs", "there are none; give at least one".to_owned()));
    }
    let mut plan = Plan::default();
    for (name, value) in rows.iter_mut().flat_map(|(_, values)| values) {
        if name == SCENE && study.scene.is_none() {
            // The value is a string in RON.
            *value = value.trim_matches('"').to_owned();
        }
        if !plan.names.contains(name) {
            plan.names.push(name.clone());
        }
    }
    let of_preparation =
        study.prepare.iter().map(|prepare| ("prepare.settings", &prepare.settings));
    for (place, settings) in [("settings", &study.settings)].into_iter().chain(of_preparation) {
        for (name, fields) in settings {
            let wrong = |message: String| wrong(&join(place, name), message);
            if !plan.names.contains(name) {
                return Err(wrong(format!(
                    "no run has `{name}`; give it values in `runs`, or leave it out"
                )));
            }
            if fields.is_empty() {
                let message = "no field; name the fields of the scene that it stands for";
                return Err(wrong(message.to_owned()));
            }
            let is_constant = |field: &&String| field.contains('=') && !field.contains("{}");
            if let Some(field) = fields.iter().find(is_constant) {
                return Err(wrong(format!(
                    "`{field}` has no place for the value; write `{{}}` there, or give it to all runs in `set`"
                )));
            }
        }
    }
    if let Some(name) = study.average_over.iter().find(|name| !plan.names.contains(name)) {
        let known: Vec<_> = plan.names.iter().map(String::as_str).collect();
        let help = suggest::help(name, &known, "names of the runs");
        return Err(wrong("average_over", format!("no run has `{name}`; {help}")));
    }
    for (k, (path, values)) in rows.iter().enumerate() {
        let value = |name| values.iter().find(|(known, _)| known == name);
        let value = |name| value(name).map_or(String::new(), |(_, value)| value.clone());
        let run =
            PlannedRun { values: plan.names.iter().map(value).collect(), ..PlannedRun::default() };
        let what = format!("run {} ({})", k + 1, run.label(&plan.names));
        plan.add(run, study, load).map_err(|message| wrong(path, format!("{what}{message}")))?;
    }
    Ok(plan)
}

impl Plan {
    /// Adds a run that has its values, and the preparation that it needs. An error begins with the
    /// punctuation after the name of the run.
    fn add(&mut self, mut run: PlannedRun, study: &Study, load: Load<'_>) -> Result<(), String> {
        let values = self.names.iter().zip(&run.values).filter(|(_, value)| !value.is_empty());
        let values: Vec<_> = values.map(|(name, value)| (name.clone(), value.clone())).collect();
        let scene = scene(study, &values)?;
        run.sets.clone_from(&study.set);
        for (name, value) in &values {
            let is_of_preparation =
                study.prepare.as_ref().is_some_and(|p| p.settings.get(name).is_some());
            match study.settings.get(name) {
                Some(fields) => run.sets.extend(sets(fields, value)),
                // It chooses the scene, or belongs to the preparation alone.
                None if is_of_preparation => {}
                None if name == SCENE && study.scene.is_none() => {}
                None => run.sets.push(format!("{name}={value}")),
            }
        }
        let mut paths = BTreeSet::new();
        let all = run.sets.iter().filter_map(|set| set.split_once('='));
        if let Some((path, _)) = all.into_iter().find(|(path, _)| !paths.insert(path.trim())) {
            return Err(format!(": `{path}` is set twice, by a name or by `set`; leave one out"));
        }
        let mut sets = run.sets.clone();
        if let Some(prepare) = &study.prepare {
            let start = self.prepared(prepare, &values, load)?;
            let before = &self.preparations[start.preparation].directory;
            sets.push(state_at(&Path::new(before).join(&start.file)));
            run.start = Some(start);
        }
        let wanted = Wanted { scene, sets: &sets, is_unprepared: run.start.is_some() };
        let loaded = load(wanted).map_err(|error| format!(":\n{error}"))?;
        if run.start.is_some() && !matches!(loaded.scene.specimen, Specimen::State { .. }) {
            return Err(format!(
                ": scene `{}` does not start from the state that is prepared; give it \
                 `specimen: State(path: \"...\")`, whose path the study sets",
                scene.display()
            ));
        }
        run.directory = hashed(&loaded).map_err(|error| format!(": {error}"))?;
        run.scene = loaded.path;
        if let Some(twin) = self.runs.iter().position(|r| r.directory == run.directory) {
            return Err(format!(" is the same as run {}; leave one of them out", twin + 1));
        }
        self.runs.push(run);
        Ok(())
    }

    /// The state that a run with some values starts from. Its preparation is added to the plan
    /// unless it is there.
    fn prepared(
        &mut self,
        prepare: &Preparation,
        values: &[(String, String)],
        load: Load<'_>,
    ) -> Result<Start, String> {
        let mut run = PlannedRun {
            values: vec![String::new(); self.names.len()],
            sets: prepare.set.clone(),
            ..PlannedRun::default()
        };
        for (name, fields) in &prepare.settings {
            let Some((_, value)) = values.iter().find(|(known, _)| known == name) else {
                return Err(format!(": its preparation needs a value of `{name}`"));
            };
            run.sets.extend(sets(fields, value));
            if let Some(at) = self.names.iter().position(|known| known == name) {
                run.values[at].clone_from(value);
            }
        }
        let wanted = Wanted { scene: &prepare.scene, sets: &run.sets, is_unprepared: false };
        let loaded = load(wanted).map_err(|error| format!(", its preparation:\n{error}"))?;
        let file = match &prepare.state {
            None => directory::FINAL_STATE.to_owned(),
            Some(state) => saved_as(&loaded.scene, state)?,
        };
        run.directory = hashed(&loaded).map_err(|error| format!(", its preparation: {error}"))?;
        run.scene = loaded.path;
        let there = self.preparations.iter().position(|p| p.directory == run.directory);
        let preparation = there.unwrap_or_else(|| {
            self.preparations.push(run);
            self.preparations.len() - 1
        });
        Ok(Start { preparation, file })
    }
}

/// The scene of a run with some values.
fn scene<'a>(study: &'a Study, values: &[(String, String)]) -> Result<&'a Path, String> {
    match &study.scene {
        Some(scene) if study.scenes.is_empty() => return Ok(scene),
        None if !study.scenes.is_empty() => {}
        _ => return Err(": give the study either `scene` or `scenes`".to_owned()),
    }
    let known: Vec<_> = study.scenes.keys().map(String::as_str).collect();
    let Some((_, value)) = values.iter().find(|(name, _)| name == SCENE) else {
        return Err(format!(": give it a `{SCENE}`: one of {}", known.join(", ")));
    };
    study.scenes.get(value).map(PathBuf::as_path).ok_or_else(|| {
        let help = suggest::help(value, &known, "scenes of the study");
        format!(": `scenes` has no `{value}`; {help}")
    })
}

/// File of the state that a stage keeps.
fn saved_as(scene: &Scene, state: &str) -> Result<String, String> {
    let saves = || {
        scene.stages.iter().filter_map(|stage| match stage {
            Stage::Save(save) => Some(save),
            _ => None,
        })
    };
    let found = saves().find(|save| save.name == state).map(Save::file);
    found.ok_or_else(|| {
        let there: Vec<_> = saves().map(|save| save.name.as_str()).collect();
        let help = suggest::help(state, &there, "states that the scene saves");
        format!(", its preparation: prepare.state: no stage `Save` is named `{state}`; {help}")
    })
}

/// Name of the directory of a run: a hash of the program's version, of the scene with its settings,
/// and of the stored specimen.
fn hashed(loaded: &LoadedScene) -> std::io::Result<String> {
    let mut content = format!("clastic {CLASTIC_VERSION}\n{}\n", loaded.text).into_bytes();
    // A shipped specimen is part of the program and of its version. A state that is prepared is not
    // there yet; the directory of its preparation is part of the path.
    if let Some(path) = loaded.specimen_file().filter(|path| path.exists()) {
        content.extend(sha256(&fs::read(path)?).into_bytes());
    }
    Ok(sha256(&content)[..DIGITS].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::from_str;

    const SCENE: &str = r#"(
        version: 1, title: "two disks",
        materials: { "m": (contact: (normal_stiffness: 1.0e6, friction: 0.5)) },
        specimen: Particles([(position: (0.0, 0.0), radius: 1.0), (position: (2.0, 0.0), radius: 1.0)]),
        stages: [Load(name: "load", increments: 1)],
    )"#;

    fn load(wanted: Wanted<'_>) -> Result<LoadedScene, String> {
        let loaded = from_str(SCENE, Path::new("two.ron"), Path::new(""), wanted.sets);
        loaded.map_err(|error| error.to_string())
    }

    fn planned(runs: &str) -> Result<Plan, String> {
        let text = format!(
            "(version: 1, title: \"t\", scene: \"two.ron\", settings: {{ \"mu\": [\"materials.m.contact.friction\"] }}, runs: {runs})"
        );
        let file = Path::new("study.ron");
        let study = Study::read(&text, file).map_err(|e| e.to_string())?;
        plan(&study, file, &load).map_err(|e| e.to_string())
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
            (r#"Grid({ "mu": [0.2, -1.0] })"#, "study.ron:1:104: runs: run 2 (mu -1.0)"),
            (r#"Grid({ "mu": [0.2], "materials.m.contact.frction": [1.0] })"#, "frction"),
            (r#"Grid({ "mu": [0.2, 0.2] })"#, "run 2 (mu 0.2) is the same as run 1"),
            (
                r#"List([{ "mu": 0.2 }, { "mu": -1.0 }])"#,
                "study.ron:1:125: runs[1]: run 2 (mu -1.0)",
            ),
            (r#"Grid({ "mu": [] })"#, "study.ron:1:104: runs: there are none"),
            (r#"Grid({ "thickness": [1.0] })"#, "study.ron:1:62: settings.mu: no run has `mu`"),
            (r#"List([{ "mu": 1.0, "mu": 2.0 }])"#, "`mu` is given twice"),
            (r#"Grit({ "mu": [0.2] })"#, "study.ron:1:"),
        ] {
            let found = planned(runs).err().unwrap_or_default();
            assert!(found.contains(expected), "{runs}: {found}");
        }
    }
}
