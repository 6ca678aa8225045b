//! Collapses, mechanisms, capped increments and key results in the output of the program.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use clastic::components::increment::{Coulomb, FrictionLaw};
use clastic::scene;
use clastic::tables::Tables;
use tempfile::TempDir;

use crate::call::{ROOT, assert_complete, clastic, json, read, rows, run, run_with, stdout};

#[test]
fn a_collapse_is_a_result() {
    // Pulled by 1 N more in every increment; the bond carries 24 N.
    let (collapsed, out) = run(
        "tension",
        &[
            "--set",
            "stages.pull.particles[1].x=Free",
            "--set",
            "stages.pull.particles[1].force=(35.0, 0.0)",
        ],
    );
    let said = stdout(&collapsed.code(0));
    assert!(said.contains("collapsed in increment 25, in stage pull"), "{said}");
    assert_complete(out.path(), "collapsed");
    let record = json(out.path(), "run.json");
    assert_eq!(
        (&record["outcome"]["stage"], &record["outcome"]["increment"]),
        (&"pull".into(), &25.into())
    );
    let events = rows(out.path(), "events.csv");
    assert_eq!((events.len(), events[0]["mode"].as_str()), (1, "tension"));
    let p: f64 = events[0]["p_n"].parse().unwrap();
    assert!((p + 24.0).abs() < 1e-6, "{p} N");
    assert_eq!(rows(out.path(), "history.csv").last().unwrap()["status"], "collapsed");
}

/// A scene that names no friction law has one of two, by its grains; the record says which.
#[test]
fn the_record_has_the_friction_law_of_each_kind_of_stage() {
    let short = ["--set", "stages.drop.increments=2"];
    let associated = ["--set", "friction_law=Associated"];
    let law = |settings: &[&str]| {
        let (ended, out) = run("bounce", settings);
        ended.code(0);
        json(out.path(), "run.json")["settings"]["friction"].clone()
    };
    let of = |dynamic: &str| serde_json::json!({ "static": "associated", "dynamic": dynamic });
    assert_eq!(law(&short), of("Coulomb"));
    assert_eq!(law(&[short, associated].concat()), of("associated"));
}

/// Of a test of one bond without a stress: the strength of the bond by hand, as in the comments of
/// the scenes, and the motion at which it is reached.
#[test]
fn the_peak_force_of_a_probe_is_a_result() {
    let peak = |scene: &str| {
        let (done, out) = run(scene, &["--quiet"]);
        let said = stdout(&done.code(0));
        assert!(said.contains("peak "), "{said}");
        json(out.path(), "run.json")["peak_force"].clone()
    };
    let near = |found: &serde_json::Value, expected: f64| {
        let found = found.as_f64().unwrap();
        assert!((found - expected).abs() < 1e-6 * expected, "{found} {expected}");
    };
    // 2 x 6 mm x 1 m x 2 kPa, over 8 MN/m.
    let tension = peak("tension");
    near(&tension["force_n"], 24.0);
    near(&tension["displacement_m"], 24.0 / 8e6);
    assert_eq!(tension["moment_nm"], serde_json::Value::Null);
    // 2 x 6 mm x 1 m x 4 kPa at an arm of 6 mm; the slip is 12 mm times the rotation.
    let shear = peak("direct_shear_0N");
    near(&shear["moment_nm"], 48.0 * 6e-3);
    near(&shear["rotation_rad"], 48.0 / 4e6 / 12e-3);
    assert_eq!((&shear["direction"], &shear["increment"]), (&"anticlockwise".into(), &100.into()));
}

#[test]
fn the_mechanism_of_a_collapse_is_a_result() {
    // When the bond breaks nothing holds the 10 N that pull the free disk along x.
    let (collapsed, out) = run("direct_shear_-10N", &[]);
    collapsed.code(0);
    let record = json(out.path(), "run.json");
    let mechanism = &record["results"]["mechanism"];
    assert_eq!(mechanism["increment"], record["outcome"]["increment"]);
    // Nothing dissipates, and no condition is violated.
    assert!((mechanism["margin"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{mechanism}");
    assert!(mechanism["defect"].as_f64().unwrap() < 1e-9, "{mechanism}");
    let text = read(out.path(), "mechanism.csv");
    assert!(text.starts_with("body,x_m,y_m,u_x,u_y,rotation\n"), "{text}");
    let rows = rows(out.path(), "mechanism.csv");
    let number = |row: usize, column: &str| rows[row][column].parse::<f64>().unwrap();
    assert_eq!(rows.len(), 2);
    for (row, u_x) in [(0, 0.0), (1, 1.0)] {
        let motion = ["u_x", "u_y", "rotation"].map(|column| number(row, column));
        assert_eq!(motion, [u_x, 0.0, 0.0]);
    }
    assert_eq!([number(0, "x_m"), number(0, "y_m"), number(1, "y_m")], [0.0; 3]);
    assert!((number(1, "x_m") - 12.0e-3).abs() < 1e-6);

    // A run that does not collapse has none.
    let (completed, out) = run("direct_shear_10N", &[]);
    completed.code(0);
    assert!(!out.path().join("mechanism.csv").exists());
    assert!(json(out.path(), "run.json")["results"]["mechanism"].is_null());
}

#[test]
fn the_first_increment_of_the_rigid_test_shows_its_mechanism() {
    let (done, out) = run("uniaxial_rigid_small", &["--set", "output.plots=false"]);
    done.code(0);
    let names = fs::read_dir(out.path().join("frames")).unwrap();
    let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert_eq!(names.filter(|name| name.ends_with(".csv")).count(), 1);
    let rows = rows(out.path(), "frames/frame_000001.csv");
    assert_eq!(rows.len(), 400);
    let moves = |column: &str, sign: f64| {
        rows.iter().map(|row| sign * row[column].parse::<f64>().unwrap()).fold(0.0, f64::max)
    };
    // The platen comes down, and the specimen gives way to both sides.
    let platen = 1.451e-6;
    for (column, sign, least) in [("uy_m", -1.0, 0.9), ("ux_m", 1.0, 0.3), ("ux_m", -1.0, 0.3)] {
        let most = moves(column, sign);
        assert!(most > least * platen, "{column}: {most}");
    }
}

/// A biaxial test without bonds under Coulomb's law. With few factorisations a solve ends before it has
/// converged, and the increment is capped.
fn capped(factorisations: u32) -> TempDir {
    let sets = [
        "friction_law=Coulomb()",
        "stages.cement.length=1e-12",
        "stages.load.increments=4",
        "output.plots=false",
    ];
    let path = Path::new(ROOT).join("scenes/biaxial_small.ron");
    let loaded = scene::load(&path, &sets.map(str::to_owned)).unwrap_or_else(|e| panic!("{e}"));
    run_with(&loaded, |world| {
        let law = Some(Coulomb { factorisations });
        world.insert_resource(FrictionLaw { in_statics: law, in_dynamics: law });
    })
}

#[test]
fn a_run_with_capped_increments_says_so_loudly() {
    let out = capped(5);
    let history = rows(out.path(), "history.csv");
    assert_eq!(history.iter().filter(|row| row["status"] == "capped").count(), 4);
    let record = json(out.path(), "run.json");
    assert_eq!(record["outcome"]["status"], "completed");
    assert_eq!((&record["increments"], &record["capped_increments"]), (&9.into(), &4.into()));
    assert_eq!(record["stages"][2]["capped"], 4);
    let message = record["outcome"]["message"].as_str().unwrap();
    assert!(message.contains("all 4 increments of stage load are capped"), "{message}");
    let page = out.path().join("both.html");
    let [folder, page] = [out.path(), &page].map(|path| path.to_str().unwrap());
    let table = stdout(&clastic(&["report", folder, folder, "--out", page]).code(0));
    assert!(table.contains("completed, 4 of 9 increments capped"), "{table}");

    // With as many factorisations as some solves need, and others do not.
    let out = capped(8);
    let history = rows(out.path(), "history.csv");
    let count = |stage: &str| {
        history.iter().filter(|row| row["stage"] == stage && row["status"] == "capped").count()
    };
    let [confine, load] = ["confine", "load"].map(count);
    assert!(confine > 0 && confine + load < 9, "{confine}, {load}");
    let record = json(out.path(), "run.json");
    assert_eq!(record["outcome"]["status"], "completed");
    let counts = (&record["increments"], &record["capped_increments"]);
    assert_eq!(counts, (&9.into(), &(confine + load).into()));
    let said = record["outcome"]["message"].as_str().unwrap();
    let of_five = if confine == 5 { "all 5".to_owned() } else { format!("{confine} of 5") };
    let warning = format!("{of_five} increments of stage confine are capped");
    assert!(said.contains(&warning), "{said}");
    assert_eq!(said.contains("increments of stage load are capped"), load > 0, "{said}");
    // A run without capped increments has no warning.
    let (done, _out) = run("tension", &["--quiet"]);
    assert!(!stdout(&done.code(0)).contains("apped"));
}

/// Five rigid disks on a rough bowl: Coulomb's law has no solution near their last state.
#[test]
fn the_command_line_names_capped_increments() {
    let disk = |k: u32| {
        let angle = 0.5785 + 0.1053 * f64::from(k);
        format!("(position: ({:?}, {:?}), radius: 0.01),", 0.19 * angle.sin(), -0.19 * angle.cos())
    };
    let disks: String = (0..7).map(disk).collect();
    let ends = "start: (-0.197, -0.034), end: (0.197, -0.034), shape: Arc(through: (0.0, -0.2))";
    let text = format!(
        "(version: 1, title: \"bowl\", gravity: (0.0, -9.81), friction_law: Coulomb(),
          materials: {{ \"m\": (density: 2650.0, contact: (friction: 0.1)) }},
          specimen: Particles([{disks}]),
          walls: [(name: \"bowl\", {ends}, contact: (friction: 0.1))],
          stages: [Load(name: \"load\", increments: 1), Load(name: \"idle\", increments: 3)],
          output: (plots: false))"
    );
    let directory = TempDir::new().unwrap();
    let scene = directory.path().join("bowl.ron");
    fs::write(&scene, text).unwrap();
    let (done, out) = run(scene.to_str().unwrap(), &["--quiet"]);
    let said = stdout(&done.code(0));
    let history = rows(out.path(), "history.csv");
    let capped = |stage: &str| {
        history.iter().filter(|row| row["stage"] == stage && row["status"] == "capped").count()
    };
    let of = ["load", "idle"].map(capped);
    assert!(of[1] > 0, "{of:?}");
    let all = of[0] + of[1];
    assert!(
        said.starts_with(&format!("completed in 4 increments, {all} of them capped\n")),
        "{said}"
    );
    assert!(
        said.contains("\nWARNING: ") && said.contains(" increments of stage idle are capped\n"),
        "{said}"
    );
}

#[test]
fn a_peak_at_a_capped_increment_counts_and_is_marked() {
    let out = capped(5);
    let record = json(out.path(), "run.json");
    let results = &record["results"];
    let history = rows(out.path(), "history.csv");
    let stresses = history.iter().filter(|row| row["stage"] == "load");
    let peak = stresses.map(|row| row["axial_stress_pa"].parse().unwrap()).fold(0.0, f64::max);
    assert_eq!(results["peak_stress_pa"].as_f64(), Some(peak));
    assert_eq!(results["peak_is_capped"], true);
    assert!(results["youngs_modulus_pa"].is_null());
    let reason = results["not_defined"]["youngs_modulus_pa"].as_str().unwrap();
    assert!(reason.contains("capped"), "{reason}");
}

/// Increments with forces of twice the maximum out of balance were accepted without a word.
#[test]
fn a_run_with_increments_out_of_balance_says_so() {
    let far = ["stages.load.walls.top[1]=-4e-6", "stages.load.increments=60"];
    let (done, out) = run("uniaxial_small", &["--quiet", "--set", far[0], "--set", far[1]]);
    let said = stdout(&done.code(0));
    let history = rows(out.path(), "history.csv");
    let count = history.iter().filter(|row| row["caps"] == "geometry").count();
    let beyond = |row: &&BTreeMap<String, String>| {
        row["imbalance_at_end"].parse::<f64>().is_ok_and(|imbalance| imbalance > 0.05)
    };
    assert!(count > 0 && history.iter().filter(beyond).all(|row| row["caps"] == "geometry"));
    let stages = json(out.path(), "run.json")["stages"].clone();
    let load = stages.as_array().unwrap().iter().find(|stage| stage["stage"] == "load").unwrap();
    assert_eq!(load["unbalanced"], count);
    let what = format!("WARNING: {count} of {} increments of stage load end out of", load["rows"]);
    assert!(said.lines().any(|line| line.starts_with(&what)), "no `{what}` in\n{said}");
}

#[test]
fn round_off_is_no_key_result() {
    // The platen moves away from the specimen.
    let away = ["stages.load.walls.top[1]=1.0e-6", "stages.load.increments=6"];
    let (done, out) = run("uniaxial_small", &["--quiet", "--set", away[0], "--set", away[1]]);
    let said = stdout(&done.code(0));
    assert!(!said.contains("E = ") && said.contains("but for round-off"), "{said}");
    let results = &json(out.path(), "run.json")["results"];
    assert!(results["youngs_modulus_pa"].is_null() && results["peak_stress_pa"].is_null());
    let reason = results["not_defined"]["youngs_modulus_pa"].as_str().unwrap();
    assert!(reason.contains("round-off"), "{reason}");
}

#[test]
fn a_reference_stage_without_a_curve_is_mentioned() {
    let load = "Load(name: \"load\", increments: 2, particles: [(select: Group(\"boundary\"), \
                rotation: Held, affine: ((0.0, 0.0), (0.0, -1.0e-6)))])";
    // The last one bonds second neighbours, at a gap of 7.3 mm.
    let cement = |name: &str, length: f64| format!("Cement(name: \"{name}\", length: {length:?})");
    let stages = format!("stages=[{}, {load}, {}]", cement("bonds", 1e-6), cement("last", 8e-3));
    let (done, _out) = run("lattice", &["--quiet", "--set", &stages]);
    let said = stdout(&done.code(0));
    let line = said.lines().find(|line| line.contains("no increment from the start"));
    let line = line.unwrap_or_else(|| panic!("nothing is said in {said}"));
    assert!(line.contains("the reference stage is last; `reference_stage`"), "{line}");
    // The other scene has a curve: no reason is given.
    let reference = "reference_stage=\"load\"";
    let (done, _out) = run("lattice", &["--quiet", "--set", &stages, "--set", reference]);
    let said = stdout(&done.code(0));
    assert!(
        said.contains("peak stress 24.2487 Pa") && !said.contains("`reference_stage`"),
        "{said}"
    );
    // Its sides are held, so that the slope of its curve is that of an oedometer.
    assert!(said.contains("E is not defined: the lateral stress changes"), "{said}");
}

/// Key results of a biaxial test against the rows of its history.
#[test]
fn key_results_agree_with_the_history() {
    let measures = r#"measures=[
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "lateral_strain", of: Strain(Walls("left", "right"))),
        (name: "axial_stress", of: Stress(Walls(walls: ["bottom", "top"], length: Between("left", "right")))),
        (name: "lateral_stress", of: Stress(Walls(walls: ["left", "right"], length: Between("bottom", "top")))),
    ]"#;
    let stop = r#"stages.load.stop=[StressDrop(0.98)]"#;
    let (done, out) = run("biaxial_small", &["--quiet", "--set", measures, "--set", stop]);
    done.code(0);
    let table = rows(out.path(), "history.csv");
    let number = |row: usize, name: &str| table[row][name].parse::<f64>().ok();
    let first = table.iter().position(|row| row["stage"] == "load").unwrap();
    let last = table.len() - 1;
    let stress = |row: usize| number(row, "axial_stress_pa").unwrap();
    let (start, peak) = (first - 1, (first..=last).map(stress).fold(0.0, f64::max));
    let at = (first..=last).find(|row| stress(*row) == peak).unwrap();
    let rise = peak - stress(start);
    assert!(last < 165 && last > at, "{last} {at}");
    let results = &json(out.path(), "run.json")["results"];
    let result = |name: &str| results[name].as_f64();
    assert_eq!(result("strength_pa"), Some(peak));
    assert_eq!(result("strain_at_peak"), number(at, "axial_strain"));
    // From the start to half of the rise, between two rows.
    let half = stress(start) + 0.5 * rise;
    let here = (first..=last).find(|row| stress(*row) >= half).unwrap();
    let part = (half - stress(here - 1)) / (stress(here) - stress(here - 1));
    let strain = |name| {
        let before = if here == first { 0.0 } else { number(here - 1, name).unwrap() };
        before + part * (number(here, name).unwrap() - before)
    };
    let nu = -strain("lateral_strain") / strain("axial_strain");
    assert!((result("poissons_ratio").unwrap() - nu).abs() < 1e-12, "{nu}");
    let broken = |row: usize| {
        let modes = ["broken_tension", "broken_shear", "broken_rolling"];
        modes.iter().map(|name| number(row, name).unwrap()).sum::<f64>() - {
            if row == start { 0.0 } else { modes.iter().map(|n| number(start, n).unwrap()).sum() }
        }
    };
    let initiated = (first..=at).find(|row| broken(*row) >= 0.01 * broken(at)).map(stress);
    let expected = initiated.filter(|_| broken(at) >= 100.0);
    assert_eq!(result("crack_initiation_stress_pa"), expected);
    let volume = |row: usize| number(row, "volumetric_strain").unwrap();
    let turn = (first..=at).max_by(|a, b| volume(*a).total_cmp(&volume(*b))).unwrap();
    assert!(turn < at, "the volume turns at the peak");
    assert_eq!(result("crack_damage_stress_pa"), Some(stress(turn)));
    assert!(results["not_defined"]["friction_angle_rad"].as_str().unwrap().contains("cohesion"));
    // Physical sanity: 6e7 N/m over 200 kPa and 1 m; grains softer than Roux and Combe's.
    let sanity = &json(out.path(), "run.json")["sanity"];
    let level = sanity["stiffness_over_pressure"].as_f64().unwrap();
    assert!((level - 300.0).abs() < 1e-6, "{level}");
    assert!(sanity["warnings"][0].as_str().unwrap().contains("k/(p h) is 300"));
}

#[test]
fn a_packing_that_is_looser_than_its_jam_says_how_it_settled() {
    let (done, out) = run("prepare_and_branch", &["--set", "stages.settle.record.frames=[1]"]);
    let said = stdout(&done.code(0));
    let settled = json(out.path(), "run.json")["settled"].clone();
    let [before, after] =
        ["porosity_before", "porosity_after"].map(|name| settled[name].as_f64().unwrap());
    // The target is 0.23 between the walls; the box around the disks is a little smaller.
    assert!((before - 0.23).abs() < 0.01, "{before}");
    let box_of = |file: &str| {
        let disks: Vec<[f64; 3]> = rows(out.path(), file)
            .iter()
            .map(|row| ["x_m", "y_m", "radius_m"].map(|name| row[name].parse().unwrap()))
            .collect();
        let side = |axis: usize| {
            let high = disks.iter().map(|d| d[axis] + d[2]).fold(f64::MIN, f64::max);
            high - disks.iter().map(|d| d[axis] - d[2]).fold(f64::MAX, f64::min)
        };
        let area: f64 = disks.iter().map(|d| std::f64::consts::PI * d[2] * d[2]).sum();
        1.0 - area / (side(0) * side(1))
    };
    let first = rows(out.path(), "history.csv");
    let first = first.iter().find(|row| row["stage"] == "settle").unwrap();
    assert!(first["motion_steps"].parse::<u32>().unwrap() > 0, "{first:?}");
    let number: u32 = first["increment"].parse().unwrap();
    assert!((after - box_of(&format!("frames/frame_{number:06}.csv"))).abs() < 1e-12, "{after}");
    let words = format!("porosity {before:.4} before, {after:.4} after");
    assert!(after < before && said.contains(&words), "no `{words}` in\n{said}");

    // A dense packing does not.
    let dense = ["--set", "stages.compact.target=Porosity(0.22)"];
    let (done, out) = run("isotropic_compression", &dense);
    assert!(!stdout(&done.code(0)).contains("settled"));
    assert!(json(out.path(), "run.json").get("settled").is_none());
}

#[test]
fn a_porosity_below_that_of_any_disks_is_refused() {
    let settings = ["--set", "stages.compact.target=Porosity(0.08)"];
    let (refused, _out) = run("prepare_and_branch", &settings);
    let said = String::from_utf8_lossy(&refused.code(3).get_output().stderr).into_owned();
    // Radii between 3 and 5 mm.
    for words in ["stage `compact` cannot begin", "0.08 is below 0.08", "Florian 1960"] {
        assert!(said.contains(words), "no `{words}` in\n{said}");
    }
}

#[test]
fn friction_angle_and_strength_are_said_where_they_are_defined() {
    let (done, out) = run("prepare_and_branch_50kPa", &[]);
    let said = stdout(&done.code(0));
    let results = &json(out.path(), "run.json")["results"];
    let words = match results["friction_angle_rad"].as_f64() {
        Some(angle) => format!("friction angle {:.2} degrees", angle.to_degrees()),
        None => panic!("{}", results["not_defined"]["friction_angle_rad"]),
    };
    assert!(said.contains(&words) && said.contains("strength (peak stress) "), "{said}");
}

/// A bent beam had a modulus: its nominal stress over the motion of the press.
#[test]
fn platens_that_do_not_span_the_specimen_give_no_modulus() {
    let results = |scene: &str| {
        let (done, out) = run(scene, &["--quiet"]);
        done.code(0);
        json(out.path(), "run.json")["results"].clone()
    };
    let beam = results("three_point_bending");
    assert!(beam["youngs_modulus_pa"].is_null() && beam["peak_stress_pa"].is_number(), "{beam}");
    let why = beam["not_defined"]["youngs_modulus_pa"].as_str().unwrap();
    assert!(why.contains("is not the area of the specimen"), "{why}");
    assert!(results("slope_block")["youngs_modulus_pa"].is_number());
}

#[test]
fn grains_that_pour_in_have_no_porosity() {
    let (done, out) = run("poured_bin", &["--set", "stages[0].increments=60"]);
    done.code(0);
    let results = &json(out.path(), "run.json")["results"];
    assert!(results["porosity"].is_null(), "{results}");
    assert!(results["not_defined"]["porosity"].as_str().unwrap().contains("pour in"), "{results}");
}

/// Bonds that the last stage makes were not counted: no increment follows it.
#[test]
fn bonds_of_a_last_stage_that_cements_are_counted() {
    let hold = r#"Load(name: "hold", increments: 1, walls: { "bottom": Fixed, "top": Fixed })"#;
    let cement = r#"Cement(name: "cement", length: 2.0e-3)"#;
    for stages in [format!("stages=[{hold}, {cement}]"), format!("stages=[{cement}]")] {
        let (done, out) = run("biaxial_small", &["--quiet", "--set", &stages]);
        done.code(0);
        let results = &json(out.path(), "run.json")["results"];
        let state = fs::read(out.path().join("final_state.npz")).unwrap();
        let bonds = Tables::decode(&state).unwrap().rows("bonds.id").unwrap();
        assert!(bonds > 500, "{bonds}");
        assert_eq!(results["bonds_created"], bonds, "{stages}");
        assert_eq!(results["bonds_intact"], bonds, "{stages}");
    }
}

/// Ties of taut bonds were counted as contacts: 876 in the history for 761 rows of the
/// table.
#[test]
fn contacts_of_the_history_are_those_of_the_table_that_carry_force() {
    for scene in ["uniaxial_small", "biaxial_small", "stack"] {
        let stages = ["--quiet", "--set", "stages.load.increments=40"];
        let settings = if scene == "biaxial_small" { &stages[..] } else { &stages[..1] };
        let (done, out) = run(scene, settings);
        done.code(0);
        let state = fs::read(out.path().join("final_state.npz")).unwrap();
        let state = Tables::decode(&state).unwrap();
        let c = state.rows("contacts.p_n").unwrap();
        let p = state.values::<f64>("contacts.p_n", &[c]).unwrap();
        let maximum = p.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
        let carrying = p.iter().filter(|p| p.abs() > 1e-9 * maximum).count();
        let last = rows(out.path(), "history.csv").pop().unwrap();
        assert_eq!(last["contacts"], carrying.to_string(), "{scene}: {c} rows");
    }
}
