//! Dumped programs: which increments, and that anyone can check them.

use serde_json::Value;

use crate::call::{clastic, json, rows, run, stderr};
use crate::common::files;

#[test]
fn a_program_is_dumped_by_increments_of_the_run_or_of_a_stage() {
    let few = ["--quiet", "--set", "stages.load.increments=3"];
    let dumps = ["--dump-program", "2", "--dump-program", "load:2", "--dump-program", "load:9"];
    let (done, out) = run("biaxial_small", &[&few[..], &dumps].concat());
    let said = stderr(&done.code(0));
    assert!(said.contains("--dump-program load:9: the stage ended with its increment 3"), "{said}");
    let names = files(out.path()).into_keys().map(|name| name.display().to_string());
    let programs: Vec<_> = names.filter(|name| name.starts_with("program_")).collect();
    // The confinement has five increments: the second one of the load is the seventh of the run.
    assert_eq!(programs, ["program_000002.json", "program_000007.json"]);
    assert_eq!(json(out.path(), "program_000007.json")["stage"], "load");
    let unknown = ["run", "biaxial_small", "--dump-program", "lod:2"];
    let said = stderr(&clastic(&unknown).code(2));
    assert!(
        said.contains(
            "no such stage; did you mean `load`? there are the stages `cement`, `confine`, `load`"
        ),
        "{said}"
    );
    for wrong in ["0", "load:", "load:0", "x"] {
        clastic(&["run", "biaxial_small", "--dump-program", wrong]).code(2);
    }
}

/// The number at a key, or the numbers of a table.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list = value.as_array().unwrap();
    assert_eq!(list.len(), N);
    std::array::from_fn(|k| number(&list[k]))
}

/// Balance and complementarity of a dumped program, from the words of its `format` alone.
fn check_dump(dump: &Value) -> [f64; 2] {
    let table = |value: &Value| -> Vec<[f64; 3]> {
        value.as_array().unwrap().iter().map(numbers).collect()
    };
    let forces = table(&dump["solution"]["forces"]);
    let u = table(&dump["solution"]["displacements"]);
    let bodies = dump["bodies"].as_array().unwrap();
    let axes: Vec<[f64; 2]> = bodies.iter().map(|b| numbers(&b["axis"])).collect();
    // Forces along x and y and moments about the centre that every body resists.
    let mut resisted = vec![[0.0; 3]; bodies.len()];
    let mut maximum = [f64::MIN_POSITIVE; 2];
    for f in &forces {
        maximum[0] = maximum[0].max(f[0].abs()).max(f[1].abs());
    }
    let global = |i: usize| {
        let (a, v) = (axes[i], u[i]);
        [a[0] * v[0] - a[1] * v[1], a[1] * v[0] + a[0] * v[1], v[2]]
    };
    for i in 0..bodies.len() {
        let v = global(i);
        maximum[1] = maximum[1].max(v[0].hypot(v[1]));
    }
    let mut product = 0.0_f64;
    let mut lever = 0.0_f64;
    for (c, [p, q, tau]) in dump["interactions"].as_array().unwrap().iter().zip(&forces) {
        let get = |key: &str| number(&c[key]);
        let limit = |key: &str| number(&c["limits"][key]);
        let (a, b) = (c["a"].as_u64().unwrap() as usize, c["b"].as_u64().unwrap() as usize);
        let [nx, ny]: [f64; 2] = numbers(&c["normal"]);
        let (x, y) = (p * nx - q * ny, p * ny + q * nx);
        let (arm_a, arm_b) = (get("arm_a"), get("arm_b"));
        let or_zero = |key: &str| c.get(key).map_or(0.0, number);
        let (normal_a, normal_b) = (or_zero("normal_arm_a"), or_zero("normal_arm_b"));
        lever = lever.max(arm_a).max(arm_b).max(normal_a.abs()).max(normal_b.abs());
        for (body, add) in [
            (a, [x, y, normal_a * p + arm_a * q + tau]),
            (b, [-x, -y, normal_b * p + arm_b * q - tau]),
        ] {
            for k in 0..3 {
                resisted[body][k] += add[k];
            }
        }
        let (ua, ub) = (global(a), global(b));
        let (dx, dy) = (ua[0] - ub[0], ua[1] - ub[1]);
        let closing = nx * dx + ny * dy + normal_a * ua[2] + normal_b * ub[2];
        let sheared = limit("cohesion") > 0.0 || limit("friction") > 0.0;
        let slip = if sheared {
            let elastic = get("tangential_compliance") * (q - get("previous_shear"));
            nx * dy - ny * dx + arm_a * ua[2] + arm_b * ub[2] - elastic
        } else {
            0.0
        };
        let rotation = if limit("rolling") > 0.0 { ua[2] - ub[2] } else { 0.0 };
        let opening = get("offset") + get("normal_compliance") * p
            - closing
            - limit("friction") * slip.abs()
            - limit("rolling") * rotation.abs();
        for (multiplier, slack) in [
            (slip, limit("cohesion") + limit("friction") * p - q * slip.signum()),
            (rotation, limit("moment") + limit("rolling") * p - tau * rotation.signum()),
            (opening, p + limit("tension")),
        ] {
            product = product.max((multiplier * slack).abs());
        }
    }
    let mut balance = 0.0_f64;
    for (i, body) in bodies.iter().enumerate() {
        let (a, r) = (axes[i], resisted[i]);
        let own = [a[0] * r[0] + a[1] * r[1], a[0] * r[1] - a[1] * r[0], r[2]];
        for k in 0..3 {
            let free = &body["dofs"][k]["free"];
            if free.is_object() {
                let defect = number(&free["inertia"]) * u[i][k] + own[k] - number(&free["load"]);
                let unit = if k < 2 { maximum[0] } else { maximum[0] * lever };
                balance = balance.max(defect.abs() / unit);
            }
        }
    }
    [balance, product / (maximum[0] * maximum[1])]
}

#[test]
fn a_dumped_program_can_be_checked_by_anyone() {
    // The last increments of the confinement: bonds, contacts, four loaded walls.
    let (done, out) = run("biaxial_small", &["--set", "stages.load.increments=2"]);
    done.code(0);
    let history = rows(out.path(), "history.csv");
    let dumped = ["confine", "load"].map(|stage| {
        let row = history.iter().rev().find(|row| row["stage"] == stage).unwrap();
        assert_eq!(row["status"], "solved");
        row["increment"].clone()
    });
    let (done, out) = run(
        "biaxial_small",
        &[
            "--set",
            "stages.load.increments=2",
            "--dump-program",
            &dumped[0],
            "--dump-program",
            &dumped[1],
        ],
    );
    done.code(0);
    for increment in dumped {
        let mut dump = json(out.path(), &format!("program_{increment:0>6}.json"));
        assert!(dump["interactions"].as_array().unwrap().len() > 400);
        let [balance, complementarity] = check_dump(&dump);
        assert!(balance <= 1e-8, "increment {increment}: balance {balance:e}");
        assert!(complementarity <= 1e-8, "increment {increment}: {complementarity:e}");
        // The check sees what is wrong: a force that is off by 1 %.
        let forces = dump["solution"]["forces"].as_array_mut().unwrap();
        let maximum = (0..forces.len())
            .max_by(|i, j| number(&forces[*i][0]).total_cmp(&number(&forces[*j][0])))
            .unwrap();
        forces[maximum][0] = (1.01 * number(&forces[maximum][0])).into();
        let [balance, complementarity] = check_dump(&dump);
        assert!(balance > 1e-4 && complementarity > 1e-8, "{balance:e}, {complementarity:e}");
    }
}
