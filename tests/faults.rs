//! Faults from outside: a run is killed or interrupted, its disk is full, its directory is removed
//! or read-only, its output is a closed pipe. Files that were written are complete, the program
//! names the fault, and the run resumes from its last checkpoint with the same results.
//!
//! Two hundred kills instead of a few: `cargo test --release --test faults -- --ignored`.
#![cfg(unix)]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::files;
use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_clastic");
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A bonded lattice that is compressed until bonds break: 64 increments in half a second, with
/// frames and the page.
const LATTICE: &str = r#"(
    version: 1,
    title: "lattice",
    rupture: (rolling: Yields, order: OneRound),
    materials: { "stone": (
        contact: (normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.3, rolling_friction: 0.05),
        bond: (normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.5, rolling_friction: 0.05,
            cohesion: 20.0e3, tensile_strength: 20.0e3),
    ) },
    specimen: Lattice(columns: 8, rows: 9, radius: 5.0e-3, origin: (5.0e-3, 5.0e-3)),
    walls: [
        (name: "bottom", start: (0.0, 0.0), end: (80.0e-3, 0.0), contact: (normal_stiffness: 6.0e7)),
        (name: "top", start: (80.0e-3, 79.282e-3), end: (0.0, 79.282e-3), probe: "top",
            contact: (normal_stiffness: 6.0e7)),
    ],
    stages: [
        Cement(name: "cement", length: 0.1e-3),
        Load(name: "load", increments: 4, walls: { "top": Force(400.0) }),
        Load(name: "compress", increments: 60, walls: { "top": Displacement(0.0, -10.0e-6) }),
    ],
    measures: [
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "axial_stress", of: Stress(Walls(walls: ["bottom", "top"], length: Fixed(80.0e-3)))),
    ],
    output: (frames_every: 8),
)"#;

/// Where a test works: the scene and its undisturbed run.
struct Place {
    parent: tempfile::TempDir,
    expected: BTreeMap<PathBuf, Vec<u8>>,
}

impl Place {
    fn new() -> Self {
        let parent = tempfile::tempdir().unwrap();
        fs::write(parent.path().join("lattice.ron"), LATTICE).unwrap();
        let mut place = Self { parent, expected: BTreeMap::new() };
        let plain = place.path("plain");
        let done = place.run(&plain, &[]).output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{}", said(&done));
        place.expected = files(&plain);
        let events = String::from_utf8_lossy(&place.expected[Path::new("events.csv")]);
        assert!(events.lines().count() > 1, "no bond broke");
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.parent.path().join(name)
    }

    /// `clastic run` of the scene into a directory.
    fn run(&self, out: &Path, arguments: &[&str]) -> Command {
        let mut command = Command::new(PROGRAM);
        command.current_dir(ROOT).arg("run").arg(self.path("lattice.ron")).arg("--out").arg(out);
        command.args(arguments);
        command
    }

    fn assert_as_undisturbed(&self, directory: &Path, what: &str) {
        let found = files(directory);
        let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&found), names(&self.expected), "{what}");
        for (name, bytes) in &self.expected {
            assert!(*bytes == found[name], "{what}: {} differs", name.display());
        }
    }

    /// Resumes a directory to its end, which must be that of the undisturbed run.
    fn resume_to_the_end(&self, directory: &Path, what: &str) {
        let done = resume(directory).output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{what}: {}", said(&done));
        self.assert_as_undisturbed(directory, what);
    }
}

fn resume(directory: &Path) -> Command {
    let mut command = Command::new(PROGRAM);
    command.arg("resume").arg(directory);
    command
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Checks that everything in a directory is whole; returns the rows of the history.
fn assert_whole(directory: &Path, what: &str) -> u64 {
    let mut rows = 0;
    for (name, bytes) in files(directory) {
        let name = name.to_string_lossy().into_owned();
        let text = String::from_utf8_lossy(&bytes);
        if name.ends_with(".part") || name.ends_with(".bin") {
            continue;
        } else if name.ends_with(".npz") {
            // A zip begins with a file and ends with its directory.
            let whole = bytes.starts_with(b"PK\x03\x04")
                && bytes[bytes.len() - 22..].starts_with(b"PK\x05\x06");
            assert!(whole, "{what}: {name} is not whole");
        } else if name.ends_with(".csv") {
            // Created and not yet written is the one state between nothing and a header.
            let mut lines = text.lines().filter(|line| !line.starts_with('#'));
            let columns = lines.next().map_or(0, |line| line.split(',').count());
            assert!(text.is_empty() || text.ends_with('\n'), "{what}: {name} ends within a row");
            for line in lines {
                assert_eq!(line.split(',').count(), columns, "{what}: {name}: {line}");
                rows += u64::from(name == "history.csv");
            }
        } else if name.ends_with(".json") {
            assert!(serde_json::from_str::<Value>(&text).is_ok(), "{what}: {name}: {text}");
        } else {
            let end = match name.rsplit('.').next() {
                Some("html") => "</html>",
                _ => ")",
            };
            assert!(text.trim_end().ends_with(end), "{what}: {name} is not whole");
        }
    }
    rows
}

/// Numbers that are spread evenly over [0, 1), and the same in every test run.
fn spread(k: u32) -> f64 {
    (f64::from(k) * 0.618_033_988_749_894_9).fract()
}

/// Kills a process after a time, if it is still there.
fn kill_after(mut child: Child, time: Duration) -> bool {
    thread::sleep(time);
    let running = child.try_wait().unwrap().is_none();
    // SIGKILL: the program cannot react.
    let _ = child.kill();
    child.wait().unwrap();
    running
}

/// Increments between checkpoints.
const EVERY: u64 = 3;

/// Kills runs and resumed runs at moments spread over their whole length.
fn killed(times: u32) {
    let place = Place::new();
    let every = EVERY.to_string();
    let arguments = ["--quiet", "--checkpoint-every", &every];
    let begun = Instant::now();
    let timed = place.run(&place.path("timed"), &arguments).output().unwrap();
    assert_eq!(timed.status.code(), Some(0), "{}", said(&timed));
    let length = begun.elapsed();
    let (mut alive, mut without, mut again, mut lost) = (0, 0, 0, 0);
    for k in 0..times {
        let out = place.path(&k.to_string());
        let after = length.mul_f64(spread(k + 1));
        let what = format!("killed after {after:?} of {length:?}");
        let child = place.run(&out, &arguments).stdout(Stdio::null()).spawn().unwrap();
        alive += u32::from(kill_after(child, after));
        let mut rows = if out.exists() { assert_whole(&out, &what) } else { 0 };
        // Some are killed once more while they resume.
        if k % 3 == 0 && out.join("checkpoint.bin").exists() {
            let child = resume(&out).arg("--quiet").stdout(Stdio::null()).spawn().unwrap();
            again += u32::from(kill_after(child, length.mul_f64(0.7 * spread(2 * k + 7))));
            rows = rows.max(assert_whole(&out, &what));
        }
        if out.join("checkpoint.bin").exists() {
            let done = resume(&out).output().unwrap();
            assert_eq!(done.status.code(), Some(0), "{what}: {}", said(&done));
            let word = said(&done);
            let from = word.split_once("resumed after increment ").unwrap().1;
            let from: u64 = from.lines().next().unwrap().parse().unwrap();
            assert!(rows <= from + EVERY, "{what}: {rows} rows, resumed after {from}");
            lost = lost.max(rows.saturating_sub(from));
        } else if !out.join("final_particles.csv").exists() {
            // Killed before the first file was written.
            assert_eq!(rows, 0, "{what}");
            without += 1;
            let done = place.run(&out, &["--quiet", "--force"]).output().unwrap();
            assert_eq!(done.status.code(), Some(0), "{what}: {}", said(&done));
        }
        place.assert_as_undisturbed(&out, &what);
        fs::remove_dir_all(&out).unwrap();
    }
    println!(
        "{times} kills: {alive} while running, {without} before the first checkpoint, {again} once more \
         while resuming; at most {lost} increments lost"
    );
    assert!(alive >= times / 2, "{alive} of {times} kills came in time");
}

#[test]
fn killed_at_any_moment() {
    killed(12);
}

#[test]
#[ignore = "some minutes"]
fn killed_at_200_moments() {
    killed(200);
}

/// Starts a run that would take hours, with a checkpoint every 20 increments, and returns once it
/// has written some of them.
fn long_run(out: &Path) -> Child {
    let mut child = Command::new(PROGRAM)
        .current_dir(ROOT)
        .args(["run", "tension", "--set", "stages.pull.increments=100000000", "--quiet"])
        .args(["--checkpoint-every", "20", "--out"])
        .arg(out)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while fs::read_to_string(out.join("history.csv")).map_or(0, |text| text.lines().count()) < 50 {
        assert_eq!(child.try_wait().unwrap(), None, "it ended by itself");
        assert!(begun.elapsed() < Duration::from_secs(60), "no rows after a minute");
        thread::sleep(Duration::from_millis(5));
    }
    child
}

#[test]
fn a_forced_run_into_a_directory_in_use_is_refused() {
    let place = Place::new();
    let out = place.path("used");
    let mut child = long_run(&out);
    let refused = place.run(&out, &["--force"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(1), "{}", said(&refused));
    let message = said(&refused);
    assert!(message.contains(&format!("{}: a run is still writing", out.display())), "{message}");
    // Without --force it does not say that --force would help.
    let refused = place.run(&out, &[]).output().unwrap();
    assert_eq!(refused.status.code(), Some(1), "{}", said(&refused));
    assert!(!said(&refused).contains("--force"), "{}", said(&refused));
    // The first run has lost nothing: its files are there and it can be resumed.
    assert_eq!(child.try_wait().unwrap(), None, "the first run ended");
    assert!(kill_after(child, Duration::ZERO));
    assert!(assert_whole(&out, "in use") >= 49);
    assert!(fs::read_to_string(out.join("scene.ron")).unwrap().contains("100000000"));
    assert!(out.join("checkpoint.bin").exists());
    // The lock is gone with its holder.
    let done = place.run(&out, &["--force", "--quiet"]).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    place.assert_as_undisturbed(&out, "written over");
}

/// Sends a signal to a process.
fn send(signal: &str, to: &Child) {
    let kill = format!("kill -{signal} {}", to.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
}

/// Waits until the history of a run has a number of lines.
fn wait_for_lines(out: &Path, lines: usize) {
    let begun = Instant::now();
    let found = || fs::read_to_string(out.join("history.csv")).map_or(0, |t| t.lines().count());
    while found() < lines {
        assert!(begun.elapsed() < Duration::from_secs(60), "no {lines} lines after a minute");
        thread::sleep(Duration::from_millis(1));
    }
}

/// The same command with the default action of SIGHUP, which who started the tests with `nohup`
/// ignores.
#[cfg(target_os = "linux")]
fn with_default_hangup(command: &Command) -> Command {
    let mut env = Command::new("env");
    env.arg("--default-signal=HUP").arg(command.get_program()).args(command.get_args());
    env.current_dir(command.get_current_dir().unwrap());
    env
}

/// Runs the scene of a place until a signal stops it; no checkpoints were asked for.
fn stopped_by(place: &Place, signal: &str, out: &Path) {
    let mut command = place.run(out, &["--quiet"]);
    #[cfg(target_os = "linux")]
    {
        command = with_default_hangup(&command);
    }
    let child = command.stdout(Stdio::null()).spawn().unwrap();
    wait_for_lines(out, 5);
    send(signal, &child);
    let code = child.wait_with_output().unwrap().status.code();
    assert_eq!(code, Some(130), "{signal}");
    assert!(out.join("checkpoint.bin").exists(), "{signal}");
    let record: Value =
        serde_json::from_str(&fs::read_to_string(out.join("run.json")).unwrap()).unwrap();
    assert_eq!(record["outcome"]["status"], "interrupted", "{signal}");
}

#[test]
fn sigterm_and_sighup_leave_a_checkpoint_as_ctrl_c_does() {
    let place = Place::new();
    for signal in ["TERM", "HUP"] {
        let out = place.path(signal);
        stopped_by(&place, signal, &out);
        place.resume_to_the_end(&out, signal);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_sighup_that_nohup_ignores_stays_ignored() {
    let parent = tempfile::tempdir().unwrap();
    let out = parent.path().join("out");
    let script = "trap '' HUP; exec \"$0\" \"$@\"";
    let child = Command::new("sh")
        .current_dir(ROOT)
        .args(["-c", script, PROGRAM, "run", "tension", "--quiet"])
        .args(["--set", "stages.pull.increments=100000000", "--out"])
        .arg(&out)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    wait_for_lines(&out, 10);
    send("HUP", &child);
    // It goes on for far longer than the one increment that a signal lets it finish.
    let lines = fs::read_to_string(out.join("history.csv")).unwrap().lines().count();
    wait_for_lines(&out, lines + 200);
    send("TERM", &child);
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(130));
}

#[test]
fn interrupted_and_resumed() {
    let place = Place::new();
    let out = place.path("interrupted");
    stopped_by(&place, "INT", &out);
    place.resume_to_the_end(&out, "interrupted");
    // Now there is nothing left to do, and that is no error.
    let done = resume(&out).output().unwrap();
    assert_eq!(done.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&done.stdout).contains("nothing to resume"));
}

#[test]
fn more_increments_for_a_completed_run_without_its_checkpoint_are_refused_with_a_way_out() {
    let place = Place::new();
    let plain = place.path("plain");
    let set = ["--set", "stages.compress.increments=80"];
    let last = plain.join("final_checkpoint.bin");
    let kept = fs::read(&last).unwrap();
    fs::remove_file(&last).unwrap();
    let refused = resume(&plain).args(set).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(refused.stdout.is_empty());
    let message = said(&refused);
    for what in ["at its end", "Run the scene again", "stages.compress.increments=80", "--force"] {
        assert!(message.contains(what), "no `{what}` in {message}");
    }
    fs::write(&last, kept).unwrap();
    place.assert_as_undisturbed(&plain, "refused");
    // The advice of the message works.
    let done = place.run(&plain, &["--force", "--quiet"]).args(set).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let history = fs::read_to_string(plain.join("history.csv")).unwrap();
    assert_eq!(history.lines().filter(|line| line.contains(",compress,")).count(), 80);
}

#[test]
fn a_run_without_checkpoints_cannot_be_resumed() {
    let out = tempfile::tempdir().unwrap();
    let run = Command::new(PROGRAM)
        .current_dir(ROOT)
        .args(["run", "tension", "--set", "stages.pull.increments=100000000", "--quiet", "--out"])
        .arg(out.path())
        .spawn()
        .unwrap();
    assert!(kill_after(run, Duration::from_millis(500)));
    let refused = resume(out.path()).output().unwrap();
    assert_eq!(refused.status.code(), Some(1));
    let message = said(&refused);
    for what in [&*out.path().to_string_lossy(), "no checkpoint", "--checkpoint-every"] {
        assert!(message.contains(what), "no `{what}` in {message}");
    }
    let nothing = resume(&out.path().join("nowhere")).output().unwrap();
    assert_eq!(nothing.status.code(), Some(1));
    assert!(said(&nothing).contains("no run is here"), "{}", said(&nothing));
}

#[test]
fn a_change_that_cannot_be_is_wrong_usage() {
    let place = Place::new();
    let out = place.path("out");
    let child = place.run(&out, &["--quiet", "--checkpoint-every", "1"]).spawn().unwrap();
    while !out.join("checkpoint.bin").exists() {
        thread::sleep(Duration::from_millis(1));
    }
    kill_after(child, Duration::ZERO);
    let refused = resume(&out).args(["--set", "specimen.radius=4.0e-3"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("`specimen` cannot change"), "{}", said(&refused));
    // It has left no files.
    place.resume_to_the_end(&out, "after a refusal");
}

/// A program whose files may not grow beyond `limit` blocks of 512 bytes. The signal that comes
/// with it is ignored: a full disk sends none.
fn limited(limit: u32) -> Command {
    let script = format!("trap '' XFSZ; ulimit -f {limit}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.current_dir(ROOT).args(["-c", &script, PROGRAM]);
    command
}

/// What a run leaves that could not write one of its files.
fn assert_full(run: &Output, out: &Path, file: &str) {
    let message = said(run);
    assert_eq!(run.status.code(), Some(1), "{message}");
    let expected = format!("{}: File too large", out.join(file).display());
    assert!(message.contains(&expected), "{message}");
    assert_whole(out, &message);
    assert!(files(out).keys().all(|name| !name.ends_with(".part")), "{message}");
    assert_eq!(
        message.contains("clastic resume"),
        out.join("checkpoint.bin").exists(),
        "{message}"
    );
}

#[test]
fn disk_full_at_a_checkpoint() {
    let place = Place::new();
    // The first checkpoint does not fit; the first does and the second, with its bonds, does not.
    for (limit, any) in [(24, false), (60, true)] {
        let out = place.path(&limit.to_string());
        let mut run = limited(limit);
        run.arg("run").arg(place.path("lattice.ron"));
        run.args(["--quiet", "--checkpoint-every", "5", "--out"]).arg(&out);
        assert_full(&run.output().unwrap(), &out, "checkpoint.bin");
        assert_eq!(out.join("checkpoint.bin").exists(), any);
        if any {
            place.resume_to_the_end(&out, "disk full");
        }
    }
}

#[test]
fn disk_full_at_a_saved_state() {
    let parent = tempfile::tempdir().unwrap();
    let (scene, out) = (parent.path().join("saving.ron"), parent.path().join("out"));
    let text = LATTICE.replacen("stages: [", "stages: [Save(name: \"first\"), ", 1);
    fs::write(&scene, text).unwrap();
    let mut run = limited(16);
    run.arg("run").arg(&scene).args(["--quiet", "--out"]).arg(&out);
    assert_full(&run.output().unwrap(), &out, "state_first.npz");
    // The one at the end is the largest of what does not grow with the run.
    let mut run = limited(36);
    run.arg("run").arg(&scene).args(["--quiet", "--force", "--out"]).arg(&out);
    let few = ["stages.compress.increments=2", "output.frames_every=0"];
    run.args(few.map(|set| format!("--set={set}")));
    let failed = run.output().unwrap();
    assert_eq!(failed.status.code(), Some(1), "{}", said(&failed));
    assert!(said(&failed).contains("File too large"), "{}", said(&failed));
    assert_whole(&out, "at the end");
}

#[test]
fn disk_full_at_a_row() {
    let parent = tempfile::tempdir().unwrap();
    let (plain, out) = (parent.path().join("plain"), parent.path().join("out"));
    let arguments = ["run", "tension", "--quiet", "--set", "stages.pull.increments=250"];
    let done = Command::new(PROGRAM)
        .current_dir(ROOT)
        .args(arguments)
        .arg("--out")
        .arg(&plain)
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let mut run = limited(60);
    run.args(arguments).args(["--checkpoint-every", "20", "--out"]).arg(&out);
    assert_full(&run.output().unwrap(), &out, "history.csv");
    let done = resume(&out).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert!(files(&out) == files(&plain));
}

#[test]
fn directory_removed_under_a_run() {
    let parent = tempfile::tempdir().unwrap();
    let out = parent.path().join("out");
    let child = long_run(&out);
    // It may write a file between the listing and the removal.
    while fs::remove_dir_all(&out).is_err() && out.exists() {}
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(1), "{}", said(&ended));
    assert!(said(&ended).contains("out"), "{}", said(&ended));
    assert!(!out.exists());
}

/// A command that has to respect permissions, whoever runs the test.
fn unprivileged(program: &str) -> Command {
    let directory = tempfile::tempdir().unwrap();
    fs::set_permissions(directory.path(), permissions(0o555)).unwrap();
    if fs::write(directory.path().join("probe"), "").is_err() {
        return Command::new(program);
    }
    let mut command = Command::new("setpriv");
    command.args(["--bounding-set=-dac_override,-dac_read_search", program]);
    command
}

fn permissions(mode: u32) -> fs::Permissions {
    std::os::unix::fs::PermissionsExt::from_mode(mode)
}

#[test]
fn read_only_directory() {
    let place = Place::new();
    let parent = place.path("closed");
    fs::create_dir(&parent).unwrap();
    fs::set_permissions(&parent, permissions(0o555)).unwrap();
    let out = parent.join("out");
    let run = unprivileged(PROGRAM)
        .args(["run", "--quiet", "--out"])
        .args([&out, &place.path("lattice.ron")])
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(1), "{}", said(&run));
    assert!(said(&run).contains("closed/out: Permission denied"), "{}", said(&run));
    fs::set_permissions(&parent, permissions(0o755)).unwrap();

    // Made read-only under a run: rows can still be written, a checkpoint cannot.
    let mut child = unprivileged(PROGRAM)
        .args(["run", "--quiet", "--checkpoint-every", "1", "--out"])
        .args([&out, &place.path("lattice.ron")])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !out.join("checkpoint.bin").exists() {
        assert_eq!(child.try_wait().unwrap(), None, "it ended by itself");
        thread::sleep(Duration::from_millis(1));
    }
    fs::set_permissions(&out, permissions(0o555)).unwrap();
    let ended = child.wait_with_output().unwrap();
    fs::set_permissions(&out, permissions(0o755)).unwrap();
    assert_eq!(ended.status.code(), Some(1), "{}", said(&ended));
    assert!(said(&ended).contains("Permission denied"), "{}", said(&ended));
    assert_whole(&out, "read-only");
    place.resume_to_the_end(&out, "read-only");
}

#[test]
fn nobody_listens() {
    let place = Place::new();
    // `clastic run ... | head -0`: the results are in files, and the run is not disturbed.
    let out = place.path("pipe");
    let mut child =
        place.run(&out, &[]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    place.assert_as_undisturbed(&out, "closed pipe");

    // A full disk behind standard output is an error: what was to be read is lost.
    if Path::new("/dev/full").exists() {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let list =
            Command::new(PROGRAM).current_dir(ROOT).arg("list").stdout(full).output().unwrap();
        assert_eq!(list.status.code(), Some(1));
        assert!(said(&list).contains("standard output: No space left"), "{}", said(&list));
    }
}
