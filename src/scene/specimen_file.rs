//! Stored specimens: CSV with the columns `x_m`, `y_m`, `radius_m` and optionally `material` and
//! `group`, in any order. Other columns of `final_particles.csv` and of frames are permitted and
//! ignored.
//!
//! Lines that begin with `#` are comments. Names of materials contain no commas or quotes.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::coincident::coincident;
use super::files::{decode, read_at_most};
use super::limits::{MAX_NUMBER, MAX_PARTICLES, MIN_NUMBER};
pub use super::stored_state::{ReadError, StoredParticle, StoredSpecimen};
use crate::text::diagnostic::{Finding, Placed, SceneErrors, line_and_column};
use crate::text::edited::EditedText;

/// Maximum size of the file, bytes: that of `MAX_PARTICLES` rows with all digits.
const MAX_BYTES: u64 = 500_000_000;

const COLUMNS: [&str; 4] = ["x_m", "y_m", "radius_m", "material"];

/// Column with the name of a group, which selections take; empty for a particle of none.
const GROUP: &str = "group";

/// Columns of the engine's own files that are ignored. A specimen begins at rest and free of
/// stress, with particles numbered row by row.
const NOT_READ: [&str; 4] = ["id", "rotation_rad", "ux_m", "uy_m"];

/// Reads a stored specimen.
pub fn read(path: &Path) -> Result<StoredSpecimen, ReadError> {
    let refuse = |why: &str| ReadError::File(format!("cannot read `{}`: {why}", path.display()));
    let bytes = read_at_most(path, MAX_BYTES).map_err(|error| refuse(&error.to_string()))?;
    let Some(bytes) = bytes else {
        return Err(refuse(&format!("it has more than {} MB", MAX_BYTES / 1_000_000)));
    };
    let mut reading = Reading::default();
    let text = decode(bytes, "save it as UTF-8").unwrap_or_else(|(text, placed)| {
        reading.placed.push(placed);
        text
    });
    if reading.placed.is_empty() {
        reading.text(&text);
        let disks: Vec<_> = reading.rows.iter().map(|row| (row.x, row.y, row.r)).collect();
        for (earlier, later) in coincident(&disks) {
            let (line, _) = line_and_column(&text, reading.starts[earlier]);
            let message = format!("the same place as the particle of line {line}");
            reading.note(reading.starts[later], "x_m", &message, "leave one of them out");
        }
    }
    if reading.placed.is_empty() {
        Ok(StoredSpecimen { groups: reading.groups, ..StoredSpecimen::of(reading.rows) })
    } else {
        Err(ReadError::Rows(SceneErrors::new(path, &EditedText::of(&text), reading.placed)))
    }
}

/// Writes a stored specimen. Numbers are written so that reading gives them back exactly.
pub fn write(path: &Path, rows: &[StoredParticle]) -> io::Result<()> {
    let names = || rows.iter().filter_map(|row| row.material.as_deref());
    let unfit = |name: &&str| name.contains([',', '"', '\n', '\r']) || name.trim() != *name;
    if let Some(name) = names().find(unfit) {
        let message = format!("material `{name}` does not fit into a stored specimen");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let columns = if names().next().is_some() { &COLUMNS[..] } else { &COLUMNS[..3] };
    let mut file = BufWriter::new(fs::File::create(path)?);
    writeln!(file, "{}", columns.join(","))?;
    for StoredParticle { x, y, r, material } in rows {
        write!(file, "{x:?},{y:?},{r:?}")?;
        if columns.len() == COLUMNS.len() {
            write!(file, ",{}", material.as_deref().unwrap_or_default())?;
        }
        writeln!(file)?;
    }
    file.flush()
}

/// Columns of a file that describe a particle.
#[derive(Clone, Copy)]
struct Columns {
    /// Number of columns of the file.
    number: usize,
    /// Indices of `x_m`, `y_m` and `radius_m`.
    numbers: [usize; 3],
    material: Option<usize>,
    group: Option<usize>,
}

impl Columns {
    /// Columns of a header, or its mistake.
    fn of(header: &[&str]) -> Result<Self, &'static str> {
        let known =
            |name: &&str| COLUMNS.contains(name) || NOT_READ.contains(name) || *name == GROUP;
        if !header.iter().all(known) {
            return Err("unknown columns");
        }
        if header.iter().enumerate().any(|(k, name)| header[..k].contains(name)) {
            return Err("a column is given twice in");
        }
        let place = |name: &str| header.iter().position(|found| *found == name);
        let numbers = [place(COLUMNS[0]), place(COLUMNS[1]), place(COLUMNS[2])];
        let [Some(x), Some(y), Some(r)] = numbers else {
            return Err("`x_m`, `y_m` or `radius_m` is missing in the columns");
        };
        let (material, group) = (place(COLUMNS[3]), place(GROUP));
        Ok(Self { number: header.len(), numbers: [x, y, r], material, group })
    }
}

#[derive(Default)]
struct Reading {
    rows: Vec<StoredParticle>,
    groups: Vec<Option<String>>,
    /// Byte at which each row begins.
    starts: Vec<usize>,
    placed: Vec<Placed>,
}

impl Reading {
    fn note(&mut self, at: usize, column: &str, message: &str, help: &str) {
        self.placed.push(Placed { at, finding: Finding::new(column, message, help) });
    }

    fn text(&mut self, text: &str) {
        let mut at = 0;
        let mut columns = None;
        for whole in text.split_inclusive('\n') {
            let start = at;
            at += whole.len();
            let line = whole.trim_end().trim_start_matches('\u{feff}');
            if line.trim().is_empty() || line.starts_with('#') {
                continue;
            }
            let fields: Vec<_> = line.split(',').map(str::trim).collect();
            let Some(columns) = columns else {
                match Columns::of(&fields) {
                    Ok(found) => columns = Some(found),
                    Err(message) => {
                        let message = format!("{message} `{line}`");
                        let help = "the first line is `x_m,y_m,radius_m`, and optionally `material` and \
                                    `group` after it";
                        return self.note(start, "", &message, help);
                    }
                }
                continue;
            };
            if self.rows.len() as u64 == MAX_PARTICLES {
                let message = format!("more than {MAX_PARTICLES} particles");
                return self.note(start, "", &message, "take a smaller specimen");
            }
            if fields.len() == columns.number {
                self.row(line, start, &fields, columns);
            } else {
                let message = format!("{} values (`{line}`)", fields.len());
                let help = format!("this file has {} columns", columns.number);
                self.note(start, "", &message, &help);
            }
        }
        if columns.is_none() {
            self.note(0, "", "no header", "the first line is `x_m,y_m,radius_m`");
        } else if self.rows.is_empty() && self.placed.is_empty() {
            let help = "give every particle a line below the header, as in `0.0,0.005,0.005`";
            self.note(text.len(), "", "no particles: only a header", help);
        }
    }

    fn row(&mut self, line: &str, start: usize, fields: &[&str], columns: Columns) {
        let before = self.placed.len();
        let mut numbers = [0.0; 3];
        for (i, number) in numbers.iter_mut().enumerate() {
            let field = fields[columns.numbers[i]];
            // Each field is found by the comma before it, so that equal fields keep their places.
            let commas = line.match_indices(',').map(|(comma, _)| comma + 1);
            let at = std::iter::once(0).chain(commas).nth(columns.numbers[i]).unwrap_or_default();
            let column = at + line.get(at..).and_then(|rest| rest.find(field)).unwrap_or_default();
            let is_radius = i == 2;
            let message = match field.parse::<f64>() {
                Ok(value) if !value.is_finite() => format!("not finite ({value})"),
                Ok(value) if value.abs() > MAX_NUMBER => format!("too large ({value:?})"),
                Ok(value) if is_radius && value <= 0.0 => format!("not greater than 0 ({value:?})"),
                Ok(value) if is_radius && value < MIN_NUMBER => format!("too small ({value:?})"),
                Ok(value) => {
                    *number = value;
                    continue;
                }
                Err(_) => format!("not a number (`{field}`)"),
            };
            let help = if is_radius { "give a radius in m" } else { "give a number in m" };
            self.note(start + column, COLUMNS[i], &message, help);
        }
        if self.placed.len() == before {
            let [x, y, r] = numbers;
            let text = |column: Option<usize>| {
                column.map(|k| fields[k].to_owned()).filter(|name| !name.is_empty())
            };
            let material = text(columns.material);
            if columns.group.is_some() {
                self.groups.push(text(columns.group));
            }
            self.rows.push(StoredParticle { x, y, r, material });
            self.starts.push(start);
        }
    }
}
