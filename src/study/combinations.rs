//! The values of the runs of a study.

use indexmap::IndexMap;

use super::format::Runs;
use crate::text::read::Verbatim;

/// Names and values of a run, the values in RON.
pub(super) type Values = Vec<(String, String)>;

/// The values of all runs, each with the path of the part of the study that it comes from.
pub(super) fn combinations(runs: &Runs, path: &str) -> Vec<(String, Values)> {
    match runs {
        Runs::Grid(axes) => grid(axes).into_iter().map(|row| (path.to_owned(), row)).collect(),
        Runs::List(list) => {
            let row = |(k, run): (usize, &IndexMap<String, Verbatim>)| {
                (format!("{path}[{k}]"), run.iter().map(|(name, of)| value(name, of)).collect())
            };
            list.iter().enumerate().map(row).collect()
        }
        Runs::Several(parts) => {
            let of_part = |(k, part): (usize, &Runs)| combinations(part, &format!("{path}[{k}]"));
            parts.iter().enumerate().flat_map(of_part).collect()
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
