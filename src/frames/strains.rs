//! Strains of the disks between two frames.

use glam::{DMat2, DVec2};

use super::Frame;
use super::mesh::triangles;

/// A disk at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disk {
    /// Identity.
    pub id: u32,
    /// Centre, m.
    pub position: DVec2,
    /// Radius, m.
    pub radius: f64,
    /// Displacement since the start of the first run, m.
    pub displacement: DVec2,
}

impl Frame {
    /// The particles as strains need them.
    pub fn disks(&self) -> Vec<Disk> {
        let bodies = &self.bodies;
        let disk = |row: usize| Disk {
            id: bodies.id[row],
            position: self.centre(row).into(),
            radius: bodies.radius_m[row].into(),
            displacement: bodies.displacement_m[row].map(f64::from).into(),
        };
        (0..bodies.id.len()).map(disk).collect()
    }
}

/// Strain of the neighbourhood of a disk; contraction is positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    /// Sum of the principal strains.
    pub volumetric: f64,
    /// Difference of the principal strains, the maximum engineering shear strain.
    pub shear: f64,
}

/// Strain of every disk of `now` since `from`, both by identity. The displacement is linear in the
/// triangles of the Delaunay triangulation of the centres in `from`, so that each has one small strain, the
/// symmetric part of its gradient. A disk has the mean of its triangles by area. Triangles with a
/// side across a gap wider than the mean diameter bridge a void or the outline of the specimen and
/// do not count; a disk without a triangle, or that was not there, has no strain.
pub fn strains(now: &[Disk], from: &[Disk]) -> Vec<Option<Strain>> {
    let row = |disk: &Disk| from.binary_search_by_key(&disk.id, |disk| disk.id).ok();
    let before: Vec<Option<&Disk>> = now.iter().map(|disk| Some(&from[row(disk)?])).collect();
    let moved = |row: usize| Some(now[row].displacement - before[row]?.displacement);
    let corners =
        before.iter().enumerate().filter_map(|(row, d)| d.map(|d| (row, d.position, d.radius)));
    // Sum of area times strain (xx, yy, xy) and of the areas, by row.
    let mut sums = vec![[0.0; 4]; now.len()];
    for rows in triangles(corners) {
        let [Some(a), Some(b), Some(c)] = rows.map(|row| before[row]) else { continue };
        let [Some(u), Some(v), Some(w)] = rows.map(moved) else { continue };
        let sides = DMat2::from_cols(b.position - a.position, c.position - a.position);
        let area = 0.5 * sides.determinant().abs();
        if !(area > 0.0) {
            continue;
        }
        let gradient = DMat2::from_cols(v - u, w - u) * sides.inverse();
        let [xx, yx] = gradient.x_axis.to_array();
        let [xy, yy] = gradient.y_axis.to_array();
        for row in rows {
            for (sum, value) in sums[row].iter_mut().zip([-xx, -yy, -0.5 * (xy + yx), 1.0]) {
                *sum += area * value;
            }
        }
    }
    let strain = |[xx, yy, xy, area]: [f64; 4]| {
        let [xx, yy, xy] = [xx / area, yy / area, xy / area];
        (area > 0.0).then(|| Strain { volumetric: xx + yy, shear: (xx - yy).hypot(2.0 * xy) })
    };
    sums.into_iter().map(strain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Disks of radius 0.5 on a square grid, displaced by a linear field.
    fn grid(gradient: DMat2) -> Vec<Disk> {
        let disk = |k: u32| {
            let place = DVec2::new(f64::from(k % 7), f64::from(k / 7));
            let displacement = gradient * place;
            Disk { id: k, position: place + displacement, radius: 0.5, displacement }
        };
        (0..49).map(disk).collect()
    }

    #[test]
    fn a_linear_field_has_its_strain_everywhere() {
        let start = grid(DMat2::ZERO);
        // du_x/dx = 0.01, du_y/dy = -0.03, du_x/dy = 0.02.
        let now = grid(DMat2::from_cols(DVec2::new(0.01, 0.0), DVec2::new(0.02, -0.03)));
        for strain in strains(&now, &start) {
            let strain = strain.unwrap();
            assert!((strain.volumetric - 0.02).abs() < 1e-12, "{strain:?}");
            assert!((strain.shear - 0.04_f64.hypot(0.02)).abs() < 1e-12, "{strain:?}");
        }
    }

    #[test]
    fn a_rotation_strains_nothing_and_new_disks_have_no_strain() {
        let start = grid(DMat2::ZERO);
        let mut now = grid(DMat2::from_cols(DVec2::new(0.0, 1e-3), DVec2::new(-1e-3, 0.0)));
        assert!(strains(&now, &start).iter().flatten().all(|s| s.shear < 1e-15));
        now.push(Disk { id: 99, radius: 0.5, ..Default::default() });
        assert_eq!(strains(&now, &start)[49], None);
    }
}
