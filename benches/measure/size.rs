//! Time and memory of an elastic increment against the number of disks.

use crate::chart::{Chart, Line};
use clastic::components::contact::BodyTable;
use clastic::components::observation::{Observation, Timings};
use clastic::cone::program::ConeProgram;
use clastic::reference;
use clastic::run::{Simulation, Step};

use crate::clock::{middle, time};
use crate::machine::{forget_peak_memory, peak_memory};
use crate::rigs::Scenes;
use crate::table::{Part, Table};
use crate::{BenchError, Extent};

/// Increments of every specimen. The first one, which orders and analyses the matrix, is listed
/// separately.
const INCREMENTS: u32 = 6;

/// Specimens: whether tiles are the large ones (7380 disks, else 400), columns, rows.
const SIZES: [(bool, u32, u32); 5] =
    [(false, 3, 1), (true, 1, 1), (true, 2, 2), (true, 5, 3), (true, 7, 6)];

/// Runs this part.
///
/// # Errors
/// Where a scene is not there or an increment fails.
pub fn run(scenes: &Scenes, extent: Extent) -> Result<Part, BenchError> {
    let mut table = Table::new(
        "size",
        "Elastic increments of bonded rock, 0.005 % each",
        &[
            "disks",
            "interactions",
            "force_variables",
            "setup_s",
            "first_increment_s",
            "increment_s",
            "solve_s",
            "rest_s",
            "peak_memory_mib",
        ],
    );
    let count = match extent {
        Extent::Quick => 3,
        Extent::Standard => 4,
        Extent::Full => 5,
    };
    let mut points = Vec::new();
    for &(large, columns, rows) in &SIZES[..count] {
        forget_peak_memory();
        let boxed = scenes.rock(large)?.tiled(columns, rows);
        let loaded = scenes.compression_of(boxed, INCREMENTS)?;
        let (setup, mut simulation) =
            time(|| Simulation::new(&loaded.scene, loaded.specimen.as_ref()));
        let (mut whole, mut solve) = (Vec::new(), Vec::new());
        for n in 1..=INCREMENTS {
            let (seconds, step) = time(|| simulation.step());
            let record = simulation.world().resource::<Observation>();
            if step != Step::Increment || !record.ruptures.is_empty() || record.fraction < 1.0 {
                return Err(BenchError::Run(format!("size: increment {n} is not elastic")));
            }
            whole.push(seconds);
            solve.push(simulation.world().resource::<Timings>().solve);
        }
        let world = simulation.world();
        let disks = world.resource::<BodyTable>().particles;
        let program = world.resource::<ConeProgram>();
        let first = whole[0];
        let (increment, solve) = (middle(&mut whole[1..]), middle(&mut solve[1..]));
        points.push((disks as f64, increment, peak_memory()));
        table.rows.push(vec![
            disks.into(),
            program.interactions.len().into(),
            reference::size(program).forces.into(),
            setup.into(),
            first.into(),
            increment.into(),
            solve.into(),
            (increment - solve).into(),
            peak_memory().map(|bytes| bytes / f64::from(1 << 20)).into(),
        ]);
    }
    // A thousand disks fit into the caches: their increments would flatten the slope.
    let large: Vec<_> = points.iter().filter(|p| p.0 > 5e3).collect();
    let times: Vec<_> = large.iter().map(|p| (p.0, p.1)).collect();
    let memory: Vec<_> = large.iter().filter_map(|p| Some((p.0, p.2?))).collect();
    let mut growth = Table::new(
        "size_exponents",
        "Exponents of the number of disks, least squares from 7380 disks on",
        &["quantity", "exponent"],
    );
    growth.rows.push(vec!["time of an increment".into(), exponent(&times).into()]);
    growth.rows.push(vec!["peak memory".into(), exponent(&memory).into()]);
    let chart = Chart {
        title: "Elastic increment against the number of disks".to_owned(),
        caption: format!(
            "time grows as n^{:.2}, memory as n^{:.2} (from 7380 disks on)",
            exponent(&times).unwrap_or(f64::NAN),
            exponent(&memory).unwrap_or(f64::NAN)
        ),
        x: "log10 of the number of disks".to_owned(),
        y: "log10 of the time in s".to_owned(),
        lines: vec![Line {
            name: "increment".to_owned(),
            points: points.iter().map(|p| (p.0.log10(), p.1.log10())).collect(),
        }],
    };
    let text = "Specimens are the stored packings (400 and 7380 disks) and mirrored tiles of the \
        larger one. `setup_s` is the time to spawn the bodies. `first_increment_s` \
        includes cementing, the first detection, and ordering and symbolic analysis of \
        the matrix. `increment_s` is the median of the next five increments, and \
        `rest_s` its part outside of the solve. Memory is the maximum resident set of \
        the process, with the scene.";
    Ok(Part {
        name: "size",
        text: text.to_owned(),
        tables: vec![table, growth],
        charts: vec![("size".to_owned(), chart)],
    })
}

/// Slope of log y over log x; none with fewer than two points.
fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let above: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let below: f64 = logs.iter().map(|p| (p.0 - x).powi(2)).sum();
    (points.len() > 1 && below > 0.0).then(|| above / below)
}

#[cfg(test)]
mod tests {
    use super::exponent;

    #[test]
    fn exponents_of_powers() {
        let power: Vec<_> = [1e3, 7e3, 1e5].map(|n: f64| (n, 3.0 * n.powf(1.3))).to_vec();
        assert!(exponent(&power).is_some_and(|e| (e - 1.3).abs() < 1e-12));
        assert_eq!(exponent(&power[..1]), None);
    }
}
