//! Triangles between the centres of neighbouring disks.

use glam::DVec2;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation as _};

struct Corner {
    row: usize,
    place: Point2<f64>,
    radius: f64,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.place
    }
}

/// Triangles of the Delaunay triangulation of disks, each given by its row, centre and radius, as
/// sorted rows of their corners. Triangles with a side across a gap wider than the mean diameter
/// bridge a void or the outline of the specimen and are left out.
pub fn triangles(disks: impl Iterator<Item = (usize, DVec2, f64)>) -> Vec<[usize; 3]> {
    let corner = |(row, centre, radius): (usize, DVec2, f64)| {
        let place = Point2::new(centre.x, centre.y);
        Corner { row, place, radius }
    };
    let corners: Vec<_> = disks.map(corner).collect();
    let number = corners.len().max(1) as f64;
    let widest = 2.0 * corners.iter().map(|corner| corner.radius).sum::<f64>() / number;
    // Centres are distinct and finite, so that all are inserted.
    let Ok(mesh) = DelaunayTriangulation::<Corner>::bulk_load_stable(corners) else {
        return Vec::new();
    };
    let apart = |[a, b]: [&Corner; 2]| {
        (a.place.x - b.place.x).hypot(a.place.y - b.place.y) - a.radius - b.radius
    };
    let mut triangles: Vec<_> = mesh
        .inner_faces()
        .filter_map(|face| {
            let corners = face.vertices();
            let [a, b, c] = [corners[0].data(), corners[1].data(), corners[2].data()];
            let is_wide = [[a, b], [b, c], [c, a]].into_iter().any(|side| apart(side) > widest);
            (!is_wide).then_some([a.row, b.row, c.row])
        })
        .collect();
    triangles.sort_unstable();
    triangles
}
