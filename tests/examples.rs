//! Every program of `examples/` runs to its end; each checks its own numbers.

use std::fmt::Display;
use std::process::ExitCode;

/// What the `main` of a program returns.
trait Ending {
    fn ended(self);
}

impl Ending for () {
    fn ended(self) {}
}

impl<E: Display> Ending for Result<(), E> {
    fn ended(self) {
        self.unwrap_or_else(|e| panic!("{e}"));
    }
}

macro_rules! examples {
    ($($name:ident in $path:literal)*) => {
        $(
            #[path = $path]
            mod $name;
        )*

        mod runs {
            use super::Ending;

            $(
                #[test]
                fn $name() {
                    super::$name::main().ended();
                }
            )*
        }

        const LISTED: &[&str] = &[$($path),*];
    };
}

examples! {
    background in "../examples/background.rs"
    custom_measure in "../examples/custom_measure.rs"
    custom_membrane in "../examples/custom_membrane.rs"
    custom_rupture_rule in "../examples/custom_rupture_rule.rs"
    custom_stage in "../examples/custom_stage.rs"
    custom_wall in "../examples/custom_wall.rs"
    embed in "../examples/embed.rs"
    fixed_update in "../examples/fixed_update.rs"
    interpolated in "../examples/interpolated.rs"
    load_until_collapse in "../examples/load_until_collapse.rs"
    run_app in "../examples/run_app.rs"
    run_scene in "../examples/run_scene.rs"
    scene_in_app in "../examples/scene_in_app.rs"
    states in "../examples/states.rs"
    step_by_hand in "../examples/step_by_hand.rs"
    sub_apps in "../examples/sub_apps.rs"
}

#[path = "../examples/custom_program.rs"]
mod custom_program;

/// Two disks under a lid, with a measure and a condition of the plugin.
const FABRIC: &str = r#"(
    version: 1, title: "fabric",
    materials: { "m": (contact: (normal_stiffness: 1.0e6)) },
    specimen: Particles([(position: (1.0, 1.0), radius: 1.0), (position: (1.0, 3.0), radius: 1.0)]),
    walls: [
        (name: "floor", start: (0.0, 0.0), end: (2.0, 0.0), contact: (normal_stiffness: 1.0e6)),
        (name: "lid", start: (2.0, 4.0), end: (0.0, 4.0), contact: (normal_stiffness: 1.0e6)),
        (name: "left", start: (0.0, 4.0), end: (0.0, 0.0)),
        (name: "right", start: (2.0, 0.0), end: (2.0, 4.0)),
    ],
    stages: [Load(name: "press", increments: 9, walls: { "lid": Displacement(0.0, -1.0e-4) },
        stop: [Above("anisotropy", 0.999)])],
    measures: [(name: "anisotropy", of: Custom("KIND"))],
)"#;

#[test]
fn a_program_with_plugins_has_the_whole_command_line() {
    let folder = tempfile::tempdir().unwrap_or_else(|e| panic!("{e}"));
    let scene = |kind: &str| {
        let path = folder.path().join(format!("{kind}.ron"));
        std::fs::write(&path, FABRIC.replace("KIND", kind)).unwrap_or_else(|e| panic!("{e}"));
        path.display().to_string()
    };
    let (good, bad) = (scene("fabric"), scene("fabrik"));
    let code = |of: ExitCode| format!("{of:?}");
    let call = |arguments: &[&str]| {
        let arguments = [&["custom"], arguments].concat();
        code(clastic::cli::call(&[], arguments, custom_program::fabric).into())
    };
    let (done, refused) = (code(ExitCode::SUCCESS), code(ExitCode::from(3)));
    assert_eq!(call(&["check", &good]), done);
    assert_eq!(call(&["check", &bad]), refused);
    assert_eq!(code(clastic::cli::call(&[], ["bare", "check", &good], ()).into()), refused);
    let out = folder.path().join("out").display().to_string();
    assert_eq!(
        call(&["run", &good, "--out", &out, "--quiet", "--set", "output.plots=false"]),
        done
    );
    let history = std::fs::read_to_string(format!("{out}/history.csv")).unwrap_or_default();
    // The disks lie on one another: every normal is vertical, and the first increment ends the
    // stage.
    let rows: Vec<&str> = history.lines().collect();
    assert!(rows.len() == 2 && rows[0].ends_with(",anisotropy"), "{history}");
    let last: f64 = rows[1].rsplit(',').next().unwrap_or("").parse().unwrap_or(f64::NAN);
    assert!((last - 1.0).abs() < 1e-9, "{history}");
}

/// Examples that are not run as they are: they take the arguments of the process.
const CALLED: [fn() -> ExitCode; 1] = [custom_program::main];

#[test]
fn no_example_is_left_out() {
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/examples");
    let count = std::fs::read_dir(directory).map(Iterator::count);
    assert_eq!(count.unwrap_or_else(|e| panic!("{e}")), LISTED.len() + CALLED.len());
}
