//! Tables and charts of a part of the benchmark, as plain data.

use crate::chart::Chart;
use clastic::output::csv_file::{Field, Row};

/// A cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A text.
    Text(String),
    /// A count.
    Count(u64),
    /// A number; an empty field if it is not finite.
    Number(f64),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Count(u64::from(count))
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        Self::Number(number.unwrap_or(f64::NAN))
    }
}

/// A table: a CSV file and, shortened, a part of the summary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Name of the CSV file, without its ending.
    pub name: String,
    /// What it shows, one line.
    pub title: String,
    /// Headings: names of the CSV columns, with units.
    pub columns: Vec<&'static str>,
    /// Rows.
    pub rows: Vec<Vec<Cell>>,
    /// Whether the summary has it too.
    pub in_summary: bool,
}

impl Table {
    /// An empty table that goes into the summary.
    #[must_use]
    pub fn new(name: &str, title: &str, columns: &[&'static str]) -> Self {
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            columns: columns.to_vec(),
            rows: Vec::new(),
            in_summary: true,
        }
    }

    /// The whole table as CSV.
    #[must_use]
    pub fn csv(&self) -> String {
        let header = Row::default().and(self.columns.iter().copied());
        fn field(cell: &Cell) -> Field<'_> {
            match cell {
                Cell::Text(text) => text.as_str().into(),
                Cell::Count(count) => (*count).into(),
                Cell::Number(number) => Some(*number).filter(|x| x.is_finite()).into(),
            }
        }
        let rows = self.rows.iter().map(|cells| Row::default().and(cells.iter().map(field)).line());
        std::iter::once(header.line()).chain(rows).collect()
    }

    /// The table in Markdown, with aligned columns.
    #[must_use]
    pub fn markdown(&self) -> String {
        let texts: Vec<Vec<String>> = std::iter::once(
            self.columns.iter().map(|name| name.replace('_', " ")).collect::<Vec<_>>(),
        )
        .chain(self.rows.iter().map(|row| row.iter().map(short).collect()))
        .collect();
        let widths: Vec<usize> = (0..self.columns.len())
            .map(|k| texts.iter().map(|row| row[k].chars().count()).max().unwrap_or(0).max(3))
            .collect();
        let right: Vec<bool> = (0..self.columns.len())
            .map(|k| !self.rows.iter().any(|row| matches!(row[k], Cell::Text(_))))
            .collect();
        let mut out = String::new();
        for (i, row) in texts.iter().enumerate() {
            for (k, text) in row.iter().enumerate() {
                let w = widths[k];
                out += &if right[k] { format!("| {text:>w$} ") } else { format!("| {text:<w$} ") };
            }
            out += "|\n";
            if i == 0 {
                for (k, w) in widths.iter().enumerate() {
                    let line = "-".repeat(w + 1);
                    out += &if right[k] { format!("|{line}:") } else { format!("|{line}-") };
                }
                out += "|\n";
            }
        }
        out
    }
}

/// A cell for a reader: three digits.
fn short(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Count(count) => count.to_string(),
        Cell::Number(x) if !x.is_finite() => String::new(),
        Cell::Number(0.0) => "0".to_owned(),
        Cell::Number(x) => {
            let digits = 2 - x.abs().log10().floor() as i32;
            if (-3..=5).contains(&digits) {
                format!("{x:.*}", digits.max(0) as usize)
            } else {
                format!("{x:.1e}")
            }
        }
    }
}

/// Results of a part of the benchmark.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Name.
    pub name: &'static str,
    /// What was done and how to read it: paragraphs.
    pub text: String,
    /// Tables.
    pub tables: Vec<Table>,
    /// Charts with the names of their files, without ending.
    pub(crate) charts: Vec<(String, Chart)>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_csv_and_markdown() {
        let mut table = Table::new("t", "a table", &["scene", "time_ms", "rows"]);
        table.rows.push(vec!["a, b".into(), 0.123_456.into(), 12_usize.into()]);
        table.rows.push(vec!["c".into(), None.into(), 3_usize.into()]);
        assert_eq!(table.csv(), "scene,time_ms,rows\n\"a, b\",0.123456,12\nc,,3\n");
        assert_eq!(
            table.markdown(),
            "| scene | time ms | rows |\n|-------|--------:|-----:|\n| a, b  |   0.123 |   12 |\n| c     |         |    3 |\n"
        );
    }

    #[test]
    fn numbers_have_three_digits() {
        let found = [0.0, 1234.5, 12.34, 0.012_345, 1.5e-7, -2.0].map(|x| short(&Cell::Number(x)));
        assert_eq!(found, ["0", "1234", "12.3", "0.0123", "1.5e-7", "-2.00"]);
    }
}
