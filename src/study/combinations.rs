//! The values of the runs of a study.

use std::path::Path;

use indexmap::IndexMap;

use super::format::{Runs, StudyError};
use crate::scene::reader::read::Verbatim;

/// Names and values of a run, the values in RON. An empty value is none.
pub(super) type Values = Vec<(String, String)>;

/// The values of all runs that stand in the study `file`.
pub(super) fn combinations(runs: &Runs, file: &Path) -> Result<Vec<Values>, StudyError> {
    match runs {
        Runs::Grid(axes) => Ok(grid(axes)),
        Runs::List(list) => {
            let row = |run: &IndexMap<String, Verbatim>| {
                run.iter().map(|(name, of)| value(name, of)).collect()
            };
            Ok(list.iter().map(row).collect())
        }
        Runs::Table(path) => table(&file.parent().unwrap_or(Path::new("")).join(path)),
        Runs::Several(parts) => {
            let parts: Result<Vec<_>, _> = parts.iter().map(|p| combinations(p, file)).collect();
            Ok(parts?.concat())
        }
    }
}

fn value(name: &str, value: &Verbatim) -> (String, String) {
    (name.to_owned(), value.0.clone())
}

/// Every combination of the values. The last name changes fastest.
fn grid(axes: &IndexMap<String, Vec<Verbatim>>) -> Vec<Values> {
    axes.iter().fold(vec![Vec::new()], |rows, (name, values)| {
        let longer = |row: &Values| -> Vec<Values> {
            values.iter().map(|of| [row.as_slice(), &[value(name, of)]].concat()).collect()
        };
        rows.iter().flat_map(longer).collect()
    })
}

fn table(path: &Path) -> Result<Vec<Values>, StudyError> {
    let wrong = |error: csv::Error| StudyError::new(path, error.to_string());
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(wrong)?;
    let names: Vec<String> = reader.headers().map_err(wrong)?.iter().map(str::to_owned).collect();
    if let Some(twice) = names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)) {
        let message = format!("column `{}` stands twice; leave one of them out", twice.1);
        return Err(StudyError::new(path, message));
    }
    let row = |record: csv::Result<csv::StringRecord>| {
        let record = record.map_err(wrong)?;
        Ok(names.iter().cloned().zip(record.iter().map(str::to_owned)).collect())
    };
    reader.records().map(row).collect()
}
