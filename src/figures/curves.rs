//! Figures of the history: curves of one run or of several.

use super::FigureError;
use super::run::Run;
use crate::history_columns::ENERGY_COLUMNS;
use crate::output::plots::chart::{Chart, Line};
use crate::output::plots::stress_strain::{SIGNS, STRAIN};
use crate::output::plots::{compare, force_displacement, strength, stress_strain};
use crate::study::strength::Strength;

use super::fabric::Fabric;

/// Stress against strain: of one run with the broken bonds, of several over one another.
pub fn stress(runs: &[Run]) -> Result<Chart, FigureError> {
    let chart = match runs {
        [run] => stress_strain::stress("", &run.history),
        runs => compare::stress(&named(runs)),
    };
    chart.ok_or_else(|| no_strain("stress"))
}

/// Volumetric against axial strain.
pub fn volumetric(runs: &[Run]) -> Result<Chart, FigureError> {
    let chart = match runs {
        [run] => stress_strain::volumetric("", &run.history),
        runs => compare::volumetric(&named(runs)),
    };
    chart.ok_or_else(|| no_strain("volumetric strain"))
}

fn named(runs: &[Run]) -> Vec<(String, crate::output::plots::history::History)> {
    runs.iter().map(|run| (run.name.clone(), run.history.clone())).collect()
}

fn no_strain(what: &str) -> FigureError {
    FigureError::Absent(format!(
        "no row of the history has an axial strain and a {what}; the scene must measure them \
         (`measures`)"
    ))
}

/// Force on the probes against their motion.
pub fn probes(runs: &[Run]) -> Result<Chart, FigureError> {
    let mut charts = Vec::new();
    for run in runs {
        let chart = force_displacement::probes("", &run.history);
        charts.push((run, chart.ok_or_else(|| no_motion(run))?));
    }
    let mut charts = charts.into_iter();
    let Some((first, mut chart)) = charts.next() else {
        return Err(FigureError::Usage("a figure needs a run".to_owned()));
    };
    if runs.len() == 1 {
        return Ok(chart);
    }
    let rename = |run: &Run, lines: Vec<Line>| -> Vec<Line> {
        let single = lines.len() == 1;
        let name = |line: &Line| match single {
            true => run.name.clone(),
            false => format!("{} {}", run.name, line.name),
        };
        lines.into_iter().map(|line| Line { name: name(&line), ..line }).collect()
    };
    chart.lines = rename(first, chart.lines);
    for (run, other) in charts {
        if (&other.x, &other.y) != (&chart.x, &chart.y) {
            return Err(FigureError::Absent(format!(
                "{}: its axes are {} and {}, those of {} are {} and {}",
                run.name, other.x, other.y, first.name, chart.x, chart.y
            )));
        }
        chart.lines.extend(rename(run, other.lines));
    }
    Ok(chart)
}

/// Why a run has no curve of its probes.
fn no_motion(run: &Run) -> FigureError {
    let names = run.history.probes().join("`, `");
    let what = if names.is_empty() {
        "the scene names no probe: give a wall `probe: \"NAME\"`, or particles by `probes`, and run \
         it again"
            .to_owned()
    } else {
        format!(
            "no probe moved (`{names}`), and without displacement there is no curve; their forces \
             stand in history.csv"
        )
    };
    FigureError::Absent(format!("{}: {what}", run.name))
}

/// Energies of the ledger.
pub fn energies(run: &Run) -> Result<Chart, FigureError> {
    let history = &run.history;
    let strain = history.column("axial_strain");
    let time = history.column("time_s");
    let times: Vec<f64> = time.iter().flatten().copied().collect();
    let (along, label, factor) = if strain.iter().any(Option::is_some) {
        ("axial_strain", STRAIN, 100.0)
    } else if times.first() < times.last() {
        ("time_s", "time, s", 1.0)
    } else {
        ("increment", "increment", 1.0)
    };
    let mut lines: Vec<Line> = Vec::new();
    for column in ENERGY_COLUMNS {
        let points = match along {
            "axial_strain" => history.curve(column),
            _ => history.points(along, column),
        };
        if points.iter().any(|p| p.1 != 0.0) {
            let name = column.trim_start_matches("energy_").trim_end_matches("_j");
            let points = points.into_iter().map(|(x, e)| (factor * x, e)).collect();
            lines.push(Line { name: name.replace('_', " "), points });
        }
    }
    let largest = lines.iter().flat_map(|line| &line.points).map(|p| p.1.abs()).fold(0.0, f64::max);
    if largest <= 0.0 {
        return Err(FigureError::Absent(
            "the history has no energies; run the scene with `output: (energy: true)`".to_owned(),
        ));
    }
    // Other terms would be invisible in the picture.
    lines.retain(|line| line.points.iter().any(|p| p.1.abs() > 2e-3 * largest));
    let (unit, size) = match largest {
        e if e >= 1e6 => ("MJ", 1e6),
        e if e >= 1e3 => ("kJ", 1e3),
        e if e >= 1.0 => ("J", 1.0),
        e if e >= 1e-3 => ("mJ", 1e-3),
        _ => ("µJ", 1e-6),
    };
    for point in lines.iter_mut().flat_map(|line| &mut line.points) {
        point.1 /= size;
    }
    Ok(Chart {
        caption: "terms below 0.2 % of the largest are not drawn".to_owned(),
        x: label.to_owned(),
        y: format!("energy, {unit}"),
        lines,
        ..Default::default()
    })
}

/// Mohr circles of runs at their peaks, and the linear envelope.
pub fn mohr(runs: &[Run]) -> Result<Chart, FigureError> {
    let mut strengths = Vec::new();
    for run in runs {
        let axial = run.history.points("axial_strain", "axial_stress_pa");
        let lateral = run.history.points("axial_strain", "lateral_stress_pa");
        let results = &run.record["results"];
        let peak = results["peak_stress_pa"].as_f64();
        let (Some(peak), false) = (peak, axial.is_empty()) else {
            let reason = results["not_defined"]["peak_stress_pa"].as_str().unwrap_or("not defined");
            return Err(FigureError::Absent(format!("{}: no peak: {reason}", run.name)));
        };
        let strain = axial.iter().find(|p| p.1 == peak).map_or(f64::NAN, |p| p.0);
        // A specimen without lateral walls has no confining stress.
        let confining = lateral.iter().find(|p| p.0 == strain).map_or(0.0, |p| p.1);
        // A legend has no room for the residual of the increment.
        let confining = format!("{confining:.4e}").parse().unwrap_or(confining);
        strengths.push(Strength { confining, peak });
    }
    Ok(strength::mohr(&strengths, ""))
}

/// Anisotropy of contacts and forces, and the coordination, in all frames.
pub fn fabric(run: &Run) -> Result<Chart, FigureError> {
    let all = run.all()?;
    let is_strained = all.iter().any(|moment| moment.strain.is_some());
    let first = all.iter().position(|moment| moment.strain.is_some()).unwrap_or(0);
    let is_timed = all.first().map(|m| m.time) < all.last().map(|m| m.time);
    let names = ["contacts, a", "normal forces, a_n", "coordination 2 N_c / N"];
    let mut lines = names.map(|name| Line { name: name.to_owned(), points: Vec::new() });
    for (row, moment) in all.iter().enumerate() {
        let x = match moment.strain {
            Some(strain) => 100.0 * strain,
            None if !is_strained && is_timed => moment.time,
            None if !is_strained => moment.increment as f64,
            // The frame of the start.
            None if row + 1 == first => 0.0,
            None => continue,
        };
        if let Some(fabric) = Fabric::of(moment) {
            let values = [fabric.contact.0, fabric.force.0, fabric.coordination];
            for (line, value) in lines.iter_mut().zip(values) {
                line.points.push((x, value));
            }
        }
    }
    let [contacts, forces, coordination] = lines;
    if contacts.points.len() < 2 {
        return Err(FigureError::Absent(
            "two frames with contacts are needed; ask for frames with `output: (frames_every: N)`"
                .to_owned(),
        ));
    }
    Ok(Chart {
        caption: SIGNS.to_owned(),
        x: match (is_strained, is_timed) {
            (true, _) => STRAIN,
            (false, true) => "time, s",
            (false, false) => "increment",
        }
        .to_owned(),
        y: "anisotropy".to_owned(),
        lines: vec![contacts, forces],
        second: Some(coordination),
        ..Default::default()
    })
}
