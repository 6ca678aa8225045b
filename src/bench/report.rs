//! Writes what the parts found: `NAME.csv`, `NAME.svg` and `NAME.md` a part, and `summary.md` from
//! all parts that the directory holds.

use std::fs;
use std::path::Path;

use super::Part;
use super::machine::describe;
use crate::output::OutputError;
use crate::output::atomic::write_atomic;

/// Names of the parts, in the order of the summary.
pub const PARTS: [&str; 6] = ["precision", "increments", "theta", "stages", "size", "threads"];

/// Writes a part: its tables, charts and page.
///
/// # Errors
/// Where a file cannot be written.
pub fn write_part(directory: &Path, part: &Part, command: &str) -> Result<(), OutputError> {
    fs::create_dir_all(directory).map_err(OutputError::at(directory))?;
    for table in &part.tables {
        write_atomic(&directory.join(format!("{}.csv", table.name)), table.csv())?;
    }
    for (name, chart) in &part.charts {
        let path = directory.join(format!("{name}.svg"));
        write_atomic(&path, chart.svg().map_err(OutputError::at(&path))?)?;
    }
    write_atomic(&directory.join(format!("{}.md", part.name)), page(part, command))
}

fn page(part: &Part, command: &str) -> String {
    let mut facts: Vec<String> =
        describe().iter().map(|(name, value)| format!("{name}: {value}")).collect();
    facts.push(format!("command: `{command}`"));
    let mut out = format!("## {}\n\n{}\n\n{}\n", part.name, facts.join("; "), part.text.trim());
    for table in part.tables.iter().filter(|table| table.in_summary) {
        out += &format!("\n**{}** (`{}.csv`)\n\n{}", table.title, table.name, table.markdown());
    }
    for (name, chart) in &part.charts {
        out += &format!("\n![{}]({name}.svg)\n", chart.title);
    }
    out
}

/// Puts the pages of all parts that are there into one, `summary.md`.
///
/// # Errors
/// Where a file cannot be read or written.
pub fn write_summary(directory: &Path) -> Result<(), OutputError> {
    let mut out = "# Benchmark: run time against error\n\nWritten by `clastic bench`.\n".to_owned();
    for name in PARTS {
        let path = directory.join(format!("{name}.md"));
        if path.exists() {
            out += "\n";
            out += &fs::read_to_string(&path).map_err(OutputError::at(&path))?;
        }
    }
    write_atomic(&directory.join("summary.md"), out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::table::Table;

    #[test]
    fn the_summary_holds_all_parts_that_are_there() -> Result<(), Box<dyn std::error::Error>> {
        let dir = tempfile::tempdir()?;
        for name in ["theta", "precision"] {
            let tables = vec![Table::new(name, "title", &["a"])];
            let part = Part { name, text: format!("On {name}."), tables, ..Default::default() };
            write_part(dir.path(), &part, "clastic bench")?;
        }
        write_summary(dir.path())?;
        let text = fs::read_to_string(dir.path().join("summary.md"))?;
        let places = ["On precision.", "On theta."].map(|part| text.find(part));
        assert!(places[0].is_some() && places[0] < places[1], "{text}");
        assert_eq!(fs::read_to_string(dir.path().join("theta.csv"))?, "a\n");
        Ok(())
    }
}
