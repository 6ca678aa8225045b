//! Coulomb's law as a complementarity problem.
//!
//! The associated law opens a sliding contact by `mu |slip|`. Coulomb's law does not, and its
//! solution is not the minimum of an energy. A time step in which grains slide begins with sweeps of
//! Coulomb's law from the last forces ([`Coulomb::sweep`]). Elsewhere the search begins at the
//! associated solution: both laws have the same admissible forces, so that a proof of collapse holds
//! for both. From either start follow
//!
//! 1. an interior-point iteration (`interior`);
//! 2. where it stalls, the path of the perturbed problem (`arc`), followed past its turning points,
//!    from two starts.
//!
//! In statics none, one or several solutions may exist; the order of the starts is fixed, so that
//! runs repeat. In dynamics with a small time step the solution is unique.

mod arc;
mod cell;
mod interior;
mod settings;
mod system;

use crate::program::{ConeProgram, ConeSolution, SlidingLaw, SolveStatus};

pub use self::settings::{ArcSettings, CoulombInteriorSettings, CoulombSettings};
use self::system::System;
use super::condensed::matrix::UnsymmetricMatrix;
use super::condensed::settings::DEFAULT_RESIDUAL;
use super::condensed::{sleeping, sweeps};
use super::residuals::{applied_force, choose_displacements, min_force, natural_map};

/// Requirements on a solution.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// Maximum residual.
    pub tolerance: f64,
    /// Whether the first point within the tolerance suffices. If not, the iteration goes on from
    /// there while it gains much: a product within the tolerance leaves its square root in the
    /// forces.
    pub at_once: bool,
}

/// The solver of Coulomb's law. It keeps the pattern of its matrix between calls.
#[derive(Default)]
pub struct Coulomb {
    settings: CoulombSettings,
    matrix: UnsymmetricMatrix,
}

impl Coulomb {
    /// A solver with these settings.
    pub fn new(settings: CoulombSettings) -> Self {
        Self { settings, ..Self::default() }
    }

    /// A time step in which grains slide after [sweeps](sweeps::sweep) of Coulomb's law from the last
    /// forces.
    ///
    /// `None` where sweeps do not apply, where bodies sleep, which the associated solver leaves out,
    /// and where nothing slides: both laws then have the same solution, and the associated one is the
    /// more exact. `moved` are the displacements of the last solution, m and rad.
    pub fn sweep(
        program: &ConeProgram,
        moved: &[[f64; 3]],
        tolerance: f64,
    ) -> Option<ConeSolution> {
        let applies = program.is_dynamic()
            && sweeps::applies(program)
            && sleeping::find(program, moved).is_none();
        if !applies {
            return None;
        }
        let start = sweeps::sweep(program, SlidingLaw::Coulomb, tolerance);
        let mut closed = program.interactions.iter().zip(&start.forces).filter(|(_, f)| f[0] > 0.0);
        let slides = closed.any(|(c, f)| c.limits.slides(f) || c.limits.rolls(f));
        slides.then_some(start)
    }

    /// Solves a program under Coulomb's law from a solution under the associated law, or from forces of
    /// Coulomb's law, those of the last solution or after [sweeps](Self::sweep), in at most `max`
    /// factorisations. The result is solved if its residual is within the tolerance of the goal,
    /// otherwise the best point on the way, stalled.
    pub fn solve(
        &mut self,
        program: &ConeProgram,
        start: &ConeSolution,
        goal: Goal,
        max: u32,
    ) -> ConeSolution {
        let settings = self.settings;
        let mut trial = Trial::new(program, start, &settings, goal);
        trial.offer(start.forces.clone(), start.displacements.clone());
        let is_associated = program.interactions.iter().all(|c| c.limits.has_strength());
        // The associated solution is exact, and nothing slides where it solves Coulomb's law.
        let is_of_law = start.law == SlidingLaw::Coulomb;
        let is_found = if is_of_law { trial.is_sharp() } else { trial.is_within(DEFAULT_RESIDUAL) };
        if is_associated || is_found {
            return trial.into_solution(0);
        }
        // The force scale of the program may be far above its forces.
        let mut scaled = program.clone();
        scaled.scales.force = unit_of_force(program, start);
        let mut system = System::new(&scaled, &mut self.matrix, &settings);
        let (du, df) = system.units;
        let of = |u: &[f64; 3], d: &[f64; 3]| [0, 1, 2].map(|k| u[k] / d[k]);
        let u: Vec<_> =
            system.matrix.order().iter().map(|i| of(&start.displacements[*i], &du)).collect();
        let s: Vec<_> = start.forces.iter().map(|f| of(f, &df)).collect();
        let product = match is_of_law {
            true if program.is_dynamic() && trial.worst > settings.near => settings.arc_products[0],
            true => settings.share * trial.worst,
            false => settings.product,
        };
        let z = system.near(&u, &s, product);
        let first = max.min(settings.max_iterations);
        interior::iterate(&mut system, z, &settings.interior, first, &mut trial);
        for product in settings.arc_products {
            let left = max.saturating_sub(system.factorisations);
            if trial.is_solved() || left == 0 {
                break;
            }
            let z = system.near(&u, &s, product);
            let end =
                arc::follow(&mut system, z, &settings.arc, left.min(settings.max_arc), &mut trial);
            if let Some(z) = end.filter(|_| trial.is_solved() && !goal.at_once) {
                let (u, s) = (&z.u, z.cells.iter().map(|x| x.s).collect::<Vec<_>>());
                let z = system.near(u, &s, settings.share * goal.tolerance);
                let left = max.saturating_sub(system.factorisations).min(settings.max_sharpening);
                interior::iterate(&mut system, z, &settings.interior, left, &mut trial);
            }
        }
        let spent = system.factorisations;
        trial.into_solution(spent)
    }
}

/// Maximum force, contact or applied, N; at least the minimum that residuals are relative to.
fn unit_of_force(program: &ConeProgram, start: &ConeSolution) -> f64 {
    let contact = start.forces.iter().map(|f| f[0].abs().max(f[1].abs())).fold(0.0, f64::max);
    contact.max(applied_force(program)).max(min_force(program, &start.forces))
}

/// Evaluates points on the program in SI units and keeps the best one.
pub struct Trial<'a> {
    program: &'a ConeProgram,
    settings: &'a CoulombSettings,
    goal: Goal,
    best: ConeSolution,
    /// Its residual.
    worst: f64,
    /// Residuals of the last two points, oldest first.
    residuals: [f64; 2],
}

impl<'a> Trial<'a> {
    fn new(
        program: &'a ConeProgram,
        start: &ConeSolution,
        settings: &'a CoulombSettings,
        goal: Goal,
    ) -> Self {
        let best = ConeSolution { law: SlidingLaw::Coulomb, ..start.clone() };
        let (worst, residuals) = (f64::INFINITY, [f64::INFINITY; 2]);
        Self { program, settings, goal, best, worst, residuals }
    }

    fn is_solved(&self) -> bool {
        self.worst <= self.goal.tolerance
    }

    /// Whether another iteration pays: the last point was much better than the one before.
    fn sharpens(&self) -> bool {
        let [before, last] = self.residuals;
        !self.is_sharp() && last <= self.settings.progress * before
    }

    /// Whether the best point needs no further iteration.
    fn is_sharp(&self) -> bool {
        let Goal { tolerance, at_once } = self.goal;
        if at_once { self.is_solved() } else { self.is_within(self.settings.sharp * tolerance) }
    }

    /// Whether the best point is a solution whose natural map is at most `map`.
    fn is_within(&self, map: f64) -> bool {
        self.is_solved() && natural_map(self.program, &self.best) <= map
    }

    /// Evaluates a point with its forces clamped to their limits; whether it is a solution.
    fn consider(&mut self, system: &System, z: &system::Vector) -> bool {
        let (du, df) = system.units;
        // Imposed displacements are exact, without round-off of the units.
        let mut displacements = self.program.imposed();
        for (i, k) in system.program.all_free() {
            displacements[system.matrix.order()[i]][k] = z.u[i][k] * du[k];
        }
        let cells = system.cells.iter().zip(&z.cells);
        let clamped = cells.map(|(cell, x)| cell.clamp(&x.s));
        let forces = clamped.map(|s| [0, 1, 2].map(|f| s[f] * df[f])).collect();
        self.offer(forces, displacements)
    }

    /// Evaluates forces, N, and displacements, m; whether they are a solution.
    fn offer(&mut self, forces: Vec<[f64; 3]>, displacements: Vec<[f64; 3]>) -> bool {
        let law = SlidingLaw::Coulomb;
        let mut solution = ConeSolution { law, forces, displacements, ..Default::default() };
        let r = choose_displacements(self.program, &mut solution, self.goal.tolerance).worst();
        self.residuals = [self.residuals[1], r];
        if r < self.worst {
            self.worst = r;
            self.best = solution;
        }
        self.is_solved()
    }

    fn into_solution(self, iterations: u32) -> ConeSolution {
        let status = if self.is_solved() { SolveStatus::Solved } else { SolveStatus::Stalled };
        ConeSolution { status, iterations, message: "Coulomb".to_owned(), ..self.best }
    }
}
