//! `report.html` in a browser: headless Chromium operates the page, and its numbers are compared
//! with the files of the run.
//!
//! Chromium is `chromium` (Debian's package), or what the environment variable `CLASTIC_CHROMIUM`
//! names. Without it the tests of the page say so and pass; `.ci/run` asks for it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clastic::frames;
use clastic::tables::Tables;
use serde_json::Value;

use crate::call::{json, read, run, stdout};

/// The page, with what collects errors before everything else and what uses the page at its end.
fn checked(page: &Path) -> PathBuf {
    let text = fs::read_to_string(page).unwrap();
    let listen = format!("<head>\n<script>\n{}</script>", include_str!("report/listen.js"));
    let check = format!("<script>\n{}</script>\n</body>", include_str!("report/check.js"));
    let at = text.rfind("</body>").unwrap();
    let text = [&text[..at], &check, &text[at + "</body>".len()..]].concat();
    let out = page.with_file_name("checked.html");
    fs::write(&out, text.replacen("<head>", &listen, 1)).unwrap();
    out
}

/// A headless browser; `None`, with a message, if there is none.
fn chromium() -> Option<Command> {
    let program = std::env::var("CLASTIC_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let quiet = |command: &mut Command| {
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status()
    };
    if quiet(Command::new(&program).arg("--version")).is_err() {
        eprintln!("SKIPPED: no `{program}`; install Debian's package, or set CLASTIC_CHROMIUM");
        return None;
    }
    let mut command = Command::new(program);
    command.args(["--headless=new", "--no-sandbox", "--use-angle=swiftshader"]);
    command.args(["--enable-unsafe-swiftshader", "--window-size=1280,1000"]);
    // Dark mode.
    command.arg("--blink-settings=preferredColorScheme=0");
    Some(command)
}

/// What the page leaves in its element `seen`.
fn seen(page: &Path) -> Option<Value> {
    let profile = tempfile::tempdir().unwrap();
    let mut command = chromium()?;
    command.arg(format!("--user-data-dir={}", profile.path().display()));
    command.args(["--virtual-time-budget=120000", "--dump-dom"]);
    command.arg(format!("file://{}", checked(page).display()));
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let start = text.find("<pre id=\"seen\">").map(|at| at + "<pre id=\"seen\">".len());
    let Some(start) = start else {
        let said = String::from_utf8_lossy(&output.stderr);
        panic!("the page said nothing\n{said}\n{}", &text[text.len().saturating_sub(2000)..]);
    };
    let end = start + text[start..].find("</pre>").unwrap();
    let plain = text[start..end].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    Some(serde_json::from_str(&plain).unwrap())
}

fn number(of: &Value, name: &str) -> f64 {
    of[name].as_f64().unwrap_or_else(|| panic!("no {name} in {of}"))
}

/// Equal within half a step of values of which 1 % exceed `typical`.
fn is_shown(shown: f64, exact: f64, typical: f64) -> bool {
    (shown - exact).abs() <= (1e-6 * exact.abs()).max(typical / 32_000.0)
}

/// Magnitude that 1 % of some values exceed.
fn typical(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<_> = values.map(f64::abs).collect();
    values.sort_by(f64::total_cmp);
    values[(0.99 * (values.len() - 1) as f64).round() as usize]
}

#[test]
fn a_reader_finds_what_the_engine_has() {
    let set = ["--set", "output.frames_every=8", "--set", "output.energy=true"];
    let (done, out) = run("uniaxial_small", &set);
    done.code(0);
    let out = out.path();
    let Some(seen) = seen(&out.join("report.html")) else { return };
    assert_eq!(seen["errors"], Value::Array(Vec::new()));
    assert_eq!(seen["sources"], serde_json::json!(["data:,"]), "the page asks for a file");

    // Every frame of the directory is there; the slider moves the picture, and back.
    let series = frames::series(out).unwrap();
    let increments: Vec<_> = series.iter().map(|frame| frame.increment).collect();
    assert_eq!(seen["frames"], serde_json::json!(increments));
    assert!(number(&seen, "changed") > 0.01, "{}", seen["changed"]);
    assert_eq!((number(&seen, "unchanged"), number(&seen, "back")), (0.0, 0.0));
    assert_eq!(seen["arrow"].as_u64().unwrap() as usize, series.len() - 2);
    assert!(number(&seen, "zoomed") > 0.01);
    let colours = seen["colours"].as_object().unwrap();
    assert_eq!(colours.len(), 7, "{colours:?}");
    assert!(colours.values().all(|part| part.as_f64() > Some(1e-3)), "{colours:?}");

    // Grains and bonds as the state at the end has them.
    let state = Tables::decode(&fs::read(out.join("final_state.npz")).unwrap()).unwrap();
    let vectors = |name: &str| state.vectors::<2>(name, 400).unwrap();
    let (places, origins) = (vectors("particles.position_m"), vectors("particles.origin_m"));
    let numbers = |name: &str| state.values::<f64>(name, &[state.rows(name).unwrap()]).unwrap();
    let (radii, turns) = (numbers("particles.radius_m"), numbers("particles.rotation_rad"));
    let start = frames::Frame::read(&out.join("frames/start.npz")).unwrap();
    let end = series.last().unwrap();
    let grains = seen["grains"].as_array().unwrap();
    assert_eq!(grains.len(), 20);
    let after: Vec<_> = series.iter().filter(|f| f.increment >= start.increment).collect();
    let turned = |frame: &frames::Frame| {
        let pairs = frame.bodies.rotation_rad.iter().zip(&start.bodies.rotation_rad);
        pairs.map(|(now, then)| f64::from(now - then)).collect::<Vec<_>>()
    };
    let rotation = typical(after.iter().flat_map(|frame| turned(frame)));
    let stresses = after.iter().flat_map(|frame| &frame.bodies.stress_pa);
    let stress = typical(stresses.map(|[xx, yy, _]| 0.5 * f64::from(xx + yy)));
    let forces = after.iter().flat_map(|frame| &frame.pairs.p_n);
    let force = typical(forces.filter(|p| **p != 0.0).map(|p| f64::from(*p)));
    let largest = (0..400).map(|i| (places[i][1] - origins[i][1]).abs()).fold(0.0, f64::max);
    for grain in grains {
        assert_eq!(grain["clicked"], grain["grain"], "{grain}");
        let i = grain["grain"].as_u64().unwrap() as usize;
        assert!(grain["text"].as_str().unwrap().starts_with(&format!("Grain {i}")), "{grain}");
        for (k, [place, moved]) in [["x_m", "ux_m"], ["y_m", "uy_m"]].into_iter().enumerate() {
            // The specimen is 30 mm high.
            assert!((number(grain, place) - places[i][k]).abs() < 1e-8, "{place}: {grain}");
            let before = f64::from(start.bodies.displacement_m[i][k]);
            let exact = places[i][k] - origins[i][k] - before;
            assert!((number(grain, moved) - exact).abs() < 1e-5 * largest, "{moved}: {grain}");
        }
        assert!(is_shown(number(grain, "radius_m"), radii[i], 0.0), "{grain}");
        let turn = turns[i] - f64::from(start.bodies.rotation_rad[i]);
        assert!(is_shown(number(grain, "rotation_rad"), turn, rotation), "{grain} {turn}");
        let [xx, yy, xy] = end.bodies.stress_pa[i].map(f64::from);
        assert!(is_shown(number(grain, "mean_stress_pa"), 0.5 * (xx + yy), stress), "{grain}");
        let shear = (0.5 * (xx - yy)).hypot(xy);
        assert!(is_shown(number(grain, "shear_stress_pa"), shear, stress), "{grain} {shear}");
        assert_eq!(grain["fragment"], end.bodies.fragment[i]);
    }

    // Strains are those of `frames::strains`.
    let before = &series[series.len() - 2];
    for (k, from) in [&start, before].into_iter().enumerate() {
        let exact = frames::strains(&end.disks(), &from.disks());
        let most = exact.iter().flatten().map(|s| s.shear).fold(0.0, f64::max);
        assert!(most > 1e-4, "{most}");
        for (grain, shown) in grains.iter().zip(seen["strains"].as_array().unwrap()) {
            let i = grain["grain"].as_u64().unwrap() as usize;
            let (shown, exact) = (shown[k].as_f64().unwrap(), exact[i].unwrap().shear);
            assert!((shown - exact).abs() < 1e-3 * most, "{i}: {shown} {exact}");
        }
    }
    let resized = &seen["resized"];
    assert_eq!(resized[0], 480);
    assert!(resized[1].as_f64() > Some(0.05), "blank after a resize: {resized}");
    assert_eq!(seen["followed"], serde_json::json!([true, "strain-step", true]));

    let ids = |name: &str| state.values::<u32>(name, &[state.rows(name).unwrap()]).unwrap();
    let (bond_ids, bond_a, bond_b) = (ids("bonds.id"), ids("bonds.a"), ids("bonds.b"));
    let states = state.values::<u8>("bonds.state", &[bond_ids.len()]).unwrap();
    let (a, b) = (ids("contacts.a"), ids("contacts.b"));
    let (p, q) = (numbers("contacts.p_n"), numbers("contacts.q_n"));
    let bonds = seen["bonds"].as_array().unwrap();
    assert_eq!(bonds.len(), 20);
    let mut loaded = 0;
    for bond in bonds {
        assert_eq!(bond["clicked"], bond["bond"], "{bond}");
        let k = bond_ids.iter().position(|id| bond["bond"] == *id).unwrap();
        assert_eq!((&bond["a"], &bond["b"]), (&bond_a[k].into(), &bond_b[k].into()));
        assert_eq!(bond["state"], states[k] + 1);
        let contact = (0..a.len()).find(|c| (a[*c], b[*c]) == (bond_a[k], bond_b[k]));
        let (p, q) = contact.map_or((0.0, 0.0), |c| (p[c], q[c]));
        loaded += usize::from(p != 0.0);
        assert!(is_shown(number(bond, "p_n"), p, force), "{bond} {p}");
        assert!(is_shown(number(bond, "q_n"), q, force), "{bond} {q}");
    }
    assert!(loaded > 5, "hardly a bond carries anything");

    // Contacts without a bond: each that carries force, and no other.
    let contacts = seen["contacts"].as_array().unwrap();
    assert!(contacts.len() >= 5, "{contacts:?}");
    let is_bonded = |c: usize| (0..bond_ids.len()).any(|k| (bond_a[k], bond_b[k]) == (a[c], b[c]));
    // An open contact has a force of the size of round-off, which the page shows as none.
    let carries = |c: &usize| !is_bonded(*c) && !is_shown(0.0, p[*c], force);
    let free: Vec<_> = (0..a.len()).filter(carries).collect();
    assert_eq!(contacts.len(), free.len());
    for (contact, c) in contacts.iter().zip(free) {
        assert_eq!((&contact["a"], &contact["b"]), (&a[c].into(), &b[c].into()), "{contact}");
        assert!(is_shown(number(contact, "p_n"), p[c], force), "{contact} {}", p[c]);
        assert!(is_shown(number(contact, "q_n"), q[c], force), "{contact} {}", q[c]);
    }

    // The jump to the first rupture shows the bond that broke first, in the frame after it.
    let events = crate::call::rows(out, "events.csv");
    assert_eq!(seen["first"]["bond"].to_string(), events[0]["bond"]);
    let first: u64 = events[0]["increment"].parse().unwrap();
    let after = increments.iter().find(|increment| **increment >= first).unwrap();
    assert_eq!(seen["first"]["increment"], *after);
    assert_eq!(seen["curves"], serde_json::json!(["Stress", "Broken bonds", "Energies"]));
    assert!(seen["marked"].as_array().unwrap().iter().all(|mark| mark == "visible"));
    assert_eq!(seen["paper"], serde_json::json!([true, true]));
    let corners = [0, 1].map(|k| seen["corners"][k].as_u64().unwrap());
    assert!(corners[0] > 240 && corners[1] < 60, "printed and shown: {corners:?}");
    assert!(number(&seen, "inked") > 0.05, "{}", seen["inked"]);
    assert_eq!(number(&seen, "wide"), 0.0, "the page is wider than the window");
}

#[test]
fn runs_with_pictures_have_a_page_and_others_on_demand() {
    let (done, with) = run("tension", &[]);
    done.code(0);
    assert!(read(with.path(), "report.html").contains("id=\"frame0\""));
    let (done, out) = run("tension", &["--set", "output.plots=false"]);
    done.code(0);
    let out = out.path();
    assert!(!out.join("report.html").exists());
    let report = |arguments: &[&str]| {
        let program =
            assert_cmd::Command::new(crate::call::PROGRAM).arg("report").args(arguments).assert();
        stdout(&program.code(0))
    };
    let said = report(&[out.to_str().unwrap()]);
    assert!(said.contains("report.html"), "{said}");
    let page = read(out, "report.html");
    assert!(page.contains(json(out, "run.json")["title"].as_str().unwrap()));
    assert!(page.contains("id=\"frame0\""), "a run has frames of its start and end");

    // Two runs over one another have no animation.
    let both = out.join("both.html");
    let directory = out.to_str().unwrap();
    report(&[directory, directory, "--out", both.to_str().unwrap()]);
    let page = fs::read_to_string(&both).unwrap();
    assert!(page.contains("<title>2 runs</title>") && !page.contains("id=\"frame0\""));

    let none = tempfile::tempdir().unwrap();
    let program =
        assert_cmd::Command::new(crate::call::PROGRAM).arg("report").arg(none.path()).assert();
    let failed = program.code(1);
    let said = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(said.contains("no run is here"), "{said}");
}
