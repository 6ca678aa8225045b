//! The solver of a scene, and what is said about a wrong one.

use super::read;
use super::samples::SMALL;
use crate::scene::format::Solver;

/// The small scene with this solver, or what is said about it.
fn with(solver: &str) -> Result<Solver, String> {
    let text = SMALL.replace("version: 1,", &format!("version: 1, solver: {solver},"));
    assert_ne!(text, SMALL);
    let loaded = read(&text, &[]).map_err(|error| error.to_string().replace("s.ron:", ""))?;
    Ok(loaded.scene.solver)
}

#[test]
fn a_solver_has_a_name() {
    assert_eq!(with("Condensed").unwrap(), Solver::default());
    for clarabel in ["Clarabel", "Clarabel()"] {
        assert_eq!(with(clarabel).unwrap(), Solver::Clarabel {});
    }
}

#[test]
fn a_wrong_solver_is_named() {
    for (solver, expected) in [
        (
            "Condensd",
            "2:25: solver: unknown variant `Condensd`; did you mean `Condensed`? there are the variants `Condensed`, `Clarabel`",
        ),
        (
            "Condensed(tolerance: 1e-9)",
            "2:25: solver: expected plain `Condensed`, found `Condensed(tolerance: 1e-9)`",
        ),
        ("Clarabel(1e-9)", "2:25: solver: expected plain `Clarabel`, found `Clarabel(1e-9)`"),
        (
            "Clarabel(tolerance: 1e-9)",
            "2:34: solver.tolerance: unknown field `tolerance`; leave it out: there are no fields here",
        ),
    ] {
        assert_eq!(with(solver).unwrap_err(), expected, "{solver}");
    }
}
