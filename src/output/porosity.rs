//! Porosity of a specimen.

use std::collections::BTreeSet;

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::observation::{Measures, StrainMeasure};
use clastic_components::wall::Wall;

use crate::frames::mesh::triangles;

use super::prepared::Prepared;
use crate::run::disks::{Disks, ends};
use crate::scene::StoredParticle;

/// Porosity at the start of the reference stage: one minus the area of the disks over that of the
/// specimen, which is that of the periodic cell. Without a cell an extent of the specimen is the
/// distance between the two walls of a strain measure, and without such walls that of the box
/// around the disks. `None` without disks.
pub fn porosity(measures: &Measures, walls: &Query<&Wall>, start: &Prepared) -> Option<f64> {
    if start.cell_area.is_some() {
        return in_cell_or_box(start);
    }
    let start = &start.rows;
    let normal = |measure: &Option<StrainMeasure>| match measure {
        Some(StrainMeasure::Walls(wall, _)) => walls.get(*wall).ok().map(Wall::inward),
        _ => None,
    };
    let (axial, lateral) = (normal(&measures.axial_strain), normal(&measures.lateral_strain));
    let axis = axial.or_else(|| lateral.map(DVec2::perp)).unwrap_or(DVec2::Y);
    let [height, width] = measures.reference.unwrap_or([f64::NAN; 2]);
    let height = if axial.is_some() { height } else { extent(start, axis)? };
    let width = if lateral.is_some() { width } else { extent(start, axis.perp())? };
    Some(1.0 - total(start) / (height * width)).filter(|p| p.is_finite())
}

/// Porosity of the periodic cell, or without one within the axis-aligned box around the disks; `None`
/// without disks.
pub(crate) fn in_cell_or_box(packing: &Prepared) -> Option<f64> {
    let disks = &packing.rows;
    let in_box = || Some(extent(disks, DVec2::X)? * extent(disks, DVec2::Y)?);
    Some(1.0 - total(disks) / packing.cell_area.or_else(in_box)?)
}

/// Porosity within the [triangles] between the centres of neighbouring disks: that of a specimen
/// whose outline was cut, so that walls and boxes around it enclose voids that are not part of it.
/// A disk fills of a triangle the sector between two sides, less the segment that lies beyond the
/// outline. `None` without triangles.
pub fn within(disks: &[StoredParticle]) -> Option<f64> {
    let all = disks.iter().enumerate();
    let triangles = triangles(all.map(|(row, disk)| (row, place(disk), disk.r)));
    let side = |a: usize, b: usize| (a.min(b), a.max(b));
    // The sides of one triangle alone.
    let mut outline = BTreeSet::new();
    for [a, b, c] in &triangles {
        for side in [side(*a, *b), side(*b, *c), side(*c, *a)] {
            if !outline.insert(side) {
                outline.remove(&side);
            }
        }
    }
    let (mut filled, mut area) = (0.0, 0.0);
    for rows in triangles {
        let corners = rows.map(|row| place(&disks[row]));
        let double = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]).abs();
        area += 0.5 * double;
        for (k, row) in rows.into_iter().enumerate() {
            let [i, j] = [1, 2].map(|next| (k + next) % 3);
            let [a, b] = [corners[i] - corners[k], corners[j] - corners[k]];
            let r = disks[row].r;
            filled += 0.5 * libm::atan2(double, a.dot(b)) * r.powi(2);
            let height = double / a.distance(b);
            if height < r && outline.contains(&side(rows[i], rows[j])) {
                let half = (r * r - height * height).sqrt();
                filled -= r * r * libm::atan2(half, height) - height * half;
            }
        }
    }
    (area > 0.0).then(|| 1.0 - filled / area)
}

fn place(disk: &StoredParticle) -> DVec2 {
    DVec2::new(disk.x, disk.y)
}

/// Total area of the disks, m^2.
pub(super) fn total(disks: &[StoredParticle]) -> f64 {
    Disks::of(disks.iter().map(|disk| disk.r)).area
}

/// Extent of the disks along a direction, m.
pub(super) fn extent(disks: &[StoredParticle], axis: DVec2) -> Option<f64> {
    let disks = disks.iter().map(|disk| (place(disk).dot(axis), disk.r));
    ends(disks).map(|(low, high)| high - low)
}

#[cfg(test)]
mod tests {
    use bevy_ecs::system::RunSystemOnce as _;

    use super::*;

    fn disk(x: DVec2, r: f64) -> StoredParticle {
        StoredParticle { x: x.x, y: x.y, r, material: None }
    }

    fn of(rows: Vec<StoredParticle>, cell_area: Option<f64>) -> Option<f64> {
        let prepared = Prepared { rows, cell_area };
        let mut world = World::new();
        world.init_resource::<Measures>();
        let measure = move |measures: Res<Measures>, walls: Query<&Wall>| {
            porosity(&measures, &walls, &prepared)
        };
        world.run_system_once(measure).ok().flatten()
    }

    /// The densest lattice has a porosity of 1 - pi/(2 sqrt(3)), whatever outline is cut out of it.
    #[test]
    fn a_disk_that_is_cut_out_of_a_lattice() {
        let place = |k: i32| {
            let (row, column) = (k / 40, k % 40);
            DVec2::new(
                2.0 * f64::from(column) + f64::from(row % 2),
                3.0_f64.sqrt() * f64::from(row),
            )
        };
        let expected = 1.0 - std::f64::consts::PI / 12.0_f64.sqrt();
        // Three disks in a row on the outline make a triangle without area by round-off of their places.
        for (radius, off) in [(25.3, 0.0), (25.3, 0.007), (11.0, 0.3), (17.0, 0.1)] {
            let inside = |x: &DVec2| x.distance(DVec2::splat(35.0 + off)) < radius;
            let all = (0..1600).map(|k| place(k) * 0.1 + DVec2::splat(off));
            let cut: Vec<_> = all.filter(|x| inside(&(*x * 10.0))).map(|x| disk(x, 0.1)).collect();
            let found = within(&cut).unwrap_or(f64::NAN);
            assert!((found - expected).abs() < 1e-9, "{found} within {radius}");
        }
        assert_eq!(within(&[]), None);
    }

    #[test]
    fn one_disk_in_its_box_or_cell() {
        let one = vec![disk(DVec2::ONE, 0.5)];
        let quarter = 0.25 * std::f64::consts::PI;
        for (cell, area) in [(None, 1.0), (Some(4.0), 4.0)] {
            let found = of(one.clone(), cell).unwrap_or(f64::NAN);
            assert!((found - (1.0 - quarter / area)).abs() < 1e-15, "{found}");
        }
        assert_eq!(of(Vec::new(), None), None);
    }
}
