//! Primal-dual interior-point method on the condensed system, with the predictor and corrector of
//! Mehrotra (1992).
//!
//! An interaction's forces and multipliers are eliminated through its own small system
//! (`local_system`): `ds = T (G' du) + ds_0`, which leaves `(M + G T G') du = r` for the bodies.
//!
//! | file | what |
//! |---|---|
//! | `point` | a point, where the method starts and ends |
//! | `iteration` | the current point, and the steps that make an iteration |
//! | `history` | the best point so far, and what ends the method |
//! | `groups` | the interactions by branches of the matrix |
//! | `cell` | one interaction |
//! | `local_system` | elimination of one interaction |
//! | `slacks` | slacks and multipliers of its limits |

mod cell;
mod groups;
mod history;
mod iteration;
mod law;
mod local_system;
mod point;
mod slacks;

use self::history::History;
use self::iteration::Iteration;
pub use self::point::{Goal, Interior, Warm, max_magnitude, slack};
use super::matrix::BodyMatrix;
use super::scaled::Scaled;
use super::settings::InteriorSettings;

/// Runs the method from the displacements `start` until `is_enough` accepts a point near the
/// `goal`, or the residual no longer falls. Returns the best point, `None` if there was none.
#[must_use]
pub fn solve(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    settings: &InteriorSettings,
    goal: Goal,
    is_enough: impl Fn(&Interior) -> bool,
) -> Option<Interior> {
    solve_from(program, matrix, start, None, settings, goal, is_enough)
}

/// Runs the method from displacements and forces; without forces from the elastic trial at the
/// displacements.
#[must_use]
pub fn solve_from(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    warm: Option<Warm>,
    settings: &InteriorSettings,
    goal: Goal,
    is_enough: impl Fn(&Interior) -> bool,
) -> Option<Interior> {
    let mut iteration = Iteration::new(program, matrix, settings, start, warm);
    let mut history = History::new(settings, goal);
    let mut iterations = 0;
    loop {
        iteration.update_residuals();
        if !iteration.is_finite() {
            break;
        }
        history.record(&mut iteration);
        let enough = history.is_enough(&is_enough);
        if enough || history.is_over() || iterations >= settings.max_iterations {
            break;
        }
        iterations += 1;
        iteration.assemble();
        if !iteration.predict() {
            break;
        }
        let target = iteration.target();
        iteration.correct(target);
        iteration.make_step();
    }
    let point = history.into_best()?;
    Some(Interior { iterations, ..point })
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::samples::{column, contact, held, loaded, posed};
    use super::*;
    use crate::program::{ConeProgram, Dof};

    fn solved(program: &ConeProgram) -> (Interior, Vec<usize>) {
        let (scaled, mut matrix, place) = posed(program);
        let start = vec![[0.0; 3]; scaled.free.len()];
        let (settings, goal) = (InteriorSettings::default(), Goal::exact(1e-11));
        let point = solve(&scaled, &mut matrix, &start, &settings, goal, |_| false).unwrap();
        assert!(point.merit <= 1e-9, "{:e}", point.merit);
        (point, place)
    }

    fn on_a_floor(x: f64, y: f64, inertia: f64) -> ConeProgram {
        let mut body = loaded(x, y);
        for dof in &mut body.dofs {
            if let Dof::Free(free) = dof {
                free.inertia = inertia;
            }
        }
        ConeProgram {
            bodies: vec![held(), body],
            interactions: vec![contact(0, 1, DVec2::Y, 0.0, 0.5)],
            ..ConeProgram::default()
        }
    }

    /// A rigid column: contact k carries the weight of all bodies above it.
    #[test]
    fn a_rigid_column() {
        let (point, _) = solved(&column(3, 0.0));
        for (s, force) in point.s.iter().zip([3.0, 2.0, 1.0]) {
            assert!((s[0] - force).abs() < 1e-8, "{:?}", point.s);
        }
    }

    /// Friction holds a disk of weight 1 against a force of 0.3 where mu = 0.5.
    #[test]
    fn friction_below_its_limit_holds() {
        let (point, place) = solved(&on_a_floor(0.3, -1.0, 0.0));
        assert!((point.s[0][0] - 1.0).abs() < 1e-8 && (point.s[0][1].abs() - 0.3).abs() < 1e-8);
        assert!(point.u[place[1]].iter().all(|u| u.abs() < 1e-6), "{:?}", point.u);
    }

    /// With inertia 1 and the load f = (1, -1) beyond the friction cone the force is the projection
    /// of f onto the cone: p = (f.d)/|d|^2 = 1.2 with d = (mu, -1), q = mu p, and what is left of f
    /// moves the disk, u = (0.4, 0.2): it slides, and the associated law opens the contact by mu
    /// times the slip.
    #[test]
    fn a_disk_that_slides() {
        let (point, place) = solved(&on_a_floor(1.0, -1.0, 1.0));
        let [p, q, _] = point.s[0];
        assert!((p - 1.2).abs() < 1e-7 && (q.abs() - 0.6).abs() < 1e-7, "{p} {q}");
        let [x, y, _] = point.u[place[1]];
        assert!((x - 0.4).abs() < 1e-7 && (y - 0.2).abs() < 1e-7, "{x} {y}");
    }

    /// The steps of an iteration: the aim of the corrector is not above the mean product, the mean
    /// product stays positive, and the residual falls by 1e-9 in a few iterations.
    #[test]
    fn an_iteration_step_by_step() {
        let (scaled, mut matrix, _) = posed(&on_a_floor(0.3, -1.0, 0.0));
        let settings = InteriorSettings::default();
        let start = vec![[0.0; 3]; 2];
        let mut iteration = Iteration::new(&scaled, &mut matrix, &settings, &start, None);
        iteration.update_residuals();
        let first = iteration.merit();
        let mut iterations = 0;
        while iteration.merit() > 1e-9 * first {
            iterations += 1;
            assert!(iterations <= 20, "{:e} of {first:e}", iteration.merit());
            let mu = iteration.mean_product();
            assert!(mu > 0.0 && iteration.is_finite());
            iteration.assemble();
            assert!(iteration.predict());
            let target = iteration.target();
            assert!((0.0..=mu).contains(&target), "{target:e} of {mu:e}");
            iteration.correct(target);
            iteration.make_step();
            iteration.update_residuals();
        }
    }

    #[test]
    fn slacks_have_their_difference_and_product() {
        for difference in [-1e8, -1.0, -1e-8, 0.0, 1e-8, 1.0, 1e8] {
            for product in [1e-20, 1e-3, 10.0] {
                let w = slack(difference, product);
                let lambda = product / w;
                let size = w.max(lambda);
                assert!(w > 0.0 && (w - lambda - difference).abs() <= 1e-15 * size);
            }
        }
    }
}
