//! Reads `history.csv`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::history::PROBE_COLUMNS;
use super::{OutputError, csv_file, directory};

/// A probe after an increment of the test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TestPoint {
    /// The increment; 0 for the state before the first one.
    pub increment: u64,
    /// Displacement in m or rotation in rad since the start of the test.
    pub motion: f64,
    /// Force in N or moment in N m of the outside world.
    pub force: f64,
}

/// Numbers of a history by column. Texts and empty fields are `None`.
#[derive(Clone, Debug, Default)]
pub struct History {
    names: Vec<String>,
    rows: Vec<Vec<Option<f64>>>,
    /// Stages, in order, with their first rows.
    stages: Vec<(String, usize)>,
    /// First row of the test.
    test: usize,
    /// Whether a compaction came immediately before the test. Its forces have no meaning.
    is_compacted: bool,
    /// Whether earlier runs preceded this one. Their last row would be the state before the first
    /// row.
    is_continued: bool,
    /// Probes that are rigid groups: their force is that of the contacts on the body.
    rigid_groups: Vec<String>,
}

impl History {
    /// Reads the history of a run directory.
    ///
    /// # Errors
    /// If it has no run, or the history cannot be read.
    pub fn of_run(directory: &Path) -> Result<Self, OutputError> {
        Self::of_record(directory, &directory::record(directory)?)
    }

    /// Reads the history of a run directory with this record.
    ///
    /// # Errors
    /// If the history cannot be read.
    pub(crate) fn of_record(
        directory: &Path,
        record: &serde_json::Value,
    ) -> Result<Self, OutputError> {
        let history = Self::read(&directory.join(directory::HISTORY))?;
        let mut history = history.after(record["increments"].as_u64().unwrap_or(0));
        // Without a reference stage the test begins with the last stage.
        let stage = record["settings"]["reference_stage"].as_str().unwrap_or_default();
        let begins = history.stages.iter().find(|(name, _)| name == stage);
        history.test = begins.map_or(history.test, |(_, row)| *row);
        // Of the stages with a seed, time passes in those that pour.
        let before = history.stages.iter().rev().find(|(_, row)| *row < history.test);
        let is_compacted = before.is_some_and(|(name, row)| {
            let time = history.column("time_s");
            record["seeds"].get(format!("stage {name}")).is_some()
                && time.get(*row) == time.get(history.test - 1)
        });
        let groups = Vec::deserialize(&record["settings"]["rigid_groups"]);
        Ok(Self { is_compacted, rigid_groups: groups.unwrap_or_default(), ..history })
    }

    /// States how many increments the run has made by itself. Increments count over all runs that
    /// led here, as they do for a scene that starts from a saved state.
    pub fn after(self, made: u64) -> Self {
        let last = self.column("increment").into_iter().flatten().fold(0.0, f64::max);
        Self { is_continued: last > made as f64, ..self }
    }

    /// Reads a history.
    ///
    /// # Errors
    /// If the file cannot be read or is not CSV.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let (header, records) = csv_file::read(path)?;
        let stage = header.iter().position(|n| n == "stage");
        let mut stages: Vec<(String, usize)> = Vec::new();
        for (k, record) in records.iter().enumerate() {
            let now = stage.and_then(|stage| record.get(stage)).unwrap_or_default();
            if stages.last().is_none_or(|(last, _)| last != now) {
                stages.push((now.to_owned(), k));
            }
        }
        let test = stages.last().map_or(0, |(_, row)| *row);
        let names = header.iter().map(str::to_owned).collect();
        let number = |field: &str| field.parse().ok().filter(|x: &f64| x.is_finite());
        let rows = records.iter().map(|record| record.iter().map(number).collect()).collect();
        Ok(Self { names, rows, stages, test, ..Self::default() })
    }

    /// A column; empty if the history does not have it.
    pub fn column(&self, name: &str) -> Vec<Option<f64>> {
        let Some(k) = self.names.iter().position(|n| n == name) else { return Vec::new() };
        self.rows.iter().map(|row| row.get(k).copied().flatten()).collect()
    }

    /// Points of a column against the axial strain, from the initial state on, at which the strain
    /// is 0. The value there is that of the row before the first strain, or 0 if that row has no
    /// value or does not exist. The initial state of a run that starts from a saved state is not in
    /// its history.
    pub fn curve(&self, column: &str) -> Vec<(f64, f64)> {
        let (strains, values) = (self.column("axial_strain"), self.column(column));
        let pairs = strains.iter().zip(&values);
        let mut points: Vec<_> = pairs.filter_map(|(x, y)| Some(((*x)?, (*y)?))).collect();
        let first = strains.iter().position(Option::is_some);
        let Some(first) = first.filter(|_| !points.is_empty()) else { return points };
        let before = first.checked_sub(1).map(|row| values[row].unwrap_or(0.0));
        // Strains count from the initial state, whatever led there.
        let of_strain = column.ends_with("strain").then_some(0.0);
        let free = (!self.is_continued).then_some(0.0);
        if let Some(start) = of_strain.or(before).or(free) {
            points.insert(0, (0.0, start));
        }
        points
    }

    /// Motion and force of a probe after every increment of the test, from the state before it on,
    /// in which the displacement is 0. Before the first row of a run forces are 0. The state before
    /// a run that starts from a saved state is not in its history: its displacements are not
    /// shifted. `motion` and `force` are columns of the probe without its name.
    pub(crate) fn of_test(&self, probe: &str, [motion, force]: [&str; 2]) -> Vec<TestPoint> {
        let increments = self.column("increment");
        let of = |column: &str| self.column(&format!("{probe}{column}")).into_iter();
        // The outside world balances the contacts of a rigid group.
        let sign = if self.rigid_groups.iter().any(|name| name == probe) { -1.0 } else { 1.0 };
        let values = of(motion).zip(of(force).map(|force| Some(sign * force?)));
        let point = |(row, (motion, force)): (usize, (Option<f64>, Option<f64>))| {
            let increment = increments.get(row).copied().flatten().unwrap_or_default() as u64;
            Some(TestPoint { increment, motion: motion?, force: force? })
        };
        let first = self.test.saturating_sub(1);
        let mut points: Vec<_> = values.enumerate().skip(first).filter_map(point).collect();
        if self.test > 0 {
            let start = points.first().map_or(0.0, |p| p.motion);
            points.iter_mut().for_each(|p| p.motion -= start);
            if let Some(first) = points.first_mut().filter(|_| self.is_compacted) {
                first.force = 0.0;
            }
        } else if !self.is_continued {
            points.insert(0, TestPoint::default());
        }
        points
    }

    /// Names of the probes.
    pub fn probes(&self) -> Vec<&str> {
        self.names.iter().filter_map(|name| name.strip_suffix(PROBE_COLUMNS[0].0)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(rows: &str) -> Result<History, std::io::Error> {
        let file = tempfile::NamedTempFile::new()?;
        let header =
            "increment,stage,axial_strain,volumetric_strain,axial_stress_pa,broken_shear\n";
        std::fs::write(file.path(), format!("{header}{rows}"))?;
        History::read(file.path()).map_err(std::io::Error::other)
    }

    #[test]
    fn curves_start_at_the_initial_state() -> Result<(), std::io::Error> {
        let loaded = history("1,press,,,5,1\n2,load,0.1,0.2,7,2\n")?;
        assert_eq!(loaded.curve("axial_stress_pa"), [(0.0, 5.0), (0.1, 7.0)]);
        assert_eq!(loaded.curve("broken_shear"), [(0.0, 1.0), (0.1, 2.0)]);
        assert_eq!(loaded.curve("volumetric_strain"), [(0.0, 0.0), (0.1, 0.2)]);
        let compacted = history("1,compact,,,,0\n2,load,0.1,0.2,7,2\n")?;
        assert_eq!(compacted.curve("axial_stress_pa"), [(0.0, 0.0), (0.1, 7.0)]);
        let fresh = history("9,load,0.1,0.2,7,2\n")?;
        assert_eq!(fresh.curve("axial_stress_pa"), [(0.0, 0.0), (0.1, 7.0)]);
        let branch = fresh.after(3);
        assert_eq!(branch.curve("axial_stress_pa"), [(0.1, 7.0)]);
        assert_eq!(branch.curve("volumetric_strain"), [(0.0, 0.0), (0.1, 0.2)]);
        assert_eq!(branch.curve("no_such_column"), []);
        Ok(())
    }
}
