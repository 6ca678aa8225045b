//! The values of the runs of a study.

use indexmap::IndexMap;

use super::format::Runs;
use crate::text::read::Verbatim;

/// Names and values of a run, the values in RON.
pub(super) type Values = Vec<(String, String)>;

/// The values of all runs.
pub(super) fn combinations(runs: &Runs) -> Vec<Values> {
    match runs {
        Runs::Grid(axes) => grid(axes),
        Runs::List(list) => {
            let row = |run: &IndexMap<String, Verbatim>| {
                run.iter().map(|(name, of)| value(name, of)).collect()
            };
            list.iter().map(row).collect()
        }
        Runs::Several(parts) => parts.iter().flat_map(combinations).collect(),
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
