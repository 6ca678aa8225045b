//! The values of the runs of a study.

use std::path::Path;

use super::format::{Runs, StudyError};
use super::ordered::Ordered;

/// The values of all runs.
pub(super) struct Combinations {
    /// Names that a run may give a value.
    pub names: Vec<String>,
    /// Values per run, in RON, in the order of the names; empty where the run lacks the name.
    pub rows: Vec<Vec<String>>,
}

impl Combinations {
    /// The values of runs that stand in the study `file`.
    pub fn of(runs: &Runs, file: &Path) -> Result<Self, StudyError> {
        match runs {
            Runs::Grid(axes) => Ok(grid(axes)),
            Runs::List(list) => Ok(several(list.iter().map(row))),
            Runs::Table(path) => table(&file.parent().unwrap_or(Path::new("")).join(path)),
            Runs::Several(parts) => {
                let parts: Result<Vec<_>, _> = parts.iter().map(|p| Self::of(p, file)).collect();
                Ok(several(parts?.into_iter()))
            }
        }
    }
}

fn text(value: &ron::value::RawValue) -> String {
    value.get_ron().trim().to_owned()
}

fn grid(axes: &Ordered<Vec<Box<ron::value::RawValue>>>) -> Combinations {
    let names = axes.0.iter().map(|(name, _)| name.clone()).collect();
    let mut rows = vec![Vec::new()];
    for (_, values) in &axes.0 {
        let longer = |row: &Vec<String>| {
            let row = row.clone();
            values.iter().map(move |value| [row.as_slice(), &[text(value)]].concat())
        };
        rows = rows.iter().flat_map(longer).collect();
    }
    Combinations { names, rows }
}

fn row(run: &Ordered<Box<ron::value::RawValue>>) -> Combinations {
    let names = run.0.iter().map(|(name, _)| name.clone()).collect();
    Combinations { names, rows: vec![run.0.iter().map(|(_, value)| text(value)).collect()] }
}

/// The runs of all parts, one part after the other, with the names of all.
fn several(parts: impl Iterator<Item = Combinations>) -> Combinations {
    let mut all = Combinations { names: Vec::new(), rows: Vec::new() };
    for part in parts {
        for name in &part.names {
            if !all.names.contains(name) {
                all.names.push(name.clone());
            }
        }
        for row in part.rows {
            let mut values = vec![String::new(); all.names.len()];
            for (name, value) in part.names.iter().zip(row) {
                if let Some(at) = all.names.iter().position(|known| known == name) {
                    values[at] = value;
                }
            }
            all.rows.push(values);
        }
    }
    let width = all.names.len();
    all.rows.iter_mut().for_each(|row| row.resize(width, String::new()));
    all
}

fn table(path: &Path) -> Result<Combinations, StudyError> {
    let wrong = |error: csv::Error| StudyError::new(path, error.to_string());
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(wrong)?;
    let names: Vec<String> = reader.headers().map_err(wrong)?.iter().map(str::to_owned).collect();
    if let Some(twice) = names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)) {
        let message = format!("column `{}` stands twice; leave one of them out", twice.1);
        return Err(StudyError::new(path, message));
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        rows.push(record.map_err(wrong)?.iter().map(str::to_owned).collect());
    }
    Ok(Combinations { names, rows })
}
