//! The solver of a scene: with settings, without, and what is said about wrong ones.

use std::collections::BTreeSet;

use clastic_cone::condensed::CondensedSettings;

use super::read;
use super::samples::SMALL;
use crate::scene::format::{CONDENSED_FIELDS, Solver};

/// The small scene with this solver, or what is said about it.
fn with(solver: &str) -> Result<Solver, String> {
    let text = SMALL.replace("version: 1,", &format!("version: 1, solver: {solver},"));
    assert_ne!(text, SMALL);
    let loaded = read(&text, &[]).map_err(|error| error.to_string().replace("s.ron:", ""))?;
    Ok(loaded.scene.solver)
}

#[test]
fn no_settings_are_the_defaults_with_and_without_brackets() {
    for none in ["Condensed", "Condensed()", "Condensed( )", "Condensed /* none */"] {
        let solver = with(none).unwrap();
        assert_eq!(solver, Solver::default(), "{none}");
        assert_eq!(serde_json::to_string(&solver).unwrap(), r#""Condensed""#);
    }
    assert_eq!(
        with("Clarabel()").unwrap(),
        Solver::Clarabel { tolerance: 1e-10, max_iterations: 200 }
    );
}

#[test]
fn settings_are_those_of_the_solver() {
    let solver = with(
        "Condensed(tolerance: 1e-9, loose_tolerance: 1e-7, newton_margin: 10.0, \
         loose_newton_margin: 2.0, interior_margin: 100.0, large: 0, \
         max_start: 0.0,)",
    );
    let mut expected = CondensedSettings::default();
    expected.tolerance = 1e-9;
    expected.loose_tolerance = 1e-7;
    expected.newton_margin = 10.0;
    expected.loose_newton_margin = 2.0;
    expected.interior_margin = 100.0;
    expected.large = 0;
    expected.max_start = 0.0;
    let solver = solver.unwrap();
    assert_eq!(solver, Solver::Condensed(Box::new(expected)));
    let record = serde_json::to_value(&solver).unwrap();
    let record = record["Condensed"].as_object().unwrap();
    let names: BTreeSet<_> = record.keys().map(String::as_str).collect();
    assert_eq!(names, CONDENSED_FIELDS.into());
    assert_eq!(record["tolerance"], 1e-9);
    assert_eq!(record["large"], 0);
}

#[test]
fn wrong_settings_are_named() {
    for (solver, expected) in [
        (
            "Condensed(tolerance: 0.0)",
            "2:46: solver.tolerance: zero (0.0); give a tolerance above 0 and up to 1e-2",
        ),
        (
            "Condensed(tolerance: 1e-3)",
            "2:46: solver.tolerance: above `acceptance.residual` (0.001 > 1e-8); give a tolerance up to the residual",
        ),
        (
            "Condensed(newton_margin: 0.5, interior_margin: 1e7)",
            "2:50: solver.newton_margin: out of range (0.5); give a factor from 1 to 1e6
2:72: solver.interior_margin: out of range (10000000.0); give a factor from 1 to 1e6",
        ),
        (
            "Condensed(max_start: -1.0)",
            "2:46: solver.max_start: negative (-1.0); give a multiple of the expected displacement of 0 or more",
        ),
        (
            "Condensed(large: 2.5)",
            "2:42: solver.large: expected a whole number from 0, found `2.5`; write 2 or 3",
        ),
        (
            "Condensed(tolerence: 1e-9)",
            "2:35: solver.tolerence: unknown field `tolerence`; did you mean `tolerance`? the fields here are `tolerance`, `loose_tolerance`, `newton_margin`, `loose_newton_margin`, `interior_margin`, `large`, `max_start`",
        ),
        (
            "Condensed(safety: 0.5)",
            "2:35: solver.safety: unknown field `safety`; the fields here are `tolerance`, `loose_tolerance`, `newton_margin`, `loose_newton_margin`, `interior_margin`, `large`, `max_start`",
        ),
        (
            "Condensed(1e-9)",
            "2:25: solver: expected `Condensed(tolerance: ...)`, found `Condensed(1e-9)`; write `Condensed(tolerance: 1e-9)`",
        ),
        (
            "Condensed((tolerance: 1e-9))",
            "2:25: solver: expected `Condensed(tolerance: ...)`, found `Condensed((tolerance: 1e-9))`; leave out one pair of brackets",
        ),
        (
            "Condensd",
            "2:25: solver: unknown variant `Condensd`; did you mean `Condensed`? there are the variants `Condensed`, `Clarabel`",
        ),
        (
            "Clarabel",
            "2:25: solver: expected `Clarabel(...)`, found `Clarabel`; its fields are `tolerance`, `max_iterations`",
        ),
    ] {
        assert_eq!(with(solver).unwrap_err(), expected, "{solver}");
    }
}

/// A mistake elsewhere sends the scene to the second reader, which must not object to the solver.
#[test]
fn both_readers_take_the_variant_with_and_without_brackets() {
    for solver in ["Condensed", "Condensed()", "Condensed(large: 10)"] {
        let said = with(&format!("{solver}, gravty: (0.0, 0.0)")).unwrap_err();
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(said.contains("did you mean `gravity`?"), "{said}");
    }
}
