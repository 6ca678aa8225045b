//! Writes the results of the parts: `NAME.csv`, `NAME.svg` and `NAME.md` a part, `summary.md` from
//! all parts that the directory holds, and the passages of a page that are copies of such files.

use std::fs;
use std::io;
use std::path::Path;

use clastic::output::OutputError;
use clastic::output::atomic::write_atomic;

use crate::Part;
use crate::machine::describe;

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

/// Joins the existing pages of all parts to one, `summary.md`.
///
/// # Errors
/// Where a file cannot be read or written.
pub fn write_summary(directory: &Path) -> Result<(), OutputError> {
    let mut out = "# Benchmark: run time against error\n\nWritten by `clastic_bench`.\n".to_owned();
    for name in PARTS {
        let path = directory.join(format!("{name}.md"));
        if path.exists() {
            out += "\n";
            out += &fs::read_to_string(&path).map_err(OutputError::at(&path))?;
        }
    }
    write_atomic(&directory.join("summary.md"), out)
}

/// Updates a Markdown page: the text between the lines `<!-- begin NAME.md -->` and `<!-- end
/// NAME.md -->` becomes the content of that file in `directory`, with links to its pictures.
/// Passages whose file is missing do not change.
///
/// # Errors
/// Where a file cannot be read or written, or a passage has no end.
pub fn update_page(page: &Path, directory: &Path) -> Result<(), OutputError> {
    let text = fs::read_to_string(page).map_err(OutputError::at(page))?;
    let beside = page.parent().unwrap_or(Path::new(""));
    let way = directory.strip_prefix(beside).unwrap_or(directory).display();
    let mut out = String::new();
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        out += line;
        out += "\n";
        let name = line.strip_prefix("<!-- begin ").and_then(|rest| rest.strip_suffix(" -->"));
        let Some(name) = name else { continue };
        let end = format!("<!-- end {name} -->");
        let mut before = String::new();
        let closed = lines.by_ref().map(|(_, line)| line).any(|line| {
            if line != end {
                before += line;
                before += "\n";
            }
            line == end
        });
        if !closed {
            let message = format!("line {}: no line `{end}` follows; add it", number + 1);
            let error = io::Error::new(io::ErrorKind::InvalidData, message);
            return Err(OutputError::at(page)(error));
        }
        let path = directory.join(name);
        if path.exists() {
            let content = fs::read_to_string(&path).map_err(OutputError::at(&path))?;
            out += &content.replace("](", &format!("]({way}/"));
        } else {
            out += &before;
        }
        out += &end;
        out += "\n";
    }
    write_atomic(page, out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Table;

    #[test]
    fn the_summary_holds_all_parts_that_are_there() -> Result<(), Box<dyn std::error::Error>> {
        let dir = tempfile::tempdir()?;
        for name in ["theta", "precision"] {
            let tables = vec![Table::new(name, "title", &["a"])];
            let part = Part { name, text: format!("On {name}."), tables, ..Default::default() };
            write_part(dir.path(), &part, "clastic_bench")?;
        }
        write_summary(dir.path())?;
        let text = fs::read_to_string(dir.path().join("summary.md"))?;
        let places = ["On precision.", "On theta."].map(|part| text.find(part));
        assert!(places[0].is_some() && places[0] < places[1], "{text}");
        assert_eq!(fs::read_to_string(dir.path().join("theta.csv"))?, "a\n");
        Ok(())
    }

    #[test]
    fn a_page_is_brought_up_to_date() -> Result<(), Box<dyn std::error::Error>> {
        let dir = tempfile::tempdir()?;
        let (page, results) = (dir.path().join("page.md"), dir.path().join("bench"));
        fs::create_dir(&results)?;
        fs::write(results.join("a.md"), "new\n![p](p.svg)\n")?;
        let passage =
            |name: &str, text: &str| format!("<!-- begin {name} -->\n{text}<!-- end {name} -->\n");
        let of = |text: &str| {
            format!("# Page\n{}{}End.\n", passage("a.md", text), passage("b.md", "b\n"))
        };
        fs::write(&page, of("old\n"))?;
        for _ in 0..2 {
            update_page(&page, &results)?;
            assert_eq!(fs::read_to_string(&page)?, of("new\n![p](bench/p.svg)\n"));
        }
        fs::write(&page, "# Page\n<!-- begin a.md -->\n")?;
        let error = update_page(&page, &results).map_err(|e| e.to_string());
        assert!(error.is_err_and(|e| e.contains("line 2: no line `<!-- end a.md -->`")));
        Ok(())
    }
}
