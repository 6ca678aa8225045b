//! VTK XML files of poly data (`.vtp`): points with fields, or lines with fields.
//!
//! Arrays are raw little-endian values in base64, each after its length in bytes as `UInt64`. They
//! read back to the bit, in a quarter of the space of text.
//! (<https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>)

use std::fmt::Write as _;

use base64::prelude::{BASE64_STANDARD, Engine as _};

/// Values of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// One number a row.
    Scalars(Vec<f64>),
    /// Three numbers a row.
    Vectors(Vec<[f64; 3]>),
    /// Whole numbers.
    Counts(Vec<i64>),
}

/// A field, by its name.
pub type Field = (&'static str, Values);

/// Points or lines with fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolyData {
    /// Points, m.
    pub points: Vec<[f64; 3]>,
    /// Pairs of points that are lines; without lines every point is a vertex.
    pub lines: Vec<[i64; 2]>,
    /// Fields of the points.
    pub of_points: Vec<Field>,
    /// Fields of the lines.
    pub of_lines: Vec<Field>,
}

impl PolyData {
    /// Adds a line between two points of its own.
    pub fn line(&mut self, a: [f64; 2], b: [f64; 2]) {
        let first = self.points.len() as i64;
        self.points.extend([a, b].map(|[x, y]| [x, y, 0.0]));
        self.lines.push([first, first + 1]);
    }

    /// The file, for a moment in s, with the width, height and tilt of the periodic cell in m, if
    /// there is one.
    pub fn encode(&self, time: f64, cell: Option<[f64; 3]>) -> String {
        let are_lines = !self.lines.is_empty();
        let points = self.points.len();
        let (vertices, lines) = if are_lines { (0, self.lines.len()) } else { (points, 0) };
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n",
        );
        let time = Values::Scalars(vec![time]);
        array(&mut text, "TimeValue", &time, " NumberOfTuples=\"1\"");
        if let Some(cell) = cell {
            let cell = Values::Vectors(vec![cell]);
            array(&mut text, "cell_m", &cell, " NumberOfTuples=\"1\"");
        }
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "</FieldData>\n<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" \
             NumberOfLines=\"{lines}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">"
        );
        for (element, fields) in [("PointData", &self.of_points), ("CellData", &self.of_lines)] {
            let _ = writeln!(text, "<{element}>");
            for (name, values) in fields {
                array(&mut text, name, values, "");
            }
            let _ = writeln!(text, "</{element}>");
        }
        text.push_str("<Points>\n");
        array(&mut text, "Points", &Values::Vectors(self.points.clone()), "");
        text.push_str("</Points>\n");
        let (element, cells, size) = match are_lines {
            true => ("Lines", self.lines.iter().flatten().copied().collect(), 2),
            false => ("Verts", (0..points as i64).collect::<Vec<_>>(), 1),
        };
        let ends = (1..=(cells.len() / size) as i64).map(|cell| cell * size as i64).collect();
        let _ = writeln!(text, "<{element}>");
        array(&mut text, "connectivity", &Values::Counts(cells), "");
        array(&mut text, "offsets", &Values::Counts(ends), "");
        let _ = writeln!(text, "</{element}>\n</Piece>\n</PolyData>\n</VTKFile>");
        text
    }
}

fn array(text: &mut String, name: &str, values: &Values, more: &str) {
    let (kind, width, bytes): (_, _, Vec<u8>) = match values {
        Values::Scalars(v) => ("Float64", 1, v.iter().flat_map(|x| x.to_le_bytes()).collect()),
        Values::Vectors(v) => {
            ("Float64", 3, v.iter().flatten().flat_map(|x| x.to_le_bytes()).collect())
        }
        Values::Counts(v) => ("Int64", 1, v.iter().flat_map(|x| x.to_le_bytes()).collect()),
    };
    let mut raw = (bytes.len() as u64).to_le_bytes().to_vec();
    raw.extend(bytes);
    let _ = writeln!(
        text,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\"{more} \
         format=\"binary\">{}</DataArray>",
        BASE64_STANDARD.encode(&raw)
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_vertices_and_lines_have_their_points() {
        let mut data = PolyData { points: vec![[0.0; 3]; 3], ..Default::default() };
        let text = data.encode(0.0, None);
        assert!(!text.contains("cell_m"));
        assert!(text.contains("NumberOfPoints=\"3\" NumberOfVerts=\"3\" NumberOfLines=\"0\""));
        data.line([0.0, 1.0], [2.0, 3.0]);
        let text = data.encode(0.0, Some([1.0, 2.0, 0.5]));
        assert!(text.contains("Name=\"cell_m\" NumberOfComponents=\"3\" NumberOfTuples=\"1\""));
        assert!(text.contains("NumberOfPoints=\"5\" NumberOfVerts=\"0\" NumberOfLines=\"1\""));
        assert_eq!(data.lines, [[3, 4]]);
    }
}
