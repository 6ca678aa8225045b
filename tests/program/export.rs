//! `clastic export`: files for ParaView.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use base64::prelude::{BASE64_STANDARD, Engine as _};

use crate::call::{PROGRAM, ROOT};

fn clastic(arguments: &[&str], code: i32) -> String {
    let program = Command::new(PROGRAM).current_dir(ROOT).args(arguments).assert().code(code);
    let output = program.get_output();
    let text = if code == 0 { &output.stdout } else { &output.stderr };
    String::from_utf8_lossy(text).into_owned()
}

/// A biaxial test of 400 bonded disks just past the peak, with frames and energies.
fn run(parent: &Path) -> PathBuf {
    let out = parent.join("biaxial");
    let path = out.to_str().unwrap();
    let sets = ["stages.load.increments=24", "output.frames_every=5", "output.energy=true"];
    let mut arguments = vec!["run", "biaxial_small", "--quiet", "--out", path];
    arguments.extend(sets.iter().flat_map(|set| ["--set", set]));
    clastic(&arguments, 0);
    out
}

#[test]
fn an_export_has_the_rows_of_the_frames() {
    let parent = tempfile::tempdir().unwrap();
    let out = run(parent.path());
    let dir = out.to_str().unwrap();
    let one = out.join("one");
    let said = clastic(&["export", dir, "--frame", "end", "--out", one.to_str().unwrap()], 0);
    assert!(said.starts_with("1 frames"), "{said}");
    let text = |kind: &str| {
        let path = fs::read_dir(&one).unwrap().map(|entry| entry.unwrap().path()).find(|path| {
            let name = path.file_name().unwrap().to_string_lossy();
            name.starts_with(&format!("{kind}_")) && name.ends_with(".vtp")
        });
        fs::read_to_string(path.unwrap()).unwrap()
    };
    let rows = |kind: &str, element: &str| {
        let text = text(kind);
        let (_, rest) = text.split_once(&format!("{element}=\"")).unwrap();
        rest.split('"').next().unwrap().parse::<usize>().unwrap()
    };
    assert_eq!((rows("bodies", "NumberOfPoints"), rows("walls", "NumberOfLines")), (400, 4));
    // The last row of the history counts the bonds that hold and those that broke.
    let history = fs::read_to_string(out.join("history.csv")).unwrap();
    let column = |name: &str| {
        let at = history.lines().next().unwrap().split(',').position(|n| n == name).unwrap();
        let last = history.lines().last().unwrap().split(',').nth(at).unwrap();
        last.parse::<usize>().unwrap()
    };
    let broken = ["broken_tension", "broken_shear", "broken_rolling"].map(column);
    assert!(broken[1] > 0);
    assert_eq!(rows("cracks", "NumberOfLines"), broken.iter().sum::<usize>());
    let all = column("bonds") + broken.iter().sum::<usize>();
    assert_eq!(rows("bonds", "NumberOfLines"), all);
    // Whole numbers of eight bytes each, after the number of bytes.
    let bonds = text("bonds");
    let (_, states) = bonds.split_once("Name=\"state\"").unwrap();
    let states = states.split(['<', '>']).nth(1).unwrap();
    let states = BASE64_STANDARD.decode(states).unwrap();
    let states: Vec<_> = states.chunks(8).skip(1).collect();
    assert_eq!(states.len(), all);
    let intact = states.iter().filter(|state| state.iter().all(|byte| *byte == 0));
    assert_eq!(intact.count(), column("bonds"));

    // In the order of time, and each once, however they are asked for.
    let some = out.join("some");
    let moments = ["--frame", "end", "--frame", "start", "--frame", "end"];
    let to = ["export", dir, "--out", some.to_str().unwrap()];
    let said = clastic(&[&to[..], &moments].concat(), 0);
    assert!(said.starts_with("2 frames"), "{said}");
    let series = fs::read_to_string(some.join("bodies.pvd")).unwrap();
    let times: Vec<f64> = series
        .split("timestep=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
        .collect();
    assert!(times.len() == 2 && times[0] < times[1], "{times:?}");

    clastic(&["export", dir], 0);
    let frames = fs::read_dir(out.join("frames")).unwrap();
    let moments = frames.filter(|entry| {
        let name = entry.as_ref().unwrap().file_name();
        name.to_string_lossy().ends_with(".npz")
    });
    let series = fs::read_to_string(out.join("vtk/bodies.pvd")).unwrap();
    let listed = series.matches("<DataSet").count();
    // The start, the peak and the end may be frames that were asked for as well.
    let all = moments.count();
    assert!(listed >= all - 3 && listed <= all, "{listed} of {all}: {series}");
    for line in series.lines().filter(|line| line.contains("file=")) {
        let name = line.split("file=\"").nth(1).unwrap().split('"').next().unwrap();
        let text = fs::read_to_string(out.join("vtk").join(name)).unwrap();
        assert!(text.contains("NumberOfPoints=\"400\" NumberOfVerts=\"400\""), "{name}");
    }
}

/// Two minerals without bonds between two platens, which no measure calls a stress.
const MINERALS: &str = r#"(
    version: 1,
    title: "Two minerals",
    materials: {
        "quartz": (density: 2650.0, contact: (normal_stiffness: 6.0e9, friction: 0.5)),
        "mica": (density: 2800.0, contact: (normal_stiffness: 2.0e9, friction: 0.3)),
    },
    specimen: Particles([
        (position: (0.0, 1.0), radius: 1.0, material: "quartz"),
        (position: (4.0, 1.0), radius: 1.0, material: "mica"),
        (position: (8.0, 1.0), radius: 1.0, material: "mica"),
    ]),
    walls: [
        (name: "floor", start: (-1.0, 0.0), end: (9.0, 0.0), contact: (normal_stiffness: 6.0e9)),
        (name: "lid", start: (9.0, 2.0), end: (-1.0, 2.0), contact: (normal_stiffness: 6.0e9),
            probe: "lid"),
    ],
    stages: [
        Load(name: "press", increments: 4, walls: { "lid": Displacement(0.0, -1.0e-4) }),
        Load(name: "lift", increments: 3, walls: { "lid": Displacement(0.0, 1.0e-4) }),
    ],
    reference_stage: "press",
    output: (frames_every: 1),
)"#;

#[test]
fn a_test_without_stress_has_the_peak_of_its_force_and_what_is_not_there_is_said() {
    let parent = tempfile::tempdir().unwrap();
    let (scene, out) = (parent.path().join("minerals.ron"), parent.path().join("out"));
    fs::write(&scene, MINERALS).unwrap();
    let dir = out.to_str().unwrap();
    clastic(&["run", scene.to_str().unwrap(), "--quiet", "--out", dir], 0);
    clastic(&["export", dir, "--frame", "peak"], 0);
    assert!(out.join("vtk/bodies_000004.vtp").exists());
    let said = clastic(&["export", dir, "--frame", "9999"], 1);
    assert!(said.contains("it has frames of the increments 0, 1, 2"), "{said}");
}
