//! `clastic compare`: the curves of several runs in one picture, and their key results in one table.

use std::fs;
use std::path::{Path, PathBuf};

use clastic::output::OutputError;
use clastic::output::atomic::write_atomic;
use clastic::output::directory;
use clastic::output::plots::compare;
use clastic::output::plots::history::History;

use super::exit::{Exit, Failure, say};

/// Compares runs.
pub fn compare(runs: &[PathBuf], out: &Path) -> Result<Exit, Failure> {
    let mut read = Vec::new();
    for run in runs {
        read.push((name(run), History::read(&run.join(directory::HISTORY))?));
    }
    say(format_args!("{}", table(runs)?))?;
    fs::create_dir_all(out).map_err(OutputError::at(out))?;
    let charts =
        [("stress.svg", compare::stress(&read)), ("volumetric.svg", compare::volumetric(&read))];
    let mut drawn = false;
    for (file, chart) in charts {
        if let Some(chart) = chart {
            let path = out.join(file);
            write_atomic(&path, chart.svg().map_err(OutputError::at(&path))?)?;
            say(format_args!("drawn: {}", path.display()))?;
            drawn = true;
        }
    }
    if !drawn {
        say(format_args!("no picture: none of the runs defines an axial strain with a stress"))?;
    }
    Ok(Exit::Ok)
}

fn name(run: &Path) -> String {
    run.file_name().unwrap_or(run.as_os_str()).to_string_lossy().into_owned()
}

/// Columns of the table: name in `run.json`, heading, factor, digits.
const COLUMNS: [(&str, &str, f64, usize); 5] = [
    ("youngs_modulus_pa", "E, MPa", 1e-6, 3),
    ("first_crack_stress_pa", "first crack, MPa", 1e-6, 4),
    ("peak_stress_pa", "peak, MPa", 1e-6, 4),
    ("strain_at_peak", "at strain, %", 100.0, 4),
    ("porosity", "porosity", 1.0, 4),
];

fn table(runs: &[PathBuf]) -> Result<String, Failure> {
    let width = runs.iter().map(|run| name(run).chars().count()).max().unwrap_or(0).max(3);
    let mut text = format!("{:width$}", "run");
    for (_, heading, ..) in COLUMNS {
        text += &format!("  {heading:>16}");
    }
    text += "  outcome";
    for run in runs {
        let path = run.join(directory::RUN);
        let record = fs::read_to_string(&path).map_err(OutputError::at(&path))?;
        let record: serde_json::Value =
            serde_json::from_str(&record).map_err(OutputError::at(&path))?;
        text += &format!("\n{:width$}", name(run));
        for (key, _, factor, digits) in COLUMNS {
            let value = record["results"][key].as_f64();
            let value =
                value.map_or_else(|| "-".to_owned(), |v| format!("{:.digits$}", v * factor));
            text += &format!("  {value:>16}");
        }
        text += &format!("  {}", record["outcome"]["status"].as_str().unwrap_or("not ended"));
    }
    Ok(text)
}
