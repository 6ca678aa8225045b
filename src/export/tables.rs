//! The files of a moment as points and lines with fields.

use glam::DVec2;

use clastic_components::bond::RuptureMode;

use super::vtp::{Field, PolyData, Values};
use crate::moment::{Disk, Moment};

/// Bodies, contacts, bonds, walls, cracks and membranes, in the order of [`super::KINDS`].
pub fn of(moment: &Moment) -> [PolyData; 6] {
    [
        bodies(moment),
        contacts(moment),
        bonds(moment),
        walls(moment),
        cracks(moment),
        membranes(moment),
    ]
}

fn flat(v: DVec2) -> [f64; 3] {
    [v.x, v.y, 0.0]
}

fn bodies(moment: &Moment) -> PolyData {
    let disks = &moment.disks;
    let numbers = |of: &dyn Fn(&Disk) -> f64| Values::Scalars(disks.iter().map(of).collect());
    let vectors = |of: &dyn Fn(&Disk) -> DVec2| {
        Values::Vectors(disks.iter().map(|disk| flat(of(disk))).collect())
    };
    let counts = |of: &dyn Fn(&Disk) -> u32| {
        Values::Counts(disks.iter().map(|disk| of(disk).into()).collect())
    };
    PolyData {
        points: disks.iter().map(|disk| flat(disk.position)).collect(),
        of_points: vec![
            ("id", counts(&|disk| disk.id)),
            ("radius_m", numbers(&|disk| disk.radius)),
            ("displacement_m", vectors(&|disk| disk.displacement)),
            ("rotation_rad", numbers(&|disk| disk.rotation)),
            ("velocity_m_s", vectors(&|disk| disk.velocity)),
            ("angular_velocity_rad_s", numbers(&|disk| disk.spin)),
            ("material", counts(&|disk| disk.material)),
            ("stress_xx_pa", numbers(&|disk| disk.stress[0])),
            ("stress_yy_pa", numbers(&|disk| disk.stress[1])),
            ("stress_xy_pa", numbers(&|disk| disk.stress[2])),
            ("fragment", counts(&|disk| disk.fragment)),
        ],
        ..Default::default()
    }
}

/// Lines with whole numbers and numbers, collected row by row.
#[derive(Default)]
struct Lines {
    data: PolyData,
    counts: Vec<Vec<i64>>,
    numbers: Vec<Vec<f64>>,
}

impl Lines {
    fn push(&mut self, ends: [DVec2; 2], counts: &[i64], numbers: &[f64]) {
        self.data.line(ends[0].to_array(), ends[1].to_array());
        self.counts.push(counts.to_vec());
        self.numbers.push(numbers.to_vec());
    }

    fn named(self, counts: &[&'static str], numbers: &[&'static str]) -> PolyData {
        let count = |(k, name): (usize, &&'static str)| -> Field {
            (name, Values::Counts(self.counts.iter().map(|row| row[k]).collect()))
        };
        let number = |(k, name): (usize, &&'static str)| -> Field {
            (name, Values::Scalars(self.numbers.iter().map(|row| row[k]).collect()))
        };
        let counts = counts.iter().enumerate().map(count);
        let of_lines = counts.chain(numbers.iter().enumerate().map(number)).collect();
        PolyData { of_lines, ..self.data }
    }
}

/// From the centre of a to that of b, or to the nearest point of a wall.
fn contacts(moment: &Moment) -> PolyData {
    let mut lines = Lines::default();
    for pair in &moment.pairs {
        let ends = moment.disk(pair.a).zip(moment.far_end(pair.a, pair.b));
        if let Some((a, far)) = ends {
            let force = pair.normal_force * pair.normal + pair.shear_force * pair.normal.perp();
            lines.push(
                [a.position, far],
                &[pair.a.into(), pair.b.into(), pair.bond.map_or(-1, i64::from)],
                &[
                    pair.normal_force,
                    pair.shear_force,
                    pair.moment,
                    pair.gap,
                    pair.normal.x,
                    pair.normal.y,
                    force.x,
                    force.y,
                ],
            );
        }
    }
    lines.named(
        &["a", "b", "bond"],
        &["p_n", "q_n", "tau_nm", "gap_m", "normal_x", "normal_y", "force_x_n", "force_y_n"],
    )
}

/// Number of a state: 0 intact, broken in 1 tension, 2 shear, 3 rolling.
fn number(broken: Option<RuptureMode>) -> i64 {
    match broken {
        None => 0,
        Some(RuptureMode::Tension) => 1,
        Some(RuptureMode::Shear) => 2,
        Some(RuptureMode::Rolling) => 3,
    }
}

fn bonds(moment: &Moment) -> PolyData {
    let mut lines = Lines::default();
    for bond in &moment.bonds {
        if let Some((a, far)) = moment.disk(bond.a).zip(moment.far_end(bond.a, bond.b)) {
            let ids = [bond.id, bond.a, bond.b].map(i64::from);
            let [id, a_id, b_id] = ids;
            lines.push([a.position, far], &[id, a_id, b_id, number(bond.broken)], &[]);
        }
    }
    lines.named(&["id", "a", "b", "state"], &[])
}

fn walls(moment: &Moment) -> PolyData {
    let mut lines = Lines::default();
    for piece in &moment.walls {
        lines.push(piece.ends, &[piece.id.into(), (!piece.is_line).into()], &piece.force);
    }
    lines.named(&["id", "is_thin"], &["force_x_n", "force_y_n", "moment_nm"])
}

fn cracks(moment: &Moment) -> PolyData {
    let mut lines = Lines::default();
    for (bond, crack) in moment.cracks() {
        lines.push(crack.ends, &[bond.into(), number(Some(crack.mode))], &[]);
    }
    lines.named(&["bond", "mode"], &[])
}

/// The links of the chains.
fn membranes(moment: &Moment) -> PolyData {
    let mut lines = Lines::default();
    for ends in &moment.membranes {
        lines.push(*ends, &[], &[]);
    }
    lines.named(&[], &[])
}

/// The rows as CSV: points by `x_m`, `y_m`, lines by the ends `x1_m`, `y1_m`, `x2_m`, `y2_m`.
pub fn csv(data: &PolyData) -> String {
    let are_lines = data.of_points.is_empty();
    let (mut header, fields) = match are_lines {
        true => (vec!["x1_m", "y1_m", "x2_m", "y2_m"], &data.of_lines),
        false => (vec!["x_m", "y_m"], &data.of_points),
    };
    let places: Vec<Vec<f64>> = match are_lines {
        true => data
            .lines
            .iter()
            .map(|ends| ends.iter().flat_map(|k| data.points[*k as usize][..2].to_vec()).collect())
            .collect(),
        false => data.points.iter().map(|point| point[..2].to_vec()).collect(),
    };
    let mut names: Vec<String> = header.drain(..).map(str::to_owned).collect();
    for (name, values) in fields {
        match values {
            Values::Vectors(_) => {
                // The unit stays at the end.
                let (stem, unit) = name.split_once('_').unwrap_or((name, ""));
                names.extend(["x", "y"].map(|axis| format!("{stem}_{axis}_{unit}")));
            }
            _ => names.push((*name).to_owned()),
        }
    }
    let mut text = names.join(",") + "\n";
    for (row, place) in places.iter().enumerate() {
        let mut fields_of: Vec<String> = place.iter().map(|x| format!("{x:?}")).collect();
        for (_, values) in fields {
            match values {
                Values::Scalars(v) => fields_of.push(format!("{:?}", v[row])),
                Values::Counts(v) => fields_of.push(v[row].to_string()),
                Values::Vectors(v) => {
                    fields_of.extend(v[row][..2].iter().map(|x| format!("{x:?}")));
                }
            }
        }
        text += &(fields_of.join(",") + "\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moment::tests::row_of_three;

    #[test]
    fn every_kind_has_its_rows() {
        let link = [DVec2::new(0.0, 1.0), DVec2::new(2.0, 1.0)];
        let moment = Moment { membranes: vec![link], ..row_of_three() };
        let [bodies, contacts, bonds, walls, cracks, membranes] = of(&moment);
        let lines = [&contacts, &bonds, &walls, &cracks, &membranes].map(|data| data.lines.len());
        assert_eq!((bodies.points.len(), lines), (3, [2, 3, 1, 2, 1]));
        assert_eq!(membranes.points, [[0.0, 1.0, 0.0], [2.0, 1.0, 0.0]]);
        assert_eq!(csv(&membranes), "x1_m,y1_m,x2_m,y2_m\n0.0,1.0,2.0,1.0\n");
        // The second contact rests on the floor: its line ends there.
        assert_eq!(contacts.points[3], [2.0, 0.0, 0.0]);
        let text = csv(&contacts);
        let mut rows = text.lines();
        assert!(
            rows.next().is_some_and(|header| header.starts_with("x1_m,y1_m,x2_m,y2_m,a,b,bond"))
        );
        assert_eq!(rows.nth(1), Some("2.0,1.0,2.0,0.0,1,7,-1,2.0,1.0,0.0,0.0,0.0,-1.0,1.0,-2.0"));
        assert!(csv(&bodies).starts_with("x_m,y_m,id,radius_m,displacement_x_m,displacement_y_m,"));
    }
}
