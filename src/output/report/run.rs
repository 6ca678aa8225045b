//! Data of a run in a page besides its frames: record, scene, curves, ruptures.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::{Map, Value, json};

use crate::output::drive::Drive;
use crate::output::history::has_column;
use crate::output::marks::marks;
use crate::output::read_history::{History, TestPoint};
use crate::output::{OutputError, csv_file, directory};

/// Columns of texts.
const TEXTS: [&str; 4] = ["stage", "status", "caps", "mode"];

pub struct Run {
    /// Its data, as the page reads them.
    pub value: Value,
    /// Increments of the rows of the history with the axial strain, if the scene defines one.
    pub strains: Vec<(u64, Option<f64>)>,
    /// Number of ruptures by increment.
    pub ruptures: BTreeMap<u64, usize>,
}

impl Run {
    pub fn read(name: &str, path: &Path) -> Result<Self, OutputError> {
        let record = directory::record(path)?;
        let scene_file = path.join(directory::SCENE);
        let scene = fs::read_to_string(&scene_file).map_err(OutputError::at(&scene_file))?;
        // Columns of probes have a dot in their names.
        let history = table(&path.join(directory::HISTORY), |name| !name.contains('.'))?;
        let measures: Vec<_> = history.keys().filter(|name| !has_column(name)).collect();
        let broken = table(&path.join(directory::EVENTS), |name| {
            !name.starts_with("normal") && name != "stage"
        })?;
        let released = table(&path.join(directory::AVALANCHES), |name| name != "stage")?;
        let numbers = |table: &Map<String, Value>, name: &str| -> Vec<Option<f64>> {
            let column = table.get(name).and_then(Value::as_array);
            column.map(|values| values.iter().map(Value::as_f64).collect()).unwrap_or_default()
        };
        let increments = numbers(&history, "increment").into_iter();
        let strains = increments.zip(numbers(&history, "axial_strain"));
        let strains = strains.filter_map(|(n, strain)| Some((n? as u64, strain))).collect();
        let mut ruptures = BTreeMap::new();
        for increment in numbers(&broken, "increment").into_iter().flatten() {
            *ruptures.entry(increment as u64).or_default() += 1;
        }
        // Curves of a run without a stress: the force of the drive.
        let drives = match history.get("axial_stress_pa").and_then(Value::as_array) {
            Some(stress) if stress.iter().any(Value::is_number) => Vec::new(),
            _ => Drive::all(&History::of_record(path, &record)?),
        };
        let peak = Drive::most(&drives).and_then(|drive| {
            let TestPoint { increment, motion, force } = drive.peak()?;
            Some(json!({
                "probe": drive.probe,
                "direction": drive.direction,
                "increment": increment,
                "motion": motion,
                "force": force,
            }))
        });
        let value = json!({
            "name": name,
            "marks": marks(&record),
            "record": record,
            "scene": scene,
            "history": history,
            "measures": measures,
            "drives": drives,
            "peak": peak,
            "events": broken,
            "avalanches": released,
        });
        Ok(Self { value, strains, ruptures })
    }
}

/// The columns of a CSV file with these names. Empty fields are null. A file that is not there has
/// none.
fn table(path: &Path, is_read: impl Fn(&str) -> bool) -> Result<Map<String, Value>, OutputError> {
    if !path.exists() {
        return Ok(Map::new());
    }
    let (header, rows) = csv_file::read(path)?;
    let column = |(k, name): (usize, &str)| {
        let is_text = TEXTS.contains(&name);
        let value = |field: &str| if is_text { field.into() } else { number(field) };
        (name.to_owned(), rows.iter().map(|row| value(&row[k])).collect())
    };
    Ok(header.iter().enumerate().filter(|(_, name)| is_read(name)).map(column).collect())
}

/// A field as a number of the page: null if it is no number, an integer if it is whole, otherwise
/// with seven significant digits.
fn number(field: &str) -> Value {
    let Some(x) = field.parse::<f64>().ok().filter(|x| x.is_finite()) else { return Value::Null };
    if x == x.trunc() && x.abs() < 9.0e15 {
        return json!(x as i64);
    }
    format!("{x:.6e}").parse::<f64>().map_or(Value::Null, Value::from)
}
