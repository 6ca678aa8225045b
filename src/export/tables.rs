//! The files of a frame as points and lines with fields.

use glam::DVec2;

use clastic_components::cell;

use super::vtp::{PolyData, Values};
use crate::frames::{Frame, NONE};

/// The kinds of files of a frame.
pub fn of(frame: &Frame) -> [(&'static str, PolyData); 6] {
    [
        ("bodies", bodies(frame)),
        ("contacts", contacts(frame)),
        ("bonds", bonds(frame)),
        ("walls", walls(frame)),
        ("cracks", cracks(frame)),
        ("membranes", membranes(frame)),
    ]
}

fn bodies(frame: &Frame) -> PolyData {
    let bodies = &frame.bodies;
    let numbers = |of: &[f32]| Values::Scalars(of.iter().map(|x| f64::from(*x)).collect());
    let vectors = |of: &[[f32; 2]]| {
        Values::Vectors(of.iter().map(|[x, y]| [f64::from(*x), f64::from(*y), 0.0]).collect())
    };
    let counts = |of: &[u32]| Values::Counts(of.iter().map(|x| i64::from(*x)).collect());
    let stress = |k: usize| {
        Values::Scalars(bodies.stress_pa.iter().map(|stress| f64::from(stress[k])).collect())
    };
    let point = |row: usize| {
        let [x, y] = frame.centre(row);
        [x, y, 0.0]
    };
    PolyData {
        points: (0..bodies.id.len()).map(point).collect(),
        of_points: vec![
            ("id", counts(&bodies.id)),
            ("radius_m", numbers(&bodies.radius_m)),
            ("displacement_m", vectors(&bodies.displacement_m)),
            ("rotation_rad", numbers(&bodies.rotation_rad)),
            ("velocity_m_s", vectors(&bodies.velocity_m_s)),
            ("angular_velocity_rad_s", numbers(&bodies.angular_velocity_rad_s)),
            ("material", counts(&bodies.material)),
            ("stress_xx_pa", stress(0)),
            ("stress_yy_pa", stress(1)),
            ("stress_xy_pa", stress(2)),
            ("fragment", counts(&bodies.fragment)),
        ],
        ..Default::default()
    }
}

/// Lines with fields of whole numbers and of numbers, row by row.
fn lines<const C: usize, const N: usize>(
    counts: [&'static str; C],
    numbers: [&'static str; N],
    rows: impl Iterator<Item = ([DVec2; 2], [i64; C], [f64; N])>,
) -> PolyData {
    let mut data = PolyData::default();
    let (mut whole, mut others) = (counts.map(|_| Vec::new()), numbers.map(|_| Vec::new()));
    for ([a, b], counts, numbers) in rows {
        data.line(a.to_array(), b.to_array());
        whole.iter_mut().zip(counts).for_each(|(column, count)| column.push(count));
        others.iter_mut().zip(numbers).for_each(|(column, number)| column.push(number));
    }
    data.of_lines.extend(counts.into_iter().zip(whole.map(Values::Counts)));
    data.of_lines.extend(numbers.into_iter().zip(others.map(Values::Scalars)));
    data
}

/// End of a line from disk `a` to body `b`, m: the centre of a disk, the nearest point of a wall. In
/// a periodic cell it is the centre of the image that is nearest to `a`.
fn far_end(frame: &Frame, a: usize, b: u32) -> Option<DVec2> {
    let from = DVec2::from(frame.centre(a));
    let Some(row) = frame.row(b) else { return foot(frame, from, b) };
    let to = DVec2::from(frame.centre(row));
    Some(to + frame.cell_m.map_or(DVec2::ZERO, |cell| cell::shift(cell, to - from)))
}

/// Point of a wall that is nearest to a point, m.
fn foot(frame: &Frame, point: DVec2, wall: u32) -> Option<DVec2> {
    let feet = pieces(frame).filter(|(row, _)| frame.walls.id[*row] == wall);
    let feet = feet.map(|(row, [start, end])| {
        let along = end - start;
        let share = (point - start).dot(along) / along.length_squared();
        start + along * if frame.walls.is_thin[row] { share.clamp(0.0, 1.0) } else { share }
    });
    feet.min_by(|x, y| x.distance(point).total_cmp(&y.distance(point)))
}

/// The straight pieces of the walls with the rows of these.
fn pieces(frame: &Frame) -> impl Iterator<Item = (usize, [DVec2; 2])> + '_ {
    (0..frame.walls.id.len()).flat_map(|row| {
        let line = frame.wall_line(row);
        line.windows(2).map(move |ends| (row, [ends[0].into(), ends[1].into()]))
    })
}

/// Every pair that carries force: from the centre of a to that of b, or to the nearest point of a
/// wall.
fn contacts(frame: &Frame) -> PolyData {
    let pairs = &frame.pairs;
    let line = |k: usize| {
        let [p, q, tau] = [pairs.p_n[k], pairs.q_n[k], pairs.tau_nm[k]].map(f64::from);
        let row = frame.row(pairs.a[k]).filter(|_| p != 0.0 || q != 0.0 || tau != 0.0)?;
        let far = far_end(frame, row, pairs.b[k])?;
        let normal = DVec2::from_angle(pairs.angle_rad[k].into());
        let force = p * normal + q * normal.perp();
        let bond = Some(pairs.bond[k]).filter(|bond| pairs.state[k] == 1 && *bond != NONE);
        let counts = [pairs.a[k].into(), pairs.b[k].into(), bond.map_or(-1, i64::from)];
        let numbers = [p, q, tau, pairs.gap_m[k].into(), normal.x, normal.y, force.x, force.y];
        Some(([frame.centre(row).into(), far], counts, numbers))
    };
    lines(
        ["a", "b", "bond"],
        ["p_n", "q_n", "tau_nm", "gap_m", "normal_x", "normal_y", "force_x_n", "force_y_n"],
        (0..pairs.a.len()).filter_map(line),
    )
}

/// Rows of the bonds, intact or broken, whose bodies are there, by identity: bond, rows of the pair
/// and of the disk a, and the end of the line to b.
fn of_bonds(frame: &Frame) -> Vec<(u32, usize, usize, DVec2)> {
    let pairs = &frame.pairs;
    let rows = (0..pairs.a.len()).filter(|k| pairs.bond[*k] != NONE);
    let bond = |k: usize| {
        let a = frame.row(pairs.a[k])?;
        Some((pairs.bond[k], k, a, far_end(frame, a, pairs.b[k])?))
    };
    let mut bonds: Vec<_> = rows.filter_map(bond).collect();
    bonds.sort_unstable_by_key(|(id, ..)| *id);
    bonds
}

/// States: 0 intact, broken in 1 tension, 2 shear, 3 rolling.
fn bonds(frame: &Frame) -> PolyData {
    let pairs = &frame.pairs;
    let line = |(id, k, a, far): (u32, usize, usize, DVec2)| {
        let state = i64::from(pairs.state[k]) - 1;
        let counts = [id.into(), pairs.a[k].into(), pairs.b[k].into(), state];
        ([frame.centre(a).into(), far], counts, [])
    };
    lines(["id", "a", "b", "state"], [], of_bonds(frame).into_iter().map(line))
}

fn walls(frame: &Frame) -> PolyData {
    let walls = &frame.walls;
    let counts = |row: usize| [walls.id[row].into(), walls.is_thin[row].into()];
    let rows = pieces(frame).map(|(row, ends)| (ends, counts(row), walls.force[row]));
    lines(["id", "is_thin"], ["force_x_n", "force_y_n", "moment_nm"], rows)
}

/// Broken bonds as strokes half-way between the two surfaces, at a right angle to the line that
/// joins the bodies, and as long as the bond was wide: twice the smaller radius, which is the
/// section that its strength counts (formulation, section 3).
fn cracks(frame: &Frame) -> PolyData {
    let pairs = &frame.pairs;
    let broken = of_bonds(frame).into_iter().filter(|(_, k, ..)| pairs.state[*k] > 1);
    let rows = broken.map(|(id, k, a, far)| {
        let centre = DVec2::from(frame.centre(a));
        let radius = |row: usize| f64::from(frame.bodies.radius_m[row]);
        let normal = (far - centre).normalize_or(DVec2::X);
        let (surface, half) = match frame.row(pairs.b[k]) {
            Some(b) => (far - radius(b) * normal, radius(a).min(radius(b))),
            None => (far, radius(a)),
        };
        let middle = 0.5 * (centre + radius(a) * normal + surface);
        let along = half * normal.perp();
        let mode = i64::from(pairs.state[k]) - 1;
        ([middle - along, middle + along], [id.into(), mode], [])
    });
    lines(["bond", "mode"], [], rows)
}

/// The links of the chains.
fn membranes(frame: &Frame) -> PolyData {
    let chains = &frame.membranes;
    let links = |chain: usize| {
        let points = &chains.point_m[chains.points(chain)];
        let back = points.first().filter(|_| chains.is_closed[chain]);
        let next = points.iter().skip(1).chain(back);
        points.iter().zip(next).map(|(a, b)| ([*a, *b].map(DVec2::from), [], []))
    };
    lines([], [], (0..chains.name.len()).flat_map(links))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{FrameBodies, FrameMembranes, FramePairs, FrameWalls};

    /// Three disks of radius 1 in a row above a floor. The first two are bonded, the other bonds
    /// are broken: in shear, and from the floor in tension.
    fn row_of_three() -> Frame {
        let down = -std::f32::consts::FRAC_PI_2;
        Frame {
            bodies: FrameBodies {
                id: vec![0, 1, 2],
                offset_m: vec![[0.0, 1.0], [2.0, 1.0], [4.0, 1.0]],
                radius_m: vec![1.0; 3],
                displacement_m: vec![[0.0; 2]; 3],
                rotation_rad: vec![0.0; 3],
                velocity_m_s: vec![[0.0; 2]; 3],
                angular_velocity_rad_s: vec![0.0; 3],
                material: vec![0; 3],
                group: vec![NONE; 3],
                stress_pa: vec![[0.0; 3]; 3],
                fragment: vec![0; 3],
            },
            pairs: FramePairs {
                a: vec![0, 1, 1, 2],
                b: vec![1, 2, 7, 7],
                bond: vec![0, 1, NONE, 2],
                state: vec![1, 3, 0, 2],
                p_n: vec![2.0, 0.0, 2.0, 0.0],
                q_n: vec![1.0, 0.0, 1.0, 0.0],
                tau_nm: vec![0.0; 4],
                gap_m: vec![0.0; 4],
                angle_rad: vec![0.0, 0.0, down, down],
            },
            walls: FrameWalls {
                id: vec![7],
                name: vec!["floor".to_owned()],
                is_thin: vec![false],
                force: vec![[0.0; 3]],
                first_point: vec![0, 2],
                point_m: vec![[0.0, 0.0], [4.0, 0.0]],
            },
            membranes: FrameMembranes {
                name: vec!["skin".to_owned()],
                is_closed: vec![false],
                first_point: vec![0, 2],
                body: vec![0, 1],
                point_m: vec![[0.0, 1.0], [2.0, 1.0]],
            },
            ..Default::default()
        }
    }

    #[test]
    fn every_kind_has_its_rows() {
        let of_kind = of(&row_of_three()).map(|(_, data)| data);
        let [bodies, contacts, bonds, walls, cracks, membranes] = of_kind;
        let lines = [&contacts, &bonds, &walls, &cracks, &membranes].map(|data| data.lines.len());
        assert_eq!((bodies.points.len(), lines), (3, [2, 3, 1, 2, 1]));
        assert_eq!(membranes.points, [[0.0, 1.0, 0.0], [2.0, 1.0, 0.0]]);
        // The second contact rests on the floor: its line ends there.
        assert_eq!(contacts.points[3], [2.0, 0.0, 0.0]);
        assert_eq!(contacts.points[2], [2.0, 1.0, 0.0]);
        let counts = |of: [i64; 2]| Values::Counts(of.to_vec());
        let numbers = |of: [f64; 2]| Values::Scalars(of.to_vec());
        let expected = [
            ("a", counts([0, 1])),
            ("b", counts([1, 7])),
            ("bond", counts([0, -1])),
            ("p_n", numbers([2.0, 2.0])),
            ("q_n", numbers([1.0, 1.0])),
            ("tau_nm", numbers([0.0, 0.0])),
            ("gap_m", numbers([0.0, 0.0])),
        ];
        assert_eq!(contacts.of_lines[..7], expected);
        let names: Vec<_> = bodies.of_points.iter().map(|(name, _)| *name).collect();
        assert_eq!(names[..3], ["id", "radius_m", "displacement_m"]);
    }

    #[test]
    fn a_pair_across_the_side_of_a_cell_ends_at_the_near_image() {
        let mut frame = row_of_three();
        assert_eq!(far_end(&frame, 0, 2), Some(DVec2::new(4.0, 1.0)));
        frame.cell_m = Some([6.0, 3.0, 1.0]);
        assert_eq!(far_end(&frame, 0, 2), Some(DVec2::new(-2.0, 1.0)));
        assert_eq!(far_end(&frame, 2, 0), Some(DVec2::new(6.0, 1.0)));
        // One row up the images are moved by the tilt.
        frame.bodies.offset_m[1] = [1.5, 4.0];
        assert_eq!(far_end(&frame, 0, 1), Some(DVec2::new(0.5, 1.0)));
    }

    #[test]
    fn cracks_lie_across_their_contacts_and_are_as_long_as_the_bonds_are_wide() {
        let mut frame = row_of_three();
        let cracks = cracks(&frame);
        assert_eq!(cracks.points[..2], [[3.0, 0.0, 0.0], [3.0, 2.0, 0.0]]);
        assert_eq!(cracks.points[2..], [[3.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
        frame.bodies.offset_m[2] = [5.5, 1.0];
        frame.bodies.radius_m[2] = 2.0;
        let points = super::cracks(&frame).points;
        assert_eq!(points[..2], [[3.25, 0.0, 0.0], [3.25, 2.0, 0.0]]);
    }
}
