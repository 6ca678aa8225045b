//! VTK XML files of poly data (`.vtp`): points with fields, or lines with fields.
//!
//! Arrays are raw little-endian values in base64, each after its length in bytes as `UInt64`. They
//! read back to the bit, in a quarter of the space of text.
//! (<https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>)

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

pub type Field = (&'static str, Values);

/// Points or lines with fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PolyData {
    /// Points, m.
    pub points: Vec<[f64; 3]>,
    /// Pairs of points that are lines; without lines every point is a vertex.
    pub lines: Vec<[i64; 2]>,
    pub of_points: Vec<Field>,
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
        let one = " NumberOfTuples=\"1\"";
        let time = array("TimeValue", &Values::Scalars(vec![time]), one);
        let cell = cell.map(|cell| array("cell_m", &Values::Vectors(vec![cell]), one));
        let of_file = time + &cell.unwrap_or_default();
        let points = self.points.len();
        let (element, cells, size, [vertices, lines]) = match self.lines.len() {
            0 => ("Verts", (0..points as i64).collect::<Vec<_>>(), 1, [points, 0]),
            lines => ("Lines", self.lines.iter().flatten().copied().collect(), 2, [0, lines]),
        };
        let ends = (1..=(cells.len() / size) as i64).map(|cell| cell * size as i64).collect();
        let cells = [("connectivity", Values::Counts(cells)), ("offsets", Values::Counts(ends))];
        let parts: [(_, &[Field]); 4] = [
            ("PointData", &self.of_points),
            ("CellData", &self.of_lines),
            ("Points", &[("Points", Values::Vectors(self.points.clone()))]),
            (element, &cells),
        ];
        let parts = parts.map(|(element, fields)| {
            let arrays: String =
                fields.iter().map(|(name, values)| array(name, values, "")).collect();
            format!("<{element}>\n{arrays}</{element}>\n")
        });
        format!(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n{of_file}</FieldData>\n\
             <Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" \
             NumberOfLines=\"{lines}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n{}</Piece>\n\
             </PolyData>\n</VTKFile>\n",
            parts.concat()
        )
    }
}

fn array(name: &str, values: &Values, more: &str) -> String {
    let (kind, width, bytes): (_, _, Vec<u8>) = match values {
        Values::Scalars(v) => ("Float64", 1, v.iter().flat_map(|x| x.to_le_bytes()).collect()),
        Values::Vectors(v) => {
            ("Float64", 3, v.iter().flatten().flat_map(|x| x.to_le_bytes()).collect())
        }
        Values::Counts(v) => ("Int64", 1, v.iter().flat_map(|x| x.to_le_bytes()).collect()),
    };
    let mut raw = (bytes.len() as u64).to_le_bytes().to_vec();
    raw.extend(bytes);
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\"{more} \
         format=\"binary\">{}</DataArray>\n",
        BASE64_STANDARD.encode(&raw)
    )
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
