//! Work and precision: one program, every solver at every tolerance, time against error.
//!
//! Errors are measured against a reference that the *other* solver made, far tighter. Where the two
//! references differ by more than [`UNIQUE`] in a measure, that measure is not unique in the
//! program and is left out; their difference is the floor below which errors mean nothing.

use crate::chart::{Chart, Line};
use clastic::cone::condensed::{Condensed, CondensedSettings};
use clastic::cone::program::{ConeProgram, ConeSolution, SolveStatus};
use clastic::cone::residuals::residuals;
use clastic::cone::solver::ConeSolver;
use clastic::reference::{Clarabel, PolishSettings};

use crate::accuracy::{Errors, errors};
use crate::capture::{Captured, Moment, capture};
use crate::clock::{Repetitions, median, time};
use crate::rigs::Scenes;
use crate::table::{Cell, Part, Table};
use crate::{BenchError, Extent};

/// Maximum difference of the references in a measure that is taken to be unique.
pub const UNIQUE: f64 = 1e-4;

/// Tolerances with which references are tried, tightest first.
const TIGHT: [f64; 5] = [1e-12, 1e-11, 1e-10, 1e-9, 9e-9];

/// Errors for which the summary gives the time.
const LEVELS: [f64; 4] = [1e-2, 1e-4, 1e-6, 1e-8];

/// The solvers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Clarabel,
    Condensed,
}

impl Kind {
    const ALL: [Self; 2] = [Self::Clarabel, Self::Condensed];

    fn name(self) -> &'static str {
        match self {
            Self::Clarabel => "Clarabel",
            Self::Condensed => "Condensed",
        }
    }

    fn solver(self, tolerance: f64, polish: bool) -> Box<dyn ConeSolver> {
        match self {
            Self::Clarabel => {
                let polish = polish.then(PolishSettings::default);
                Box::new(Clarabel { tolerance, polish, ..Default::default() })
            }
            Self::Condensed => {
                Box::new(Condensed::new(CondensedSettings::with_tolerance(tolerance)))
            }
        }
    }

    /// The most accurate solution of this solver. Where it finds none a looser
    /// tolerance is tried.
    fn reference(self, problem: &Captured) -> Option<ConeSolution> {
        TIGHT.iter().find_map(|&tolerance| {
            let mut solver = self.solver(tolerance, true);
            self.warm(solver.as_mut(), problem);
            let solution = solver.solve(&problem.program, 0.0).ok()?;
            (worst(&problem.program, &solution) <= 1e-8).then_some(solution)
        })
    }

    /// Prepares the solver with the data that it has in a run before this program.
    fn warm(self, solver: &mut dyn ConeSolver, problem: &Captured) {
        if let (Self::Condensed, Some(before)) = (self, &problem.before) {
            let _ = solver.solve(before, 0.0);
        }
    }
}

/// Maximum residual, regularisation excluded; none where there is no solution.
fn worst(program: &ConeProgram, solution: &ConeSolution) -> f64 {
    let complete = solution.forces.len() == program.interactions.len()
        && solution.displacements.len() == program.bodies.len();
    if !complete || matches!(solution.status, SolveStatus::Collapsed | SolveStatus::Locked) {
        return f64::NAN;
    }
    residuals(program, solution).worst()
}

/// One measurement.
struct Point {
    solver: Kind,
    tolerance: f64,
    seconds: f64,
    errors: Errors,
    cells: Vec<Cell>,
}

/// The problems.
///
/// # Errors
/// If a scene is missing or ends before the increment in question.
pub fn problems(scenes: &Scenes, full: bool) -> Result<Vec<Captured>, BenchError> {
    let rock = [
        ("elastic increment", Moment::Increment("load", 10)),
        ("peak", Moment::Peak),
        ("after the peak", Moment::AfterPeak),
    ];
    let mut all = capture(&scenes.uniaxial(full, 160)?, &rock)?;
    let rigid = scenes.load(if full { "uniaxial_rigid" } else { "uniaxial_rigid_small" }, &[])?;
    all.extend(capture(&rigid, &[("rigid limit load", Moment::Increment("load", 1))])?);
    let rolling = [("rolling biaxial", Moment::Increment("load", 20))];
    all.extend(capture(&scenes.biaxial(full, &[])?, &rolling)?);
    // Not the increment of the impact, which begins and ends at a gap of zero: errors of no
    // displacement have no scale.
    let bounce = [("bounce", Moment::Increment("drop", 103))];
    all.extend(capture(&scenes.load("bounce", &[])?, &bounce)?);
    let collapse = [("column collapse", Moment::Increment("release", 50))];
    all.extend(capture(&scenes.collapse(full)?, &collapse)?);
    Ok(all)
}

/// Runs this part.
///
/// # Errors
/// See [`problems`].
pub fn run(scenes: &Scenes, extent: Extent) -> Result<Part, BenchError> {
    let full = extent > Extent::Quick;
    let mut table = Table::new(
        "precision",
        "Time and error of one program by solver and tolerance",
        &[
            "problem",
            "bodies",
            "interactions",
            "solver",
            "tolerance",
            "time_s",
            "iterations",
            "method",
            "residual",
            "objective_error",
            "forces_error",
            "walls_error",
            "displacements_error",
            "objective_floor",
            "forces_floor",
            "walls_floor",
            "displacements_floor",
        ],
    );
    // The levels below say the same in fewer lines.
    table.in_summary = false;
    let mut levels = Table::new(
        "precision_levels",
        "Minimum time (ms) to a maximum error, and the error at the default tolerance",
        &[
            "problem",
            "bodies",
            "interactions",
            "solver",
            "1e-2_ms",
            "1e-4_ms",
            "1e-6_ms",
            "1e-8_ms",
            "default_ms",
            "default_error",
            "floor",
            "measured",
        ],
    );
    let mut charts = Vec::new();
    for problem in problems(scenes, full)? {
        let (points, floor) = measure(&problem, extent);
        for point in &points {
            let mut row = vec![
                problem.name.as_str().into(),
                problem.program.bodies.len().into(),
                problem.program.interactions.len().into(),
                point.solver.name().into(),
                point.tolerance.into(),
                point.seconds.into(),
            ];
            row.extend(point.cells.clone());
            row.extend(point.errors.all().map(Cell::from));
            row.extend(floor.all().map(Cell::from));
            table.rows.push(row);
        }
        levels.rows.extend(summary(&problem, &points, &floor));
        // Without a reference no error is known.
        let chart = chart(&problem, &points);
        if chart.lines.iter().any(|line| !line.points.is_empty()) {
            charts.push((format!("precision_{}", problem.name.replace(' ', "_")), chart));
        }
    }
    let text = "The programs come from increments of running scenes. The condensed solver starts \
        from the increment before, as in a run, and keeps order and symbolic \
        factorisation while the pairs do not change; Clarabel starts anew and is not \
        polished. Tolerances are those given to the solver. The error is the maximum of \
        the relative errors of forces (energy norm), reactions of moving walls and \
        displacements, against a polished solution of the other solver. A measure in \
        which the two reference solutions differ by more than 1e-4 is not unique and is \
        left out. `floor` is the difference of the reference solutions in the other \
        measures; smaller errors are not significant. Empty cells: the error was not \
        reached or is below the floor, or the other solver did not reach a residual of \
        1e-8. `bounce` is a program with one contact.";
    Ok(Part { name: "precision", text: text.to_owned(), tables: vec![levels, table], charts })
}

fn measure(problem: &Captured, extent: Extent) -> (Vec<Point>, Errors) {
    let program = &problem.program;
    let references = Kind::ALL.map(|kind| kind.reference(problem));
    let floor = match &references {
        [Some(a), Some(b)] => errors(program, a, b),
        _ => Errors::default(),
    };
    let step = if extent == Extent::Full { 1 } else { 2 };
    let repetitions = match extent {
        Extent::Quick => Repetitions { minimum: 3, maximum: 15, seconds: 0.15 },
        _ => Repetitions { minimum: 3, maximum: 15, seconds: 1.0 },
    };
    let mut points = Vec::new();
    for kind in Kind::ALL {
        let other = match kind {
            Kind::Clarabel => &references[1],
            Kind::Condensed => &references[0],
        };
        let decades = (2..=12).step_by(step).map(|k| 10.0_f64.powi(-k));
        for tolerance in decades.chain([9e-9]) {
            let mut last = None;
            let seconds = median(&repetitions, || {
                let mut solver = kind.solver(tolerance, false);
                kind.warm(solver.as_mut(), problem);
                let (seconds, solution) = time(|| solver.solve(program, 0.0));
                last = solution.ok();
                seconds
            });
            let Some(solution) = last else { continue };
            let residual = worst(program, &solution);
            let found = match other {
                Some(reference) if residual.is_finite() => errors(program, &solution, reference),
                _ => Errors::default(),
            };
            points.push(Point {
                solver: kind,
                tolerance,
                seconds,
                errors: found.unique(&floor, UNIQUE),
                cells: vec![
                    solution.iterations.into(),
                    solution.message.clone().into(),
                    residual.into(),
                ],
            });
        }
    }
    (points, floor)
}

fn summary(problem: &Captured, points: &[Point], floor: &Errors) -> Vec<Vec<Cell>> {
    let measured: Vec<&str> = ["objective", "forces", "walls", "displacements"]
        .into_iter()
        .zip(floor.unique(floor, UNIQUE).all())
        .filter_map(|(name, floor)| floor.map(|_| name))
        .collect();
    let row = |kind: Kind| {
        let own = || points.iter().filter(move |p| p.solver == kind);
        let unique = floor.unique(floor, UNIQUE);
        let lowest = unique.worst().or(unique.objective).unwrap_or(f64::NAN);
        let mut row = vec![
            problem.name.as_str().into(),
            problem.program.bodies.len().into(),
            problem.program.interactions.len().into(),
            kind.name().into(),
        ];
        for level in LEVELS {
            let times = own().filter(|p| score(p).is_some_and(|e| e <= level)).map(|p| p.seconds);
            let least = times.reduce(f64::min).filter(|_| level >= lowest);
            row.push(least.map(|s| 1e3 * s).into());
        }
        let default = own().find(|p| p.tolerance == 9e-9);
        row.push(default.map(|p| 1e3 * p.seconds).into());
        row.push(default.and_then(score).into());
        row.push(lowest.into());
        row.push(measured.join(", ").into());
        row
    };
    Kind::ALL.map(row).to_vec()
}

/// The error that counts: that of the objective only if no other error is defined.
fn score(point: &Point) -> Option<f64> {
    point.errors.worst().or(point.errors.objective)
}

fn chart(problem: &Captured, points: &[Point]) -> Chart {
    let line = |kind: Kind| Line {
        name: kind.name().to_owned(),
        points: points
            .iter()
            .filter(|p| p.solver == kind && p.tolerance != 9e-9)
            .filter_map(|p| Some((score(p)?.max(1e-16).log10(), (1e3 * p.seconds).log10())))
            .collect(),
    };
    let (n, m) = (problem.program.bodies.len(), problem.program.interactions.len());
    Chart {
        title: format!("Work and precision: {}", problem.name),
        caption: format!("{n} bodies, {m} interactions; tolerances 1e-2 to 1e-12"),
        x: "log10 of the error".to_owned(),
        y: "log10 of the time in ms".to_owned(),
        lines: Kind::ALL.map(line).to_vec(),
    }
}
