//! Key results of several runs as a table for a terminal.

use serde_json::Value;

/// Columns of the table: name in `run.json`, heading, factor, digits.
const COLUMNS: [(&str, &str, f64, usize); 6] = [
    ("youngs_modulus_pa", "E, MPa", 1e-6, 3),
    ("first_crack_stress_pa", "first crack, MPa", 1e-6, 4),
    ("peak_stress_pa", "peak, MPa", 1e-6, 4),
    ("strain_at_peak", "at strain, %", 100.0, 4),
    ("limit_load_pa", "limit load, MPa", 1e-6, 4),
    ("porosity", "porosity", 1.0, 4),
];

/// The table of runs, given by their names and the content of their `run.json`.
pub fn table(runs: &[(String, Value)]) -> String {
    let width = runs.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max(3);
    let status =
        |record: &Value| record["outcome"]["status"].as_str().unwrap_or("not ended").to_owned();
    let mut text = format!("{:width$}", "run");
    for (_, heading, ..) in COLUMNS {
        text += &format!("  {heading:>16}");
    }
    text += "  outcome";
    for (name, record) in runs {
        text += &format!("\n{name:width$}");
        for (key, _, factor, digits) in COLUMNS {
            let value = record["results"][key].as_f64();
            let value =
                value.map_or_else(|| "-".to_owned(), |v| format!("{:.digits$}", v * factor));
            text += &format!("  {value:>16}");
        }
        text += &format!("  {}", status(record));
        if let Some(capped) = record["capped_increments"].as_u64().filter(|n| *n > 0) {
            text += &format!(", {capped} of {} increments capped", record["increments"]);
        }
    }
    if runs.iter().any(|(_, record)| status(record) == "running") {
        text += "\nrunning: not at its end yet, or killed";
    }
    text
}
