//! Reads `history.csv`.

use std::path::Path;

use crate::output::OutputError;
use crate::output::history::PROBE_COLUMNS;

/// Numbers of a history by column. Texts and empty fields are `None`.
#[derive(Clone, Debug, Default)]
pub struct History {
    names: Vec<String>,
    rows: Vec<Vec<Option<f64>>>,
    /// First row of the last stage.
    last_stage: usize,
}

impl History {
    /// Reads a history.
    ///
    /// # Errors
    /// If the file cannot be read or is not CSV.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let mut reader = csv::Reader::from_path(path).map_err(OutputError::at(path))?;
        let names = reader.headers().map_err(OutputError::at(path))?;
        let names: Vec<_> = names.iter().map(str::to_owned).collect();
        let stage = names.iter().position(|n| n == "stage");
        let mut rows = Vec::new();
        let mut last_stage = (None, 0);
        for row in reader.records() {
            let row = row.map_err(OutputError::at(path))?;
            let now = stage.and_then(|k| row.get(k)).map(str::to_owned);
            if now != last_stage.0 {
                last_stage = (now, rows.len());
            }
            let number = |field: &str| field.parse().ok().filter(|x: &f64| x.is_finite());
            rows.push(row.iter().map(number).collect());
        }
        Ok(Self { names, rows, last_stage: last_stage.1 })
    }

    /// A column; empty if the history does not have it.
    #[must_use]
    pub fn column(&self, name: &str) -> Vec<Option<f64>> {
        let Some(k) = self.names.iter().position(|n| n == name) else { return Vec::new() };
        self.rows.iter().map(|row| row.get(k).copied().flatten()).collect()
    }

    /// Points of one column against another, where both values are defined.
    #[must_use]
    pub fn points(&self, x: &str, y: &str) -> Vec<(f64, f64)> {
        let pairs = self.column(x).into_iter().zip(self.column(y));
        pairs.filter_map(|(x, y)| Some((x?, y?))).collect()
    }

    /// First row of the last stage.
    #[must_use]
    pub fn last_stage(&self) -> usize {
        self.last_stage
    }

    /// Names of the probes.
    #[must_use]
    pub fn probes(&self) -> Vec<&str> {
        self.names.iter().filter_map(|name| name.strip_suffix(PROBE_COLUMNS[0])).collect()
    }
}
