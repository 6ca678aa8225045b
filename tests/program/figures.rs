//! `clastic plot` and `clastic export`: figures and files for other programs.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

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

/// What the picture of a figure must contain.
const CONTENT: [(&str, &[&str]); 20] = [
    ("stress-strain", &["axial stress", "lateral stress", "broken bonds", "axial strain, %"]),
    ("volumetric", &["volumetric strain, %"]),
    (
        "force-displacement",
        &["displacement of the probe, mm", "force in this direction, N", "<polyline"],
    ),
    ("energies", &["external", "elastic", "energy, "]),
    ("fabric", &["contacts, a", "normal forces, a_n", "coordination"]),
    ("mohr", &["normal stress, MPa", "shear stress, MPa"]),
    ("specimen", &["<circle", "broken in shear"]),
    ("bonds", &["intact bonds", "broken in shear"]),
    ("force-chains", &["in compression", "width in proportion"]),
    ("stress", &["mean stress of each disk", "MPa"]),
    ("fragments", &["largest fragment", "disks"]),
    ("rotation", &["rotation, anticlockwise positive", "mrad", "#f7f7f7"]),
    ("displacement", &["magnitude of displacement", "mm"]),
    ("shear-strain", &["maximum shear strain, %"]),
    ("volumetric-strain", &["volumetric strain, contraction positive, %"]),
    ("layers", &["#a58cc0", "#c4c4c4"]),
    ("crack-rose", &["number of cracks by direction", "in shear", "90°"]),
    ("contact-rose", &["contacts by direction of the normal", "a cos 2(t - t_a)"]),
    ("force-rose", &["mean normal force by direction", "a_n cos 2(t - t_n)"]),
    ("localisation", &["(a) peak", "(b) end", "(c) layers", "(d) rotation", "since the"]),
];

#[test]
fn every_figure_has_its_content_and_size_and_the_same_bytes() {
    let parent = tempfile::tempdir().unwrap();
    let out = run(parent.path());
    let dir = out.to_str().unwrap();
    let listed = clastic(&["plot", "--list"], 0);
    assert_eq!(listed.lines().count(), CONTENT.len());
    for (name, content) in CONTENT {
        assert!(listed.contains(name), "{name}: {listed}");
        let draw = || {
            // The name of the file is said.
            let said = clastic(&["plot", dir, "--figure", name, "--width", "90"], 0);
            assert!(said.contains(&format!("{name}.svg")), "{said}");
            fs::read_to_string(out.join("figures").join(name).with_extension("svg")).unwrap()
        };
        let svg = draw();
        for words in content {
            assert!(svg.contains(words), "{name} lacks {words}");
        }
        assert!(svg.contains("width=\"90.000mm\""), "{name}");
        assert!(
            svg.ends_with("</svg>\n")
                && svg.matches("<svg").count() == svg.matches("</svg>").count()
        );
        assert!(!svg.contains("NaN"), "{name}");
        assert_eq!(svg, draw(), "{name}");
    }

    // The frames of the run, those that the scene asks for and three more.
    let frames = clastic(&["plot", dir, "--list"], 0);
    for words in ["increment", "start", "peak", "end", "load"] {
        assert!(frames.contains(words), "{words}: {frames}");
    }
    let number = |line: &str| line.split_whitespace().next().and_then(|n| n.parse::<u64>().ok());
    let listed: Vec<_> = frames.lines().filter_map(number).collect();
    let kept: Vec<_> =
        clastic::frames::series(&out).unwrap().iter().map(|frame| frame.increment).collect();
    assert_eq!(listed, kept);

    // A crop holds fewer disks; a field since another frame is another field; the same frame is
    // found by its number and by its file.
    let figure = |more: &[&str]| {
        let file = parent.path().join("figure.svg");
        let mut arguments = vec!["plot", dir, "--out", file.to_str().unwrap(), "--figure"];
        arguments.extend(more);
        clastic(&arguments, 0);
        fs::read_to_string(file).unwrap()
    };
    let whole = figure(&["specimen"]).matches("<circle").count();
    let part = figure(&["specimen", "--crop", "0,0,0.05,0.05"]).matches("<circle").count();
    assert!(whole == 400 && 0 < part && part < 200, "{part} of {whole}");
    let since_start = figure(&["shear-strain"]);
    assert_ne!(since_start, figure(&["shear-strain", "--since", "20"]));
    let tenth = out.join("frames/frame_000010.npz");
    assert_eq!(
        figure(&["specimen", "--frame", "10"]),
        figure(&["specimen", "--frame", tenth.to_str().unwrap()])
    );
    assert!(figure(&["rotation", "--cracks", "--title"]).contains("Biaxial compression"));
    // Curves of two runs lie over one another.
    let two = figure(&["stress-strain", dir]);
    assert!(two.contains("biaxial (2)"), "{two}");
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
fn minerals_have_colours_and_a_test_without_stress_the_peak_of_its_force() {
    let parent = tempfile::tempdir().unwrap();
    let (scene, out) = (parent.path().join("minerals.ron"), parent.path().join("out"));
    fs::write(&scene, MINERALS).unwrap();
    let dir = out.to_str().unwrap();
    clastic(&["run", scene.to_str().unwrap(), "--quiet", "--out", dir], 0);
    let frames = clastic(&["plot", dir, "--list"], 0);
    let peak = frames.lines().find(|line| line.contains("peak")).unwrap_or(&frames);
    assert!(peak.trim_start().starts_with("4 "), "{frames}");
    let figure = |name: &str| {
        clastic(&["plot", dir, "--figure", name, "--frame", "peak"], 0);
        fs::read_to_string(out.join("figures").join(name).with_extension("svg")).unwrap()
    };
    let specimen = figure("specimen");
    assert!(specimen.contains("1 disks of quartz") && specimen.contains("2 disks of mica"));
    for (color, number) in [("#f3f1ec", 2), ("#9ecae1", 1)] {
        let group = specimen.split("<g ").find(|g| g.contains(&format!("fill=\"{color}\" stroke")));
        let group = group.unwrap().split("</g>").next().unwrap();
        assert_eq!(group.matches("<circle").count(), number, "{color}: {group}");
    }
    assert!(figure("force-displacement").contains("displacement along -y, mm"));
}

#[test]
fn what_cannot_be_drawn_is_explained() {
    let parent = tempfile::tempdir().unwrap();
    let out = parent.path().join("lattice");
    let dir = out.to_str().unwrap();
    clastic(&["run", "lattice", "--quiet", "--out", dir], 0);
    let fails = |arguments: &[&str], code: i32, said: &[&str]| {
        let message = clastic(arguments, code);
        for words in said {
            assert!(message.contains(words), "{arguments:?}: {message}");
        }
    };
    fails(&["plot", dir, "--figure", "force-chain"], 2, &["did you mean `force-chains`?", "mohr"]);
    fails(&["plot", dir, "--figure", "energies"], 1, &["energy: true"]);
    fails(&["plot", dir, "--figure", "crack-rose"], 1, &["no bond has broken"]);
    fails(&["plot", dir, "--figure", "specimen", "--frame", "9999"], 1, &["increments "]);
    fails(&["plot", dir, "--figure", "specimen", "--frame", "soon"], 2, &["start, peak, end"]);
    fails(&["plot", dir, dir, "--figure", "specimen"], 2, &["of one run"]);
    fails(&["plot", dir, "--figure", "specimen", "--out", "x.jpg"], 2, &[".svg, .pdf or .png"]);
    fails(&["plot", dir, "--figure", "specimen", "--crop", "1,1,0,0"], 2, &["lower left"]);
    fails(&["plot", dir, "--figure", "specimen", "--width", "3"], 2, &["from 20 to 1000"]);
    let nowhere = parent.path().join("nowhere");
    fails(&["plot", nowhere.to_str().unwrap(), "--figure", "specimen"], 1, &["no run is here"]);
    assert!(!out.join("figures").exists());
}

#[test]
fn an_export_has_the_rows_of_the_frames() {
    let parent = tempfile::tempdir().unwrap();
    let out = run(parent.path());
    let dir = out.to_str().unwrap();
    let said = clastic(&["export", dir, "--format", "csv", "--frame", "end"], 0);
    assert!(said.starts_with("1 frames"), "{said}");
    let rows = |kind: &str| {
        let path = fs::read_dir(out.join("csv")).unwrap().map(|entry| entry.unwrap().path()).find(
            |path| path.file_name().unwrap().to_string_lossy().starts_with(&format!("{kind}_")),
        );
        let text = fs::read_to_string(path.unwrap()).unwrap();
        text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!((rows("bodies").len(), rows("walls").len()), (400, 4));
    // The last row of the history counts the bonds that hold and those that broke.
    let history = fs::read_to_string(out.join("history.csv")).unwrap();
    let column = |name: &str| {
        let at = history.lines().next().unwrap().split(',').position(|n| n == name).unwrap();
        let last = history.lines().last().unwrap().split(',').nth(at).unwrap();
        last.parse::<usize>().unwrap()
    };
    let broken = ["broken_tension", "broken_shear", "broken_rolling"].map(column);
    assert!(broken[1] > 0);
    assert_eq!(rows("cracks").len(), broken.iter().sum::<usize>());
    assert_eq!(rows("bonds").len(), column("bonds") + broken.iter().sum::<usize>());
    assert_eq!(rows("bonds").iter().filter(|row| row.ends_with(",0")).count(), column("bonds"));

    // In the order of time, and each once, however they are asked for.
    let some = out.join("some");
    let moments = ["--frame", "end", "--frame", "start", "--frame", "end"];
    let to = ["export", dir, "--format", "vtk", "--out", some.to_str().unwrap()];
    let said = clastic(&[&to[..], &moments].concat(), 0);
    assert!(said.starts_with("2 frames"), "{said}");
    let series = fs::read_to_string(some.join("bodies.pvd")).unwrap();
    let times: Vec<f64> = series
        .split("timestep=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
        .collect();
    assert!(times.len() == 2 && times[0] < times[1], "{times:?}");

    clastic(&["export", dir, "--format", "vtk"], 0);
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
