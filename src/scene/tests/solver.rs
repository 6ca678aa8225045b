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
fn a_solver_has_defaults() {
    assert_eq!(with("Condensed").unwrap(), Solver::default());
    let clarabel = Solver::Clarabel { tolerance: 1e-10, max_iterations: 200 };
    assert_eq!(with("Clarabel()").unwrap(), clarabel);
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
        (
            "Clarabel",
            "2:25: solver: expected `Clarabel(...)`, found `Clarabel`; its fields are `tolerance`, `max_iterations`",
        ),
    ] {
        assert_eq!(with(solver).unwrap_err(), expected, "{solver}");
    }
}
