//! Files of a run: input, an earlier run in the same directory, columns, bytes.

use std::fs;
use std::path::Path;
use std::process::Command as Process;
use std::time::Duration;

use assert_cmd::Command;
use assert_cmd::assert::Assert;

use crate::call::{PROGRAM, ROOT, clastic, json, read, rows, run, stderr, stdout};
use crate::common::files;

#[test]
fn an_existing_run_is_written_over_by_force_only() {
    let (first, directory) = run("tension", &[]);
    first.code(0);
    let before = read(directory.path(), "history.csv");
    let out = directory.path().to_str().unwrap();
    let half = ["run", "tension", "--out", out, "--set", "stages.pull.increments=12"];
    let refused = stderr(&clastic(&half).code(1));
    assert!(refused.contains(out) && refused.contains("--force"), "{refused}");
    assert_eq!(read(directory.path(), "history.csv"), before);

    clastic(&[&half[..], &["--force"]].concat()).code(0);
    assert_eq!(rows(directory.path(), "history.csv").len(), 12);
    assert_eq!(json(directory.path(), "run.json")["overrides"][0], "stages.pull.increments=12");
    assert!(read(directory.path(), "scene.ron").contains("increments: 12,"));
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let pipe = directory.path().join("pipe.ron");
    assert!(Process::new("mkfifo").arg(&pipe).status().unwrap().success());
    let out = directory.path().join("out");
    // Nobody writes to the pipe: whoever opens it waits for ever.
    let refuse = |arguments: &[&str]| {
        let mut command = Command::new(PROGRAM);
        command.current_dir(ROOT).args(arguments).timeout(Duration::from_secs(60));
        stderr(&command.assert())
    };
    for command in ["check", "run"] {
        let said = refuse(&[command, pipe.to_str().unwrap()]);
        let expected = "pipe.ron: cannot read the scene: it is a named pipe, not a regular file";
        assert!(said.contains(expected), "{said}");
    }
    let specimen = format!("specimen.path={:?}", pipe.to_str().unwrap());
    let out = out.to_str().unwrap();
    let said = refuse(&["run", "biaxial_small", "--set", &specimen, "--out", out]);
    assert!(said.contains("pipe.ron`: it is a named pipe, not a regular file"), "{said}");
}

#[test]
fn a_specimen_of_only_a_header_is_an_input_error() {
    let directory = tempfile::tempdir().unwrap();
    let specimen = directory.path().join("header.csv");
    fs::write(&specimen, "x_m,y_m,radius_m\n").unwrap();
    let set = format!("specimen.path={:?}", specimen.to_str().unwrap());
    let (refused, out) = run("biaxial_small", &["--set", &set]);
    let said = stderr(&refused.code(3));
    assert!(said.contains("header.csv:2:1: no particles: only a header"), "{said}");
    assert_eq!(fs::read_dir(out.path()).unwrap().count(), 0);
}

#[test]
fn a_run_reads_the_final_particles_of_another_one() {
    let (first, out) = run("biaxial_small", &["--set", "stages.load.increments=1"]);
    first.code(0);
    let specimen = out.path().join("final_particles.csv");
    let set = format!("specimen.path={:?}", specimen.to_str().unwrap());
    let one = ["--set", "stages.load.increments=1", "--set", &set];
    let (second, again) = run("biaxial_small", &one);
    second.code(0);
    let expected = rows(out.path(), "final_particles.csv");
    let found = rows(again.path(), "specimen.csv");
    assert_eq!(found.len(), expected.len());
    assert_eq!(json(again.path(), "run.json")["specimen_sha256"].as_str().map(str::len), Some(64));
}

/// Grains that are poured into a box, and its end under equal stress on all sides.
fn poured(seed: u64) -> String {
    format!(
        r#"(
        version: 1,
        title: "poured bed",
        analysis: Dynamic(dt: 2.0e-3, theta: 1.0),
        gravity: (0.0, -9.81),
        materials: {{ "sand": (density: 2650.0, contact: (friction: 0.5)) }},
        specimen: Packing(
            count: 120, columns: 10, spacing: 12.5e-3, origin: (4.0e-3, 4.0e-3),
            sizes: Uniform(radius: (4.0e-3, 6.0e-3)), seed: {seed},
        ),
        walls: [
            (name: "floor", start: (0.0, 0.0), end: (0.132, 0.0)),
            (name: "left", start: (0.0, 0.5), end: (0.0, 0.0)),
            (name: "right", start: (0.132, 0.0), end: (0.132, 0.5)),
        ],
        stages: [Load(name: "pour", increments: 400)],
    )"#
    )
}

fn confined(specimen: &Path) -> String {
    let stiff = "contact: (normal_stiffness: 60.0e6)";
    let [axial, lateral] = [r#""left", "right""#, r#""floor", "lid""#]
        .map(|between| format!("Stress(stress: 100.0e3, between: ({between}))"));
    format!(
        r#"(
        version: 1,
        title: "poured bed under equal stress",
        materials: {{
            "sand": (contact: (normal_stiffness: 60.0e6, tangential_stiffness: 30.0e6, friction: 0.5)),
        }},
        specimen: File(path: {specimen:?}),
        walls: [
            (name: "floor", start: (0.0, 0.0), end: (0.132, 0.0), {stiff}),
            (name: "lid", start: (0.132, 0.14), end: (0.0, 0.14), {stiff}),
            (name: "left", start: (0.0, 0.14), end: (0.0, 0.0), {stiff}),
            (name: "right", start: (0.132, 0.0), end: (0.132, 0.14), {stiff}),
        ],
        stages: [Load(name: "confine", increments: 10, walls: {{
            "floor": {axial}, "lid": {axial}, "left": {lateral}, "right": {lateral},
        }})],
        measures: [
            (name: "axial_stress", of: Stress(Walls(walls: ["floor", "lid"], length: Between("left", "right")))),
            (name: "lateral_stress", of: Stress(Walls(walls: ["left", "right"], length: Between("floor", "lid")))),
        ],
    )"#
    )
}

/// The grains of the surface carry nothing, and the lid begins far above them: no static state lies
/// near the first stress, and the run was undecided in its first increment.
#[test]
fn a_poured_bed_that_is_read_again_is_confined() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let run = |scene: &str, text: String| {
        fs::write(path(scene), text).unwrap();
        let out = path(scene).with_extension("");
        let [scene, to] = [&path(scene), &out].map(|path| path.to_str().unwrap().to_owned());
        clastic(&["run", &scene, "--out", &to, "--force", "--set", "output.plots=false"]).code(0);
        out
    };
    for seed in [3, 4] {
        let bed = run("pour.ron", poured(seed));
        let out = run("confine.ron", confined(&bed.join("final_particles.csv")));
        let history = rows(&out, "history.csv");
        assert!(history.iter().all(|row| row["status"] == "solved"), "seed {seed}");
        let last = history.last().unwrap();
        for stress in ["axial_stress_pa", "lateral_stress_pa"] {
            let reached: f64 = last[stress].parse().unwrap();
            assert!((reached / 100e3 - 1.0).abs() < 1e-7, "seed {seed}: {stress} {reached}");
        }
    }
}

#[test]
fn headers_are_the_documented_ones() {
    let (done, out) = run("tension", &["--quiet", "--set", "stages.pull.increments=1"]);
    assert_eq!(stderr(&done.code(0)), "");
    let header = |name| read(out.path(), name).lines().next().unwrap().to_owned();
    let history = header("history.csv");
    let columns = "increment,stage,time_s,axial_strain,lateral_strain,volumetric_strain,\
        axial_stress_pa,lateral_stress_pa,contacts,bonds,broken_tension,broken_shear,\
        broken_rolling,solver_iterations,residual_balance,residual_kinematics,residual_cone,\
        residual_complementarity,imbalance_at_end,idle_motion,status,";
    assert!(history.starts_with(columns), "{history}");
    let probes = "held.x_m,held.y_m,held.rotation_rad,held.force_x_n,held.force_y_n,held.moment_nm,\
        pulled.x_m,pulled.y_m,pulled.rotation_rad,pulled.force_x_n,pulled.force_y_n,pulled.moment_nm";
    assert!(history.ends_with(probes), "{history}");
    let events = "increment,stage,bond,a,b,mode,x_m,y_m,normal_x,normal_y,p_n,q_n,tau_nm";
    assert_eq!(header("events.csv"), events);
    let timings =
        "increment,detect_s,assemble_s,solve_s,update_s,rupture_s,walls_s,record_s,output_s";
    assert_eq!(header("timings.csv"), timings);
}

#[test]
fn the_moment_of_the_stored_specimen_is_said() {
    // Poured: the disk falls in the only stage, which is the reference stage.
    let (done, out) = run("bounce", &["--quiet", "--set", "stages.drop.increments=60"]);
    let said = stdout(&done.code(0));
    let moment = "at the start of the reference stage `drop`, before its first increment";
    assert!(said.contains(&format!("specimen.csv holds the particles {moment}")), "{said}");
    assert_eq!(json(out.path(), "run.json")["specimen_csv"], moment);
    let height = |name: &str| rows(out.path(), name)[0]["y_m"].parse::<f64>().unwrap();
    assert!(height("specimen.csv") > height("final_particles.csv"));
    // A compaction leaves its packing.
    let (done, out) = run("prepare_biaxial_small", &["--quiet"]);
    let said = stdout(&done.code(0));
    let moment = "at the end of the compaction `compact`";
    assert!(said.contains(&format!("specimen.csv holds the particles {moment}")), "{said}");
    assert_eq!(json(out.path(), "run.json")["specimen_csv"], moment);
}

#[test]
fn two_runs_leave_the_same_bytes() {
    // Compaction, bonds that break, walls that a stage takes away, frames, the page, a dump.
    let settings = [
        "--set",
        "stages.load.walls.top[1]=-14.0e-6",
        "--set",
        "stages.load.increments=8",
        "--set",
        "output=(frames_every: 3)",
        "--dump-program",
        "40",
    ];
    let (first, a) = run("uniaxial_small", &[&settings[..], &["--threads", "1"]].concat());
    let (second, b) =
        run("uniaxial_small", &[&settings[..], &["--quiet", "--threads", "2"]].concat());
    let (first, second) = (first.code(0), second.code(0));
    let last = |run: &Assert| stdout(run).lines().rev().nth(1).map(str::to_owned);
    assert_eq!(last(&first), last(&second));
    let (a, b) = (files(a.path()), files(b.path()));
    assert!(a.keys().eq(b.keys()), "{:?}\n{:?}", a.keys(), b.keys());
    for (name, bytes) in &a {
        assert!(*bytes == b[name], "{} differs", name.display());
    }
    let events = String::from_utf8_lossy(&a[Path::new("events.csv")]);
    assert!(events.lines().count() > 1, "no bond broke");
    for name in ["frames/frame_000003.csv", "program_000040.json", "report.html", "specimen.csv"] {
        assert!(a.contains_key(Path::new(name)), "no {name}");
    }
}
