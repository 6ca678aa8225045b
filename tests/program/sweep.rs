//! `clastic sweep`: every run is made once, also if the sweep is interrupted.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::call::{PROGRAM, clastic, stderr, stdout};

/// Two disks pulled apart until their bond breaks, at three strengths and two steps. The force at
/// which it breaks follows from the strength; the step decides how far beyond it is seen.
const STUDY: &str = r#"(
    version: 1,
    title: "one bond, three strengths",
    scene: "tension",
    settings: { "strength": ["materials.cemented.bond.tensile_strength"] },
    runs: Grid({ "strength": [1.0e3, 2.0e3, 3.0e3], "stages.pull.increments": [150, 200] }),
)"#;

/// A folder with the study.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.ron"), STUDY).unwrap();
    folder
}

fn sweep(folder: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(PROGRAM);
    command.args(["sweep", "study.ron", "--out", "out", "--jobs", "2"]).args(more);
    command.current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn table(folder: &Path) -> String {
    fs::read_to_string(folder.join("out/study.csv")).unwrap()
}

/// The table that a sweep leaves which nothing disturbs.
fn undisturbed() -> String {
    let folder = folder();
    assert!(sweep(folder.path(), &[]).status().unwrap().success());
    table(folder.path())
}

#[test]
fn a_sweep_has_a_row_and_a_curve_per_run_and_repeats_none() {
    let folder = folder();
    assert!(sweep(folder.path(), &[]).status().unwrap().success());
    let first = table(folder.path());
    let rows: Vec<_> = first.lines().collect();
    assert_eq!(rows.len(), 7, "{first}");
    assert!(rows[0].starts_with("run,strength,stages.pull.increments,status,marks,"), "{first}");
    assert!(rows[1].contains(",1.0e3,150,completed,,"), "{first}");
    let page = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("strength 1.0e3"), "the page lacks a run");
    let record = |row: &str| {
        let name = row.split(',').next().unwrap();
        folder.path().join("out").join(name).join("run.json")
    };
    let written = |row: &str| fs::metadata(record(row)).unwrap().modified().unwrap();
    let before: Vec<_> = rows[1..].iter().map(|row| written(row)).collect();
    assert!(sweep(folder.path(), &[]).status().unwrap().success());
    assert_eq!(table(folder.path()), first);
    let after: Vec<_> = rows[1..].iter().map(|row| written(row)).collect();
    assert_eq!(before, after, "a run was made again");
}

#[test]
fn a_killed_sweep_goes_on_to_the_same_table() {
    let folder = folder();
    // Killed twice, once so that it cannot tidy up; its runs may go on without it.
    for (pause, signal) in [(40, "KILL"), (60, "TERM")] {
        let mut child = sweep(folder.path(), &[]).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(pause));
        let _ = Command::new("kill").arg(format!("-{signal}")).arg(child.id().to_string()).status();
        child.wait().unwrap();
    }
    assert!(sweep(folder.path(), &[]).status().unwrap().success());
    assert_eq!(table(folder.path()), undisturbed());
}

#[test]
fn two_sweeps_in_one_folder_share_its_runs() {
    let table_of_one = undisturbed();
    // Sometimes both end at the same moment and write the table.
    for _ in 0..10 {
        let folder = folder();
        let mut both = [0, 1].map(|_| sweep(folder.path(), &[]).spawn().unwrap());
        for child in &mut both {
            assert!(child.wait().unwrap().success());
        }
        assert_eq!(table(folder.path()), table_of_one);
    }
}

#[test]
fn tasks_of_a_job_array_leave_the_table_of_a_sweep() {
    let folder = folder();
    let path = folder.path().join("study.ron");
    let script = stdout(&clastic(&["sweep", path.to_str().unwrap(), "--emit", "slurm"]).code(0));
    assert!(script.starts_with("#!/bin/sh\n"), "{script}");
    assert!(script.contains("#SBATCH --array=1-6\n"), "{script}");
    assert!(script.contains("--only \"$SLURM_ARRAY_TASK_ID\""), "{script}");
    for task in ["6", "1", "3", "2", "5", "4"] {
        sweep(folder.path(), &["--only", task]).status().unwrap();
    }
    assert!(sweep(folder.path(), &["--collect"]).status().unwrap().success());
    assert_eq!(table(folder.path()), undisturbed());
}

#[test]
fn a_mistake_is_told_before_anything_runs() {
    for (from, to, told) in [
        ("3.0e3]", "-3.0e3]", "run 5 (strength -3.0e3, stages.pull.increments 150)"),
        ("\"stages.pull.increments\"", "\"stages.pul.increments\"", "stages.pul"),
        ("scene: \"tension\"", "scene: \"tensoin\"", "did you mean `tension`?"),
        (
            "strength\"]",
            "strength=1.0e3\"]",
            "settings.strength: `materials.cemented.bond.tensile_strength=1.0e3` has no place",
        ),
        (
            "\"stages.pull.increments\"",
            "\"materials.cemented.bond.tensile_strength\"",
            "run 1 (strength 1.0e3, materials.cemented.bond.tensile_strength 150): \
             `materials.cemented.bond.tensile_strength` is set twice",
        ),
        (
            "runs: Grid",
            "set: [\"materials.cemented.bond.tensile_strength=5.0e3\"], runs: Grid",
            "run 1 (strength 1.0e3, stages.pull.increments 150): \
             `materials.cemented.bond.tensile_strength` is set twice, by a name or by `set`",
        ),
        (
            "runs: Grid",
            "runs: Grit",
            "study.ron:6:11: runs: unknown variant `Grit`; did you mean `Grid`?",
        ),
    ] {
        let folder = folder();
        let path = folder.path().join("study.ron");
        fs::write(&path, STUDY.replace(from, to)).unwrap();
        let out = folder.path().join("out");
        let arguments = ["sweep", path.to_str().unwrap(), "--out", out.to_str().unwrap()];
        let said = stderr(&clastic(&arguments).failure());
        assert!(said.contains(told), "{to}: {said}");
        assert!(!out.exists(), "{to}");
    }
}

#[test]
fn all_mistakes_of_a_study_are_told_at_once() {
    let folder = folder();
    let text = STUDY
        .replace("title:", "titel:")
        .replace("version: 1,", "version: 1")
        .replace("{ \"strength\": [\"", "{ \"strength\": [], \"strength\": [\"");
    let path = folder.path().join("study.ron");
    fs::write(&path, text).unwrap();
    let said = stderr(&clastic(&["sweep", path.to_str().unwrap()]).failure());
    for told in [
        "study.ron:2:15: missing comma;",
        "study.ron:3:5: titel: unknown field `titel`; did you mean `title`?",
        "study.ron:5:33: settings.strength: `strength` is given twice; give it once",
    ] {
        assert!(said.contains(told), "{told}: {said}");
    }
}

/// Each of its runs is read and checked.
#[test]
fn the_shipped_study_is_sound() {
    let study = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/cemented_sand.ron");
    let script = stdout(&clastic(&["sweep", study, "--emit", "slurm"]).code(0));
    assert!(script.contains("#SBATCH --array=1-18\n"), "{script}");
    assert!(script.contains("# 18: cement 100.0e3, confining 200.0e3, seed 3"), "{script}");
}

/// The shipped granite, seed 4: its modulus is that of tension and of compression in a jacket.
/// Smooth side walls that were cemented to a rock doubled it in compression once.
#[test]
fn a_jacket_does_not_stiffen_the_shipped_granite() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["granite_packing", "granite_tension", "granite_compression"] {
        let name = format!("{scene}.ron");
        let shipped = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/studies")).join(&name);
        fs::copy(shipped, folder.path().join(name)).unwrap();
    }
    let study = r#"(
        version: 1,
        title: "one modulus",
        scenes: { "tension": "granite_tension.ron", "compression": "granite_compression.ron" },
        prepare: (scene: "granite_packing.ron", state: "packed", set: ["let.seed=4"]),
        // No bond breaks in the first two increments.
        set: ["stages.load.increments=2"],
        settings: { "confining": ["let.confining"] },
        runs: List([{ "scene": "tension" }, { "scene": "compression", "confining": 10.0e6 }]),
    )"#;
    fs::write(folder.path().join("study.ron"), study).unwrap();
    assert!(sweep(folder.path(), &[]).status().unwrap().success());
    let text = table(folder.path());
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let at = header.iter().position(|name| *name == "youngs_modulus_pa").unwrap();
    let moduli: Vec<f64> = lines.map(|row| row[at].parse().unwrap()).collect();
    // Gaps that the pressure closes add contacts: 10 MPa is 2e-4 of the modulus.
    assert!((moduli[0] / moduli[1] - 1.0).abs() < 5e-3, "{text}");
}

#[test]
fn the_shipped_studies_of_rock_are_sound() {
    let script = |name: &str| {
        let study = format!("{}/studies/{name}.ron", env!("CARGO_MANIFEST_DIR"));
        stdout(&clastic(&["sweep", &study, "--emit", "slurm"]).code(0))
    };
    let granite = script("granite");
    assert!(granite.contains("scene compression, seed 3, confining 50.0e6"), "{granite}");
    assert!(granite.contains("scene brazilian, seed 1"), "{granite}");
    assert!(script("rock_size").contains("#SBATCH --array=1-100\n"));
}

/// Tests that branch from packings of a few disks: two loads on each of two packings.
const BRANCHES: &str = r#"(
    version: 1,
    title: "two packings, two loads",
    scenes: { "slow": "branch.ron", "fast": "branch.ron" },
    prepare: (scene: "packing.ron", state: "packed", settings: { "seed": ["let.seed"] }),
    settings: { "step": ["let.step"] },
    average_over: ["seed"],
    runs: Several([
        Grid({ "scene": ["slow"], "step": [1.0e-6], "seed": [1, 2] }),
        List([{ "scene": "fast", "step": 2.0e-6, "seed": 2 }]),
    ]),
)"#;

const PACKING: &str = r#"(
    version: 1, title: "packing", let: { "seed": 1 },
    materials: { "m": (contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, friction: 0.5)) },
    specimen: Packing(count: 16, columns: 4, spacing: 2.1e-2, sizes: Uniform(radius: (8.0e-3, 1.0e-2)), seed: seed),
    walls: [
        (name: "bottom", start: (0.0, 0.0), end: (0.085, 0.0), contact: (normal_stiffness: 1.0e8)),
        (name: "top", start: (0.085, 0.1), end: (0.0, 0.1), contact: (normal_stiffness: 1.0e8)),
        (name: "left", start: (0.0, 0.1), end: (0.0, 0.0), contact: (normal_stiffness: 1.0e8)),
        (name: "right", start: (0.085, 0.0), end: (0.085, 0.1), contact: (normal_stiffness: 1.0e8)),
    ],
    stages: [
        Compact(name: "compact", wall: "top", base: "bottom", target: Porosity(0.36), step: 2.0e-3),
        Save(name: "packed"),
    ],
)"#;

const BRANCH: &str = r#"(
    version: 1, title: "branch", let: { "step": 1.0e-6 },
    materials: { "m": (contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, friction: 0.5)) },
    specimen: State(path: "set by the study"),
    stages: [Load(name: "press", increments: 5, walls: { "top": Displacement(0.0, -step) })],
    measures: [
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "axial_stress", of: Stress(Walls(walls: ["top"], length: Fixed(0.085)))),
    ],
)"#;

fn branches() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("study.ron", BRANCHES), ("packing.ron", PACKING), ("branch.ron", BRANCH)]
    {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
fn a_packing_is_made_once_and_branched() {
    let folder = branches();
    assert!(sweep(folder.path(), &[]).status().unwrap().success());
    let text = table(folder.path());
    let rows: Vec<_> = text.lines().collect();
    assert_eq!(rows.len(), 4, "{text}");
    assert!(rows[3].contains(",fast,2.0e-6,2,completed,"), "{text}");
    let runs = fs::read_dir(folder.path().join("out")).unwrap();
    let runs = runs.filter(|entry| entry.as_ref().unwrap().path().is_dir()).count();
    assert_eq!(runs, 3 + 2, "three runs and two packings");
    let means = fs::read_to_string(folder.path().join("out/study_means.csv")).unwrap();
    let rows: Vec<_> = means.lines().collect();
    assert!(rows[0].starts_with("scene,step,runs,marked_runs,"), "{means}");
    assert!(rows[1].starts_with("slow,1.0e-6,2,0,") && rows.len() == 3, "{means}");
    // The same study in another folder, by tasks of a job array, leaves the same table.
    let other = branches();
    for task in ["3", "1", "2"] {
        sweep(other.path(), &["--only", task]).status().unwrap();
    }
    assert!(sweep(other.path(), &["--collect"]).status().unwrap().success());
    assert_eq!(table(other.path()), text);
}

#[test]
fn a_killed_sweep_with_preparations_goes_on_to_the_same_table() {
    let whole = branches();
    assert!(sweep(whole.path(), &[]).status().unwrap().success());
    let killed = branches();
    for pause in [30, 60, 90] {
        let mut child = sweep(killed.path(), &[]).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(pause));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert!(sweep(killed.path(), &[]).status().unwrap().success());
    assert_eq!(table(killed.path()), table(whole.path()));
}

#[test]
fn a_preparation_that_fails_leaves_its_runs_out_and_says_so() {
    let folder = branches();
    // No packing of these disks is that dense: the compaction ends without its target.
    let packing = PACKING.replace("Porosity(0.36)", "Porosity(0.02)");
    fs::write(folder.path().join("packing.ron"), packing).unwrap();
    let out = sweep(folder.path(), &[]).stderr(Stdio::piped()).output().unwrap();
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(!out.status.success());
    assert!(said.contains("preparation, seed 1: failed:"), "{said}");
    assert!(said.contains("preparation, seed 2 was not completed"), "{said}");
    assert!(table(folder.path()).contains(",slow,1.0e-6,1,not run,not run,"));
}

#[test]
fn a_mistake_in_a_preparation_is_told_before_anything_runs() {
    for (file, from, to, told) in [
        ("study.ron", "\"packed\"", "\"paced\"", "did you mean `packed`?"),
        ("study.ron", "\"seed\": [\"let.seed\"]", "\"seed\": [\"let.sed\"]", "let.sed"),
        ("study.ron", "\"scene\": \"fast\"", "\"scene\": \"fasd\"", "did you mean `fast`?"),
        (
            "study.ron",
            "average_over: [\"seed\"]",
            "average_over: [\"sed\"]",
            "did you mean `seed`?",
        ),
        (
            "packing.ron",
            "Porosity(0.36)",
            "Porosity(1.36)",
            "run 1 (scene slow, step 1.0e-6, seed 1)",
        ),
        ("branch.ron", "increments: 5", "increments: 0", "stages[0].increments"),
        ("branch.ron", "State(path: \"set by the study\")", "Particles([])", "specimen"),
    ] {
        let folder = branches();
        let path = folder.path().join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{from}");
        fs::write(&path, text.replace(from, to)).unwrap();
        let out = sweep(folder.path(), &[]).stderr(Stdio::piped()).output().unwrap();
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(said.contains(told), "{to}: {said}");
        assert!(!folder.path().join("out").exists(), "{to}");
    }
}
