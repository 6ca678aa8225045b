//! The window under a display, driven by keys and mouse: `test.sh` starts it under Xvfb.
//!
//! Screenshots go to `screenshots`. Without a display nothing is tested, and a message says so.

mod drive;
mod looks;
mod measure;
mod own_app;
mod session;

use std::process::{Command, ExitCode};

/// Scenes of which pictures are taken, each by a process of its own, since a process has one event
/// loop.
const LOOKS: [&str; 5] = [
    "uniaxial_small",
    "column_collapse_small",
    "hopper",
    "biaxial_membrane_small",
    "simple_shear_periodic",
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["session"] => return session::run(),
        ["own_app"] => return own_app::run(),
        ["look", scene] => return looks::run(scene),
        ["measure", scene] => return measure::run(scene),
        _ => {}
    }
    if std::env::var_os("DISPLAY").is_none() {
        println!("no display: the window is not tested; test.sh starts one");
        return ExitCode::SUCCESS;
    }
    let looks = LOOKS.map(|scene| vec!["look", scene]);
    let parts = [vec!["session"], vec!["own_app"]].into_iter().chain(looks);
    let mut failed = false;
    for part in parts {
        let name = part.join(" ");
        let program = std::env::current_exe().expect("the path of this program");
        let status = Command::new(program).args(part).status().expect("a process");
        println!("{name}: {}", if status.success() { "passed" } else { "FAILED" });
        failed |= !status.success();
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
